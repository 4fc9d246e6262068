"""Memory of a step in a window, estimated and compared with the free memory."""

from __future__ import annotations

import math
from pathlib import Path

import psutil

try:
    import resource
except ImportError:  # on Windows
    resource = None  # type: ignore[assignment]

from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.interactions import Interaction

# Memory for each atom at the peak of a step under a hard wall on a periodic half space.
_PERIODIC_HARD_BYTES = 80
# Memory for each atom at the peak of a step under a hard wall on a free half space.
_FREE_HARD_BYTES = 140
# Memory for each atom at the peak of a step under a soft wall without attraction.
_SOFT_BYTES = 255
# Memory for each atom at the peak of a step under any wall on any solid.
_LARGEST_BYTES = 350
# Memory for each atom in the rectangle around the tractions of friction.
_FRICTION_BYTES = 900
# Further memory for each of these atoms if the tractions are coupled to the pressure.
_COUPLING_BYTES = 500
# Memory of figures, and for each atom of the frames that are drawn one after another.
_FIGURE_BYTES, _FIGURE_ATOM_BYTES = 22e6, 280
# Memory for each point of a roughness while it is synthesised.
_SYNTHESIS_BYTES = 30
# Memory for each point of a roughness afterwards.
_ROUGHNESS_BYTES = 11
#: Memory of Python and its libraries, including the libraries for figures: up to
#: 60 MB less in some installations.
LIBRARY_BYTES = 165e6
#: Memory of the libraries for figures.
DRAWING_BYTES = 27e6
# Memory in addition to the libraries that is not checked: reading the limits would take
# a tenth of a step in a small window.
_UNCHECKED_BYTES = 100e6


def memory_of(
    window: tuple[int, int],
    wall: Interaction | None = None,
    solid: ElasticSolid | None = None,
    *,
    points: int = 0,
    periodic: bool = False,
) -> float:
    """Estimate the peak memory of a process that calculates a step.

    Parameters
    ----------
    window : (int, int)
        Number of atoms along x and y.
    wall, solid : optional
        Wall and substrate; by default the ones that need most memory.
    points : int
        Number of points of a roughness synthesised from its spectrum; see
        `Topography.points`.
    periodic : bool
        Whether the half space is periodic.

    Returns
    -------
    float
        Memory in bytes: 165 MB, assumed for Python and its libraries, and the memory of
        the step. With the actual memory of the libraries it is between 3/4 and 4/3
        of the largest resident size of a fresh process. Atoms of ASE, measured height
        maps, and other data of the process add to it.
    """
    per_atom = _LARGEST_BYTES
    if wall and solid and not wall.attractive and solid.creep is None:
        hard = _PERIODIC_HARD_BYTES if periodic else _FREE_HARD_BYTES
        per_atom = hard if wall.hard and not wall.plastic else _SOFT_BYTES
    step = math.prod(window) * per_atom
    synthesis, roughness = _SYNTHESIS_BYTES * points, _ROUGHNESS_BYTES * points
    return LIBRARY_BYTES + max(synthesis, roughness + step)


def friction_memory(atoms: int, coupled: bool = False) -> float:
    """Estimate the memory of friction, in addition to a step, for a number of atoms."""
    return float((_FRICTION_BYTES + coupled * _COUPLING_BYTES) * atoms)


def figure_memory(atoms: int) -> float:
    """Estimate the peak memory of a process that draws frames of a number of atoms."""
    return LIBRARY_BYTES + _FIGURE_BYTES + _FIGURE_ATOM_BYTES * atoms


def peak_memory() -> float:
    """Return the largest resident memory of this process so far (bytes).

    On systems other than Linux it is the present one.
    """
    try:
        text = Path("/proc/self/status").read_text("utf-8")
    except OSError:
        return float(psutil.Process().memory_info().rss)
    (line,) = [each for each in text.splitlines() if each.startswith("VmHWM:")]
    return 1024.0 * int(line.split()[1])


def available_memory() -> float:
    """Return the memory that this process can still use (bytes).

    It is the available memory of the machine, or the unused part of a limit of the
    process's control groups (containers, batch systems) or of its address space
    (``ulimit -v``), if that is less.
    """
    free = float(psutil.virtual_memory().available)
    return min(free, control_group_memory(), _address_space())


def control_group_memory(root: Path = Path("/")) -> float:
    """Return the unused part of the memory limits of control groups on Linux.

    Parameters
    ----------
    root : Path
        Folder that contains ``proc`` and ``sys``.

    Returns
    -------
    float
        Bytes; infinity without limits.
    """
    try:
        lines = (root / "proc/self/cgroup").read_text("utf-8").splitlines()
    except OSError:
        return math.inf
    free = math.inf
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers in ("", "memory"):  # versions 2 and 1
            top = root / "sys/fs/cgroup" / controllers
            group = top / path.lstrip("/")
            # the limits of all groups above hold, too; a container has the top one
            free = min(free, *map(_unused_in_group, [group, *group.parents]))
    return free


def _unused_in_group(folder: Path) -> float:
    """Return the unused part of the limit of a control group, if it has one (bytes)."""
    for limit, usage, cache in (
        ("memory.max", "memory.current", "inactive_file"),
        ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
    ):
        try:
            allowed = int((folder / limit).read_text("utf-8"))  # or "max"
            used = int((folder / usage).read_text("utf-8"))
            lines = (folder / "memory.stat").read_text("utf-8").splitlines()
        except (OSError, ValueError):
            continue
        # cached files that are not in use give way
        cached = int(dict(line.split() for line in lines).get(cache, 0))
        return max(0.0, float(allowed - used + cached))
    return math.inf


def _address_space() -> float:
    """Return the unused part of the limit of the address space (bytes)."""
    if resource is None:
        return math.inf
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if allowed == resource.RLIM_INFINITY:
        return math.inf
    return max(0.0, float(allowed - psutil.Process().memory_info().vms))


def check_roughness(points: int) -> None:
    """Raise `MemoryError` if a roughness exceeds the free memory."""
    side = math.isqrt(points)
    _check(
        memory_of((0, 0), points=points),
        f"to synthesise a random field on a domain of {side} x {side} points",
        "choose a smaller domain (by default 4 times the longest wavelength)",
    )


def check_memory(
    window: tuple[int, int],
    wall: Interaction | None = None,
    solid: ElasticSolid | None = None,
    *,
    bound: str = "",
) -> None:
    """Raise `MemoryError` if a window exceeds the free memory.

    Parameters
    ----------
    window, wall, solid
        See `memory_of`.
    bound : str
        Words before the size of the window in the message, such as "at least ".
    """
    _check(
        memory_of(window, wall, solid),
        f"for a window of {bound}{window[0]} x {window[1]} atoms",
        "choose a smaller load, sphere or window",
    )


def _check(needed: float, purpose: str, advice: str) -> None:
    if needed < LIBRARY_BYTES + _UNCHECKED_BYTES:
        return
    available = available_memory()
    if needed > available:
        raise MemoryError(
            f"about {needed / 1e9:.3g} GB of memory are needed {purpose}, but only "
            f"{available / 1e9:.3g} GB are free: {advice}"
        )
