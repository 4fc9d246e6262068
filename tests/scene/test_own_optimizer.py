"""An optimizer that is defined outside of the package, by one entry."""

from unittest.mock import patch

import pytest
from ase.optimize import LBFGS
from small_scene import SMALL

from ase_roughcontact import NewtonKrylov
from ase_roughcontact.scene import OPTIMIZERS, Scene, on_modes


class FewSteps(NewtonKrylov):
    """Newton-Krylov solver that takes one step at most."""

    def run(self, fmax=0.05, steps=1):
        return super().run(fmax, min(steps, 1))


@pytest.mark.parametrize(
    "optimizer, converged",
    [(on_modes(LBFGS, alpha=1.0, memory=5), True), (FewSteps, False)],
)
def test_a_scene_file_names_an_optimizer_after_one_entry(optimizer, converged):
    text = SMALL.replace("LBFGS", "mine").replace("[32, 30]", "[22, 20]")
    text = text.replace("last = 0.6", "last = 0.3")
    with patch.dict(OPTIMIZERS, mine=optimizer):
        steps = list(Scene.parse(text).relax())
    assert {step.converged for step in steps} == {converged}
