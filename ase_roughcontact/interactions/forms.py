"""Parts of the 9-3 wall as functions of gaps, shape (k,).

Energy, pressure and stiffness are the rows of the returned arrays, shape (3, k).
"""

import numpy as np


def nine_three(gap: np.ndarray, distance: float, depth: float) -> np.ndarray:
    """Return the 9-3 form, with zero energy at the given distance of its minimum.

    Gaps are positive.
    """
    inverse = distance / gap
    cube = inverse * inverse * inverse
    ninth = cube * cube * cube
    half = 0.5 * depth
    scale = half / distance
    rows = np.empty((3, gap.size))
    # factored, so that no large terms cancel near the minimum
    rows[0] = half * (cube - 1.0) ** 2 * (cube + 2.0)
    rows[1] = 9.0 * scale * (ninth - cube) * inverse
    rows[2] = scale / distance * (90.0 * ninth - 36.0 * cube) * inverse**2
    return rows


def nine_three_inverse(
    pressure: np.ndarray, distance: float, depth: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gaps at which the 9-3 form has given pressures, p >= 0.

    With the distance :math:`r_0` and the depth :math:`w_0` of the minimum, and
    :math:`y = (r_0/g)^2`, four steps of Newton's method solve
    :math:`y^5 - y^2 = 2 r_0 p / 9 w_0`. The relative error is below 1e-10 up to a
    pressure of :math:`27 w_0/r_0`, the stiffness at the minimum times its distance, and
    below 2e-4 up to 160 times this pressure.

    Returns
    -------
    gap, exact, stiffness : ndarray, shape (k,)
        Gaps, and the exact pressure and stiffness at these gaps.
    """
    unit = 4.5 * depth / distance
    right = pressure / unit
    y = np.sqrt(np.sqrt(1.0 + (4.0 / 3.0) * right))
    for _ in range(4):
        square = y * y
        cube = square * y
        y -= (square * (cube - 1.0) - right) / (y * (5.0 * cube - 2.0))
    inverse, square = np.sqrt(y), y * y
    cube = square * y
    exact = unit * square * (cube - 1.0)
    stiffness = (unit / distance) * (square * inverse) * (10.0 * cube - 4.0)
    return distance / inverse, exact, stiffness


def smooth_tail(x: np.ndarray, length: float, work: float) -> np.ndarray:
    """Return the tail with the pressure ``-(12 w/D^2) x (1 - x/D)^2``, zero beyond D.

    Here x is the gap minus the distance of the minimum, D the length of the tail, and w
    the depth of the minimum.
    """
    t = np.minimum(x / length, 1.0)
    rest, tension = 1.0 - t, 12.0 * work / length
    return np.stack(
        (
            -work * rest**3 * (1.0 + 3.0 * t),
            -tension * t * rest**2,
            tension / length * rest * (1.0 - 3.0 * t),
        )
    )


def switched_off(rows: np.ndarray, x: np.ndarray, width: float) -> np.ndarray:
    """Return a form times the factor ``1 - 10 t^3 + 15 t^4 - 6 t^5``, t = x/width.

    Here x is the gap minus the gap at which the factor begins to fall from one to zero.
    """
    t = np.minimum(x / width, 1.0)
    factor = 1.0 - t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    slope = -30.0 * (t * (1.0 - t)) ** 2 / width
    curvature = -60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / width**2
    energy, pressure, _ = rows
    product = factor * rows
    product[1] -= slope * energy
    product[2] += curvature * energy - 2.0 * slope * pressure
    return product


def taylor(rows: np.ndarray, overlap: np.ndarray) -> np.ndarray:
    """Return the second-order Taylor polynomial of a form about a gap.

    The overlap is the gap of the form minus the gap at which the polynomial is wanted.
    """
    energy, pressure, stiffness = rows
    rise = stiffness * overlap
    return np.stack(
        (energy + overlap * (pressure + 0.5 * rise), pressure + rise, stiffness)
    )
