r"""Viscoelastic solids: any elastic solid times a creep function.

If Poisson's ratio does not change in time, the displacement is

.. math:: u(t) = -G * \int J(t - t')\, \dot p(t')\, dt'

with the Green's function :math:`G` of the instantaneous solid. Over a time step in
which the pressure is linear in time, :math:`u' = -G * (J_s p' + m)`: the past acts like
a pressure :math:`m`, and the step is a contact with an elastic solid that is more
compliant by the factor :math:`J_s`; see `contact.creep`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import instance_of, positive
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.greens import (
    ElasticSolid,
    Isotropic,
    modulus_label,
)
from ase_roughcontact.elasticity.subsurface import (
    ScaledWaves,
    Tractions,
    UniformResponse,
)


@dataclass(frozen=True)
class Scaled(ElasticSolid):
    """Another solid's compliance times a factor.

    Parameters
    ----------
    solid : ElasticSolid
        The other solid.
    factor : float
        Factor of the compliance, positive.

    Raises
    ------
    ValueError
        If the factor is not positive.
    """

    solid: ElasticSolid
    factor: float

    def __post_init__(self) -> None:
        positive(factor=self.factor)

    @property
    def elastic(self) -> ElasticSolid:
        """The instantaneous solid, without the factor."""
        return self.solid.elastic

    @property
    def contact_modulus(self) -> float:  # type: ignore[override]
        """Modulus of the far field (pressure)."""
        return self.solid.contact_modulus / self.factor

    @property
    def bulges(self) -> bool:  # type: ignore[override]
        """Whether a pressure lifts the surface somewhere."""
        return self.solid.bulges

    @property
    def has_cell_compliance(self) -> bool:
        """Whether free boundaries are possible; see `ElasticSolid`."""
        return self.solid.has_cell_compliance

    @property
    def uniform_compliance(self) -> float:  # type: ignore[override]
        """Depth per uniform pressure; see `ElasticSolid`."""
        return self.factor * self.solid.uniform_compliance

    @property
    def thickness(self) -> float:  # type: ignore[override]
        """Thickness of a layer at the surface; see `ElasticSolid`."""
        return self.solid.thickness

    @property
    def half_space(self) -> str:  # type: ignore[override]
        """Half space with the modulus of the far field; see `ElasticSolid`."""
        return self.solid.half_space

    def wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the compliance of plane waves; see `ElasticSolid`."""
        return self.factor * self.solid.wave_compliance(qx, qy)

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the compliance of a cell; see `ElasticSolid`."""
        return self.factor * self.solid.cell_compliance(i, j, spacing)

    @property
    def coupling(self) -> float:  # type: ignore[override]
        """Lateral over normal displacement by pressure; see `ElasticSolid`."""
        return self.solid.coupling

    def lateral_wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the lateral displacement by lateral traction; see `ElasticSolid`."""
        return self.factor * self.solid.lateral_wave_compliance(qx, qy)

    def lateral_cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the displacement by lateral traction on a cell; see `ElasticSolid`."""
        return self.factor * self.solid.lateral_cell_compliance(i, j, spacing)

    def cross_wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the lateral displacement by pressure; see `ElasticSolid`."""
        return self.factor * self.solid.cross_wave_compliance(qx, qy)

    def cross_cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the displacement by pressure on a cell; see `ElasticSolid`."""
        return self.factor * self.solid.cross_cell_compliance(i, j, spacing)

    @property
    def has_subsurface(self) -> bool:
        """Whether stresses below the surface are known; see `ElasticSolid`."""
        return self.solid.has_subsurface

    def subsurface(self, tractions: Tractions) -> ScaledWaves:
        """Return the stress, which is independent of the factor."""
        return ScaledWaves(self.solid.subsurface(tractions), self.factor)

    def uniform_response(self, depth: float) -> UniformResponse:
        """Return the response to a uniform traction; see `ElasticSolid`."""
        response = self.solid.uniform_response(depth)
        return UniformResponse(response.stress, self.factor * response.displacement)

    def check(self, spacing: float) -> None:
        """Raise an error if the solid can't be used with a grid; see `ElasticSolid`."""
        self.solid.check(spacing)


@dataclass(frozen=True)
class Viscoelastic(Scaled):
    r"""Linear viscoelastic solid.

    .. math:: u(t) = -G * \int J(t - t')\, \dot p(t')\, dt'

    Sudden changes are elastic, with the Green's function G of `solid`. States depend on
    time, so that this solid needs a path in time: `time_path`, or `sliding_path` with a
    `Schedule`.

    Parameters
    ----------
    solid : ElasticSolid or float
        Instantaneous solid. A number is the contact modulus of an isotropic solid
        (pressure), for rubber the modulus of the glassy state.
    creep : Creep
        Creep compliance relative to the instantaneous compliance.

    Raises
    ------
    ValueError
        If the instantaneous solid is viscoelastic.
    TypeError
        If `creep` is not a `Creep`.

    Examples
    --------
    >>> from ase.units import GPa
    >>> from ase_roughcontact import Creep, Viscoelastic
    >>> creep = Creep.standard_solid(relaxed=0.1, time=0.5)
    >>> solid = Viscoelastic(2.0 * GPa, creep)
    >>> round(solid.relaxed.contact_modulus / GPa, 3)
    0.2
    """

    solid: Any
    factor: float = field(default=1.0, init=False, repr=False)
    creep: Creep

    def __post_init__(self) -> None:
        if not isinstance(self.solid, ElasticSolid):
            object.__setattr__(self, "solid", Isotropic(self.solid))
        if self.solid.creep is not None:
            raise ValueError(
                f"the instantaneous solid must be elastic, got {self.solid}"
            )
        instance_of(Creep, creep=self.creep)

    @property
    def relaxed(self) -> ElasticSolid:
        """Elastic solid after a long time; raises `ValueError` for a fluid."""
        if not self.creep.relaxed:
            raise ValueError(
                "a fluid, with a creep that has a flow, relaxes to no solid"
            )
        return Scaled(self.solid, 1.0 / self.creep.relaxed)

    def label(self, name: str) -> str:
        """Return a description with the moduli at first and in the end."""
        label = self.solid.label(name)
        if not self.creep.relaxed:
            return f"{label}, a fluid in the end"
        return f"{label}, relaxing to {modulus_label(self.relaxed.contact_modulus)}"

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, which identify the solid in files."""
        parts = {"solid": self.solid.todict(), "creep": self.creep.todict()}
        return {"name": type(self).__name__, **parts}
