"""Theories of the smooth sphere of a scene: over its depth, at limits of its solid."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ase_roughcontact import theory
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.bodies import Bodies

# Extent of a curve of theory relative to that of the steps.
_EXTENT = 1.2


def sphere_limits(bodies: Bodies) -> dict[str, theory.SphereTheory]:
    """Return theories with the instantaneous and the relaxed modulus, by these words.

    There are none for an elastic solid or a flat, and a fluid has no relaxed modulus.
    """
    creep, wall = bodies.solid.creep, bodies.wall
    if creep is None or bodies.radius == math.inf:
        return {}
    adhesion = wall.work_of_adhesion, wall.attraction_range
    instantaneous = bodies.solid.contact_modulus
    moduli = {"instantaneous": instantaneous, "relaxed": creep.relaxed * instantaneous}
    return {
        name: theory.sphere_theory(bodies.radius, modulus, *adhesion)
        for name, modulus in moduli.items()
        if modulus
    }


def forces_over_depth(
    bodies: Bodies,
    theories: Mapping[str, theory.SphereTheory],
    steps: Sequence[LoadStep],
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return penetrations (Å) and forces (eV/Å) of theories in the range of steps.

    There are none for a rough sphere, whose penetration is relative to its highest
    peak, not its mean.
    """
    if bodies.rough is not None or bodies.whole_tip is not None:
        return {}
    area = max(getattr(step, step.area_column) for step in steps)
    largest_force = max(step.normal_force for step in steps)
    found = {}
    for label, each in theories.items():
        # wider than the atoms under pressure: with the rim under tension
        highest = max(largest_force, -each.pull_off_force)
        radius = max(float(each.contact_radius(highest)), math.sqrt(area / math.pi))
        found[label] = each.curve(_EXTENT * radius + bodies.spacing)
    return found
