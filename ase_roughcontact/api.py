"""The public names of the package, imported when one of them is used."""

from importlib import import_module
from typing import TYPE_CHECKING

from ase_roughcontact._util.parts import shown_by
from ase_roughcontact._util.units import GPa, nm, nN
from ase_roughcontact.atoms.calculator import RoughContact, calculator_of
from ase_roughcontact.atoms.snapshot import pressure_of, restore, snapshot
from ase_roughcontact.atoms.substrate import substrate
from ase_roughcontact.contact import Problem, State
from ase_roughcontact.elasticity import Creep, Isotropic, Layer, Viscoelastic
from ase_roughcontact.elasticity.material import fcc_spacing
from ase_roughcontact.interactions import (
    DugdaleWall,
    ExponentialWall,
    HardWall,
    Interaction,
    LennardJones93,
    PlasticWall,
    PowerLawWall,
)
from ase_roughcontact.interactions.friction import Coulomb, FrictionLaw, Tresca
from ase_roughcontact.interactions.rate_and_state import RateAndState
from ase_roughcontact.interactions.slip_weakening import SlipWeakening
from ase_roughcontact.loading.load_path import load_path
from ase_roughcontact.optimize import (
    ActiveSet,
    FourierModes,
    HalfSpacePrecon,
    NewtonKrylov,
)
from ase_roughcontact.optimize.comparison import compare_optimizers
from ase_roughcontact.optimize.comparison_result import OptimizerComparison
from ase_roughcontact.optimize.settings import on_modes, settings_for
from ase_roughcontact.optimize.tolerance import fmax_for
from ase_roughcontact.paths.output import Output
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.results.column import column
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import Validity, ValidityWarning
from ase_roughcontact.scene.finished_run import Results
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.step import Stepper
from ase_roughcontact.theory import JKR, Hertz
from ase_roughcontact.topography import (
    CompositeRoughness,
    HeightMap,
    Heterogeneity,
    Inverted,
    RoughSphere,
    SelfAffine,
    TabulatedSpectrum,
)

__all__ = [
    "JKR",
    "ActiveSet",
    "CompositeRoughness",
    "Coulomb",
    "Creep",
    "DugdaleWall",
    "ExponentialWall",
    "FourierModes",
    "FrictionLaw",
    "GPa",
    "HalfSpacePrecon",
    "HardWall",
    "HeightMap",
    "Hertz",
    "Heterogeneity",
    "Interaction",
    "Inverted",
    "Isotropic",
    "Layer",
    "LennardJones93",
    "LoadStep",
    "NewtonKrylov",
    "OptimizerComparison",
    "Output",
    "PlasticWall",
    "PowerLawWall",
    "Problem",
    "RateAndState",
    "Results",
    "RoughContact",
    "RoughSphere",
    "Scene",
    "Schedule",
    "SelfAffine",
    "SlipWeakening",
    "State",
    "StepOptions",
    "Stepper",
    "TabulatedSpectrum",
    "Tresca",
    "Validity",
    "ValidityWarning",
    "Viscoelastic",
    "calculator_of",
    "column",
    "compare_optimizers",
    "fcc_spacing",
    "fmax_for",
    "load_path",
    "nN",
    "nm",
    "on_modes",
    "pressure_of",
    "restore",
    "settings_for",
    "snapshot",
    "substrate",
]

if TYPE_CHECKING:
    from ase_roughcontact.fitting.series.row import FittedCurve
    from ase_roughcontact.fitting.series.run import fit_curves, read_fitted_curves
    from ase_roughcontact.fitting.series.table import FittedCurves
    from ase_roughcontact.path_kinds.loop.atoms import adhesion_loop
    from ase_roughcontact.path_kinds.loop.cantilever import cantilever_curve
    from ase_roughcontact.path_kinds.loop.instabilities import AdhesionLoop
    from ase_roughcontact.path_kinds.sliding.atoms import release, sliding_path, stick
    from ase_roughcontact.path_kinds.sliding.record import SlidingStep
    from ase_roughcontact.path_kinds.sliding.timed_record import TimedSlidingStep
    from ase_roughcontact.path_kinds.time.atoms import time_path
    from ase_roughcontact.path_kinds.time.record import TimeStep

    __all__ += [
        "AdhesionLoop",
        "FittedCurve",
        "FittedCurves",
        "SlidingStep",
        "TimeStep",
        "TimedSlidingStep",
        "adhesion_loop",
        "cantilever_curve",
        "fit_curves",
        "read_fitted_curves",
        "release",
        "sliding_path",
        "stick",
        "time_path",
    ]
else:
    for name, module in shown_by("api").items():  # of packages that can be left out
        globals()[name] = getattr(import_module(module), name)
    __all__ += shown_by("api")
