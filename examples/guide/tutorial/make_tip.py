"""Make ``tip.txt``, the scan of the tutorial: a blunt tip seen by a microscope.

    python make_tip.py

The tip has a radius of 25 nm, self-affine roughness with a root mean square of 0.25 nm
between 5 and 24 nm, and the scan a noise of 0.02 nm on 64 x 64 pixels of 0.75 nm.
"""

import numpy as np

POINTS, PIXEL, RADIUS, ROUGHNESS, NOISE = 64, 0.75, 25.0, 0.25, 0.02  # lengths in nm

rng = np.random.default_rng(8)
x = PIXEL * (np.arange(POINTS) - 0.5 * (POINTS - 1))
q = np.fft.fftfreq(POINTS, PIXEL)
q = np.hypot(q[:, None], q)
wave = (q > 1 / 24) & (q < 1 / 5)
amplitude = np.where(wave, np.where(wave, q, 1.0) ** -1.8, 0.0)
rough = np.fft.ifft2(amplitude * np.fft.fft2(rng.normal(size=q.shape))).real
height = -(x[:, None] ** 2 + x**2) / (2 * RADIUS) + ROUGHNESS * rough / rough.std()
height += rng.normal(0.0, NOISE, height.shape)
side = PIXEL * POINTS
head = f"Channel: Height\nWidth: {side:g} nm\nHeight: {side:g} nm\nValue units: nm"
np.savetxt("tip.txt", height.T - height.min(), fmt="%.3f", header=head)
