"""
Numbers of the comparison with the paper
========================================

The tables of the page "The paper, claim by claim", from the steps of Fig. 2::

    python examples/paper/reproduction.py

prints them, ``--page FILE`` replaces those in a file, and ``--check`` makes the runs
that show how well they are converged (minutes).
"""

import argparse
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from pathlib import Path

import numpy as np
from ase.units import J, m
from flat_reference import flat_fraction
from paper_scenes import DOMAIN, WORKS, Curve, curves, read_table, scenes, theory

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact.analysis import first_contact
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.ensemble import case_of
from ase_roughcontact.theory import (
    contact_fraction,
    first_contact_radius_from_height,
)

HERE = Path(__file__).parent
Table = Mapping[str, np.ndarray]
# The linear range: above so many N_c of the first asperity, below so many N_c, where
# Eq. (2) is one per cent below the line.
ABOVE, BELOW = 30.0, 0.008
# Contacts of fewer atoms have no area to speak of.
FEWEST = 3.0
# Contact radius of the convergence checks, in a0.
MIDDLE = 2.0**6.5
# Steps of a window over which an exponent is measured, 2^(3/2) in load each.
WINDOW = 4


def mean_and_error(values: Iterable[float], digits: int = 2) -> str:
    """Write the mean of the realisations and its standard error."""
    known = np.array([value for value in values if np.isfinite(value)])
    if len(known) < 2:
        return "-"
    error = np.std(known, ddof=1) / np.sqrt(len(known))
    return f"{known.mean():.{digits}f} ± {error:.{digits}f}"


def markdown(head: str, rows: Iterable[Iterable[object]]) -> Iterator[str]:
    """Lines of a table; columns of the head are separated by commas."""
    titles = head.split(", ")
    yield f"| {' | '.join(titles)} |"
    yield f"|{'---|' * len(titles)}"
    for row in rows:
        yield f"| {' | '.join(map(str, row))} |"


def missing(table: Table) -> Iterator[str]:
    """Report the points of the figure that the table does not contain."""
    done = set(zip(table["case"].tolist(), table["step"].tolist(), strict=True))
    calculated: dict[tuple, bool] = {}
    for scene in (scene for band in scenes("paper") for scene in band):
        case, wall, rough = case_of(scene), scene.interaction, scene.roughness
        joule = wall.parameters.get("work_of_adhesion")
        work = f" {joule * J / m**2:g}" if joule else ""
        slope = 0.0 if rough is None else rough.rms_slope
        seed = -1 if rough is None else rough.seed
        for step, load in enumerate(scene.targets):
            a = round(np.cbrt(0.75 * load * scene.radius))
            point = wall.kind + work, f"{scene.radius:g}", slope, a, seed
            calculated[point] = calculated.get(point, False) or (case, step) in done
    counts: dict[tuple, Counter] = {}
    for wall, *sphere, a, _ in (point for point in calculated if not calculated[point]):
        counts.setdefault((wall, *sphere), Counter())[a] += 1
    spheres: dict[tuple[str, str], list[str]] = {}
    for (name, radius, slope), radii in counts.items():
        missing_radii = ", ".join(f"{a} ({n})" for a, n in sorted(radii.items()))
        spheres.setdefault((name, missing_radii), []).append(f"{radius}/{slope}")
    total, failed = len(calculated), np.count_nonzero(~table["converged"])
    yield f"{sum(calculated.values())} of {total} points were calculated;"
    yield f"{failed} steps did not converge."
    hours = table["seconds"].sum() / 3600.0
    yield f"The sum of the times of all steps is {hours:.1f} h."
    if spheres:
        rows = [(wall, radii, ", ".join(on)) for (wall, radii), on in spheres.items()]
        yield ""
        head = "wall, missing contact radii/a0 (realisations), of R/a0 / h'rms"
        yield from markdown(head, rows)


def linear_range(curve: Curve) -> tuple[float, float]:
    """Return the loads between which the area should grow as the load."""
    scales = curve.theory
    return ABOVE * scales.asperity_load, BELOW * scales.crossover_load


def kappas(curve: Curve, areas: np.ndarray) -> np.ndarray:
    """Kappa of each realisation in the linear range, NaN with less than three steps.

    The least-squares line through the origin, with errors as the areas.
    """
    least, largest = linear_range(curve)
    used = (curve.loads >= least) & (curve.loads <= largest)
    found = np.full(areas.shape[1], np.nan)
    for seed, values in enumerate(areas[used].T):
        known = np.isfinite(values)
        if np.count_nonzero(known) >= 3:
            x = curve.loads[used][known] / curve.slope / values[known]
            found[seed] = x.sum() / (x**2).sum()
    return found


def kappa(table: Table) -> Iterator[str]:
    """Kappa of the walls that only repel."""
    rows = []
    for curve in curves(table):
        found = kappas(curve, curve.areas)
        corrected = kappas(curve, curve.corrected)
        if curve.kind == "adhesive" or not np.isfinite(found).any():
            continue
        ends = *linear_range(curve), curve.loads[-1]
        radii = sorted(np.cbrt(0.75 * load * curve.radius) for load in ends)
        span = f"{radii[0]:.0f} to {radii[1]:.0f}"
        paper = f"{curve.theory.kappa_repulsive:g}"
        sphere = curve.kind, f"{curve.radius:g}", curve.slope
        both = mean_and_error(found), mean_and_error(corrected)
        rows.append((*sphere, span, paper, *both))
    head = "wall, R/a0, h'rms, contact radii/a0, paper, counted, corrected"
    yield from markdown(head, rows)


def asperity(table: Table) -> Iterator[str]:
    """Radius of the first asperity, from the areas while it is alone."""
    rows = []
    for curve in curves(table):
        scales = curve.theory
        seen = np.nanmean(curve.areas, axis=1) >= FEWEST
        used = seen & (curve.loads <= scales.asperity_load)
        if curve.kind == "adhesive" or curve.slope != 0.1 or not used.any():
            continue
        loads, areas = curve.loads[used, None], curve.areas[used]
        radii = (areas / np.pi) ** 1.5 * 4.0 / (3.0 * loads)
        rho = theory(curve.radius, curve.slope, "hard").asperity_radius
        atoms = np.nanmean(areas, axis=1)
        paper = f"{scales.asperity_factor:g}"
        found = mean_and_error(np.exp(np.nanmean(np.log(radii), axis=0)) / rho)
        first = mean_and_error(radii[0] / rho)
        span = f"{atoms[0]:.0f} to {atoms[-1]:.0f}"
        sphere = curve.kind, f"{curve.radius:g}", curve.slope
        rows.append((*sphere, span, paper, first, found))
    head = "wall, R/a0, h'rms, atoms, ρ/ρ(6) paper, at the least load, all loads"
    yield from markdown(head, rows)


def attraction(table: Table) -> Iterator[str]:
    """1/kappa_att: what the attraction takes off the pressure, load by load."""
    found = {(c.kind, c.radius, c.slope, c.work): c for c in curves(table)}
    rows: list[tuple[object, ...]] = []
    for curve in found.values():
        if curve.kind != "adhesive" or curve.radius < 1e5:
            continue
        repulsive = found["repulsive", curve.radius, curve.slope, 0.0]
        for load, areas in zip(curve.loads, curve.areas, strict=True):
            row = np.flatnonzero(np.isclose(repulsive.loads, load, rtol=1e-9))
            if load < ABOVE * curve.theory.asperity_load / 10 or not len(row):
                continue
            others = repulsive.areas[row[0], : len(areas)]
            inverse = load / curve.slope * (1.0 / others - 1.0 / areas)
            a = np.cbrt(0.75 * load * curve.radius)
            paper = {0.0005: 0.04, 0.005: 0.25}[curve.work]
            scales = theory(curve.radius, curve.slope, "repulsive", curve.work)
            formula = 1.0 / scales.kappa_repulsive - scales.inverse_kappa
            ours = mean_and_error(inverse, 3)
            rows.append((curve.work, f"{a:.0f}", paper, f"{formula:.3f}", ours))
    head = "w/(E* a0), contact radius/a0, paper, formula with our D, found"
    yield from markdown(head, rows)
    yield ""
    pressures = np.array([0.0005, 0.001, 0.002])
    inverse = {w: pressures / 0.1 / flat_fraction(w)(pressures) for w in (0.0, *WORKS)}
    rows = []
    for work in WORKS:
        values = inverse[0.0] - inverse[work]
        rows.append((work, *(f"{value:.3f}" for value in values)))
    head = "rough flats w/(E* a0), p = 0.0005 E*, 0.001 E*, 0.002 E*"
    yield from markdown(head, rows)


def collapse(table: Table) -> Iterator[str]:
    """Rms distance from Eq. (4) of the points beyond the first asperity."""
    points: dict[tuple, list[float]] = {}
    for curve in curves(table):
        scales = theory(curve.radius, curve.slope, curve.kind, curve.work)
        unit, rho = curve.theory.crossover_load, curve.theory.asperity_load
        used = curve.loads >= ABOVE * rho
        pressure = curve.loads / curve.hertz
        flat = contact_fraction(pressure, scales.rough_pressure)
        if curve.work:
            flat = flat_fraction(curve.work)(pressure)
        ratio = np.nanmean(curve.areas, axis=1) / curve.hertz / flat
        wall = curve.kind + (f" {curve.work:g}" if curve.work else "")
        for load, value in zip(curve.loads[used], ratio[used], strict=True):
            decade = min(int(np.floor(np.log10(load / unit))), 2)
            points.setdefault((wall, decade), []).append(np.log10(value))
    walls = sorted({wall for wall, _ in points}, key=lambda w: (w[0] == "a", w))
    decades = sorted({decade for _, decade in points})

    def entry(wall: str, decade: int) -> str:
        values = np.array(points.get((wall, decade), []))
        if not len(values):
            return ""
        return f"{np.sqrt((values**2).mean()):.3f} ({len(values)})"

    rows = [(f"10^{d}", *(entry(wall, d) for wall in walls)) for d in decades]
    yield from markdown(", ".join(["N/N_c from", *walls]), rows)


def exponents(table: Table) -> Iterator[str]:
    """Largest exponent d ln A/d ln N, and the range in which the area is linear."""
    rows = []
    for curve in curves(table):
        if curve.kind == "adhesive" or curve.slope != 0.1:
            continue
        seen = np.nanmean(curve.areas, axis=1) >= FEWEST
        seen &= np.isfinite(curve.areas).all(axis=1)
        x, y = np.log(curve.loads[seen]), np.log(curve.areas[seen])
        starts = range(len(x) - WINDOW + 1)
        slopes = np.array(
            [np.polyfit(x[n : n + WINDOW], y[n : n + WINDOW], 1)[0] for n in starts]
        )
        best = slopes.mean(axis=1).argmax()
        ends = x[[best, best + WINDOW - 1]] - np.log(curve.theory.crossover_load)
        where = " to ".join(f"{value:.0e}" for value in np.exp(ends))
        linear = slopes.mean(axis=1) > 0.9
        covered = {n + k for n in np.flatnonzero(linear) for k in range(WINDOW)}
        decades = max(len(covered) - 1, 0) * np.log10(2**1.5)
        sphere = curve.kind, f"{curve.radius:g}"
        rows.append((*sphere, mean_and_error(slopes[best]), where, f"{decades:.1f}"))
    head = "wall, R/a0, largest exponent, N/N_c there, decades of N with more than 0.9"
    yield from markdown(head, rows)


def areas_of(
    kind: str,
    seed: int,
    loads: Iterable[float],
    radius: float,
    spacing: float = 1.0,
    accuracy: float = 1e-4,
) -> list[float]:
    """Areas along a path, on atoms of any spacing; sphere and wall do not change."""
    rough = SelfAffine(0.1, 0.8, 4.0, 512.0, domain=1024.0, seed=seed)
    sphere = RoughSphere(radius, rough)
    walls = {
        "hard": HardWall(),
        "repulsive": LennardJones93.repulsive(1.0, 1.0),
        "adhesive": LennardJones93.adhesive(1.0, 1.0, WORKS[-1]),
    }
    atoms = substrate("Cu", (8, 8), sphere, spacing=spacing, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, walls[kind])
    atoms.positions[-1, 2] = contact_of(atoms).first_contact
    steps = list(load_path(atoms, loads=list(loads), window="auto", accuracy=accuracy))
    if not all(step.converged for step in steps):
        raise RuntimeError(f"{kind}, seed {seed}, spacing {spacing}: not converged")
    return np.array([(step.contact_area, step.continuum_area) for step in steps]).T


def grid(seeds: int = 10) -> Iterator[str]:
    """Kappa and rho on finer grids, at fixed roughness."""
    rows = []
    linear, rho = (
        4.0 * MIDDLE**3 / (3.0 * 1e4),
        theory(1e4, 0.1, "hard").asperity_radius,
    )
    for kind, spacing in product(("hard", "repulsive"), (1.0, 0.5, 0.25)):
        alone = theory(1e4, 0.1, kind).asperity_load / 4.0
        found = [areas_of(kind, s, [alone, linear], 1e4, spacing) for s in range(seeds)]
        (first, _), (last, corrected) = np.transpose(found)
        radii = (first / np.pi) ** 1.5 * 4.0 / (3.0 * alone)
        rows.append(
            (
                kind,
                spacing,
                mean_and_error(last * 0.1 / linear),
                mean_and_error(corrected * 0.1 / linear),
                mean_and_error(radii / rho),
            )
        )
    yield from markdown("wall, spacing/a0, A h'rms E*/N, A_c h'rms E*/N, ρ/ρ(6)", rows)


def converged() -> Iterator[str]:
    """Area at a = 64 a0 against tolerance, steps of the path, and grid."""
    radii = 2.0 ** np.arange(-1.0, 6.1, 0.5)
    finer = 2.0 ** np.arange(-1.0, 6.1, 0.125)
    rows = []
    for kind in ("hard", "repulsive", "adhesive"):
        variants: list[tuple] = [
            (radii, 1.0, accuracy) for accuracy in (1e-2, 1e-4, 1e-8)
        ]
        variants += [(finer, 1.0, 1e-4), (radii, 0.5, 1e-4)]
        found = [
            areas_of(kind, 0, 4.0 * contacts**3 / 3e3, 1e3, *settings)[0, -1]
            for contacts, *settings in variants
        ]
        rows.append((kind, *(f"{value:g}" for value in found)))
    head = "wall, A/a0² at accuracy 1e-2, 1e-4, 1e-8, 4 times the loads, spacing a0/2"
    yield from markdown(head, rows)


def first(seeds: int = 20) -> Iterator[str]:
    """Where the first atom touches, beside a'."""
    rows = []
    for radius in (1e3, 1e4, 1e5):
        found = []
        for seed in range(seeds):
            rough = SelfAffine(0.1, 0.8, 4.0, 512.0, domain=DOMAIN, seed=seed)
            found.append(first_contact(RoughSphere(radius, rough), 1.0).distance)
        printed = theory(radius, 0.1, "hard").first_contact_radius
        solved = first_contact_radius_from_height(radius, rough)
        row = (
            f"{radius:g}",
            f"{printed:.0f}",
            f"{float(solved):.0f}",
            mean_and_error(found, 0),
        )
        rows.append((*row, f"{max(found):.0f}"))
    yield from markdown("R/a0, Eq. (3), solved, found, farthest", rows)


def replaced(page: str, name: str, lines: Iterable[str]) -> str:
    """Page with other lines between the marks of a name."""
    block = "\n".join((f"<!-- {name} -->", *lines, f"<!-- /{name} -->"))
    marks = rf"<!-- {name} -->.*?<!-- /{name} -->"
    text, times = re.subn(marks, lambda _: block, page, flags=re.DOTALL)
    if times != 1:
        raise ValueError(f"the page must have the marks of {name} once, got {times}")
    return text


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    add = parser.add_argument
    add("--table", type=Path, default=HERE / "results" / "figure2-paper.csv")
    add("--page", type=Path, help="file whose numbers are to be replaced")
    add("--check", action="store_true", help="measure convergence as well")
    options = parser.parse_args(arguments)
    table = read_table(options.table)
    readings = missing, kappa, asperity, attraction, collapse, exponents
    parts = {reading.__name__: list(reading(table)) for reading in readings}
    if options.check:
        parts |= {check.__name__: list(check()) for check in (grid, converged, first)}
    for name, lines in parts.items():
        print("\n".join((f"\n{name}", *lines)))
    if options.page:
        page = options.page.read_text(encoding="utf-8")
        for name, lines in parts.items():
            page = replaced(page, name, lines)
        options.page.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
