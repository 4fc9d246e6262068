"""Files of microscopes, written as their formats describe them.

Each function writes heights, shape (n, m), the first index along x, with the size of a
pixel along x and y, all in nm. The first line of a scan (y = 0) is the upper one of its
image. NaN is a missing point, where the format has such.
"""

import struct
import zipfile

import numpy as np
from scipy.io import netcdf_file


def write_ibw(file, heights, pixel):
    """Igor binary wave, version 5, with a second channel, as of Asylum Research."""
    n, m = heights.shape
    names = [b"", b"HeightRetrace", b"PhaseRetrace"]
    labels = b"".join(name.ljust(32, b"\0") for name in names)
    note = b"MicroscopeModel: made up\r"
    waves = np.stack([1e-9 * heights, 0.0 * heights], axis=2)[:, ::-1]
    data = waves.astype("<f4").tobytes("F")
    wave = struct.pack("<IIIihh6xh32s8x", 0, 0, 0, waves.size, 2, 0, 1, b"scan")
    wave += struct.pack("<4i4d4d", n, m, 2, 0, *(1e-9 * np.array(pixel)), *[1.0] * 6)
    wave += b"m\0\0\0" * 3 + bytes(320 - len(wave) - 12)
    sizes = (320 + len(data), 0, len(note), 0, 0, 0, 0, 0, 0, 0, len(labels), 0, 0, 0)

    def head(checksum):
        return struct.pack("<hh15i", 5, checksum, *sizes, 0)

    total = int(np.frombuffer(head(0) + wave, "<i2").sum(dtype=np.int16))
    file.write_bytes(head(np.int16(-total)) + wave + data + note + labels)


def write_gwy(file, heights, pixel):
    """Native format of Gwyddion; missing points are a mask."""

    def item(name, kind, value):
        return name.encode() + b"\0" + kind + value

    def double(value):
        return struct.pack("<d", value)

    def group(name, *items):
        content = b"".join(items)
        return name.encode() + b"\0" + struct.pack("<I", len(content)) + content

    def field(values, unit):
        lines = np.ascontiguousarray(values.T, "<f8")
        units = {"si_unit_xy": "m", "si_unit_z": unit}
        return group(
            "GwyDataField",
            item("xres", b"i", struct.pack("<i", values.shape[0])),
            item("yres", b"i", struct.pack("<i", values.shape[1])),
            item("xreal", b"d", double(1e-9 * pixel[0] * values.shape[0])),
            item("yreal", b"d", double(1e-9 * pixel[1] * values.shape[1])),
            *(
                item(
                    k,
                    b"o",
                    group("GwySIUnit", item("unitstr", b"s", v.encode() + b"\0")),
                )
                for k, v in units.items()
            ),
            item("data", b"D", struct.pack("<I", lines.size) + lines.tobytes()),
        )

    missing = np.isnan(heights)
    content = group(
        "GwyContainer",
        item("/0/data", b"o", field(1e-9 * np.nan_to_num(heights), "m")),
        item("/0/data/title", b"s", b"Height\0"),
        *([item("/0/mask", b"o", field(1.0 * missing, ""))] if missing.any() else []),
    )
    file.write_bytes(b"GWYP" + content)


def write_sdf(file, heights, pixel):
    """ISO 25178-71, text."""
    n, m = heights.shape
    keys = {
        "ManufacID": "made up",
        "CreateDate": "010120260000",
        "ModDate": "010120260000",
        "NumPoints": n,
        "NumProfiles": m,
        "Xscale": 1e-9 * pixel[0],
        "Yscale": 1e-9 * pixel[1],
        "Zscale": 1e-12,
        "Zresolution": -1,
        "Compression": 0,
        "DataType": 7,
        "CheckType": 0,
    }
    head = ["aISO-1.0", *(f"{key:<12}= {value}" for key, value in keys.items()), "*"]
    values = (1e3 * heights).T.ravel()
    body = [" ".join("BAD" if np.isnan(z) else f"{z:.9g}" for z in values), "*", "*"]
    file.write_text("\n".join(head + body))


def write_binary_sdf(file, heights, pixel):
    """ISO 25178-71, binary, with integers of 32 bits."""
    n, m = heights.shape
    head = struct.pack("<8s10s12s12sHH", b"bISO-1.0", b"made up", b"", b"", n, m)
    head += struct.pack("<4dBBB", *(1e-9 * np.array(pixel)), 1e-15, -1.0, 0, 6, 0)
    values = np.where(np.isnan(heights), -(2**31), np.rint(1e6 * heights))
    file.write_bytes(head + values.T.astype("<i4").tobytes())


def write_jpk(file, heights, pixel):
    """TIFF with the tags of JPK Instruments: a thumbnail, and the height in m."""
    from tifffile import TiffWriter  # comes with SurfaceTopography

    n, m = heights.shape
    scale, offset = 1e-13, -2e-6
    lines = np.rint((1e-9 * heights.T - offset) / scale).astype(np.uint32)[::-1]

    def text(code, value):
        return code, 2, 0, value, True

    def number(code, value):
        return code, 12, 1, value, True

    size = [number(0x8042, 1e-9 * pixel[0] * n), number(0x8043, 1e-9 * pixel[1] * m)]
    slots = (0x8090, "raw"), (0x80C0, "calibrated")
    tags = [text(0x8052, "Height (measured)"), (0x8051, 4, 1, 0, True)]
    tags += [text(0x8081, "calibrated"), (0x8080, 4, 1, len(slots), True)]
    for first, name in slots:
        tags += [text(first, name), text(first + 0x11, f"{name} encoder")]
    first = slots[1][0]
    tags += [text(first + 0x12, "m"), text(first + 0x13, "LinearScaling")]
    tags += [number(first + 0x14, scale), number(first + 0x15, offset)]
    with TiffWriter(file) as tiff:
        date = text(0x8003, "2026-01-01 00:00:00 +0000")
        tiff.write(np.zeros((8, 8), np.uint8), extratags=[date, *size], metadata=None)
        tiff.write(lines, extratags=tags, metadata=None)


def write_x3p(file, heights, pixel):
    """ISO 25178-72: XML and binary doubles in a zip archive."""
    n, m = heights.shape
    axes = "".join(
        f"<C{name}><AxisType>{kind}</AxisType><DataType>D</DataType>"
        f"<Increment>{step!r}</Increment><Offset>0</Offset></C{name}>"
        for name, kind, step in (
            ("X", "I", 1e-9 * pixel[0]),
            ("Y", "I", 1e-9 * pixel[1]),
            ("Z", "A", 1.0),
        )
    )
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(
            "main.xml",
            '<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1>'
            "<Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>"
            f"{axes}</Axes></Record1><Record3><MatrixDimension><SizeX>{n}</SizeX>"
            f"<SizeY>{m}</SizeY><SizeZ>1</SizeZ></MatrixDimension><DataLink>"
            "<PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3>"
            "</p:ISO5436_2>",
        )
        archive.writestr("bindata/data.bin", (1e-9 * heights.T).astype("<f8").tobytes())


def write_netcdf(file, heights, pixel):
    """NetCDF 3 with the names of contact.engineering."""
    with netcdf_file(file, "w") as data:
        for name, count, step in zip("xy", heights.shape, pixel, strict=True):
            data.createDimension(name, count)
            axis = data.createVariable(name, "d", (name,))
            axis[:] = step * np.arange(count)
            axis.length, axis.unit = step * count, "nm"
        values = data.createVariable("heights", "d", ("x", "y"))
        values[:] = heights
        values.unit = "nm"


def write_mi(file, heights, pixel):
    """Molecular Imaging: the height between two channels of friction in V."""
    n, m = heights.shape
    sizes = {"xPixels": n, "yPixels": m}
    sizes |= {"xLength": 1e-9 * pixel[0] * n, "yLength": 1e-9 * pixel[1] * m}
    head = {"fileType": "Image", **sizes}
    lines = [f"{key:<14}{value}" for key, value in head.items()]
    channels = ("Friction", "V"), ("Topography", "nm"), ("Friction", "V")
    for name, unit in channels:
        keys = {"bufferLabel": name, "bufferUnit": unit, "bufferRange": _RANGE}
        lines += [f"{key:<14}{value}" for key, value in keys.items()]
    lines.append(f"{'data':<14}BINARY_32\n")
    data = np.rint(heights.T[::-1] / _RANGE * 2**31).astype("<i4").tobytes()
    file.write_bytes("\n".join(lines).encode() + 3 * data)


def write_h5(file, heights, pixel):
    """HDF5 with one data set, without sizes."""
    from h5py import File  # comes with SurfaceTopography

    with File(file, "w") as data:
        data["height"] = heights


def write_xyz(file, heights, pixel):
    """List of points; missing ones are left out."""
    points = [
        (i * pixel[0], j * pixel[1], z)
        for (i, j), z in np.ndenumerate(heights)
        if not np.isnan(z)
    ]
    np.savetxt(file, points, header="Lateral units: nm\nValue units: nm")


def write_text(file, heights, pixel):
    """Matrix of heights, as Gwyddion exports it."""
    width, height = np.multiply(heights.shape, pixel)
    header = f"Channel: Height\nWidth: {width} nm\nHeight: {height} nm\nValue units: m"
    np.savetxt(file, 1e-9 * heights.T, header=header)


# Largest height (nm) that a file with whole numbers can have.
_RANGE = 100.0

#: Writers by name of a file.
WRITERS = {
    "scan.ibw": write_ibw,
    "scan.gwy": write_gwy,
    "scan.sdf": write_sdf,
    "binary.sdf": write_binary_sdf,
    "scan.jpk": write_jpk,
    "scan.x3p": write_x3p,
    "scan.nc": write_netcdf,
    "scan.mi": write_mi,
    "scan.xyz": write_xyz,
    "scan.txt": write_text,
}
#: Names of the formats that have missing points.
WITH_MISSING = set(WRITERS) - {"scan.jpk", "scan.mi"}
