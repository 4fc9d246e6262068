"""Frames of load paths: what they have, and that files return it."""

import gc
import weakref

import numpy as np
import pytest
from built import atoms_under
from same_frames import assert_is_snapshot

from ase_roughcontact import (
    DugdaleWall,
    Output,
    PlasticWall,
    RoughSphere,
    load_path,
    snapshot,
)
from ase_roughcontact.loading.trajectory import read_frames
from ase_roughcontact.scene import Scene

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

SPHERE = RoughSphere(radius=200.0)


@pytest.mark.parametrize(
    "wall, path, options",
    [
        (
            PlasticWall(0.02, permanent=True),
            {"loads": [2.0, 9.0, 3.0]},
            {"fixed": False},
        ),
        (
            PlasticWall(0.02, permanent=True),
            {"penetrations": [0.5, 1.0, 0.2], "window": "auto"},
            {},
        ),
        (DugdaleWall(0.02, 1.0), {"heights": [0.2, 0.1, 0.4]}, {"periodic": True}),
    ],
)
def test_frames_of_a_path_are_snapshots_of_its_atoms(tmp_path, wall, path, options):
    atoms = atoms_under(SPHERE, wall, (16, 14), modulus=0.8, spacing=2.5, **options)
    output = Output(trajectory=tmp_path / "a.traj")
    snapshots = [snapshot(atoms) for _ in load_path(atoms, output=output, **path)]
    frames = list(read_frames(output.trajectory))
    assert len(frames) == len(snapshots) == 3
    for frame, expected in zip(frames, snapshots, strict=True):
        assert_is_snapshot(frame, expected)


def test_a_frame_is_freed_without_a_collection_of_garbage(tmp_path):
    atoms = atoms_under(SPHERE, shape=(16, 14), modulus=0.8, spacing=2.5)
    list(
        load_path(
            atoms, penetrations=[0.1], output=Output(trajectory=tmp_path / "a.traj")
        )
    )
    gc.disable()
    try:
        (frame,) = read_frames(tmp_path / "a.traj")
        calculator = weakref.ref(frame.calc)
        del frame
        assert calculator() is None
    finally:
        gc.enable()


SCENE = """
[substrate]
symbol = "Cu"
contact_modulus = 100.0
hardness = 5.0
[sphere]
unit = "a0"
radius = 40.0
[interaction]
kind = "plastic"
permanent = true
[path]
control = "penetration"
values = [1.0, 2.0, 0.5]
"""


def test_frames_of_a_scene_are_snapshots_of_its_atoms(tmp_path):
    scene = Scene.parse(SCENE)
    list(scene.run(tmp_path / "run", validity="ignore"))
    atoms = scene.atoms()
    path = load_path(
        atoms, penetrations=scene.targets, window="auto", validity="ignore"
    )
    snapshots = [snapshot(atoms) for _ in path]
    frames = list(read_frames(tmp_path / "run" / "sweep.traj"))
    assert len(frames) == len(snapshots) == 3
    for frame, expected in zip(frames, snapshots, strict=True):
        assert_is_snapshot(frame, expected)
    assert np.any(frames[-1].info["plastic_depth"])
