"""Scans from files: text, NumPy, and by SurfaceTopography all others."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.extras import imported
from ase_roughcontact._util.validation import FloatArray, check_matrix, lookup
from ase_roughcontact.topography.scan_text import RawScan, scan_from_text

#: Endings of the names of text files.
TEXT = ".txt", ".asc", ".dat", ".csv", ".xyz", ".tsv"


def read_scan(file: str | Path, channel: int | str | None = None) -> RawScan:
    """Read a scan.

    Parameters
    ----------
    file : path
        NumPy array (.npy), text (.txt, .asc, .dat, .csv, .tsv, .xyz), or any format
        that SurfaceTopography reads.
    channel : int or str, optional
        Number or name of the channel of a file with several; by default the height.

    Raises
    ------
    ValueError
        If the file cannot be read.
    """
    path = Path(file)
    try:
        if path.suffix == ".npy":
            return RawScan(_array(np.load(path)))
        if path.suffix.lower() in TEXT and not _is_binary(path):
            return scan_from_text(path.read_text(encoding="utf-8", errors="replace"))
        return _with_surface_topography(path, channel)
    except ImportError:
        raise
    except Exception as error:  # readers of foreign formats raise errors of any kind
        message = f"cannot read a scan from {str(file)!r}: {error}"
        raise ValueError(message) from error


def scan_of(topography: Any) -> RawScan:
    """Return the scan of an array or of a topography of SurfaceTopography.

    Masked and NaN points are missing.

    Raises
    ------
    ValueError
        If it is not two-dimensional.
    """
    if not callable(getattr(topography, "heights", None)):
        return RawScan(_array(topography))
    pixel_size = getattr(topography, "pixel_size", None)
    if getattr(topography, "dim", 2) != 2 or pixel_size is None:
        raise ValueError(
            f"a topography must be a map of heights on a grid, got {topography!r}"
        )
    x, y = (float(size) for size in pixel_size)
    return RawScan(
        _array(topography.heights()),
        (x, y),
        getattr(topography, "unit", None),
        bool(getattr(topography, "is_periodic", False)),
    )


def _array(values: Any) -> FloatArray:
    """Return heights with NaN in place of masked and infinite points."""
    array: Any = np.ma.asarray(values)
    check_matrix(array)
    heights = array.astype(float).filled(np.nan)
    heights[~np.isfinite(heights)] = np.nan
    return heights


def _with_surface_topography(path: Path, channel: int | str | None) -> RawScan:
    if not path.is_file():
        raise FileNotFoundError("there is no such file")
    need = f"{path} needs the package SurfaceTopography"
    package = imported(
        "SurfaceTopography", "topography", need, "; or export the scan as text"
    )
    # scipy warns when a NetCDF file is closed before its arrays, which are copied
    with warnings.catch_warnings(), package.open_topography(str(path)) as reader:
        warnings.filterwarnings("ignore", "Cannot close a netcdf_file")
        names = [each.name for each in reader.channels]
        if isinstance(channel, str):
            channel = lookup(
                channel, {name: i for i, name in enumerate(names)}, "channel"
            )
        topography = reader.topography(channel_index=channel)
        return scan_of(topography)


def _is_binary(path: Path) -> bool:
    with path.open("rb") as file:
        return b"\0" in file.read(4096)
