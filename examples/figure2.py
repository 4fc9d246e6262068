"""Figure 2 of the paper: contact area against load, from the first touch to Hertz.

Calculates what is missing in a database, and goes on from the table that is there:

    python examples/figure2.py --scale quick
"""

import argparse
from pathlib import Path

from paper import BANDS, scenes

from ase_roughcontact.ensemble import fill_database, run_ensemble, write_table

HERE = Path(__file__).parent


def calculate(scale: str, table: Path, database: Path, workers: int | None) -> None:
    """Calculate the steps that neither table nor database hold."""
    if table.exists():
        fill_database(database, table)
    for band in scenes(scale):
        for progress in run_ensemble(band, database, workers=workers):
            print(f"\r{progress}", end="    ", flush=True)
            write_table(database, table)
        print()


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scale", choices=BANDS, default="quick")
    parser.add_argument("--out", type=Path, default=HERE / "results")
    parser.add_argument("--workers", type=int, help="processes; one per processor")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    name = f"figure2-{options.scale}"
    table, database = options.out / f"{name}.csv", options.out / f"{name}.db"
    calculate(options.scale, table, database, options.workers)


if __name__ == "__main__":
    main()
