"""Stress by loads on a disc, as integrals of the closed forms of point forces."""

import numpy as np


def boussinesq(x, y, z, nu):
    """Stress by a unit force into the solid, z into the solid (Johnson, 3.19)."""
    r2, rho = x * x + y * y, np.sqrt(x * x + y * y + z * z)
    part, near = (1 - 2 * nu) / r2, 1 - z / rho
    xx = (
        part * (near * (x * x - y * y) / r2 + z * y * y / rho**3)
        - 3 * z * x * x / rho**5
    )
    yy = (
        part * (near * (y * y - x * x) / r2 + z * x * x / rho**3)
        - 3 * z * y * y / rho**5
    )
    zz = -3 * z**3 / rho**5
    xy = part * (2 * near * x * y / r2 - x * y * z / rho**3) - 3 * x * y * z / rho**5
    yz, xz = -3 * y * z * z / rho**5, -3 * x * z * z / rho**5
    return np.stack([xx, yy, zz, yz, xz, xy]) / (2 * np.pi)


def cerruti(x, y, z, nu):
    """Stress by a unit force along x, z into the solid (Johnson, 3.76)."""
    rho = np.sqrt(x * x + y * y + z * z)
    part, sum2 = 1 - 2 * nu, rho * (rho + z) ** 2
    cube, last = rho**2 * sum2, rho**2 * (rho + z) ** 3
    xx = -3 * x**3 / rho**5 + part * (
        x / rho**3 - 3 * x / sum2 + x**3 / cube + 2 * x**3 / last
    )
    yy = -3 * x * y * y / rho**5 + part * (
        x / rho**3 - x / sum2 + x * y * y / cube + 2 * x * y * y / last
    )
    zz = -3 * x * z * z / rho**5
    xy = -3 * x * x * y / rho**5 + part * (
        -y / sum2 + x * x * y / cube + 2 * x * x * y / last
    )
    yz, xz = -3 * x * y * z / rho**5, -3 * x * x * z / rho**5
    return np.stack([xx, yy, zz, yz, xz, xy]) / (2 * np.pi)


def hertz_stress(point, a, nu, friction):
    """Stress at a point by a pressure sqrt(1 - r^2/a^2) and a traction along x.

    The z axis points upward, out of the solid; depths are positive.
    """
    x, y, depth = point
    nodes, weights = np.polynomial.legendre.leggauss(80)
    angle = np.pi * (nodes + 1) / 2  # r = a sin(angle/2)
    r = a * np.sin(angle / 2)
    weight = weights * np.pi / 2 * a / 2 * np.cos(angle / 2) * r * np.cos(angle / 2)
    directions = 2 * np.pi * (np.arange(400) + 0.5) / 400
    dx = x - r[:, None] * np.cos(directions)
    dy = y - r[:, None] * np.sin(directions)
    stress = boussinesq(dx, dy, depth, nu) + friction * cerruti(dx, dy, depth, nu)
    total = (stress * weight[:, None]).sum(axis=(1, 2)) * 2 * np.pi / 400
    total[3:5] *= -1  # z upward
    return total
