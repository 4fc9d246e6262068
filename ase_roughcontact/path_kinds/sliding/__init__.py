"""Sliding with friction.

``coupling`` solves for normal and lateral motion in turn, and ``lateral_state`` has the
tractions of a step; files named ``timed`` have paths in time.
"""

SHOWN = {
    "api": {
        "SlidingStep": "record",
        "TimedSlidingStep": "timed_record",
        "release": "atoms",
        "sliding_path": "atoms",
        "stick": "atoms",
    },
    "plot": {
        "draw_friction": "figures",
        "draw_sliding_in_time": "timed_figures",
        "draw_tractions": "figures",
        "plot_friction_loop": "figures",
        "plot_friction_over_time": "timed_figures",
        "plot_slip_areas": "figures",
        "plot_slip_rate": "timed_figures",
        "plot_tractions": "figures",
    },
    "scene": {"Sliding": "scene", "TimedSliding": "timed_scene"},
}
