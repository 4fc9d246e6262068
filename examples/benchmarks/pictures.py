"""Pictures of the guide: of commands, and of the roles of a scan.

Each is written to the present folder::

python pictures.py contact    # contact.png of the first run
python pictures.py gui        # its view.traj, as `ase gui` shows it
python pictures.py fit        # fit.png of a synthetic force curve
python pictures.py roles      # which body was scanned
"""

import shutil
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from ase.io import read, write

from ase_roughcontact.cli import main
from ase_roughcontact.plot import BLUE, style

TESTS = Path(__file__).resolve().parents[2] / "tests"


def contact():
    """Copy the maps of the first run."""
    main(["run", "--out", "first", "--quiet"])
    shutil.copy("first/contact.png", "contact.png")


def gui():
    """Draw the third step of the first run from the side."""
    main(["run", "--out", "first", "--quiet"])
    atoms = read("first/view.traj", 2)
    del atoms[atoms.symbols == "X"]
    write("gui.png", atoms, rotation="-60x", maxwidth=900, scale=18)


def fit():
    """Fit the work of adhesion to the synthetic curve of the tests."""
    sys.path[:0] = [str(TESTS), str(TESTS / "cli")]
    from microscope_files import write_gwy
    from test_microscope_chain import PIXEL, SCENE, WORK, scan, write_curve

    rng = np.random.default_rng(7)
    write_gwy(Path("scan.gwy"), scan(rng), (PIXEL, PIXEL))
    Path("my.toml").write_text(SCENE, encoding="utf-8")
    main(["run", "my.toml", "--out", "results", "--quiet"])
    write_curve("results/cantilever.csv", Path("curve.csv"), rng)
    Path("fit.toml").write_text(SCENE.replace(str(WORK), "0.05"), encoding="utf-8")
    free = "work_of_adhesion,force_offset,force_slope"
    main(["fit", "curve.csv", "fit.toml", "--free", free, "--quiet"])


def roles():
    """Draw a scan, and how it is pressed in both roles."""
    x = np.linspace(0.0, 10.0, 300)
    bumps = ((1.4, 2.8, 0.3), (-1.0, 6.8, 0.6), (0.5, 8.8, 0.2))
    scan = sum(h * np.exp(-((x - place) ** 2) / w) for h, place, w in bumps)
    body = {"facecolor": BLUE, "alpha": 0.4, "edgecolor": BLUE}
    smooth = {"facecolor": "0.8", "edgecolor": "0.4"}
    with style():
        figure, panels = plt.subplots(1, 3, figsize=(6.8, 1.9), sharey=True)
        for panel in panels[:2]:
            panel.fill_between(x, scan, -2.0, **body)
        panels[0].text(2.8, 1.6, "high: sticks out", ha="center")
        tip = scan[np.abs(x - 2.8).argmin()] + 0.6 * (x - 2.8) ** 2
        panels[1].fill_between(x[tip < 4.5], tip[tip < 4.5], 4.5, **smooth)
        panels[2].fill_between(x, scan.max() - scan[::-1], 4.5, **body)
        panels[2].fill_between(x, 0.0, -2.0, **smooth)
        names = "scan $z(x)$", 'role = "substrate"', 'role = "indenter"'
        below = (
            "the body that was scanned",
            "$h(x) = -z(x)$: stays in place,\na smooth tip comes from above",
            "$h(x) = -z(-x)$: turned over,\nabove a smooth solid",
        )
        for letter, panel, name, text in zip("abc", panels, names, below, strict=True):
            panel.set(title=f"({letter}) {name}", xticks=[], yticks=[], xlabel=text)
            panel.spines[:].set_visible(False)
        figure.savefig("roles.png", dpi=150)


if __name__ == "__main__":
    {function.__name__: function for function in (contact, gui, fit, roles)}[
        sys.argv[1]
    ]()
