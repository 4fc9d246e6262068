"""Choice of the law for a smooth sphere: Hertz, JKR, DMT or Maugis-Dugdale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import finite, nonnegative, positive
from ase_roughcontact.theory.dmt import dmt_contact_radius, dmt_pull_off_force
from ase_roughcontact.theory.hertz import hertz_contact_radius
from ase_roughcontact.theory.jkr import jkr_contact_radius, jkr_pull_off_force
from ase_roughcontact.theory.maugis import (
    maugis_dugdale_contact_radius,
    maugis_dugdale_pull_off_force,
    maugis_parameter,
    tabor_parameter,
)

#: Maugis' parameters below which DMT, and above which JKR is accurate: R. W. Carpick,
#: D. F. Ogletree, M. Salmeron, J. Colloid Interface Sci. 211, 395 (1999).
DMT_BELOW, JKR_ABOVE = 0.1, 5.0

#: Relative increase of the area by adhesion below which the law is called Hertz.
NEGLIGIBLE_ADHESION = 0.1


@dataclass(frozen=True, kw_only=True)
class SmoothContact:
    """Contact of a smooth sphere and the law that describes it.

    Attributes
    ----------
    law : {"Hertz", "JKR", "DMT", "Maugis-Dugdale"}
        Name of the law.
    contact_area : float
        A, area.
    tabor_parameter, maugis_parameter : float or None
        Dimensionless; None without adhesion.
    pull_off_force : float or None
        Force, negative; None without adhesion.
    """

    law: str
    contact_area: float
    tabor_parameter: float | None = None
    maugis_parameter: float | None = None
    pull_off_force: float | None = None


def smooth_contact(
    normal_force: float,
    radius: float,
    contact_modulus: float,
    work_of_adhesion: float = 0.0,
    attraction_range: float | None = None,
) -> SmoothContact:
    """Return the contact area of a smooth sphere and the law that describes it.

    Parameters
    ----------
    normal_force : float
        N, force, at least the pull-off force.
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
    SmoothContact

    Raises
    ------
    ValueError
        If an argument is out of range or missing, or the force is below the pull-off
        force.

    Notes
    -----
    The law is called Hertz, too, if adhesion increases the area by less than
    `NEGLIGIBLE_ADHESION`; the area is that with adhesion even then.

    References
    ----------
    K. L. Johnson, J. A. Greenwood, J. Colloid Interface Sci. 192, 326 (1997): map of
    the ranges of these laws.
    """
    finite(normal_force=normal_force)
    nonnegative(work_of_adhesion=work_of_adhesion)
    positive(radius=radius, contact_modulus=contact_modulus)
    if work_of_adhesion == 0:
        a = hertz_contact_radius(normal_force, radius, contact_modulus)
        return SmoothContact(law="Hertz", contact_area=float(np.pi * a**2))
    if attraction_range is None:
        raise ValueError(
            "attraction_range must be given with a work_of_adhesion, got None"
        )
    positive(attraction_range=attraction_range)

    system = radius, contact_modulus, work_of_adhesion
    stress = work_of_adhesion / attraction_range
    parameter = float(maugis_parameter(*system, stress))
    if parameter > JKR_ABOVE:
        law, a = "JKR", jkr_contact_radius(normal_force, *system)
        pull_off = float(jkr_pull_off_force(radius, work_of_adhesion))
    elif parameter < DMT_BELOW:
        law, a = "DMT", dmt_contact_radius(normal_force, *system)
        pull_off = float(dmt_pull_off_force(radius, work_of_adhesion))
    else:
        law = "Maugis-Dugdale"
        a = maugis_dugdale_contact_radius(normal_force, *system, stress)
        reduced = maugis_dugdale_pull_off_force(parameter)
        pull_off = float(reduced * np.pi * work_of_adhesion * radius)

    hertz = hertz_contact_radius(max(normal_force, 0.0), radius, contact_modulus)
    if a**2 < (1 + NEGLIGIBLE_ADHESION) * hertz**2:
        law = "Hertz"
    return SmoothContact(
        law=law,
        contact_area=float(np.pi * a**2),
        tabor_parameter=float(tabor_parameter(*system, attraction_range)),
        maugis_parameter=parameter,
        pull_off_force=pull_off,
    )
