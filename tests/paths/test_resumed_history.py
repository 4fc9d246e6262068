"""A path is resumed on the surface with which it began, or on which it ended."""

import pytest

import ase_roughcontact as rc
from ase_roughcontact import Output, Schedule
from ase_roughcontact.elasticity import Creep, Isotropic, Viscoelastic
from ase_roughcontact.loading.trajectory import read_frames

SPHERE = rc.RoughSphere(60.0)
PLASTIC = rc.PlasticWall(0.01, permanent=True)
CREEPING = Viscoelastic(0.8, Creep([1.0], [1.0]))


def pressed(atoms, parts, **options):
    return rc.load_path(
        atoms, penetrations=[0.8, 1.0, 1.2, 1.1][: parts + 1], **options
    )


def slid(atoms, parts, **options):
    options["displacements"] = [0.0, 0.4, 0.2, 0.3][: parts + 1]
    return rc.sliding_path(atoms, rc.Coulomb(0.3), penetrations=1.0, **options)


def held(atoms, parts, **options):
    path = Schedule(0.8)
    for _ in range(parts):
        path = path.ramp(path.last + 0.2, time=1.0)
    return rc.time_path(atoms, penetrations=path, tolerance=0.3, **options)


# Path, wall, solid, and an entry of the history that the path leaves.
KINDS = {
    "plastic depth": (pressed, PLASTIC, Isotropic(0.8), "plastic_depth"),
    "slip": (slid, rc.HardWall(), Isotropic(0.8, 0.3), "traction_x"),
    "creep": (held, rc.HardWall(), CREEPING, "creep_pressure_1"),
}


@pytest.fixture(params=KINDS)
def kind(request):
    """Make new atoms, the function that follows parts of a path, and an entry."""
    path, wall, solid, entry = KINDS[request.param]

    def new():
        atoms = rc.substrate("Cu", (16, 16), SPHERE, spacing=2.5)
        atoms.calc = rc.RoughContact(SPHERE, solid=solid, wall=wall)
        return atoms

    def followed(atoms, parts, file):
        output = Output(trajectory=file, resume=True)
        steps = path(atoms, parts, validity="ignore", output=output)
        return [step.normal_force for step in steps]

    return new, followed, entry


def test_a_path_of_new_atoms_is_not_resumed_on_atoms_with_a_history(kind, tmp_path):
    new, followed, entry = kind
    followed(new(), 1, tmp_path / "a.traj")
    atoms = new()
    followed(atoms, 2, tmp_path / "b.traj")
    with pytest.raises(ValueError, match=entry):
        followed(atoms, 2, tmp_path / "a.traj")


def test_a_path_of_atoms_with_a_history_is_not_resumed_on_new_atoms(kind, tmp_path):
    new, followed, entry = kind

    def with_history():
        atoms = new()
        followed(atoms, 2, tmp_path / "b.traj")
        return atoms

    file = tmp_path / "a.traj"
    first = followed(with_history(), 1, file)
    with pytest.raises(ValueError, match=entry):
        followed(new(), 2, file)
    longer = followed(with_history(), 2, file)
    assert longer[: len(first)] == first
    assert len(longer) > len(first)


def test_a_path_is_resumed_on_the_atoms_on_which_it_ended(kind, tmp_path):
    new, followed, _ = kind
    atoms = new()
    first = followed(atoms, 1, tmp_path / "a.traj")
    longer = followed(atoms, 2, tmp_path / "a.traj")
    assert longer[: len(first)] == first
    assert len(longer) > len(first)


def test_the_rounding_of_frames_is_not_another_history(tmp_path):
    file = tmp_path / "a.traj"
    atoms = rc.substrate("Cu", (16, 16), SPHERE, spacing=2.5)
    calculator = {"contact_modulus": 0.8, "wall": PLASTIC}
    atoms.calc = rc.RoughContact(SPHERE, **calculator)
    list(pressed(atoms, 1, output=Output(trajectory=file)))
    *_, seen = read_frames(file)
    seen.calc = rc.RoughContact(SPHERE, **calculator)
    steps = list(pressed(seen, 2, output=Output(trajectory=file, resume=True)))
    assert len(steps) == 3
