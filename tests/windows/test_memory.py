"""Memory: the estimate compared with the largest resident size of a fresh process.

Python and its libraries need more or less in other installations: they are measured,
with the atoms.
"""

import json
import math
import resource
import subprocess
import sys
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.topography.topography import topography_of
from ase_roughcontact.windows.memory import (
    available_memory,
    check_memory,
    control_group_memory,
    memory_of,
)

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
from ase_roughcontact.windows.memory import memory_of

def peak():
    with open("/proc/self/status") as file:  # rusage would have the parent's memory
        (kilobytes,) = [int(line.split()[1]) for line in file if "VmHWM" in line]
    return 1024 * kilobytes

wall, cell, size, domain = *sys.argv[1:3], *map(int, sys.argv[3:])
shape = (8, 8) if cell == "auto" else (size, size)
periodic = cell == "periodic"

def atoms_under(sphere, wall, shape):
    atoms = substrate("Cu", shape, sphere, spacing=1.0, periodic=periodic, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, wall)
    return atoms

smooth = RoughSphere(1000.0)
small = atoms_under(smooth, HardWall(), (8, 8))
list(load_path(small, loads=[1e-3], window="unchecked", validity="ignore"))
atoms_under(smooth, HardWall(), shape)
base = peak()  # of Python, its libraries and the atoms
rough = domain and SelfAffine(0.1, 0.8, 4.0, 512.0, seed=1, domain=float(domain))
sphere = RoughSphere(1000.0, rough or None)
walls = {
    "hard": HardWall(),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.005),
}
atoms = atoms_under(sphere, walls[wall], shape)
load = 4.0 * (0.35 * size) ** 3 / (3.0 * 1000.0)
window = "auto" if cell == "auto" else "unchecked"
(step,) = load_path(atoms, loads=[load], window=window, accuracy=1e-2)
json.dump([base + step.memory - memory_of((0, 0)), peak(), step.converged], sys.stdout)
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


# Free memory


def test_free_memory_is_the_memory_of_the_machine_in_bytes():
    lines = Path("/proc/meminfo").read_text().splitlines()
    (kilobytes,) = (int(x.split()[1]) for x in lines if x.startswith("MemAvailable"))
    expected = min(1024.0 * kilobytes, control_group_memory())
    assert available_memory() == pytest.approx(expected, rel=0.05)


def test_free_memory_of_another_system_is_that_available_not_the_total(monkeypatch):
    memory = SimpleNamespace(total=8e9, available=123e6)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: memory)
    assert available_memory() == 123e6


def test_limit_of_the_address_space_is_seen():
    before = resource.getrlimit(resource.RLIMIT_AS)
    used = psutil.Process().memory_info().vms
    resource.setrlimit(resource.RLIMIT_AS, (used + 300_000_000, before[1]))
    try:
        assert available_memory() == pytest.approx(3e8, rel=0.1)
        with pytest.raises(MemoryError, match=r"0\.\d+ GB are free"):
            check_memory((3000, 3000))
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def files(folder, contents):
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        (folder / name).write_text(f"{content}\n")


def group(limit, used, cached):
    """Files of a control group of version 2."""
    stat = f"anon 7\ninactive_file {cached}"
    return {"memory.max": limit, "memory.current": used, "memory.stat": stat}


def old_group(limit, used, cached):
    """Files of a control group of version 1."""
    stat = f"cache 7\ninactive_file 1\ntotal_inactive_file {cached}"
    names = "memory.limit_in_bytes", "memory.usage_in_bytes", "memory.stat"
    return dict(zip(names, (limit, used, stat), strict=True))


CGROUP = "sys/fs/cgroup"
# Memory left, list of groups of the process, and files of groups by folder.
GROUPS = {
    "none": (math.inf, None, {}),
    "no limit": (math.inf, "0::/", {CGROUP: group("max", 5, 1)}),
    "container": (6e9, "0::/", {CGROUP: group(8 * 10**9, 3 * 10**9, 10**9)}),
    "seen from outside": (
        5e9,
        "0::/docker/1f",
        {CGROUP: group(8 * 10**9, 3 * 10**9, 0)},
    ),
    "of a parent": (
        1e9,
        "0::/slurm/job/step",
        {
            f"{CGROUP}/slurm/job": group(2 * 10**9, 10**9, 0),
            f"{CGROUP}/slurm/job/step": group("max", 10**9, 0),
        },
    ),
    "used up": (0.0, "0::/", {CGROUP: group(10**9, 2 * 10**9, 0)}),
    "version 1": (
        3e9,
        "5:cpu:/other\n4:memory:/job\n0::/",
        {
            f"{CGROUP}/memory": old_group(2**63 - 4096, 9, 0),
            f"{CGROUP}/memory/job": old_group(4 * 10**9, 2 * 10**9, 10**9),
        },
    ),
}


@pytest.mark.parametrize("left, lines, folders", GROUPS.values(), ids=GROUPS.keys())
def test_limits_of_control_groups_are_seen(left, lines, folders, tmp_path):
    if lines is not None:
        files(tmp_path / "proc/self", {"cgroup": lines})
    for folder, contents in folders.items():
        files(tmp_path / folder, contents)
    assert control_group_memory(tmp_path) == left


# Points of a roughness


def test_only_a_synthesised_roughness_has_points():
    for indenter in (ROUGH, RoughSphere(10.0, ROUGH)):
        assert topography_of(indenter).points(2.0) == 1024**2
    for indenter in (RoughSphere(10.0), HeightMap([[0.0, 1.0], [1.0, 0.0]], 1.0)):
        assert topography_of(indenter).points(2.0) == 0


def test_synthesising_a_roughness_may_need_more_memory_than_a_step():
    small, large = (100, 100), (4000, 4000)
    smooth, rough = memory_of(small), memory_of(small, points=4096**2)
    assert rough - smooth > 2.0 * (memory_of(large, points=4096**2) - memory_of(large))


def test_limits_are_not_read_for_little_memory(monkeypatch):
    """Reading takes a tenth of a small step; a window of 535 x 535 needs 100 MB."""
    monkeypatch.setattr("ase_roughcontact.windows.memory.available_memory", lambda: 0.0)
    check_memory((530, 530))
    with pytest.raises(MemoryError):
        check_memory((540, 540))
