"""Forms that the 9-3 wall is made of; rows are energy, pressure and stiffness."""

import numpy as np


def nine_three(gap: np.ndarray, distance: float, depth: float) -> np.ndarray:
    """9-3 form, its energy counted from the minimum.

    Parameters
    ----------
    gap : ndarray, shape (k,)
        Positive (length).
    distance, depth : float
        Of the minimum (length, energy per area).

    Returns
    -------
    ndarray, shape (3, k)
    """
    inverse = distance / gap
    cube = inverse * inverse * inverse
    ninth = cube * cube * cube
    half = 0.5 * depth
    scale = half / distance
    rows = np.empty((3, gap.size))
    rows[0] = half * (cube - 1.0) ** 2 * (cube + 2.0)  # no difference near the minimum
    rows[1] = 9.0 * scale * (ninth - cube) * inverse
    rows[2] = scale / distance * (90.0 * ninth - 36.0 * cube) * inverse**2
    return rows


def smooth_tail(
    x: np.ndarray, reach: float, stiffness: float, work: float
) -> np.ndarray:
    """Tail of the cubic pressure ``-k x (1 - x/D)^2``, zero beyond D.

    Parameters
    ----------
    x : ndarray, shape (k,)
        Gap beyond the minimum, not negative (length).
    reach : float
        D, not negative (length).
    stiffness : float
        k at the minimum (pressure per length).
    work : float
        ``k D^2/12``, what is left of it from the minimum on (energy per area): given,
        it is not rounded.

    Returns
    -------
    ndarray, shape (3, k)
    """
    rows = np.zeros((3, x.size))
    if reach == 0.0:
        return rows
    part = np.minimum(x / reach, 1.0)
    left = 1.0 - part
    # integral of -p from x to the end of the tail
    rows[0] = -work * left**3 * (1.0 + 3.0 * part)
    rows[1] = -stiffness * reach * part * left**2
    rows[2] = stiffness * left * (1.0 - 3.0 * part)
    return rows


def switched_off(rows: np.ndarray, x: np.ndarray, width: float) -> np.ndarray:
    """Form brought to zero by the factor ``1 - 10 t^3 + 15 t^4 - 6 t^5``, t = x/width.

    Parameters
    ----------
    rows : ndarray, shape (3, k)
        Of the form.
    x : ndarray, shape (k,)
        Gap beyond the onset of the switch, not negative (length).
    width : float
        Of the switch (length).

    Returns
    -------
    ndarray, shape (3, k)
    """
    t = np.minimum(x / width, 1.0)
    factor = 1.0 - t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    slope = -30.0 * (t * (1.0 - t)) ** 2 / width
    bend = -60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / width**2
    energy, pressure, _ = rows
    off = factor * rows
    off[1] -= slope * energy
    off[2] += bend * energy - 2.0 * slope * pressure
    return off


def continued(rows: np.ndarray, overlap: np.ndarray) -> np.ndarray:
    """Second-order Taylor polynomial of a form, by how much the gap is smaller.

    Parameters
    ----------
    rows : ndarray, shape (3, k)
        Of the form where it ends.
    overlap : ndarray, shape (k,)
        Positive (length).

    Returns
    -------
    ndarray, shape (3, k)
    """
    energy, pressure, stiffness = rows
    rise = stiffness * overlap
    return np.stack(
        (energy + overlap * (pressure + 0.5 * rise), pressure + rise, stiffness)
    )
