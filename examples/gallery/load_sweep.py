"""Load sweep of a rough sphere, and what to look at in ase gui.

    python examples/gallery/load_sweep.py --radius 1000 --out sweep
    ase gui -R=-60x sweep.traj

presses a rough sphere into copper. In ase gui choose View > Colors > By tag: 1 is in
contact, 3 the indenter, cut open. OVITO reads pressure and gap from sweep.extxyz.
"""

import argparse

import numpy as np
from ase.io import read, write
from ase.units import GPa, J, m
from matplotlib.figure import Figure

from ase_roughcontact import RoughContact, RoughSphere, load_path, substrate, theory
from ase_roughcontact.atoms.view import centred, with_columns, with_indenter
from ase_roughcontact.plot import plot_contact, plot_curve, style
from ase_roughcontact.topography import SelfAffine


def main(arguments: list[str] | None = None) -> float:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radius", type=float, default=1000.0, help="in spacings")
    parser.add_argument("--out", default="sweep")
    parser.add_argument("--picture", default="load_sweep.png")
    options = parser.parse_args(arguments)
    a0, modulus, nanonewton = 2.55, 145 * GPa, 1e-9 * J / m
    rough = SelfAffine(0.1, 0.8, 4 * a0, 512 * a0, seed=1)
    sphere = RoughSphere(options.radius * a0, rough)
    atoms = substrate("Cu", (8, 8), sphere, spacing=a0, fixed=False)
    atoms.calc = RoughContact(sphere, modulus)
    loads = options.radius * np.geomspace(0.01, 1.0, 7) * nanonewton
    steps = f"{options.out}-steps.traj"
    path = load_path(atoms, loads=loads, window="auto", trajectory=steps)
    area = np.array([step.contact_area for step in path])
    frames = read(steps, ":")
    movie = [centred(with_indenter(frame, sphere, half=True)) for frame in frames]
    write(f"{options.out}.traj", movie)
    write(f"{options.out}.extxyz", [with_columns(frame, sphere) for frame in frames])
    pressure = theory.mean_contact_pressure(0.1, modulus, theory.KAPPA_REPULSIVE)
    predicted = theory.contact_area(loads, sphere.radius, modulus, pressure)
    hertz = theory.hertz_contact_area(loads, sphere.radius, modulus)
    with style():
        figure = Figure(figsize=(6.8, 2.8))
        left, right = figure.subplots(1, 2)
        plot_curve(left, loads / nanonewton, area, hertz, predicted)
        radius = float(np.sqrt(hertz[-1] / np.pi))
        first = theory.first_contact_radius(sphere.radius, 0.1, 0.8, 4 * a0)  # dashed
        image = plot_contact(right, frames[-1], radius, None, "", float(first))
        figure.colorbar(image, ax=right, label="pressure (GPa)")
        figure.savefig(options.picture, dpi=200)
    ratio = float(area[-1] / predicted[-1])
    print(f"area at {loads[-1] / nanonewton:g} nN: {ratio:.3f} of Eq. (4)")
    return ratio


if __name__ == "__main__":
    main()
