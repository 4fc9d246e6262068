"""Small files in the formats of instruments, which tests read."""

import struct
import zipfile

import numpy as np
import pytest


def afm_hdf5(file, mode, segments, **metadata):
    """File of afmformats; segments are heights (m), forces (N), in order."""
    pytest.importorskip("afmformats")
    from afmformats.mod_force_distance import AFMForceDistance

    height, force = (np.concatenate(columns) for columns in zip(*segments, strict=True))
    number = np.repeat(np.arange(len(segments)), [len(h) for h, _ in segments])
    data = {
        "force": force,
        "height (measured)": height,
        "segment": number.astype(np.uint8),
        "time": 1e-3 * np.arange(len(height)),
    }
    keys = {"imaging mode": mode, "enum": 0, "path": file, **metadata}
    AFMForceDistance(data, keys).export_data(file, fmt="hdf5")


def igor_wave(file, columns, note, spacing):
    """Wave of Igor Pro, version 5, of columns by their labels, in doubles."""
    data = np.column_stack(list(columns.values())).T.astype("<f8")
    labels = b"".join(name.encode().ljust(32, b"\0") for name in ("", *columns))
    text = note.replace("\n", "\r").encode("latin-1")
    count, size = data.size, (data.shape[1], data.shape[0], 0, 0)

    def header(checksum):
        sizes = (0, len(text), 0, *(0, 0, 0, 0), *(0, len(labels), 0, 0), 0, 0, 0)
        first = struct.pack("<hhi14i", 5, checksum, 320 + data.nbytes, *sizes)
        wave = struct.pack("<IIIihh6sh32siI", 0, 0, 0, count, 4, 0, b"", 1, b"w", 0, 0)
        wave += struct.pack("<4i4d4d", *size, spacing, 1, 1, 1, 0, 0, 0, 0)
        wave += struct.pack("<4s16shhdd", b"m", b"s", 0, 0, 0.0, 0.0)
        return first + wave.ljust(320, b"\0")

    total = sum(struct.unpack("<192h", header(0)))
    checksum = -total % 2**16
    checksum -= 2**16 * (checksum >= 2**15)
    file.write_bytes(header(checksum) + data.tobytes() + text + labels)


def afm_workshop(file, columns, extra=""):
    """Comma-separated values of AFM workshop, columns by their names."""
    rows = zip(*columns.values(), strict=True)
    lines = [
        "Force-Distance Curve",
        "File Format:\t3",
        "",
        "Date:\tFriday, February 14, 2020",
        "Time:\t1:41:26 PM",
        "Mode:\tSingle",
        "Point:\t1",
        "X, um:\t25.000000",
        "Y, um:\t40.000000",
        *extra.splitlines(),
        "",
        ",".join(columns),
        *(",".join(f"{x:.10g}" for x in row) for row in rows),
    ]
    file.write_text("\r\n".join(lines) + "\r\n")


def chiaro(file, time, load, piezo, stiffness):
    """Text of a Chiaro indenter: load (uN), piezo (nm), stiffness (N/m)."""
    bend = 1e3 * load / stiffness
    depth = piezo - bend
    depth = np.clip(depth - depth[0] - 5.0, 0.0, None)  # zero before the contact
    head = [
        "Date\t12/05/2025\tTime\t11:20:38\tStatus\tOK",
        "Scan (#)\t1\tX (#)\t1\tY (#)\t1\tIndentation (#)\t1",
        f"k (N/m)\t{stiffness}",
        "Tip radius (um)\t27.500",
        "",
        "Device:\tChiaro",
        "Max load (µN)\t0.050",
        "",
        "Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary",
    ]
    columns = time, load, depth, bend, piezo, 0.0 * time
    rows = ("\t".join(f"{x:.9f}" for x in row) for row in zip(*columns, strict=True))
    file.write_text("\n".join([*head, *rows]) + "\n", encoding="latin-1")


def nt_mdt(file, height, push, pull):
    """Text of NT-MDT Nova: height (nm), signals (nA) of both branches, without names.

    The first rows repeat a signal, where nothing was measured.
    """
    rows = zip(height, push, pull, strict=True)
    lines = ["\t".join(f"{x:.6f}" for x in row).replace(".", ",") for row in rows]
    file.write_text("\r\n".join(lines) + "\r\n")


def nano_scope(file, curves, size=4, sensor=True, ramp=1002.0, stored=None, extra=""):
    """Binary file of NanoScope with curves of heights (nm) and deflections (nm).

    A curve is an approach and a retraction in the order of the measurement. Integers
    have 60 nm/V, and 2e-8 V or 2e-5 V of four or two bytes. `stored` is the number of
    points that an approach which ended early takes in the file.
    """
    per_integer = {4: 2e-8, 2: 2e-5}[size]
    (towards, _), (back, _) = curves[0]
    stored = len(towards) if stored is None else stored

    def integers(quantity):
        parts = []
        for down, up in curves:
            rest = np.full(stored - len(towards), -9.0)
            parts += [down[quantity][::-1], rest, up[quantity]]
        values = np.concatenate(parts) / (60.0 * per_integer)
        return np.round(values).astype(f"<i{size}").tobytes()

    channels = [("DeflectionError", "DeflSens", integers(1))]
    if sensor:
        channels.append(("ZSensor", "ZsensSens", integers(0)))
    lines = ["\\*Force file list", *extra.splitlines(), "\\*Ciao scan list"]
    lines += [f"\\@Sens. {name}: V 60.00000 nm/V" for name in ("Zsens", "ZsensSens")]
    lines += ["\\@Sens. DeflSens: V 60.00000 ", "\\*Ciao force list"]
    lines += ["\\Forward vel.: 5", "\\Reverse vel.: 10", "\\Hold Time: 0"]
    if len(curves) > 1:
        lines += ["\\*Ciao image list", "\\Samps/line: 1"]
        lines += [f"\\Number of lines: {len(curves)}", "\\Scan Size: 1 2 ~m"]
    offset = 4096
    for name, sensitivity, block in channels:
        scale = f"V [Sens. {sensitivity}] ({per_integer:.12f} V/LSB) 2.5 V"
        lines += [
            "\\*Ciao force image list",
            f"\\Data offset: {offset}",
            f"\\Data length: {len(block)}",
            "\\Bytes/pixel: 2",
            f"\\Samps/line: {len(back)} {len(towards)}",
            "\\Spring Constant: 1.0",
            f'\\@4:Image Data: S [{name}] "a name"',
            f"\\@4:Z scale: {scale}",
            f"\\@4:Ramp Size: V [Sens. Zsens] (0.0067 V/LSB) {ramp / 60.0:.8f} V",
        ]
        offset += len(block)
    head = "\r\n".join([*lines, "\\*File list end", "\x1a"]).encode("latin-1")
    blocks = b"".join(block for _, _, block in channels)
    file.write_bytes(head.ljust(4096, b"\0") + blocks)


def uff(file, curve, stiffness, sensitivity):
    """Unified text file of PyFMReader: heights (m) and signals (V), contact first."""
    lines = [
        "HE UFF_code:              _1_2_3_4_5",
        f"HE Cantilever_springK_used(N/m):    {stiffness:E}",
        f"HE Recording_inv_optical_lever_sens_used(m/V): {sensitivity:E}",
        "HE Recording_number_segment:        2",
    ]
    names = ("Approach", "AP"), ("Retract", "RE")
    titles = "Displacement", "Deflection"
    for number, ((name, code), columns) in enumerate(zip(names, curve, strict=True)):
        head = f"HE Recording_segment_{number}_"
        lines += [f"{head}type:      {name}", f"{head}code:      {code}"]
        for i, title in enumerate(titles if number == 0 else "??"):
            lines.append(f"{head}col_{i}_title: {title} ")
        rows = zip(*columns, strict=True)
        lines += (f"{code}     {number}    {z:.9E}    {v:.9E} " for z, v in rows)
    file.write_text("\n".join(lines) + "\n")


def jpk_map(file, curves, shape, pixel, stiffness=0.05, sensitivity=50e-9):
    """Map of JPK: curves are places (m) and heights (m), forces (N) of both branches.

    The grid has `shape` columns and rows at distances `pixel` (m) from the origin.
    """

    def properties(values):
        return "".join(f"{key}={value}\n" for key, value in values.items())

    size = np.array(shape) * pixel
    grid = "force-scan-map.position-pattern.grid."
    head = {
        f"{grid}xcenter": size[0] / 2 - pixel / 2,
        f"{grid}ycenter": size[1] / 2 - pixel / 2,
        f"{grid}ulength": size[0],
        f"{grid}vlength": size[1],
        f"{grid}ilength": shape[0],
        f"{grid}jlength": shape[1],
    }

    def linear(prefix, unit, multiplier):
        keys = {"offset": 0.0, "multiplier": multiplier, "unit.unit": unit}
        return {f"{prefix}scaling.{key}": value for key, value in keys.items()}

    def channel(name, base, conversions):
        prefix = f"channel.{name}."
        found = {f"{prefix}data.encoder.type": "signedinteger"}
        found |= linear(f"{prefix}data.encoder.", *conversions.pop(base))
        prefix += "conversion-set."
        found |= {f"{prefix}conversions.base": base}
        for each, (unit, multiplier) in conversions.items():
            at = f"{prefix}conversion.{each}."
            found |= linear(at, unit, multiplier)
            found |= {f"{at}name": each, f"{at}base-calibration-slot": base}
            base = each
        return found

    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("header.properties", properties(head))
        archive.writestr("index/", "")
        for number, ((x, y), *branches) in enumerate(curves):
            folder = f"index/{number}/"
            place = {"x": x, "y": y}
            header = "force-scan-series.header.position"
            keys = {f"{header}.{axis}": value for axis, value in place.items()}
            keys |= {f"{header}-index": number}
            archive.writestr(folder, "")
            archive.writestr(f"{folder}header.properties", properties(keys))
            for segment, (style, (height, force)) in enumerate(
                zip(("extend", "retract"), branches, strict=True)
            ):
                info = "force-segment-header."
                steps = f"{info}settings.segment-settings."
                keys = {
                    f"{info}num-points": len(height),
                    f"{info}duration": 1.0,
                    f"{info}approach-id": "made-up",
                    f"{info}time-stamp": "2020-01-01 12:00:00 +0000",
                    f"{info}settings.style": style,
                    f"{steps}duration": 1.0,
                    f"{steps}z-start": 0.0,
                    f"{steps}z-end": 0.0,
                }
                heights = {"absolute": ("m", 1e-13), "nominal": ("m", 1.0)}
                keys |= channel("measuredHeight", "absolute", heights)
                heights = {"volts": ("V", 1e-13), "calibrated": ("m", 1.0)}
                keys |= channel("height", "volts", heights)
                signal = {"volts": ("V", 1e-8), "distance": ("m", sensitivity)}
                signal |= {"force": ("N", stiffness)}
                keys |= channel("vDeflection", "volts", signal)
                path = f"{folder}segments/{segment}/"
                data = {
                    "measuredHeight": height / 1e-13,
                    "height": height / 1e-13,
                    "vDeflection": force / stiffness / sensitivity / 1e-8,
                }
                archive.writestr(path, "")
                archive.writestr(f"{path}segment-header.properties", properties(keys))
                for name, values in data.items():
                    whole = np.rint(values).astype(">i4").tobytes()
                    archive.writestr(f"{path}channels/{name}.dat", whole)
