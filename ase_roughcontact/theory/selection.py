"""Choice of the theory of a smooth sphere: Hertz, JKR, DMT or Maugis-Dugdale."""

from __future__ import annotations

from ase_roughcontact._util.validation import nonnegative
from ase_roughcontact.theory.hertz import DMT, Hertz
from ase_roughcontact.theory.jkr import JKR
from ase_roughcontact.theory.maugis import MaugisDugdale
from ase_roughcontact.theory.smooth_sphere import SphereTheory

#: Maugis' parameters below which DMT, and above which JKR is accurate: R. W. Carpick,
#: D. F. Ogletree, M. Salmeron, J. Colloid Interface Sci. 211, 395 (1999).
DMT_BELOW, JKR_ABOVE = 0.1, 5.0


def sphere_theory(
    radius: float,
    contact_modulus: float,
    work_of_adhesion: float = 0.0,
    attraction_range: float | None = None,
) -> SphereTheory:
    """Return the theory of a smooth sphere, chosen by Maugis' parameter.

    Parameters
    ----------
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.
    work_of_adhesion : float
        w, energy per area.
    attraction_range : float, optional
        D, range of the attraction, length; required with adhesion. It is the distance
        in Tabor's parameter, and w/D is the tension in Maugis' parameter.

    Returns
    -------
    SphereTheory

    Raises
    ------
    ValueError
        If an argument is out of range or missing.

    References
    ----------
    K. L. Johnson, J. A. Greenwood, J. Colloid Interface Sci. 192, 326 (1997): map of
    the ranges of these theories.
    """
    nonnegative(work_of_adhesion=work_of_adhesion)
    if work_of_adhesion == 0:
        return Hertz(radius, contact_modulus)
    if attraction_range is None:
        raise ValueError(
            "attraction_range must be given with a work_of_adhesion, got None"
        )
    sphere = radius, contact_modulus, work_of_adhesion
    general = MaugisDugdale(*sphere, attraction_range)
    if general.parameter > JKR_ABOVE:
        return JKR(*sphere)
    if general.parameter < DMT_BELOW:
        return DMT(*sphere)
    return general
