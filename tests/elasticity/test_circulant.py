"""The circulant model against the half space that it approximates."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.elasticity.lattice import Box


def test_compliance_differs_from_the_half_space_in_long_waves_only(rng):
    halfspace = FreeHalfSpace((32, 32), 1.0, 1.0)
    noise = rng.standard_normal((32, 32))
    model = CirculantModel(halfspace, Box((0, 0), (32, 32)))
    exact = -halfspace.displacement(noise) / model.self_compliance
    assert np.std(model.compliance(noise) - exact) < 0.1 * np.std(exact)


@pytest.mark.parametrize(
    "kind, shape", [(FreeHalfSpace, (40, 36)), (PeriodicHalfSpace, (140, 130))]
)
def test_models_of_small_windows_and_periodic_surfaces_are_exact(rng, kind, shape):
    halfspace = kind(shape, 2.0, 5.0)
    noise = rng.standard_normal(shape).astype(np.float32)
    noise -= noise.mean()
    model = covering_model(halfspace, Box((3, 3), (2, 2)))
    exact = -halfspace.displacement(noise) / model.self_compliance
    assert model.exact
    assert_allclose(model.compliance(noise), exact, atol=1e-4)
    there_and_back = model.stiffness(model.compliance(noise))
    assert np.corrcoef(there_and_back.ravel(), noise.ravel())[0, 1] > 0.9
    assert covering_model(halfspace, Box((0, 0), (5, 5))) is model


def test_the_last_model_of_a_half_space_is_kept_for_the_same_box():
    halfspace = FreeHalfSpace((60, 60), 1.0, 1.0)
    model = covering_model(halfspace, Box((3, 4), (15, 13)))
    assert covering_model(halfspace, Box((3, 4), (15, 13))) is model
    assert covering_model(halfspace, Box((3, 4), (15, 14))) is not model


@pytest.mark.parametrize("wall_share", [1.0, 0.5, 1e-3, 0.0])
def test_preconditioner_inverts_a_uniform_wall_on_a_periodic_cell(rng, wall_share):
    model = CirculantModel(PeriodicHalfSpace((16, 16), 1.0, 1.0), Box((0, 0), (1, 1)))
    noise = rng.standard_normal((16, 16)).astype(np.float32)
    noise -= noise.mean()
    image = wall_share * noise + (1.0 - wall_share) * model.compliance(noise)
    found = model.preconditioner(wall_share)(image, np.empty_like(image))
    assert_allclose(found, noise, atol=1e-4)


def test_self_compliance_agrees_with_a_large_periodic_cell():
    halfspace = PeriodicHalfSpace((512, 512), 2.0, 5.0)
    unit = np.zeros((512, 512))
    unit[0, 0] = 1.0
    depth = -halfspace.displacement(unit)[0, 0]
    assert_allclose(halfspace.self_compliance, depth, rtol=0.01)
