"""A topography from a file: coarser than the atoms, tilted, rounded to 0.01 Å.

    python examples/gallery/measured_topography.py --file heights.txt --pixel 5.1

takes the tilt off heights in Å and presses them, on a sphere, into copper. Without a
file one of a known surface is written first, and tells the error.
"""

import argparse

import numpy as np
from matplotlib.figure import Figure

from ase_roughcontact import NewtonKrylov, RoughContact, snapshot, substrate
from ase_roughcontact.plot import plot_contact, style
from ase_roughcontact.topography import HeightMap, RoughSphere, SelfAffine

A0 = 2.55


def pressed(rough: HeightMap | SelfAffine, size: int):
    sphere = RoughSphere(3 * size * A0, rough)
    atoms = substrate("Cu", (size, size), sphere, spacing=A0, height=0.0)
    atoms.calc = RoughContact(sphere, contact_modulus=0.9)  # eV/Å^3
    if not NewtonKrylov(atoms, logfile=None).run(fmax=1e-5):
        raise RuntimeError("the contact did not converge")
    return snapshot(atoms)


def tilt_of(heights: np.ndarray) -> np.ndarray:
    plane = np.array([*np.indices(heights.shape), np.ones(heights.shape)]).T
    return (plane @ np.linalg.lstsq(plane.reshape(-1, 3), heights.T.ravel(), None)[0]).T


def main(arguments: list[str] | None = None) -> float:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--file", help="of heights; else heights.txt is written")
    parser.add_argument("--pixel", type=float, default=2 * A0, help="of the file (Å)")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--picture", default="measured_topography.png")
    options = parser.parse_args(arguments)
    size, pixel, file = options.size, options.pixel, options.file
    known = SelfAffine(0.1, 0.8, 8 * A0, size * A0, seed=3)
    if file is None:
        file, n = "heights.txt", int(size * A0 / pixel) + 4
        heights = known.heights((n, n), pixel, (-(n // 2) * pixel,) * 2)
        np.savetxt(file, heights + 0.2 * np.arange(n), "%.2f")
    heights = np.loadtxt(file)  # or a topography.heights() of SurfaceTopography
    frame = pressed(HeightMap(heights - tilt_of(heights), pixel), size)
    found, true = (f.info["normal_force"] for f in (frame, pressed(known, size)))
    with style():
        figure = Figure()
        figure.colorbar(plot_contact(figure.subplots(), frame), label="pressure (GPa)")
        figure.savefig(options.picture, dpi=200)
    print(f"force {found:.2f} eV/Å, off by {100 * (found / true - 1):.1f} %")
    return found / true - 1


if __name__ == "__main__":
    main()
