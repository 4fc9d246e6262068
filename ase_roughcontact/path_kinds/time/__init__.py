"""Paths in time, of viscoelastic solids.

``balance`` is the balance of energy that controls the time steps.
"""

SHOWN = {
    "api": {"TimeStep": "record", "time_path": "atoms"},
    "plot": {
        "draw_cantilever_path": "figures",
        "draw_time_path": "figures",
        "plot_over_depth": "figures",
        "plot_over_time": "figures",
    },
    "scene": {"Timed": "scene"},
}
