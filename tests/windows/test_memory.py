"""Memory: the estimate compared with the largest resident size of a fresh process."""

import json
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.windows.memory import memory_of, points_of

STATUS = Path("/proc/self/status")
pytestmark = pytest.mark.skipif(
    not STATUS.exists(), reason="the memory of a process is read there"
)
ROUGH = SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=512.0, seed=1)
# Sphere of 1000 spacings; of a periodic cell, and of a fixed window, that many atoms
# along a side, else of the contact of a rigid one.
STEP = """
import json, sys
from ase_roughcontact import HardWall, LennardJones93, RoughContact, RoughSphere
from ase_roughcontact import SelfAffine, load_path, substrate

wall, cell, size, domain = *sys.argv[1:3], *map(int, sys.argv[3:])
rough = domain and SelfAffine(0.1, 0.8, 4.0, 512.0, seed=1, domain=float(domain))
sphere = RoughSphere(1000.0, rough or None)
shape = (8, 8) if cell == "auto" else (size, size)
periodic = cell == "periodic"
atoms = substrate("Cu", shape, sphere, spacing=1.0, periodic=periodic, fixed=False)
walls = {
    "hard": HardWall(),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.005),
}
atoms.calc = RoughContact(sphere, 1.0, walls[wall])
load = 4.0 * (0.35 * size) ** 3 / (3.0 * 1000.0)
window = "auto" if cell == "auto" else "fixed"
(step,) = load_path(
    atoms, loads=[load], window=window, accuracy=1e-2, edge="ignore"
)
with open("/proc/self/status") as file:  # not that of the parent, as rusage has it
    (peak,) = [1024 * int(line.split()[1]) for line in file if "VmHWM" in line]
json.dump([step.memory, peak, step.converged], sys.stdout)
"""
slow = partial(pytest.param, marks=pytest.mark.slow)  # a process of its own each
WALLS = ("hard", "repulsive", "adhesive")
CELLS = ("auto", "periodic", "fixed")


@pytest.mark.parametrize(
    "wall, cell, size, domain",
    [
        ("repulsive", "auto", 256, 0),
        *(
            slow(wall, cell, size, domain)
            for wall in WALLS
            for cell in CELLS
            for size in (256, 512)
            for domain in (0, 2048)
        ),
        slow("repulsive", "auto", 256, 4096),
    ],
)
def test_estimate_is_within_a_third_of_the_memory_of_a_process(
    wall, cell, size, domain
):
    command = [sys.executable, "-c", STEP, wall, cell, str(size), str(domain)]
    done = subprocess.run(command, capture_output=True, text=True)
    estimate, peak, converged = json.loads(done.stdout)
    assert converged
    assert 3 / 4 <= estimate / peak <= 4 / 3


def test_only_a_synthesised_roughness_has_points():
    assert points_of(ROUGH, 2.0) == points_of(RoughSphere(10.0, ROUGH), 2.0) == 1024**2
    assert points_of(RoughSphere(10.0), 2.0) == 0
    assert points_of(HeightMap([[0.0, 1.0], [1.0, 0.0]], spacing=1.0), 1.0) == 0


def test_synthesising_a_roughness_may_need_more_memory_than_a_step():
    small, large = (100, 100), (4000, 4000)
    smooth, rough = memory_of(small), memory_of(small, points=4096**2)
    assert rough - smooth > 2.0 * (memory_of(large, points=4096**2) - memory_of(large))
