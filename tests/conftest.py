"""What the tests share: walls, boundaries, a small scene, a fast relaxation."""

import os
import resource
from contextlib import contextmanager

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import pytest
from scipy.fft import irfft2, rfft2
from scipy.optimize import minimize
from solids import CONTINUA, spring_crystal

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.interactions import LennardJones93

# The files of fixtures have no doctests, and one name.
collect_ignore_glob = ["*conftest.py"]
# In units of the contact modulus and of the spacing.
WALLS = {
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.02),
    "full": LennardJones93.full(distance=1.0, work_of_adhesion=0.04, cutoff=3.0),
}


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.get_closest_marker("first") is None)


@pytest.fixture(params=WALLS.values(), ids=WALLS.keys())
def wall(request):
    return request.param


@pytest.fixture(params=[True, False], ids=["periodic", "free"])
def periodic(request):
    return request.param


@pytest.fixture(scope="session")
def crystal():
    return spring_crystal()


@pytest.fixture(
    scope="session",
    params=[
        "isotropic",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("crystal", *CONTINUA)
        ),
    ],
)
def solid(request):
    """Isotropic solid; in the slow suite also every other one."""
    if request.param == "isotropic":
        return Isotropic(1.0)
    if request.param == "crystal":
        return request.getfixturevalue("crystal")
    return CONTINUA[request.param]


@pytest.fixture
def topography():
    """The package of the extra of this name."""
    return pytest.importorskip("SurfaceTopography", reason="needs the extra topography")


@pytest.fixture
def no_pictures(monkeypatch):
    """Skip the figures of runs, which would take most of the time."""
    monkeypatch.setattr("ase_roughcontact.cli.figures.draw", lambda *_: [])


@pytest.fixture(scope="session", params=["load", "penetration", "height"])
def case(request, tmp_path_factory):
    """A run from the command line under this control; see `command_cases`."""
    from command_cases import run_case  # in tests/cli

    return run_case(tmp_path_factory.mktemp("run"), request.param)


@pytest.fixture
def largest_file():
    """Context in which the writing of files above a size fails, as on a full disk."""

    @contextmanager
    def limited(size):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    return limited


@pytest.fixture
def rng():
    return np.random.default_rng(2016)


@pytest.fixture
def scene(periodic, wall, solid, rng):
    """A small contact with heights that span the range of every wall."""
    halfspace = (PeriodicHalfSpace if periodic else FreeHalfSpace)((6, 5), 1.0, solid)
    return Contact(halfspace, rng.uniform(0.0, 3.0, (6, 5)), wall)


@pytest.fixture(scope="session")
def relax():
    """Relaxation in scaled modes by scipy: fast, and none of the package's solvers.

    The variables x are defined by u = (K + E*/a0)^(-1/2) x, in which the elastic part
    of the Hessian is nearly the identity.
    """

    def relaxed(contact, height, start=None, gtol=1e-7):
        half = contact.halfspace
        scale = (half.stiffness + half.contact_modulus / half.spacing) ** -0.5

        def scaled(values):
            return irfft2(rfft2(values.reshape(half.grid)) * scale, half.grid)

        def energy_and_gradient(x):
            state = contact.evaluate(scaled(x), height)
            return state.energy, -scaled(state.forces).ravel()

        x = np.zeros(half.grid[0] * half.grid[1])
        if start is not None:
            x = irfft2(rfft2(start) / scale, half.grid).ravel()
        options = {"maxcor": 20, "ftol": 0.0, "gtol": gtol, "maxiter": 1000}
        result = minimize(
            energy_and_gradient, x, jac=True, method="L-BFGS-B", options=options
        )
        return scaled(result.x)

    return relaxed
