"""Atoms with any ASE calculator on top of an elastic semi-infinite crystal."""

SHOWN = {
    "api": {
        "CrystalSurface": "surface",
        "ElasticFoundation": "calculator",
        "FoundationPrecon": "precon",
        "RigidIndenter": "indenter",
        "add_indenter": "indenter",
        "crystal_slab": "builders",
    }
}
