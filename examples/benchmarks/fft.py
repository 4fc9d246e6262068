"""The FFT engines under the half space: which one is fastest on this machine.

    python fft.py --sizes 1024 2048 4096 --threads 1 2

Prints, for each grid and number of threads, the least time in milliseconds of a
forward and an inverse real transform of the whole grid, and of one elastic evaluation:
the displacement of a window of half the grid's side, padded to the grid. For scipy.fft
these are the plain calls with fresh arrays; for pyfftw and ducc0 they are those of
`ase_roughcontact.elasticity.fft.RealFFT2`, which keeps plans and buffers and skips the
half of the padded grid that is zero. Last, the ratios to the default engine. Threads
suffer from other work on the machine: run it on a quiet one.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from time import perf_counter

import numpy as np
import scipy.fft

from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[1024, 2048, 4096])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeat", type=int, default=20)
    options = parser.parse_args()
    engines = ["scipy", "pyfftw"]
    if find_spec("ducc0") is None:
        print("ducc0: skipped, not installed")
    else:
        engines.append("ducc0")
    default = engines[-1]

    print(f"{'grid':>6} threads engine {'pair ms':>10} {'elastic ms':>11}  ratios")
    for size in options.sizes:
        for threads in options.threads:
            times = {
                engine: (
                    least(pair(engine, size, threads), options.repeat),
                    least(elastic(engine, size, threads), options.repeat),
                )
                for engine in engines
            }
            for engine, (whole, padded) in times.items():
                ratios = whole / times[default][0], padded / times[default][1]
                print(
                    f"{size:6} {threads:7} {engine:6} {1e3 * whole:10.2f} "
                    f"{1e3 * padded:11.2f} {ratios[0]:7.2f} {ratios[1]:.2f}"
                )


def least(function: Callable[[], object], repeat: int) -> float:
    """Least time of a call (seconds); the first one is not counted."""
    function()
    times = []
    for _ in range(repeat):
        start = perf_counter()
        function()
        times.append(perf_counter() - start)
    return min(times)


def pair(engine: str, size: int, threads: int) -> Callable[[], object]:
    """Forward and inverse transform of a whole grid."""
    values = np.random.default_rng(0).random((size, size))
    if engine == "scipy":

        def both() -> np.ndarray:
            spectrum = scipy.fft.rfft2(values, workers=threads)
            return scipy.fft.irfft2(spectrum, values.shape, workers=threads)

        return both
    transform = RealFFT2(values.shape, engine=engine, threads=threads)

    def planned() -> np.ndarray:
        transform.forward(values)
        return transform.inverse()

    return planned


def elastic(engine: str, size: int, threads: int) -> Callable[[], object]:
    """Displacement of a window by a pressure, padded to the grid."""
    window = (size // 2, size // 2)
    pressure = np.random.default_rng(0).random(window)
    if engine != "scipy":
        halfspace = FreeHalfSpace(window, 1.0, 1.0, engine=engine, threads=threads)
        return partial(halfspace.displacement, pressure)
    grid = (size, size)
    compliance = FreeHalfSpace(window, 1.0, 1.0).compliance

    def convolve() -> np.ndarray:
        spectrum = scipy.fft.rfft2(pressure, grid, workers=threads)
        spectrum *= -compliance
        whole = scipy.fft.irfft2(spectrum, grid, workers=threads)
        return whole[: window[0], : window[1]]

    return convolve


if __name__ == "__main__":
    main()
