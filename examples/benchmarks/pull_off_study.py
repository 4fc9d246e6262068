"""Pull-off force and hysteresis of rough spheres, over their rms height.

    python pull_off_study.py             # 280 loops, continued where it was stopped
    python pull_off_study.py --stored    # table and figure of the loops so far
    python pull_off_study.py --report    # the table of the guide, from its rows

The studies in pull_off_hard.toml and pull_off_soft.toml are at a fixed rms slope: all
lengths of the roughness grow by the same factor. At a fixed rms curvature wavelengths
grow with the square root of the rms height.
"""

import argparse
import csv
import math
from dataclasses import replace
from pathlib import Path

from markdown import table

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.ensemble import product, run_ensemble, study_points
from ase_roughcontact.ensemble.figures import plot_study
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import legend_below
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import sphere_theory, stickiness

TABLE = Path(__file__).with_suffix(".csv")
DATABASE = "pull_off_study.db"
# Words and units of the columns.
COLUMNS = {
    "pull_off_force": ("pull-off force", "nN"),
    "dissipated_energy": ("dissipated energy", "eV"),
}
OVER = "roughness.rms_height"
# Shortest and longest wavelengths at a fixed rms curvature.
AT_FIXED_CURVATURE = {
    "hard": (
        ("2.55 nm", "3.6 nm", "5.1 nm", "7.2 nm"),
        ("10.2 nm", "14.4 nm", "20.4 nm", "28.8 nm"),
    ),
    "soft": (
        ("15.3 nm", "21.6 nm", "30.6 nm", "43.2 nm"),
        ("61.2 nm", "86.4 nm", "122.4 nm", "172.8 nm"),
    ),
}
# Least number of tips of a point that is shown.
LEAST_TIPS = 3
# Columns of the table with words and whole numbers.
TEXTS = "solid", "fixed", "tips", "validity"
# Height of an asperity over the rms height in Rabinovich's formula.
RABINOVICH = 1.48


def studies():
    """Yield the solid, what is fixed, the scene, its parameters and joined keys."""
    for solid, wavelengths in AT_FIXED_CURVATURE.items():
        file = Path(__file__).with_name(f"pull_off_{solid}.toml")
        scene = Scene.parse(file.read_text(encoding="utf-8"))
        study, scene = scene.study, replace(scene, study=None)
        sloped = {**study.parameters, "roughness.seed": range(study.seeds)}
        names = "roughness.short_wavelength", "roughness.long_wavelength"
        curved = sloped | dict(zip(names, wavelengths, strict=True))
        yield solid, "rms slope", scene, sloped, study.together
        yield solid, "rms curvature", scene, curved, study.together


def run():
    """Calculate the loops that are missing."""
    scenes = []
    for _, _, scene, values, together in studies():
        scenes += product(scene, values, together)
    scenes.sort(key=lambda scene: scene.roughness.seed)
    for progress in run_ensemble(scenes, DATABASE, workers=1):
        print(progress)


def rumpf(radius, rms_height, work_of_adhesion, attraction_range):
    """Return the pull-off force of a rigid rough sphere.

    Y. I. Rabinovich et al., J. Colloid Interface Sci. 232, 10 (2000), after Rumpf; the
    force of a smooth sphere is Bradley's, its distance the range of the attraction.
    """
    height = RABINOVICH * rms_height
    contact = 1.0 / (1.0 + radius / height)
    distant = 1.0 / (1.0 + height / attraction_range) ** 2
    return 2.0 * math.pi * work_of_adhesion * radius * (contact + distant)


def smooth(scene):
    """Return the pull-off force of the sphere without roughness (eV/Å)."""
    wall = scene.wall
    adhesion = wall.work_of_adhesion, wall.attraction_range
    return sphere_theory(scene.radius, scene.contact_modulus, *adhesion).pull_off_force


def write():
    """Write the table and the figure of the loops in the database."""
    rows, drawn = [], {}
    for solid, fixed, scene, values, together in studies():
        points = {
            column: study_points(scene, values, DATABASE, column, together)
            for column in COLUMNS
        }
        for column, each in points.items():
            lines = drawn.setdefault((column, solid), [])
            for point in each:
                values = {OVER: point.values[OVER], "fixed": fixed}
                if point.mean.realisations >= LEAST_TIPS:
                    lines.append(replace(point, values=values))
        for force, energy in zip(*points.values(), strict=True):
            row = row_of(solid, fixed, scene.with_values(force.values), force)
            row["dissipated (eV)"] = energy.mean.mean
            row["its error"] = abs(energy.mean.mean) * energy.mean.error
            row["its scatter"] = energy.mean.scatter
            rows.append(row)
    with Path(TABLE.name).open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        for row in rows:
            form = {k: f"{v:.6g}" for k, v in row.items() if isinstance(v, float)}
            writer.writerow(row | form)
    draw(drawn)


def row_of(solid, fixed, scene, point):
    """Return the row of a point: its roughness, theories and pull-off force."""
    wall, rough, nanonewton = scene.wall, scene.rough, UNITS["nN"]
    work, reach = wall.work_of_adhesion, wall.attraction_range
    known = rough.statistics()
    criteria = stickiness(rough, scene.contact_modulus, work, reach)
    tabor, _, robbins = (each.value for each in criteria)
    return {
        "solid": solid,
        "fixed": fixed,
        "rms height (nm)": known.rms_height / 10.0,
        "rms slope": known.rms_slope,
        "rms curvature (1/nm)": 10.0 * known.rms_curvature,
        "tips": point.mean.realisations,
        "Fuller-Tabor": tabor,
        "Pastewka-Robbins": robbins,
        "Rumpf (nN)": rumpf(scene.radius, known.rms_height, work, reach) / nanonewton,
        "smooth (nN)": smooth(scene) / nanonewton,
        "pull-off (nN)": point.mean.mean / nanonewton,
        "error": abs(point.mean.mean) * point.mean.error / nanonewton,
        "scatter": point.mean.scatter / nanonewton,
        "validity": point.mean.validity,
    }


def draw(drawn):
    """Draw the pull-off force and the dissipated energy of both solids."""
    with written(Path(TABLE.with_suffix(".png").name), 5.5, width=7.5) as figure:
        panels = figure.subplots(2, 2, sharex="col")
        for line, (column, (words, unit)) in zip(panels, COLUMNS.items(), strict=True):
            for axes, solid in zip(line, AT_FIXED_CURVATURE, strict=True):
                plot_study(axes, drawn[column, solid], OVER, unit)
                axes.set_ylabel(f"{words} ({unit})")
                axes.set_title(f"{solid} solid")
        for axes in panels[0]:
            axes.set_xlabel("")
        legend_below(figure, [*panels.flat])


def report():
    """Print means with standard errors and scatter, and theories."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    cells = []
    for row in rows:
        if int(row["tips"]) < LEAST_TIPS:
            continue
        value = {k: float(v) for k, v in row.items() if k not in TEXTS}
        cells.append(
            [
                row["solid"],
                row["fixed"],
                f"{value['rms height (nm)']:.1f}",
                f"{value['rms slope']:.2f}",
                row["tips"],
                mean_of(value["pull-off (nN)"], value["error"]),
                f"{value['scatter']:.2g}",
                f"{value['smooth (nN)']:.0f}",
                f"{value['Rumpf (nN)']:.2g}" if row["solid"] == "hard" else "",
                f"{value['Pastewka-Robbins']:.3g}",
                mean_of(value["dissipated (eV)"], value["its error"]),
            ]
        )
    table(
        "solid | fixed | rms height (nm) | rms slope | tips | pull-off (nN) | scatter "
        "| smooth (nN) | Rumpf (nN) | Pastewka-Robbins | dissipated (eV)",
        cells,
    )


def mean_of(mean, error):
    """Return a mean with its standard error, if that is known."""
    return f"{mean:.3g}" if math.isnan(error) else f"{mean:.3g} ± {error:.2g}"


def main():
    """Run the study, or print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stored", action="store_true")
    parser.add_argument("--report", action="store_true")
    options = parser.parse_args()
    if options.report:
        report()
        return
    if not options.stored:
        run()
    write()


if __name__ == "__main__":
    main()
