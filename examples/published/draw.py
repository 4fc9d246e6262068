"""Draw pressures in the contact-mechanics challenge, and stiffnesses of punches."""

import matplotlib.pyplot as plt
import numpy as np
from published import HERE, by, numbers, read_rows
from punches import SMOOTH

from ase_roughcontact.plot import style


def draw_pressures(axes):
    """Draw the density of the pressure, ours and as read off."""
    rows = numbers(read_rows(HERE / "challenge.csv"))
    for (seed, points), bins in by(rows, "seed", "points").items():
        pressure, density = np.array([(b["pressure"], b["density"]) for b in bins]).T
        label = f"seed {seed:.0f}, {points:.0f}² points"
        axes.plot(pressure, density, lw=1.0, label=label)
    read = numbers(read_rows(HERE / "papers" / "wang_mueser_2017.csv"))
    pressure, density = np.array([(r["pressure"], r["density"]) for r in read]).T
    axes.plot(pressure, density, "ko", ms=3, label="Wang, Müser 2017, read off")
    axes.set(xlabel="pressure/E*", ylabel="density", title="(a) challenge, 250 kPa")
    axes.legend(fontsize=7)


def draw_stiffnesses(axes):
    """Draw stiffness over force of rough square punches, means over the seeds."""
    rows = numbers(read_rows(HERE / "punches.csv"))
    for (hurst,), steps in by(rows, "hurst").items():
        mean = [
            (force, np.mean([each["stiffness"] for each in group]))
            for (force,), group in by(steps, "force").items()
        ]
        label = f"D = {3.0 - hurst:.1f}"
        axes.loglog(*np.transpose(mean), ".-", lw=1.0, ms=3, label=label)
    axes.axhspan(0.03 * SMOOTH, 0.3 * SMOOTH, color="0.92")
    axes.set(xlabel="force/(h'E*L²)", ylabel="stiffness/(E*L)")
    axes.set_title("(b) rough square punches; fitted in grey")
    axes.legend(fontsize=7)


def main():
    """Draw both."""
    with style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.2))
        draw_pressures(left)
        draw_stiffnesses(right)
        figure.savefig("published.png", dpi=120)


if __name__ == "__main__":
    main()
