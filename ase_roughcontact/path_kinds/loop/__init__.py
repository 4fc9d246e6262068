"""Adhesion loops: approach and retraction with all instabilities.

``instabilities`` evaluates a loop, and ``cantilever`` its force curve on a spring.
"""

SHOWN = {
    "api": {
        "AdhesionLoop": "instabilities",
        "adhesion_loop": "atoms",
        "cantilever_curve": "cantilever",
    },
    "plot": {"plot_cantilever": "figures", "plot_loop": "figures"},
    "scene": {"Loop": "scene", "relax_loop": "scene"},
}
