"""Areas of the branches of adhesion loops."""

import numpy as np


def zero_load_area(states):
    """Contact area of a branch where its force, from the deepest state on, is zero."""
    upward = sorted(states, key=lambda state: state.height)
    first = next(i for i, state in enumerate(upward) if state.normal_force <= 0.0)
    above, below = upward[first], upward[first - 1]
    forces, areas = (
        [getattr(state, name) for state in (above, below)]
        for name in ("normal_force", "contact_area")
    )
    return np.interp(0.0, forces, areas)
