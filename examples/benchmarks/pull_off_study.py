"""Pull-off force and hysteresis of rough tips, over their rms height.

    python pull_off_study.py             # 100 loops, continued where it was stopped
    python pull_off_study.py --report    # the table of the guide, from its rows

The command ``ensemble`` runs the study in pull_off_study.toml, and writes its table and
its figure into the present folder.
"""

import argparse
import csv
from pathlib import Path

from markdown import table

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main as command

SCENE = Path(__file__).with_suffix(".toml")
TABLE = Path(__file__).with_suffix(".csv")
UNITS_SHOWN = {"eV/Å": UNITS["nN"], "eV": 1.0}


def run():
    """Calculate what is missing."""
    command(["ensemble", str(SCENE), "--database", "pull_off_study.db"])
    for ending in (".csv", ".png"):
        Path(f"pull_off_study-study{ending}").replace(f"pull_off_study{ending}")


def report():
    """Print means with standard errors and scatter: forces in nN, energies in eV."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    cells = {}
    for row in rows:
        key = row["roughness.rms_height"]
        mean, error, scatter, theory = (
            float(row[name]) / UNITS_SHOWN[row["unit"]]
            for name in ("mean", "standard_error", "scatter", "theory")
        )
        found = cells.setdefault(key, [row["realisations"]])
        found += [f"{mean:.3g} ± {error:.1g}", f"{scatter:.2g}"]
        if theory == theory:
            found.append(f"{theory:.3g}")
    table(
        "rms height | seeds | pull-off (nN) | scatter | smooth sphere "
        "| dissipated (eV) | scatter",
        ([key, *found] for key, found in cells.items()),
    )


def main():
    """Run the study, or print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true")
    if parser.parse_args().report:
        report()
    else:
        run()


if __name__ == "__main__":
    main()
