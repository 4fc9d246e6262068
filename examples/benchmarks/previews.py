"""CPU time and true errors of previews, against the runs that they show.

    OMP_NUM_THREADS=1 python previews.py             # all scenes
    OMP_NUM_THREADS=1 python previews.py adhesive    # those whose names begin so

Run and preview take turns, three times; times are the least of one thread, with making
the scene of the preview and writing the files, and may vary by a tenth. Errors are
relative to the area of the run, that of atoms or of the continuum, at the same step. Of
runs so short that they are their own previews only the time is printed.
"""

import sys
import tempfile
import time

from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.preview import preview

TURNS = 3
SCENE = """
[substrate]
{substrate}
[sphere]
unit = "a0"
radius = {radius}
{rough}
[interaction]
{wall}
[path]
{path}
"""
WORK = 'kind = "{}"\nwork_of_adhesion = {}'


def scene(
    seed=None,
    radius=1000,
    slope=0.1,
    long=128.0,
    hurst=0.8,
    short=4.0,
    wall='kind = "repulsive"',
    substrate='material = "Si"',
    path=(10.0, 3000.0, 12),
):
    """Return a scene; without a seed that of a smooth sphere."""
    if not isinstance(path, str):
        ends = "first = {}, last = {}, steps = {}".format(*path)
        path = f'loads = {{ {ends}, scale = "geometric" }}'
    rough = ""
    if seed is not None:
        rough = (
            f"[roughness]\nunit = 'a0'\nseed = {seed}\nrms_slope = {slope}\n"
            f"hurst = {hurst}\nlong_wavelength = {long}\nshort_wavelength = {short}"
        )
    return Scene.parse(
        SCENE.format(
            substrate=substrate, radius=radius, rough=rough, wall=wall, path=path
        )
    )


def scenes():
    """Return scenes by name."""
    hard = 'kind = "hard"'
    found = {
        f"built-in {seed}": Scene.default().with_values({"roughness.seed": seed})
        for seed in (1, 2, 3)
    }
    found["smooth repulsive"] = scene()
    found["smooth hard"] = scene(wall=hard)
    found["smooth adhesive"] = scene(wall=WORK.format("adhesive", 0.05))
    layer = 'material = "Si"\nlayer_thickness = "10 nm"\nlayer_contact_modulus = 20.0'
    layer += '\nmodel = "atoms"'
    ends = 'first = "0.2 nm", last = "2 nm", steps = 12, scale = "geometric"'
    depths = f"penetrations = {{ {ends} }}"
    large = {"radius": 5000, "slope": 0.02, "long": 256.0, "hurst": 0.6}
    families = {
        "hard": {"wall": hard},
        "hard large": large | {"wall": hard, "path": (20.0, 2e4, 10)},
        "repulsive": {},
        "repulsive large": large | {"path": (20.0, 2e4, 10)},
        "repulsive small": {"radius": 100, "long": 64.0, "path": (1.0, 20.0, 6)},
        "adhesive 0.05": {"wall": WORK.format("adhesive", 0.05)},
        "adhesive 0.5": {"slope": 0.05, "wall": WORK.format("adhesive", 0.5)},
        "dugdale": {
            "radius": 500,
            "slope": 0.08,
            "long": 64.0,
            "wall": WORK.format("dugdale", 0.05),
            "path": (5.0, 800.0, 12),
        },
        "full": {
            "radius": 100,
            "slope": 0.05,
            "long": 32.0,
            "wall": WORK.format("full", 0.02),
            "path": (0.5, 100.0, 10),
        },
        "plastic": {
            "substrate": 'material = "Cu"',
            "wall": 'kind = "plastic"',
            "path": (10.0, 1000.0, 12),
        },
        "crystal of EMT": {
            "substrate": 'calculator = "emt"\nmaterial = "Au"',
            "radius": 800,
            "slope": 0.08,
            "long": 64.0,
            "path": (4.0, 1000.0, 12),
        },
        "continuum": {
            "substrate": 'material = "Si"\nmodel = "continuum"',
            "wall": hard,
        },
        "layer": {"substrate": layer, "path": (2.0, 500.0, 12)},
        "long waves": {"short": 16.0},
        "penetration": {"path": depths},
        "loop": {
            "radius": 300,
            "slope": 0.05,
            "long": 64.0,
            "wall": WORK.format("adhesive", 0.1),
            "path": 'kind = "loop"\ndeepest = 3.0',
        },
        "24 steps": {"hurst": 0.5, "wall": hard, "path": (20.0, 5000.0, 24)},
    }
    for name, values in families.items():
        for seed in (5, 6, 7):
            found[f"{name} {seed}"] = scene(seed, **values)
    return found


def timed(full, shown=lambda full: full):
    """Return CPU time (s) and steps of a run, or of what is shown of it."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.process_time()
        given = shown(full)
        steps = list(given.run(folder, validity="ignore"))
        if given.path.count(given.bodies) is None:  # of a loop the deepest state
            steps = [given.path.extremes(given.bodies, steps)[0]]
        return time.process_time() - start, steps


def compared(full):
    """Return both times, and relative errors and their estimates."""
    coarse = preview(full)
    turns = [(timed(full), timed(full, preview)) for _ in range(TURNS)]
    seconds = [min(run[0] for run in runs) for runs in zip(*turns, strict=True)]
    (_, exact), (_, shown) = turns[0]
    errors = []
    if coarse is full:
        return *seconds, errors
    for target, step in zip(coarse.targets, shown, strict=True):
        by_target = full.path.count(full.bodies) is not None
        number = abs(full.targets - target).argmin() if by_target else -1
        area = getattr(exact[number], full.area_column)
        error = abs(getattr(step, coarse.area_column) - area)
        errors.append((error / area, step.area_error / area))
    return *seconds, errors


def main():
    """Print a line for each scene, and how many errors are within two estimates."""
    timed(Scene.default().with_values({"path.steps": 2}))
    chosen = {
        name: full
        for name, full in scenes().items()
        if any(name.startswith(start) for start in sys.argv[1:] or [""])
    }
    print("scene               run (s)  part  error of the area / estimate")
    every = []
    for name, full in chosen.items():
        run, shown, errors = compared(full)
        text = " ".join(f"{error:.3f}/{estimate:.3f}" for error, estimate in errors)
        text = text or "the run itself"
        print(f"{name:<20}{run:7.2f}{shown / run:6.2f}  {text}", flush=True)
        every += errors
    kept = sum(error <= 2.0 * estimate for error, estimate in every)
    print(f"{kept} of {len(every)} errors in {len(chosen)} scenes within twice")


if __name__ == "__main__":
    main()
