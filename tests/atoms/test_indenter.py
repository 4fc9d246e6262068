"""The indenter atom: the surface it stands for, and the work of a load."""

import pytest
from ase.constraints import FixAtoms, FixCartesian, Hookean
from ase.io import read

import ase_roughcontact as rc
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.view import with_indenter
from ase_roughcontact.topography.base import surface_id

ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=3)
MAP = ROUGH.heights((16, 16), 1.0, (-8.0, -8.0))
SPHERE = rc.RoughSphere(40.0, ROUGH)


class Plain:
    """Heights alone, without `todict`."""

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        return SPHERE.heights(shape, spacing, origin)


def make_atoms(built_for=SPHERE, calculated_with=SPHERE, load=0.0, **options):
    atoms = rc.substrate("Cu", (12, 12), built_for, spacing=1.0, **options)
    atoms.calc = rc.RoughContact(calculated_with, 1.0, load=load)
    return atoms


# Identity

OTHERS = [
    rc.RoughSphere(41.0, ROUGH),
    rc.RoughSphere(40.0),
    rc.RoughSphere(40.0, rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=4)),
    rc.RoughSphere(40.0, rc.HeightMap(MAP, 1.0)),
    ROUGH,
]


@pytest.mark.parametrize("other", OTHERS, ids=repr)
def test_an_indenter_that_differs_from_the_atoms_is_refused(other):
    atoms = make_atoms(calculated_with=other, height=30.0)
    with pytest.raises(ValueError, match="built for the indenter RoughSphere-") as info:
        atoms.get_potential_energy()
    assert surface_id(other) in str(info.value)
    del atoms.info["indenter"]
    with pytest.raises(ValueError, match="built for another indenter"):
        atoms.get_potential_energy()
    atoms.set_tags(0)
    assert atoms.get_potential_energy() == 0.0


@pytest.mark.parametrize(
    "same", [rc.RoughSphere(40, rc.SelfAffine(0.1, 0.8, 4, 16, seed=3)), Plain()]
)
def test_equal_and_nameless_indenters_are_accepted(same):
    expected = make_atoms(height=-0.5).get_potential_energy()
    assert expected > 0.0
    for atoms in (make_atoms(calculated_with=same, height=-0.5),
                  make_atoms(built_for=same, height=-0.5)):  # fmt: skip
        assert atoms.get_potential_energy() == pytest.approx(expected)


@pytest.mark.parametrize("name", ["a.traj", "a.extxyz"])
def test_frames_from_files_know_their_indenter(tmp_path, name):
    rc.snapshot(make_atoms(height=-0.5)).write(tmp_path / name)
    frame = read(tmp_path / name)
    for atoms in (frame.copy(), rc.restore(frame, 1.0)):
        atoms.calc = rc.RoughContact(OTHERS[0], 1.0)
        with pytest.raises(ValueError, match="built for the indenter"):
            atoms.get_potential_energy()
    for look in (ContactMap.from_frame, with_indenter):
        with pytest.raises(ValueError, match="built for the indenter"):
            look(frame, OTHERS[0])
        look(frame, SPHERE)


# Load

FREE = [[], [FixCartesian([0], (True, True, False))], [Hookean(-1, (6, 6, 9), 0.1, 0)]]
FIXED = [[FixAtoms([-1])], [FixCartesian([-1], (False, False, True))]]


@pytest.mark.filterwarnings("ignore:the load of", "ignore:nothing holds")
@pytest.mark.parametrize("constraints", FREE + FIXED, ids=str)
def test_load_acts_on_a_free_indenter_only(constraints):
    loaded, unloaded = make_atoms(load=2.0, height=-0.5), make_atoms(height=-0.5)
    for atoms in (loaded, unloaded):
        atoms.set_constraint(constraints)
    acts = constraints in FREE
    work = loaded.get_potential_energy() - unloaded.get_potential_energy()
    assert work == pytest.approx(2.0 * -0.5 if acts else 0.0)
    forces = [
        atoms.get_forces(apply_constraint=False)[-1, 2] for atoms in (loaded, unloaded)
    ]
    assert forces[0] - forces[1] == pytest.approx(-2.0 if acts else 0.0)
    assert forces[1] == pytest.approx(loaded.calc.get_property("normal_force", loaded))


def test_a_load_on_a_fixed_indenter_warns_once():
    atoms = make_atoms(load=2.0)
    with pytest.warns(UserWarning, match="load of 2"):
        atoms.get_potential_energy()
    atoms.positions[-1, 2] -= 0.1
    atoms.get_potential_energy()
    atoms.calc.set(load=3.0)
    with pytest.warns(UserWarning, match="load of 3"):
        rc.NewtonKrylov(atoms).run(fmax=1e-2)
