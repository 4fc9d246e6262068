"""Rms height, slope and curvature of the roughness of a scene, by an FFT."""

import numpy as np


def amplitudes(scene):
    """Return rms height, slope and curvature of a period, by an FFT of its heights."""
    count = round(scene.rough.side / scene.spacing)
    heights = scene.rough.heights((count, count), scene.spacing)
    power = abs(np.fft.fft2(heights, norm="forward")) ** 2
    q = 2.0 * np.pi * np.fft.fftfreq(count, scene.spacing)
    square = q[:, None] ** 2 + q**2
    return [np.sqrt((square**power_of * power).sum()) for power_of in range(3)]
