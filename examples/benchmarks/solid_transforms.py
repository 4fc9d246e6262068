"""Pairs of transforms that relax rough contacts on solids, in units of E* and a0.

    python examples/benchmarks/solid_transforms.py

A rough sphere (R = 200, wavelengths from 4 to 32, rms slope 0.1, load 30) and a rough
flat (p = 0.011) on 96 x 96 atoms, to forces of 1e-6; means over four realisations, as a
table.
"""

from pathlib import Path

import numpy as np

from ase_roughcontact import (
    ActiveSet,
    HardWall,
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    SelfAffine,
    substrate,
)
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.elasticity import Crystal, Cubic, Isotropic, Layer

SIDE, SEEDS = 96, (1, 2, 3, 4)
WALLS = "hard", "repulsive", "adhesive"


def solids():
    """Yield solids by name, with a far field of unit modulus."""
    yield "isotropic", Isotropic(1.0)
    file = Path(__file__).parent / "crystals" / "EMT-Cu.json"
    yield "EMT Cu", Crystal.read(file)
    unit = Cubic(1.0, 0.7, 0.6).contact_modulus
    yield (
        "cubic, $2 C_{44}/(C_{11} - C_{12}) = 4$",
        Cubic(1.0 / unit, 0.7 / unit, 0.6 / unit),
    )
    for modulus, thickness in ((4.0, 4.0), (0.25, 4.0), (0.25, 16.0)):
        layer = Layer(modulus, thickness, 1.0, 0.3, 0.3)
        yield f"layer of {modulus} E*, {thickness:g} a0 thick", layer
    for modulus in (4.0, 0.25):
        yield f"isotropic with {modulus} E*", Isotropic(modulus)


def pairs(solid, wall, periodic, seed):
    """Return the pairs of transforms that relax a contact under a load."""
    unit, a0 = 1.0, 1.0
    if isinstance(solid, Crystal):
        unit, a0 = solid.contact_modulus, solid.spacing
    rough = SelfAffine(0.1, 0.8, 4.0 * a0, 32.0 * a0, seed=seed, domain=SIDE * a0)
    sphere = RoughSphere(np.inf if periodic else 200.0 * a0, rough)
    load = (0.011 * SIDE**2 if periodic else 30.0) * unit * a0**2
    atoms = substrate(
        "Cu", (SIDE, SIDE), sphere, spacing=a0, fixed=False, periodic=periodic
    )
    scale = {"spacing": a0, "contact_modulus": unit}
    form = {
        "hard": HardWall,
        "repulsive": lambda: LennardJones93.repulsive(**scale),
        "adhesive": lambda: LennardJones93.adhesive(
            **scale, work_of_adhesion=0.02 * unit * a0
        ),
    }[wall]()
    atoms.calc = RoughContact(sphere, solid=solid, wall=form, load=load)
    atoms.positions[-1, 2] = contact_of(atoms).first_contact
    dynamics = (ActiveSet if form.hard else NewtonKrylov)(atoms)
    if not dynamics.run(fmax=1e-6 * unit * a0**2):
        raise RuntimeError(f"the {wall} wall on {solid} did not converge")
    return dynamics.pairs


def main():
    cases = [(wall, periodic) for periodic in (False, True) for wall in WALLS]
    titles = [f"{wall}, periodic" if p else wall for wall, p in cases]
    print("| solid |", " | ".join(titles), "|")
    print("|---" * (1 + len(cases)) + "|")
    for name, solid in solids():
        means = [
            np.mean([pairs(solid, *case, seed) for seed in SEEDS]) for case in cases
        ]
        print(
            f"| {name} |", " | ".join(f"{mean:.3g}" for mean in means), "|", flush=True
        )


if __name__ == "__main__":
    main()
