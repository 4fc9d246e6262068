"""Time of a contact with one thread and with several, by the clock.

    OPENBLAS_NUM_THREADS=1 python cores.py --csv cores.csv

Contacts of a rough sphere of radius 10 000 a0 from a cold start, as in `windows.py`,
with each number of threads in turns. The machine must do nothing else; with two
processors all takes five minutes. A row is written as soon as it is known, and what the
file has is not run again. The table at the end has the least times, their ratio to one
thread, and the part p of the time of one thread that Amdahl's law, 1/(1 - p + p/k),
needs for this ratio.
"""

import argparse
import csv
import os
import time
from itertools import product
from pathlib import Path

from windows import WALLS, load_of, make_atoms

from ase_roughcontact import load_path
from ase_roughcontact._util.threads import processors, threads

RADIUS = 1e4
# Contact radii, and how often each contact is calculated.
ROUNDS = {128.0: 9, 256.0: 6, 512.0: 4, 1024.0: 2}
KEY = "wall", "contact", "round", "threads"


def seconds(wall, contact, count):
    """Return the time of a contact, after its roughness has been made."""
    with threads(count):
        atoms = make_atoms(RADIUS, wall)
        start = time.perf_counter()
        (record,) = load_path(atoms, loads=[load_of(contact, RADIUS)], window="auto")
        assert record.converged
        return time.perf_counter() - start


def read(file):
    if not file.exists():
        return []
    with file.open(newline="") as lines:
        return list(csv.DictReader(lines))


def measure(file, counts):
    """Append the rows that a file does not have yet."""
    known = {tuple(row[name] for name in KEY) for row in read(file)}
    for contact, rounds in ROUNDS.items():
        for k, wall, count in product(range(rounds), WALLS, counts):
            key = wall, f"{contact:g}", str(k), str(count)
            if key in known:
                continue
            took, load = seconds(wall, contact, count), os.getloadavg()[0]
            with file.open("a", newline="") as lines:
                writer = csv.writer(lines)
                if not lines.tell():
                    writer.writerow((*KEY, "seconds", "load of the machine"))
                writer.writerow((*key, f"{took:.4f}", f"{load:.2f}"))
            print(*key, f"{took:.3f} s", flush=True)


def table(rows, counts):
    """Print the least times and what they say about more processors."""
    least = {}
    for row in rows:
        key = row["wall"], row["contact"], int(row["threads"])
        least[key] = min(least.get(key, float("inf")), float(row["seconds"]))
    for wall, contact in dict.fromkeys(key[:2] for key in least):
        one = least.get((wall, contact, 1))
        cells = [f"{wall:10} {contact:>5}"]
        for count in counts:
            took = least.get((wall, contact, count))
            if one and took:
                cells.append(f"{count} threads {took:7.3f} s")
            if one and took and count > 1:
                ratio = one / took
                p = (1.0 - 1.0 / ratio) / (1.0 - 1.0 / count)
                cells.append(f"{ratio:.2f} times faster, p = {p:.2f}")
        print(", ".join(cells))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    counts = sorted({1, 2, processors()})
    parser.add_argument("--threads", type=int, nargs="+", default=counts)
    parser.add_argument("--csv", type=Path, default=Path("cores.csv"))
    options = parser.parse_args()
    measure(options.csv, options.threads)
    table(read(options.csv), options.threads)


if __name__ == "__main__":
    main()
