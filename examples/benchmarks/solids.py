"""Rough contact on crystals beside that on continua, in units of E* and a0.

    python examples/benchmarks/solids.py

Crystals are calculated once and kept in the folder ``crystals``, results are appended
to ``solids.csv``: a run that was interrupted goes on where it ended. ``--draw
../images/solids.png`` draws them.

flats: periodic rough flats, 256 atoms a side, wavelengths from 4 to 64 a0, rms slope
0.1, at p = 0.003 E*; kappa follows from the fraction of atoms in contact by Eq. (2).
sphere: Fig. 2(a) for R = 1000 a0, wavelengths from 4 to 512 a0, rms slope 0.1.
"""

import argparse
import csv
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
from ase.calculators.eam import EAM
from ase.calculators.emt import EMT
from ase.units import GPa
from markdown import order, table
from scipy.special import erfinv

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact.elasticity import Crystal, Isotropic
from ase_roughcontact.plot import style
from ase_roughcontact.theory import (
    Hertz,
    crossover_load,
    mean_contact_pressure,
    predicted_area,
)

HERE = Path(__file__).parent
COLUMNS = "study", "solid", "wall", "seed", "load", "area", "kappa"
WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}
SLOPE, PRESSURE, SIDE = 0.1, 0.003, 256
RADIUS, LOADS = 1000.0, np.geomspace(1e-7, 10.0, 17)  # in units of N_c


def sutton_chen(energy, a, c, n, m, cutoff, number, symbol):
    """Return the potential of A. P. Sutton, J. Chen, Philos. Mag. Lett. 61, 139 (1990).

    The functions fall smoothly to zero over the last quarter of the cutoff.
    """

    def smooth(r):
        x = np.clip(4 * (1 - r / cutoff), 0.0, 1.0)
        slope = np.where(x < 1, -120 / cutoff * (x * (1 - x)) ** 2, 0.0)
        return x**3 * (10 - 15 * x + 6 * x**2), slope

    def power(scale, k):
        def value(r):
            return scale * (a / r) ** k * smooth(r)[0]

        def slope(r):
            cut, change = smooth(r)
            return scale * (a / r) ** k * (change - k / r * cut)

        return value, slope

    pair, pair_slope = power(energy, n)
    density, density_slope = power(1.0, m)
    return EAM(
        elements=[symbol],
        embedded_energy=np.array([lambda rho: -energy * c * np.sqrt(rho)]),
        d_embedded_energy=np.array([lambda rho: -energy * c / 2 / np.sqrt(rho)]),
        electron_density=np.array([density]),
        d_electron_density=np.array([density_slope]),
        phi=np.array([[pair]]),
        d_phi=np.array([[pair_slope]]),
        cutoff=cutoff,
        form="alloy",
        Z=[number],
    )


CRYSTALS = {
    "EMT-Cu": ("Cu", EMT, {}),
    "EMT-Au": ("Au", EMT, {}),
    "EMT-Al": ("Al", EMT, {}),
    "Sutton-Chen-Cu": (
        "Cu",
        lambda: sutton_chen(1.2382e-2, 3.61, 39.432, 9, 6, 5.0, 29, "Cu"),
        {"layers": 17},
    ),
}


def crystal(name):
    """Return the crystal of a calculator, from its file or calculated."""
    file = HERE / "crystals" / f"{name}.json"
    if not file.exists():
        symbol, calculator, options = CRYSTALS[name]
        made = Crystal.from_calculator(calculator(), symbol, **options)
        file.parent.mkdir(exist_ok=True)
        made.write(file)
        print(f"{name}: {made.contact_modulus:.6f} eV/A^3, {made.figures}", flush=True)
    return Crystal.read(file)


def solids():
    """Yield solids by name, in units of their contact modulus and spacing."""
    yield "isotropic", Isotropic(1.0)
    for name in CRYSTALS:
        solid = crystal(name)
        unit = replace(solid, spacing=1.0, table=solid.table * solid.contact_modulus)
        yield name, unit
        if name == "EMT-Cu":
            yield "Cu continuum", without_dispersion(unit)


def without_dispersion(solid):
    """Return the continuum with the long waves of a crystal."""
    long = np.zeros_like(solid.table)
    long[0] = (-1.0) ** np.arange(len(long)) @ solid.table
    return replace(solid, table=long)


def flat(solid, wall, seed):
    """Yield load, area and kappa of a rough flat."""
    rough = SelfAffine(SLOPE, 0.8, 4.0, 64.0, domain=float(SIDE), seed=seed)
    atoms = substrate(
        "Cu", (SIDE, SIDE), rough, spacing=1.0, periodic=True, fixed=False
    )
    atoms.calc = RoughContact(rough, solid=solid, wall=WALLS[wall])
    loads = [PRESSURE * SIDE**2]
    for step in load_path(atoms, loads=loads, accuracy="high", validity="ignore"):
        fraction = step.contact_area / SIDE**2
        kappa = 2 / np.sqrt(np.pi) * erfinv(fraction) * SLOPE / PRESSURE
        yield step.normal_force, step.contact_area, kappa


def sphere(solid, wall, seed):
    """Yield loads and areas of a rough sphere."""
    rough = RoughSphere(RADIUS, SelfAffine(SLOPE, 0.8, 4.0, 512.0, seed=seed))
    atoms = substrate("Cu", (16, 16), rough, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(rough, solid=solid, wall=WALLS[wall])
    unit = crossover_load(RADIUS, 1.0, SLOPE, 2.0)
    path = load_path(atoms, loads=LOADS * unit, window="auto", validity="ignore")
    for step in path:
        yield step.normal_force, step.contact_area, ""


STUDIES = {
    "flats": (flat, ["hard", "repulsive"]),
    "sphere": (sphere, ["hard"]),
}


def draw(table, picture):
    """Draw areas and kappa of a table."""
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    with table.open() as file:
        rows = list(csv.DictReader(file))
    unit = crossover_load(RADIUS, 1.0, SLOPE, 2.0)
    with style():
        figure, (areas, kappas) = plt.subplots(1, 2, figsize=(6.8, 3.0))
        for number, name in enumerate(("isotropic", "EMT-Cu")):
            found = [r for r in rows if r["study"] == "sphere" and r["solid"] == name]
            area = np.array([float(row["area"]) for row in found]).reshape(
                -1, LOADS.size
            )
            relative = area / Hertz(RADIUS, 1.0).contact_area(LOADS * unit)
            mean, spread = relative.mean(axis=0), relative.std(axis=0, ddof=1)
            areas.errorbar(
                LOADS, mean, spread, fmt="os"[number], mfc="none", label=titled(name)
            )
        areas.plot(LOADS, fraction(LOADS * unit), "k-", label="Eq. (4), κ = 2")
        areas.set(
            xscale="log",
            yscale="log",
            xlabel=r"$N/N_c$",
            ylabel=r"contact area $A/A_\mathrm{Hertz}$",
        )
        areas.set_title("(a) rough sphere, hard wall")
        areas.legend()
        names = list(dict.fromkeys(row["solid"] for row in rows))
        for wall, marker in (("hard", "o"), ("repulsive", "s")):
            for place, name in enumerate(names):
                values = [
                    float(row["kappa"])
                    for row in rows
                    if (row["study"], row["solid"], row["wall"])
                    == ("flats", name, wall)
                ]
                mean, spread = np.mean(values), np.std(values, ddof=1)
                print(f"{name:15} {wall:10} kappa {mean:.3f} +- {spread:.3f}")
                label = f"{wall} wall" if place == 0 else None
                color = {"hard": "C0", "repulsive": "C1"}[wall]
                kappas.errorbar(
                    place,
                    mean,
                    spread,
                    fmt=marker,
                    color=color,
                    mfc="none",
                    label=label,
                )
        ticks = [titled(name).replace(" ", "\n") for name in names]
        kappas.set_xticks(range(len(names)), ticks, fontsize=6)
        kappas.set(ylabel="κ", ylim=(2.0, 3.6), title="(b) rough flats")
        kappas.legend()
        figure.savefig(picture, dpi=150)


def report(file):
    """Print kappa of the rough flats, mean and standard deviation."""
    found = {}
    with file.open() as rows:
        for row in csv.DictReader(rows):
            if row["study"] == "flats":
                values = found.setdefault(row["solid"], {}).setdefault(row["wall"], [])
                values.append(float(row["kappa"]))
    table(
        "solid | κ, hard wall | κ, repulsive wall",
        (
            (
                titled(solid),
                *(
                    f"{np.mean(walls[wall]):.3f} ± {np.std(walls[wall], ddof=1):.3f}"
                    for wall in WALLS
                ),
            )
            for solid, walls in found.items()
        ),
    )


FIGURES = {
    "repetition": "change when forces are calculated again",
    "rest": "change by the forces on the slab before an atom is displaced",
    "sum_rule": "resultant of the forces on all atoms",
    "symmetry": "change under exchange of two atoms",
    "reach": "force constants at the edges of the slab",
    "thickness": "change of E* with four layers less",
    "square": "difference of directions that should be alike",
    "interpolation": "error of the interpolated E*",
    "long_waves": "difference from the continuum with the moduli of the strained bulk",
}


def report_figures(_):
    """Print the errors that are stored with the crystals."""
    crystals = [crystal(name) for name in CRYSTALS]
    table(
        f"name | what it is | {' | '.join(map(titled, CRYSTALS))}",
        (
            (f"`{key}`", what, *(order(one.figures[key]) for one in crystals))
            for key, what in FIGURES.items()
        ),
    )


def titled(name):
    """Return the name of a solid for people."""
    return name.replace("-", " ").replace("Sutton Chen", "Sutton-Chen")


def report_waves(_):
    """Print the moduli of waves of the crystals (GPa)."""
    rows = []
    for name in CRYSTALS:
        solid = crystal(name)
        pi = np.pi / solid.spacing
        waves = [(1e-4 * pi, 0.0), (1e-4 * pi, 1e-4 * pi), (0.5 * pi, 0.0), (pi, 0.0)]
        waves.append((pi, pi))
        moduli = [
            2.0 / (np.hypot(*q) * float(solid.wave_compliance(*map(np.array, q))))
            for q in waves
        ]
        values = (solid.contact_modulus, *moduli)
        cells = [f"{value / GPa:.1f}" for value in values]
        lattice = f"{2**0.5 * solid.spacing:.4f}"
        rows.append((titled(name), lattice, *cells))
    head = "crystal | a (Å) | E* | long waves | at 45° | 4 a0 | 2 a0"
    table(f"{head} | corner of the zone", rows)


def fraction(loads):
    """Return Eq. (4) relative to the area of Hertz."""
    pressure = mean_contact_pressure(SLOPE, 1.0, 2.0)
    hertz = Hertz(RADIUS, 1.0).contact_area(loads)
    return predicted_area(loads, RADIUS, 1.0, pressure) / hertz


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--draw", type=Path, help="picture of the table")
    parser.add_argument("--table", type=Path, default=HERE / "solids.csv")
    reports = {"kappa": report, "figures": report_figures, "waves": report_waves}
    parser.add_argument("--of", choices=reports, default="kappa", help="what to print")
    parser.add_argument("--report", action="store_true", help="print a table")
    options = parser.parse_args(arguments)
    if options.report:
        reports[options.of](options.table)
        return
    if options.draw:
        with style():
            draw(options.table, options.draw)
        return
    done = set()
    if options.table.exists():
        with options.table.open() as file:
            done = {tuple(row[c] for c in COLUMNS[:4]) for row in csv.DictReader(file)}
    else:
        options.table.write_text(",".join(COLUMNS) + "\n", "utf-8")
    for name, solid in solids():
        for study, (calculate, walls) in STUDIES.items():
            if study == "sphere" and name not in ("isotropic", "EMT-Cu"):
                continue
            for wall in walls:
                for seed in range(options.seeds):
                    case = study, name, wall, str(seed)
                    if case in done:
                        continue
                    rows = [(*case, *row) for row in calculate(solid, wall, seed)]
                    with options.table.open("a", newline="") as file:
                        csv.writer(file, lineterminator="\n").writerows(rows)
                    print(*case, flush=True)


if __name__ == "__main__":
    main()
