"""
Fig. 1: maps of a contact and radial averages
=============================================

The contact of a rough sphere with R = 10 000 a0 and a hard wall under four loads::

    python examples/paper/figure1.py --scale paper

takes 20 s and 2.2 GB of memory; ``--scale quick`` takes seconds. The maps are stored in
``results``, and are only drawn if they are there.

.. image:: ../../images/figure1.png
"""

# sphinx_gallery_thumbnail_path = '../images/figure1.png'

import argparse
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from paper_scenes import scene, theory

from ase_roughcontact import load_path
from ase_roughcontact.analysis import ContactMap, radial_average
from ase_roughcontact.plot import BLUE, style
from ase_roughcontact.plot.style import legend_below
from ase_roughcontact.theory import Hertz

HERE = Path(__file__).parent
# With this slope the largest contact is far beyond N_c, where all atoms touch.
RADIUS, SLOPE, SEED = 1e4, 0.01, 0
# Contact radii of a smooth sphere under the loads, in a0.
CONTACTS = {
    "tiny": (2.0, 4.0, 8.0, 16.0),
    "quick": (16.0, 32.0, 64.0, 128.0),
    "paper": (16.0, 64.0, 256.0, 1024.0),
}
RINGS = 40


def calculate(contacts: tuple[float, ...]) -> list[ContactMap]:
    """Relax the contact under the loads."""
    case = scene(RADIUS, SLOPE, SEED, "hard", np.array(contacts))
    atoms, maps = case.atoms(), []
    for step in load_path(atoms, loads=list(case.targets), window="auto"):
        if not step.converged:
            raise RuntimeError(f"step {step.step} did not converge: {step.message}")
        maps.append(ContactMap.from_atoms(atoms))
        print(f"{step.window} atoms, A = {step.contact_area:g} a0^2", flush=True)
    return maps


def save(file: Path, maps: list[ContactMap]) -> None:
    """Write maps, their pressures in single precision."""
    fields: dict[str, Any] = {}
    for number, seen in enumerate(maps):
        fields[f"pressure{number}"] = seen.pressure.astype(np.float32)
        fields[f"contact{number}"] = seen.contact
        fields[f"origin{number}"] = np.array(seen.origin)
    new = file.with_suffix(".new.npz")
    np.savez_compressed(new, **fields)
    new.replace(file)  # whole, whenever this is stopped


def load(file: Path) -> list[ContactMap]:
    """Read maps."""
    with np.load(file) as fields:
        return [
            ContactMap(
                fields[f"pressure{n}"].astype(float),
                fields[f"contact{n}"],
                1.0,
                tuple(fields[f"origin{n}"]),
                periodic=False,
            )
            for n in range(len(fields.files) // 3)
        ]


def draw(maps: list[ContactMap], contacts: tuple[float, ...], picture: Path) -> None:
    """Draw maps above radial averages."""
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    scales = theory(RADIUS, SLOPE, "hard")
    figure, axes = plt.subplots(2, len(maps), figsize=(2.4 * len(maps), 5.0))
    for number, (seen, a) in enumerate(zip(maps, contacts, strict=True)):
        above, below = axes[:, number]
        farthest = np.max(seen.distance[seen.contact])
        reach = 1.1 * max(a, farthest, scales.first_contact_radius)
        load = 4.0 * a**3 / (3.0 * RADIUS) / scales.crossover_load
        digits = np.format_float_positional(load, 2, fractional=False, trim="-")
        title = f"$a_\\mathrm{{Hertz}}$ = {a:g} $a_0$, $N/N_c$ = {digits}"
        above.set_title(f"({'abcd'[number]}) {title}")
        image = draw_map(above, seen, a, scales, reach)
        draw_pressure(below, seen, a, scales.rough_pressure, reach)
    axes[0, 0].set_ylabel("$y/a_0$")
    axes[1, 0].set_ylabel(r"pressure $p/p_\mathrm{rough}$")
    label = r"pressure $p/p_\mathrm{rough}$"
    figure.colorbar(image, ax=axes[0], label=label, extend="max")
    legend_below(figure, axes[:, 0])
    figure.savefig(picture, dpi=150)
    plt.close(figure)


def draw_map(axes: Any, seen: ContactMap, a: float, scales: Any, reach: float) -> Any:
    """Pressure in contact, the contact of a smooth sphere, and a' of Eq. (3)."""
    x, y = seen.x, seen.y
    extent = (x[0] - 0.5, x[-1] + 0.5, y[0] - 0.5, y[-1] + 0.5)
    pressure = np.where(seen.contact, seen.pressure / scales.rough_pressure, np.nan)
    options = {"origin": "lower", "extent": extent, "vmin": 0, "vmax": 4}
    image = axes.imshow(pressure.T, **options)
    first = scales.first_contact_radius
    circles = {"-": (a, r"$a_\mathrm{Hertz}$"), "--": (first, "$a'$, Eq. (3)")}
    for line, (radius, name) in circles.items():
        angle = np.linspace(0.0, 2.0 * np.pi, 181)
        circle = radius * np.cos(angle), radius * np.sin(angle)
        axes.plot(*circle, line, color="k", lw=1, label=name)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="$x/a_0$")
    return image


def draw_pressure(
    axes: Any, seen: ContactMap, a: float, rough: float, reach: float
) -> None:
    """Pressure over all atoms of a ring, and over those in contact."""
    rings = radial_average(seen, np.linspace(0.0, reach, RINGS + 1))
    r = np.linspace(0.0, reach, 400)
    hertz = Hertz(RADIUS, 1.0).pressure(r, a)
    axes.plot(rings.radius, rings.pressure / rough, "k-", lw=2, label="$p$, all atoms")
    contacts = rings.contact_pressure / rough
    axes.plot(rings.radius, contacts, color=BLUE, lw=1.5, label="$p_c$, in contact")
    axes.plot(r, hertz / rough, "k-", lw=0.7, label="Hertz")
    axes.axhline(1.0, color="k", ls="--", lw=0.7, label=r"$p_\mathrm{rough}$")
    axes.set(xlim=(0, reach), ylim=(0, None), xlabel="$r/a_0$")


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scale", choices=CONTACTS, default="quick")
    parser.add_argument("--out", type=Path, default=HERE / "results")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    contacts = CONTACTS[options.scale]
    kept = options.out / f"figure1-{options.scale}.npz"
    if not kept.exists():
        save(kept, calculate(contacts))
    with style():
        draw(load(kept), contacts, options.out / "figure1.png")


if __name__ == "__main__":
    main()
