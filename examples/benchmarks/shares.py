"""Where the time of one large contact goes, and how much of it threads can share.

    OMP_NUM_THREADS=1 python shares.py --wall hard --contact 512

Prints the share of each part in the time of the processor, from a cold start and in one
thread, after the roughness has been made. Then the time without the results of the
step, relative to that of as many convolutions as there were pairs of transforms. The
last line is the share of what threads divide among them, p, and the speed-up on k
processors that Amdahl's law allows, 1/(1 - p + p/k).
"""

import argparse
import time
from functools import wraps

import numpy as np
from windows import WALLS, load_of, make_atoms, memory

from ase_roughcontact import LennardJones93, LoadStep, RoughSphere, load_path
from ase_roughcontact._util import kernels
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.elasticity import halfspace
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.optimize.base import ContactOptimizer

RESULTS = "results of the step, contact stiffness included"


class Clock:
    """Time of the processor in parts, each without the parts that it calls."""

    def __init__(self):
        self.seconds = {}
        self.running = []  # names and times of parts that the present one has called

    def part(self, owner, name, label):
        """Time a function; `label` is a name or a function of its first argument."""
        function = getattr(owner, name)

        @wraps(function)
        def timed(first, *args, **kwargs):
            part = label if isinstance(label, str) else label(first)
            if self.running and self.running[0][0] == RESULTS:
                return function(first, *args, **kwargs)
            self.running.append([part, 0.0])
            start = time.process_time()
            try:
                return function(first, *args, **kwargs)
            finally:
                took = time.process_time() - start
                _, inner = self.running.pop()
                self.seconds[part] = self.seconds.get(part, 0.0) + took - inner
                if self.running:
                    self.running[-1][1] += took

        setattr(owner, name, timed)


def precision(transform):
    single = transform.dtype == np.float32
    return "transforms of the model, single precision" if single else "convolutions"


def shared_by_threads(transform):
    points = transform.grid[0] * transform.grid[1]
    return "shared" if points >= transform.blocking.single_thread_points else "alone"


def watch():
    """Return the clock of the parts, and that of the work for threads."""
    parts, shared = Clock(), Clock()
    parts.part(RealFFT2, "filter", precision)
    parts.part(RealFFT2, "__init__", "spectra and plans")
    parts.part(FreeHalfSpace, "spectrum", "spectra and plans")
    parts.part(LennardJones93, "evaluate", "wall")
    parts.part(RoughSphere, "heights", "heights of the surface")
    parts.part(ContactOptimizer, "step", "vectors of the solver")
    of = LoadStep.of.__func__
    recorder = type("Recorder", (), {"of": of})
    parts.part(recorder, "of", RESULTS)
    LoadStep.of = classmethod(recorder.of)
    for module in (kernels, halfspace):
        shared.part(module, "thread_map", "shared")
    shared.part(RealFFT2, "filter", shared_by_threads)
    return parts.seconds, shared.seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--radius", type=float, default=1e4)
    parser.add_argument("--wall", choices=WALLS, default="hard")
    parser.add_argument("--contact", type=float, default=1024.0)
    options = parser.parse_args()
    atoms = make_atoms(options.radius, options.wall)
    load = load_of(options.contact, options.radius)
    parts, shared = watch()
    start = time.process_time()
    (record,) = load_path(atoms, loads=[load], window="auto")
    total = time.process_time() - start
    parts["atoms and windows"] = total - sum(parts.values())
    for part, seconds in sorted(parts.items(), key=lambda item: -item[1]):
        print(f"{100 * seconds / total:5.1f} %  {part}")
    solid, pair = contact_of(atoms).halfspace, []
    for _ in range(6):
        start = time.process_time()
        solid.displacement(np.ones(solid.shape))
        pair.append(time.process_time() - start)
    relaxed = (total - parts[RESULTS]) / (record.pairs * min(pair))
    print(
        f"{options.wall}, contact radius {options.contact:g}, window {record.window}: "
        f"{record.pairs:.0f} pairs, {relaxed:.2f} times its own pairs without results, "
        f"{memory():.2f} GB"
    )
    p = shared["shared"] / total
    limits = ", ".join(f"{1 / (1 - p + p / k):.1f} on {k}" for k in (2, 4, 8, 16))
    print(f"{100 * p:.0f} % shared by threads; at most {limits}")


if __name__ == "__main__":
    main()
