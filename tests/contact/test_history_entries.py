"""History of a surface: only declared entries are kept, wherever the surface goes."""

from dataclasses import dataclass

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.info import field_of
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.contact.history import HistoryEntry, declare, entry_of, is_entry
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.loading.load_path import AtomsPath
from ase_roughcontact.loading.trajectory import read_frames
from ase_roughcontact.paths.path_steps import NumberedSteps

# How often an atom was in contact, and how long it has been free; new atoms forever.
TIMES = declare(HistoryEntry("times_in_contact", in_frames=True))
FREE = declare(HistoryEntry("steps_without", entering=100.0))


@dataclass
class Counting(NumberedSteps):
    """Steps with a law that needs what happened to each atom."""

    def relax(self, last, number):
        relaxed, history = super().relax(last, number)
        before, contact = last.state.on(relaxed.state.window), relaxed.fields.contact
        none = np.zeros(contact.shape)
        times = before.history.get(TIMES.name, none) + contact
        free = before.history.get(FREE.name, none + FREE.entering) + 1.0
        kept = {TIMES.name: times, FREE.name: np.where(contact, 0.0, free)}
        return relaxed, history | kept


def counted(loads, **output):
    """Atoms after a path in windows that grow, and its results."""
    atoms = atoms_under(rc.RoughSphere(60.0), rc.HardWall(), (8, 8), fixed=False)
    files = rc.Output(**output) if output else None
    options = {"window": "auto", "validity": "ignore"}
    path = AtomsPath(atoms, LOAD, output=files, **options)
    steps = list(path.follow(Counting(path.stepper, np.array(loads))))
    return atoms, steps


def kept(atoms, name):
    n = round(len(atoms) ** 0.5)
    return atoms.arrays[name][:-1].reshape(n, n)


LOADS = [0.5, 5.0, 60.0, 20.0]


def test_an_entry_of_ones_own_survives_windows_that_grow():
    atoms, steps = counted(LOADS)
    assert len({step.window for step in steps}) > 1
    times, free = kept(atoms, TIMES.name), kept(atoms, FREE.name)
    # each atom within the smallest contact has touched in all steps
    assert times.max() == 4.0
    counts = [step.repulsive_atoms for step in steps]
    assert [int((times >= n).sum()) for n in (1, 2, 3, 4)] == sorted(counts)[::-1]
    assert int((free == 0.0).sum()) == counts[-1]
    assert int((free == 1.0).sum()) == counts[2] - counts[3]
    assert free.max() >= FREE.entering + 1.0  # atoms that never touched


def test_an_entry_of_ones_own_survives_that_the_path_is_resumed(tmp_path):
    whole, _ = counted(LOADS)
    for count in (1, 2, 3):
        file = tmp_path / f"{count}.npz"
        counted(LOADS[:count], restart=file)
        resumed, _ = counted(LOADS, restart=file, resume=True)
        for name in (TIMES.name, FREE.name):
            np.testing.assert_array_equal(kept(resumed, name), kept(whole, name))


def test_frames_have_the_entries_that_are_declared_so(tmp_path):
    atoms, _ = counted(LOADS, trajectory=tmp_path / "p.traj")
    *_, frame = read_frames(tmp_path / "p.traj")
    times = kept(atoms, TIMES.name)
    np.testing.assert_array_equal(field_of(frame, TIMES.name, times.shape), times)
    assert FREE.name not in frame.info
    frame.calc = rc.RoughContact(**atoms.calc.parameters)
    with pytest.raises(ValueError, match="steps_without"):
        frame.get_potential_energy()  # never a fresh surface


def test_a_snapshot_has_all_entries():
    atoms, _ = counted(LOADS)
    again = rc.snapshot(atoms)
    again.calc = rc.RoughContact(**atoms.calc.parameters)
    again.get_potential_energy()
    free = kept(atoms, FREE.name)
    np.testing.assert_array_equal(field_of(again, FREE.name, free.shape), free)


def test_what_is_not_declared_is_not_kept():
    state = rc.State.flat(Box((0, 0), (4, 4)), 1.0)
    with pytest.raises(ValueError, match="'age'"):
        state.keeping(age=np.zeros((4, 4)))


def test_an_entry_has_the_shape_of_the_window():
    state = rc.State.flat(Box((0, 0), (4, 4)), 1.0)
    with pytest.raises(ValueError, match=r"\(4, 4\).*\(3, 3\)"):
        state.keeping(**{FREE.name: np.zeros((3, 3))})


@pytest.mark.parametrize(
    "name, declared",
    [
        ("creep_pressure_2", True),
        ("plastic_depth", True),
        ("plastic_depth7", False),
        ("slipping2", False),
    ],
)
def test_only_names_that_end_with_an_underscore_are_numbered(name, declared):
    assert is_entry(name) == declared


def test_atoms_that_enter_a_window_have_the_declared_value():
    state = rc.State.flat(Box((0, 0), (2, 2)), 1.0)
    state = state.keeping(**{FREE.name: np.zeros((2, 2))})
    larger = state.on(Box((-1, 0), (4, 2))).history[FREE.name]
    assert larger.tolist() == [[100.0] * 2, [0.0] * 2, [0.0] * 2, [100.0] * 2]


def test_two_entries_of_one_name_are_an_error():
    assert declare(HistoryEntry("times_in_contact", in_frames=True)) == TIMES
    with pytest.raises(ValueError, match="times_in_contact"):
        declare(HistoryEntry("times_in_contact", "s"))


def test_entries_of_the_package_have_units():
    units = {"plastic_depth": "Å", "traction_x": "eV/Å^3", "creep_pressure_2": "eV/Å^3"}
    assert {name: entry_of(name).unit for name in units} == units
