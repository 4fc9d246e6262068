"""Contacts with the Fourier transforms of a class outside of the package."""

from unittest.mock import patch

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy_transform import NumpyTransform, with_numpy

import ase_roughcontact as rc
from ase_roughcontact.elasticity import FreeHalfSpace, Isotropic
from ase_roughcontact.elasticity.fft import ENGINES, Blocking, RealFFT2
from ase_roughcontact.elasticity.fft_backends import BlockTransform
from ase_roughcontact.elasticity.lateral import CrossResponse, LateralHalfSpace
from ase_roughcontact.scene import Scene

SOLID = Isotropic(1.0, 0.3)
SPHERE = rc.RoughSphere(40.0)


@pytest.fixture(autouse=True)
def known():
    with with_numpy():
        yield


def atoms_under_sphere(wall, **fft):
    atoms = rc.substrate("Cu", (20, 20), SPHERE, spacing=1.0)
    atoms.calc = rc.RoughContact(SPHERE, solid=SOLID, wall=wall, fft=fft)
    return atoms


def steps_under(wall, coupling="", **fft):
    """Two steps of a sphere, with friction if a coupling is given."""
    atoms = atoms_under_sphere(wall, **fft)
    options = {"validity": "ignore", "window": "auto"}
    if not coupling:
        return list(rc.load_path(atoms, penetrations=[0.5, 1.0], **options))
    options |= {"displacements": [0.1, 0.3], "coupling": coupling}
    return list(
        rc.sliding_path(atoms, rc.Coulomb(0.4), penetrations=[0.5, 1.0], **options)
    )


contacts = pytest.mark.parametrize(
    "wall, coupling",
    [
        (rc.HardWall(), ""),
        (rc.LennardJones93.repulsive(1.0, 1.0), ""),
        (rc.DugdaleWall(0.02, 0.5), ""),
        (rc.HardWall(), "neglected"),
        (rc.HardWall(), "solved"),
    ],
    ids=["hard", "soft", "adhesive", "friction", "coupled friction"],
)


@contacts
def test_contacts_are_the_same_with_a_transform_of_ones_own(wall, coupling):
    names = ["normal_force", "contact_area", "pairs"]
    if coupling:
        names += ["lateral_force_x", "dissipated_energy", "friction_pairs"]
    own = steps_under(wall, coupling, engine="numpy")
    transforms = NumpyTransform.forward, NumpyTransform.inverse
    assert min(transforms) >= sum(step.pairs for step in own)
    for found, expected in zip(own, steps_under(wall, coupling), strict=True):
        assert found.converged
        for name in names:
            assert getattr(found, name) == pytest.approx(
                getattr(expected, name), rel=1e-8
            )
    # the second path has not called it
    assert transforms == (NumpyTransform.forward, NumpyTransform.inverse)


@contacts
def test_contacts_use_the_given_engine_alone(wall, coupling):
    with patch.dict(ENGINES, {"numpy": NumpyTransform}, clear=True):
        steps = steps_under(wall, coupling, engine="numpy")
    assert all(step.converged for step in steps)


def test_a_scene_names_the_engine():
    text = """
    [substrate]
    contact_modulus = 80.0
    [sphere]
    radius = "5 nm"
    [path]
    values = ["10 nN", "20 nN"]
    [solver]
    engine = "numpy"
    """
    with patch.dict(ENGINES, {"numpy": NumpyTransform}, clear=True):
        own = list(Scene.parse(text).relax())
    usual = list(Scene.parse(text.replace("numpy", "pyfftw")).relax())
    for found, expected in zip(own, usual, strict=True):
        assert found.contact_area == pytest.approx(expected.contact_area, rel=1e-8)


def test_atoms_that_stick_use_the_given_engine_alone():
    atoms = atoms_under_sphere(rc.HardWall(), engine="numpy")
    list(rc.load_path(atoms, penetrations=[1.0], validity="ignore"))
    with patch.dict(ENGINES, {"numpy": NumpyTransform}, clear=True):
        sticking = rc.stick(atoms, rc.Tresca(1.0))
        sticking.move(atoms, [0.1, 0.0])
        forces = atoms.get_forces(apply_constraint=False)
    assert abs(forces[:, 0]).max() > 0.0


@pytest.mark.parametrize("kind", [LateralHalfSpace, CrossResponse])
def test_lateral_responses_have_the_precision_of_the_transforms(kind, periodic):
    fields, found = np.random.default_rng(3).normal(size=(2, 7, 6)), []
    for dtype in ("float32", "float64"):
        half = kind((7, 6), 1.3, SOLID, periodic, dtype=dtype, engine="numpy")
        respond = half.normal if kind is CrossResponse else half.displacement
        found.append(respond(fields))
        assert found[-1].dtype == dtype
        assert dtype in NumpyTransform.precisions
    assert_allclose(*found, atol=1e-6 * abs(found[1]).max())


def test_friction_in_single_precision_is_that_in_double_precision():
    single = steps_under(rc.HardWall(), "solved", dtype="float32")[-1]
    double = steps_under(rc.HardWall(), "solved", dtype="float64")[-1]
    assert single.converged
    assert single.lateral_force_x == pytest.approx(double.lateral_force_x, rel=1e-4)
    assert single.lateral_force_x != double.lateral_force_x


def test_lateral_responses_take_the_number_of_threads():
    half = LateralHalfSpace((8, 8), 1.0, SOLID, threads=3)
    assert half.transform.threads == 3


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_displacements_of_the_padding_are_of_the_engine(precision):
    half = FreeHalfSpace((6, 9), 1.3, 2.0, engine="numpy", dtype=precision)
    pressure = np.random.default_rng(3).normal(size=(6, 9))
    everywhere = half.grid_displacement(pressure)
    assert NumpyTransform.precisions == {precision}
    assert (NumpyTransform.forward, NumpyTransform.inverse) == (1, 1)
    padded = np.zeros(half.grid)
    padded[:6, :9] = pressure
    spectrum = np.fft.rfft2(padded) * -half.compliance
    expected = np.fft.irfft2(spectrum, half.grid)
    tolerance = 1e-6 if precision == "float32" else 1e-13
    assert_allclose(everywhere, expected, atol=tolerance * abs(expected).max())


@pytest.mark.parametrize("in_blocks, rows", [(True, 4), (False, 40)])
def test_a_transform_says_whether_large_grids_are_cut(in_blocks, rows):
    class Sized(NumpyTransform):
        engine = "sized"
        longest = 0

        def rows_forward(self, spectra):
            Sized.longest = max(Sized.longest, len(self.rows))
            super().rows_forward(spectra)

    Sized.in_blocks = in_blocks
    small = Blocking(row_block=4 * 40, column_block=1, whole_grid_bytes=0)
    fft = RealFFT2((40, 40), engine="sized", blocking=small, threads=1)
    values = np.random.default_rng(3).normal(size=(40, 40))
    one = fft.multiplier(np.ones((40, 21)))
    assert_allclose(fft.filter(values, one), values, atol=1e-13)
    assert Sized.longest == rows


def test_the_name_of_a_transform_is_its_own():
    with pytest.raises(ValueError, match="'pyfftw' is the engine of PyfftwTransform"):

        class Other(NumpyTransform):
            engine = "pyfftw"

    assert ENGINES["pyfftw"].__name__ == "PyfftwTransform"


def test_a_transform_without_a_name_is_not_registered():
    before = dict(ENGINES)

    class Unnamed(BlockTransform):
        """Base of others."""

    assert before == ENGINES
