"""Pictures of the modulus of waves of crystals, and of contacts under smooth spheres.

    python examples/benchmarks/solid_shapes.py

``zones.png``: E*(q) over the Brillouin zone of the crystals in the folder ``crystals``.
``smooth.png``: contacts of radius a (hard wall, R = 20 a) on EMT gold and on a cubic
continuum with 2 C44/(C11 - C12) = 9, beside Hertz's theory; their differences from it
are printed.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from solids import titled

from ase_roughcontact import (
    ActiveSet,
    HardWall,
    RoughContact,
    RoughSphere,
    substrate,
)
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.elasticity import Crystal, Cubic, Isotropic
from ase_roughcontact.plot import style

HERE = Path(__file__).parent
METALS = "EMT-Cu", "EMT-Au", "EMT-Al", "Sutton-Chen-Cu"
RADII = 10.0, 30.0, 100.0
MARKS = {"cubic": "os", "EMT Au": "x+"}


def unit_crystal(name):
    """Return a crystal in units of its contact modulus and spacing."""
    solid = Crystal.read(HERE / "crystals" / f"{name}.json")
    return replace(solid, spacing=1.0, table=solid.table * solid.contact_modulus)


def draw_zones(picture):
    """Draw the modulus of waves over the Brillouin zone."""
    half = np.linspace(0.005, np.pi, 120)
    q = np.concatenate([-half[::-1], half])
    qx, qy = np.meshgrid(q, q)
    with style():
        figure, panels = plt.subplots(
            2, 2, figsize=(5.2, 4.5), sharex=True, sharey=True
        )
        for letter, panel, name in zip("abcd", panels.flat, METALS, strict=True):
            solid = unit_crystal(name)
            modulus = 2.0 / (np.hypot(qx, qy) * solid.wave_compliance(qx, qy))
            print(f"{name}: E*(q) from {modulus.min():.3f} to {modulus.max():.3f} E*")
            image = panel.imshow(
                modulus, origin="lower", extent=(-1, 1, -1, 1), vmin=0.7, vmax=1.45
            )
            panel.set(title=f"({letter}) {titled(name)}")
        for below, beside in zip(panels[1], panels[:, 0], strict=True):
            below.set(xlabel=r"$q_x a_0/\pi$")
            beside.set(ylabel=r"$q_y a_0/\pi$")
        figure.colorbar(image, ax=panels, label=r"$E^*(q)/E^*$")
        figure.savefig(picture, dpi=150)


def contact(solid, a):
    """Return penetration and pressure of a contact of radius a, relative to Hertz."""
    sphere = RoughSphere(20.0 * a)
    n = 2 * int(1.2 * a) + 1
    load = 4.0 * a**3 / (3.0 * sphere.radius)
    symbol = getattr(solid, "symbol", "Cu")
    atoms = substrate(symbol, (n, n), sphere, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(sphere, solid=solid, wall=HardWall(), load=load)
    first = contact_of(atoms).first_contact
    atoms.positions[-1, 2] = first
    if not ActiveSet(atoms).run(fmax=1e-8 * load):
        raise RuntimeError(f"the contact on {solid} did not converge")
    penetration = (first - atoms.positions[-1, 2]) / (a * a / sphere.radius)
    largest = 1.5 * load / (np.pi * a**2)  # of Hertz
    return penetration, atoms.calc.state(atoms).pressure / largest


def hertzian(n, a):
    """Return distances from the middle, and the pressure of Hertz."""
    x = np.arange(n) - n // 2
    r = np.hypot(x[:, None], x) / a
    return r, np.sqrt(np.clip(1.0 - r**2, 0.0, None))


def draw_contacts(picture):
    """Draw pressures, and print their differences from Hertz's theory."""
    strong = Cubic(1.0, 0.85, 0.675)
    unit = strong.contact_modulus
    solids = {
        "isotropic": Isotropic(1.0),
        "cubic": Cubic(*(c / unit for c in (1.0, 0.85, 0.675))),
        "EMT Au": unit_crystal("EMT-Au"),
    }
    with style():
        figure, (atoms, profile) = plt.subplots(1, 2, figsize=(6.8, 2.9))
        for name, solid in solids.items():
            for a in RADII:
                penetration, pressure = contact(solid, a)
                r, expected = hertzian(len(pressure), a)
                error = abs(pressure - expected)[r < 0.9].max()
                edge = r[pressure > 0.0].max()
                outside = r[pressure == 0.0].min()
                print(
                    f"{name:9} a = {a:3g}: penetration {penetration - 1:+.2%}, "
                    f"pressure {error:.1e}, radius from {outside:.3f} to {edge:.3f}"
                )
                if a != RADII[1] or name == "isotropic":
                    continue
                middle = len(pressure) // 2
                x = np.arange(middle + 1)
                color = {"cubic": "C0", "EMT Au": "C1"}[name]
                along = pressure[middle:, middle], np.diag(pressure)[middle:]
                for values, step, mark, where in zip(
                    along, (1.0, 2**0.5), MARKS[name], ("rows", "45°"), strict=True
                ):
                    profile.plot(
                        *(x * step / a, values), mark, color=color, mfc="none", ms=3,
                        label=f"{name}, {where}",
                    )  # fmt: skip
                if name == "cubic":
                    side = (middle + 0.5) / a
                    image = atoms.imshow(
                        pressure.T, origin="lower", extent=(-side, side, -side, side)
                    )
        r = np.linspace(0.0, 1.2, 500)
        profile.plot(r, np.sqrt(np.clip(1.0 - r**2, 0, None)), "k-", label="Hertz")
        profile.set(xlabel="$r/a$", ylabel="$p/p_0$", xlim=(0.0, 1.2))
        profile.set_title("(b) along two directions")
        profile.legend()
        angle = np.linspace(0.0, 2.0 * np.pi, 200)
        atoms.plot(np.cos(angle), np.sin(angle), "w--", lw=1.0)
        atoms.set(xlabel="$x/a$", ylabel="$y/a$", title="(a) cubic continuum")
        figure.colorbar(image, ax=atoms, label=r"$p/p_0$")
        figure.savefig(picture, dpi=150)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path())
    out = parser.parse_args(arguments).out
    draw_zones(out / "zones.png")
    draw_contacts(out / "smooth.png")


if __name__ == "__main__":
    main()
