"""The FFT engines under the half space: which one is fastest on this machine.

    python fft.py --sizes 16 64 256 1024 --threads 1 2

Prints, for each window of a free half space and number of threads, the least time in
milliseconds of one elastic evaluation, the displacement by a pressure, and its ratio to
the time with pyfftw. The engines take turns, so that other work on the machine slows
all of them. scipy.fft, which is not an engine of the package, is called for the same
blocks of rows and columns. Threads suffer from other work: run it on a quiet machine.
"""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from time import perf_counter

import numpy as np
import scipy.fft

from ase_roughcontact.elasticity.fft_backends import BlockTransform
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace


class ScipyTransform(BlockTransform):
    """Transforms by scipy.fft."""

    engine = "scipy"

    def rows_forward(self, spectra: np.ndarray) -> None:
        """Transform rows."""
        spectra[:] = scipy.fft.rfft(self.rows[: len(spectra)], overwrite_x=True)

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """Transform rows back."""
        length, options = self.rows.shape[1], {"norm": "forward", "overwrite_x": True}
        self.rows[: len(spectra)] = scipy.fft.irfft(spectra, length, **options)

    def columns_forward(self, count: int) -> None:
        """Transform columns."""
        columns = self.columns[:, :count]
        columns[:] = scipy.fft.fft(columns, axis=0, overwrite_x=True)

    def columns_inverse(self, count: int) -> None:
        """Transform columns back."""
        columns, options = self.columns[:, :count], {"norm": "forward", "axis": 0}
        columns[:] = scipy.fft.ifft(columns, overwrite_x=True, **options)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    sizes = [16, 32, 64, 128, 256, 512, 1024, 2048]
    parser.add_argument("--sizes", type=int, nargs="+", default=sizes)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeat", type=int, default=20)
    options = parser.parse_args()
    engines = ["pyfftw", "scipy"]
    if find_spec("ducc0") is None:
        print("ducc0: skipped, not installed")
    else:
        engines.append("ducc0")

    print(f"{'window':>6} threads engine {'ms':>10} ratio")
    for size in options.sizes:
        for threads in options.threads:
            times = least_times(engines, size, threads, options.repeat)
            for engine, time in times.items():
                ratio = time / times["pyfftw"]
                row = f"{size:6} {threads:7} {engine:6} {1e3 * time:10.3f} {ratio:5.2f}"
                print(row, flush=True)


def least_times(
    engines: list[str], size: int, threads: int, repeat: int
) -> dict[str, float]:
    """Least times of an elastic evaluation by engine (seconds)."""
    window = (size, size)
    pressure = np.random.default_rng(0).random(window)
    solids = {
        engine: FreeHalfSpace(window, 1.0, 1.0, engine=engine, threads=threads)
        for engine in engines
    }
    for solid in solids.values():
        solid.displacement(pressure)  # its first call prepares others
    least = dict.fromkeys(engines, np.inf)
    for _ in range(repeat):
        for engine, solid in solids.items():
            start = perf_counter()
            solid.displacement(pressure)
            least[engine] = min(least[engine], perf_counter() - start)
    return least


if __name__ == "__main__":
    main()
