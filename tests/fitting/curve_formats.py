"""Small files in the formats of instruments, which tests read."""

import struct

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
