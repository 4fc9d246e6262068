"""Stress below a sliding sphere in closed forms.

The pressure on the surface is sqrt(1 - r^2/a^2), and the traction along x is the
pressure times the friction. The z axis points upward; depths are positive.

References
----------
G. M. Hamilton, Proc. Inst. Mech. Eng. C 197, 53 (1983); K. L. Johnson, Contact
Mechanics (1985), Sec. 3.4.
"""

import numpy as np


def on_the_axis(depth, a, nu, friction):
    """All components below the centre of the contact."""
    t = depth / a
    angle = t * np.arctan(1 / t)
    lateral = -((1 + nu) * (1 - angle) - 0.5 / (1 + t * t))
    shear = 1 - 1.5 * angle + 0.5 * t * t / (1 + t * t)
    return np.array([lateral, lateral, -1 / (1 + t * t), 0, friction * shear, 0])


def on_the_surface(x, y, a, nu, friction):
    """All components inside of the contact."""
    r = np.hypot(x, y)
    p, cosine, sine = np.sqrt(1 - (r / a) ** 2), x / r, y / r
    part = (1 - 2 * nu) / 3 * (a / r) ** 2 * (1 - p**3)
    radial, hoop = part - p, -part - 2 * nu * p
    xx = cosine**2 * radial + sine**2 * hoop
    yy = sine**2 * radial + cosine**2 * hoop
    xy = cosine * sine * (radial - hoop)
    slope = friction * np.pi / a
    xx -= slope * x * (4 + nu) / 8
    yy -= slope * x * 3 * nu / 8
    xy -= slope * y * (2 - nu) / 8
    return np.array([xx, yy, -p, 0, friction * p, xy])


def normal_and_trace(x, y, depth, a, nu, friction):
    """Component zz, and the sum of xx, yy and zz, at any point off the axis."""
    r2, z2 = x * x + y * y, depth * depth
    square = r2 + z2 - a * a
    size = np.sqrt(square**2 + 4 * a * a * z2)
    m, n = np.sqrt((size + square) / 2), np.sqrt((size - square) / 2)
    angle = np.arctan(a / m)
    normal = -n + a * depth * m / size
    normal += friction * depth * x * n / (2 * r2) * (1 - (r2 + z2 + a * a) / size)
    trace = 2 * (depth * angle - n) - friction * x * (angle - a * m / (m * m + a * a))
    return normal / a, (1 + nu) * trace / a
