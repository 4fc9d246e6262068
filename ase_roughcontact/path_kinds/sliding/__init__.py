"""Sliding with friction.

``coupling`` solves for normal and lateral motion in turn, and ``lateral_state`` has the
tractions of a step.
"""

SHOWN = {
    "api": {
        "SlidingStep": "record",
        "release": "atoms",
        "sliding_path": "atoms",
        "stick": "atoms",
    },
    "plot": {
        "draw_friction": "figures",
        "draw_tractions": "figures",
        "plot_friction_loop": "figures",
        "plot_slip_areas": "figures",
        "plot_tractions": "figures",
    },
    "scene": {"Sliding": "scene"},
}
