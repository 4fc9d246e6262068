"""Force curves of scenes, as an instrument measures them."""

import numpy as np

from ase_roughcontact.fitting.force_curve import ForceCurve


def sampled(exact, highest, points, noise, zero):
    """Approach and retraction of a cantilever at equal steps of the base, with noise.

    The base goes up to a height (Å); `zero` is the height at which the depth is zero.
    """
    base = np.linspace(exact.approach.distance[-1], highest, points)
    down, up = (
        np.interp(base, *(values[order] for values in (each.distance, each.force)))
        for each in (exact.approach, exact.retraction)
        for order in [np.argsort(each.distance, kind="stable")]
    )
    force = np.append(down[::-1], up[1:])
    force += noise * np.random.default_rng(1).normal(size=force.size)
    tip = np.append(base[::-1], base[1:]) + force / exact.stiffness
    return ForceCurve(zero - tip, force, exact.stiffness)
