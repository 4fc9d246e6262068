"""The tests of the solvers again, as time steps of a viscoelastic solid."""

import numpy as np
import pytest

from ase_roughcontact import Creep, Viscoelastic
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.viscoelastic import Scaled

CREEP = Creep([0.5, 2.0], [0.3, 4.0], flow=0.1)
SHORT = 0.01


@pytest.fixture(
    autouse=True, params=["elastic", pytest.param("creep", marks=pytest.mark.slow)]
)
def kind_of_solid(request, monkeypatch):
    """Elastic solid; in the slow suite also a short step of one that creeps.

    Over the step, and with a past, it responds as the elastic solid of the test.
    """
    if request.param == "elastic":
        return
    elastic, softer = Contact.__init__, CREEP.over(SHORT).compliance

    def of_step(self, halfspace, heights, *others, **past):
        if isinstance(halfspace.solid, Scaled):
            elastic(self, halfspace, heights, *others, **past)
            return
        solid = Viscoelastic(Scaled(halfspace.solid, 1.0 / softer), CREEP)
        crept = type(halfspace)(
            halfspace.shape, halfspace.spacing, solid, **halfspace.fft
        )
        n, m = halfspace.shape
        pressure = np.random.default_rng(1).random((n, m))
        depth = -crept.displacement(0.1 * solid.contact_modulus * pressure)[:n, :m]
        past["past_depth"] = depth
        elastic(self, crept.softened(softer), heights - depth, *others, **past)
        self.indenter_heights = np.asarray(heights, dtype=float)  # of the test

    monkeypatch.setattr(Contact, "__init__", of_step)
