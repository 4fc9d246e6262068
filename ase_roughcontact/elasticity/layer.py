r"""Isotropic layer on a half space of another material or on a rigid base.

The compliance of a plane wave of pressure is the compliance of a half space of the
layer's material times a function F of the wave number and the thickness h,

.. math:: G(q) = \frac{2}{E_1^* |q|} F(|q| h), \qquad F(\infty) = 1, \qquad
          F(0) = \frac{E_1^*}{E_2^*} .

:math:`F - 1` is expanded in exponentials. Each is the Green's function of a point force
at a depth below the surface (an image):

.. math:: F(x) - 1 = \sum_k c_k e^{-b_k x} \quad\Rightarrow\quad
          \Delta G(r) = \frac{1}{\pi E_1^*} \sum_k
          \frac{c_k}{\sqrt{r^2 + b_k^2 h^2}} .
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import check_poisson, positive
from ase_roughcontact.elasticity.greens import (
    ElasticSolid,
    Isotropic,
    modulus_label,
)
from ase_roughcontact.elasticity.subsurface import (
    LayeredWaves,
    Tractions,
    UniformResponse,
    isotropic_uniform,
    uniform_strain,
)

# Number of images of a layer as stiff as its base, or softer.
_IMAGES = 40
# Additional images for each doubling of the stiffness of the layer.
_IMAGES_PER_OCTAVE = 6
# Depth of the shallowest image, in units of the thickness.
_MIN_DEPTH = 1.0
# Depth of the deepest image of a layer as stiff as its base, in units of the thickness;
# it is proportional to the ratio of the moduli of a stiffer layer.
_MAX_DEPTH = 60.0
# Distance, in cells, up to which images are integrated over the cell in closed form.
_CLOSED_FORM_CELLS = 32
# Number of knots of the spline in the logarithm of the distance, beyond it.
_KNOTS = 1000
# Largest ratio of the moduli of layer and base. For larger ones, nothing but rounding
# errors is left of the compliance of long waves.
_MAX_RATIO = 1e6
# Rise by a unit force, in units of ``1/(pi E_1* h)``, up to which a surface is flat.
_MAX_FLAT_RISE = 1e-6


@dataclass(frozen=True)
class Layer(ElasticSolid):
    r"""Isotropic elastic layer, bonded to its base or sliding on it without friction.

    With :math:`x = |q| h`, the ratio :math:`\mu` of the shear moduli of layer and base,
    :math:`\kappa = (\mu - 1)/(\mu + 3 - 4 \nu_1)` and
    :math:`\lambda = 1 - 4 (1 - \nu_1)/[1 + \mu (3 - 4 \nu_2)]`, the compliance of
    a bonded layer is :math:`2 F/(E_1^* |q|)` with

    .. math:: F = \frac{1 + 4 x \kappa e^{-2x} - \lambda \kappa e^{-4x}}
                       {1 - (\lambda + \kappa + 4 \kappa x^2) e^{-2x}
                        + \lambda \kappa e^{-4x}} .

    A sliding layer is the sum of its symmetric and its bending deformation,

    .. math:: F = \frac{2 S B + \beta (S + B)}{S + B + 2 \beta}, \qquad
              S = \frac{\cosh x - 1}{\sinh x + x}, \quad
              B = \frac{\cosh x + 1}{\sinh x - x}, \quad
              \beta = \frac{E_1^*}{E_2^*} .

    The Green's function on one cell is accurate to about 1e-7 of the Green's function
    of a half space of the softer material, and to 1e-4 if the layer is a million times
    as stiff.

    Parameters
    ----------
    layer_modulus : float
        Contact modulus of the layer, ``E_1* = E/(1 - nu^2)`` (pressure).
    thickness : float
        Thickness h of the layer (length).
    base_modulus : float, optional
        Contact modulus ``E_2*`` of the half space below the layer (pressure); by
        default the base is rigid.
    poisson, base_poisson : float
        Poisson's ratios of layer and base. The base's ratio matters only to a bonded
        layer.
    bonded : bool
        Whether the layer is bonded to the base, or slides on it without friction.

    Attributes
    ----------
    bulges : bool
        Whether the surface rises somewhere under pressure.
    contact_modulus : float
        Modulus of the base; on a rigid base, where there is no far field, the modulus
        of the layer (pressure).
    uniform_compliance : float
        Depth per uniform pressure (length/pressure): on a rigid base the compliance of
        uniaxial strain, ``h (1 - 2 nu_1)/[(1 - nu_1)^2 E_1*]``, as a periodic cell
        keeps its size; otherwise zero. Heights above a periodic layer are measured
        from the mean plane of its surface, which a mean pressure p lowers by
        ``uniform_compliance p``.

    Raises
    ------
    ValueError
        If a modulus or the thickness is not positive, the layer is more than a million
        times as stiff as its base, or Poisson's ratio is not above -1 and at most 1/2.

    References
    ----------
    D. M. Burmister, J. Appl. Phys. 16, 89 (1945); T. Nogi, T. Kato, J. Tribol. 119, 493
    (1997); K. L. Johnson, Contact Mechanics (1985), Sec. 5.8; G. Carbone,
    L. Mangialardi, J. Mech. Phys. Solids 56, 684 (2008).

    Examples
    --------
    >>> from ase_roughcontact import RoughContact, RoughSphere
    >>> from ase_roughcontact.elasticity import Layer
    >>> soft = Layer(0.1, thickness=20.0, base_modulus=0.9)
    >>> soft.contact_modulus  # modulus of the base, which determines the far field
    0.9
    >>> calculator = RoughContact(RoughSphere(200.0), solid=soft)
    """

    layer_modulus: float
    thickness: float
    base_modulus: float | None = None
    poisson: float = 0.5
    base_poisson: float = 0.5
    bonded: bool = True

    def __post_init__(self) -> None:
        positive(layer_modulus=self.layer_modulus, thickness=self.thickness)
        if self.base_modulus is not None:
            positive(base_modulus=self.base_modulus)
        if not self._ratio <= _MAX_RATIO:
            raise ValueError(
                f"a layer must be at most {_MAX_RATIO:.0e} times as stiff as its base, "
                f"got {self.layer_modulus:g} on {self.base_modulus:g}"
            )
        check_poisson(poisson=self.poisson, base_poisson=self.base_poisson)

    @property
    def contact_modulus(self) -> float:  # type: ignore[override]
        """Contact modulus of the base; of the layer if the base is rigid."""
        return self.layer_modulus if self.base_modulus is None else self.base_modulus

    @property
    def uniform_compliance(self) -> float:  # type: ignore[override]
        """Depth per uniform pressure on a rigid base (length/pressure)."""
        if self.base_modulus is not None:
            return 0.0
        strain = (1.0 - 2.0 * self.poisson) / (1.0 - self.poisson) ** 2
        return self.thickness * strain / self.layer_modulus

    @property
    def half_space(self) -> str:  # type: ignore[override]
        """Half space with the modulus `contact_modulus`; see `ElasticSolid`."""
        if self.base_modulus is None:
            return "on the material of the layer"
        return "on the base without a layer"

    def label(self, name: str) -> str:
        """Return a description of the layer and of its base, which has the name."""
        thickness = f"{self.thickness / UNITS['nm']:.4g} nm"
        layer = f"layer of {thickness}, {modulus_label(self.layer_modulus)}"
        base = "a rigid base" if self.base_modulus is None else super().label(name)
        return f"{layer}, {'bonded to' if self.bonded else 'sliding on'} {base}"

    @property
    def bulges(self) -> bool:  # type: ignore[override]
        """Whether the surface rises somewhere under pressure."""
        strengths, depths = self._images
        r = np.geomspace(0.01, 30.0, 300)[:, None]  # in units of the thickness
        images = (strengths / np.hypot(r, depths)).sum(axis=1)
        return bool((1.0 / r[:, 0] + images).min() < -_MAX_FLAT_RISE)

    def wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return ``2 F(|q| h)/(E_1* |q|)``; see `ElasticSolid`."""
        q = np.hypot(qx, qy)
        return 2.0 * self._factor(q * self.thickness) / (self.layer_modulus * q)

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return Love's kernel plus the images; see `ElasticSolid`."""
        x, y = np.broadcast_arrays(abs(np.asarray(i, float)), abs(np.asarray(j, float)))
        strengths, depths = self._images
        depths = depths * self.thickness / spacing
        near = np.maximum(x, y) <= _CLOSED_FORM_CELLS
        images = np.empty(x.shape)
        images[near] = _image_integral(x[near], y[near], strengths, depths)
        images[~near] = _distant_images(np.hypot(x[~near], y[~near]), strengths, depths)
        images *= spacing / (np.pi * self.layer_modulus)
        return images + Isotropic(self.layer_modulus).cell_compliance(i, j, spacing)

    def subsurface(self, tractions: Tractions) -> LayeredWaves:
        """Return the stress in layer and base; see `ElasticSolid`."""
        base = self._base
        return LayeredWaves(
            tractions,
            self.thickness,
            self._material.shear_modulus,
            self.poisson,
            None if base is None else (base.shear_modulus, self.base_poisson),
            self.bonded,
        )

    def uniform_response(self, depth: float) -> UniformResponse:
        """Return the response to a uniform traction; see `ElasticSolid`."""
        layer = uniform_strain(self._material.shear_modulus, self.poisson)
        if depth <= self.thickness:
            return isotropic_uniform(self.poisson, -depth * layer)
        strain, poisson = np.zeros((3, 3)), self.base_poisson
        if self._base is not None:
            strain = uniform_strain(self._base.shear_modulus, poisson)
        moved = -self.thickness * layer - (depth - self.thickness) * strain
        return isotropic_uniform(poisson, moved)

    @property
    def _material(self) -> Isotropic:
        """Half space of the material of the layer."""
        return Isotropic(self.layer_modulus, self.poisson)

    @property
    def _base(self) -> Isotropic | None:
        """Half space of the material of the base; None if it is rigid."""
        if self.base_modulus is None:
            return None
        return Isotropic(self.base_modulus, self.base_poisson)

    def _factor(self, x: np.ndarray) -> np.ndarray:
        """Return ``F(x)``, the compliance relative to a half space of the layer."""
        return self._bonded(x) if self.bonded else self._sliding(x)

    def _bonded(self, x: np.ndarray) -> np.ndarray:
        decay, k = np.exp(-2.0 * x), 3.0 - 4.0 * self.poisson
        if self.base_modulus is None:
            rise = (k - 1.0) * (1.0 - decay**2) + 2.0 * _sinh_excess(2.0 * x)
            return rise / (k * (1.0 + decay**2) + decay * (k**2 + 1.0 + 4.0 * x**2))
        shear = self._ratio * (1.0 - self.poisson) / (1.0 - self.base_poisson)
        kappa = (shear - 1.0) / (shear + k)
        base = 1.0 + shear * (3.0 - 4.0 * self.base_poisson)
        lambda_ = 1.0 - 4.0 * (1.0 - self.poisson) / base
        last = lambda_ * kappa * decay**2
        middle = (lambda_ + kappa + 4.0 * kappa * x**2) * decay
        return (1.0 + 4.0 * x * kappa * decay - last) / (1.0 - middle + last)

    def _sliding(self, x: np.ndarray) -> np.ndarray:
        decay = np.exp(-x)
        symmetric = np.expm1(-x) ** 2 / (1.0 - decay**2 + 2.0 * x * decay)
        # the stiffness of bending: its compliance diverges for long waves
        bending = 2.0 * _sinh_excess(x) / (1.0 + decay) ** 2
        if self.base_modulus is None:
            return 2.0 * symmetric / (symmetric * bending + 1.0)
        ratio, both = self._ratio, symmetric * bending + 1.0
        return (2.0 * symmetric + ratio * both) / (both + 2.0 * ratio * bending)

    @property
    def _ratio(self) -> float:
        """Ratio of the moduli of layer and base; zero on a rigid base."""
        return self.layer_modulus / (self.base_modulus or np.inf)

    @cached_property
    def _images(self) -> tuple[np.ndarray, np.ndarray]:
        """Strengths and depths of the images, depths in units of the thickness."""
        stiffer = max(self._ratio, 1.0)
        number = _IMAGES + round(_IMAGES_PER_OCTAVE * np.log2(stiffer))
        depths = np.geomspace(_MIN_DEPTH, _MAX_DEPTH * stiffer, number)
        x = np.concatenate(
            [np.geomspace(1e-4 / stiffer, 1.0, 400), np.linspace(1.0, 40.0, 1000)[1:]]
        )
        change = self._factor(x) - 1.0
        weight = 1.0 / (1.0 + abs(change))
        waves = np.exp(-np.outer(x, depths)) * weight[:, None]
        strengths = np.linalg.lstsq(waves, change * weight, rcond=1e-14)[0]
        return strengths, depths


def _sinh_excess(x: np.ndarray) -> np.ndarray:
    """Return ``exp(-x) (sinh x - x)`` without cancellation."""
    x2 = np.square(x)
    series = x2 / 6 * (1 + x2 / 20 * (1 + x2 / 42 * (1 + x2 / 72 * (1 + x2 / 110))))
    decay = np.exp(-x)
    return np.where(x < 0.5, decay * x * series, (1.0 - decay**2) / 2.0 - x * decay)


def _image_integral(
    x: np.ndarray, y: np.ndarray, strengths: np.ndarray, depths: np.ndarray
) -> np.ndarray:
    """Integrate the images over the unit cells at (x, y), shape (n,)."""
    total = np.zeros((x.size, depths.size))
    for s in (0.5, -0.5):
        for t in (0.5, -0.5):
            cx, cy = (x + s)[:, None], (y + t)[:, None]
            corner = cx * np.arcsinh(cy / np.hypot(cx, depths))
            corner += cy * np.arcsinh(cx / np.hypot(cy, depths))
            distance = np.sqrt(cx**2 + cy**2 + depths**2)
            corner -= depths * np.arctan(cx * cy / (depths * distance))
            total += np.copysign(corner, s * t * corner)
    return total @ strengths


def _distant_images(
    r: np.ndarray, strengths: np.ndarray, depths: np.ndarray
) -> np.ndarray:
    """Integrate the images over unit cells at distances r, to the second order."""
    if not r.size:
        return r
    knots = np.geomspace(r.min(), 1.001 * r.max(), _KNOTS)
    square = knots[:, None] ** 2 + depths**2
    laplacian = 1.0 / square - 3.0 * depths**2 / square**2
    profile = ((1.0 + laplacian / 24.0) / np.sqrt(square)) @ strengths
    return CubicSpline(np.log(knots), profile)(np.log(r))
