"""Comparison of the frames of a trajectory with snapshots of atoms."""

import pytest

from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.info import field_of

#: Entries of the `info` of a frame that a path adds.
ADDED = {"load_step", "path"}
#: Entries of the `info` of a snapshot that the frames of a path leave out.
LEFT_OUT = {"past_depth", "traction_depth", "creep_pressure_1", "pressure_rate"}
#: Difference by single precision.
ROUNDING = {"rel": 1e-6, "abs": 1e-6}


def plain(value):
    """A value of `info` with lists in place of tuples, as files return it."""
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    return list(value) if isinstance(value, tuple) else value


def assert_is_snapshot(frame, snapshot):
    """A frame of a path is the snapshot of atoms in the same state."""
    grid = SurfaceGrid.of(snapshot)
    assert SurfaceGrid.of(frame) == grid
    assert frame.positions == pytest.approx(snapshot.positions, **ROUNDING)
    assert frame.cell.array == pytest.approx(snapshot.cell.array)
    assert (frame.symbols == snapshot.symbols).all()
    assert (frame.get_tags() == snapshot.get_tags()).all()
    charges = snapshot.get_initial_charges()
    assert frame.get_initial_charges() == pytest.approx(charges, **ROUNDING)
    assert repr(frame.constraints) == repr(snapshot.constraints)
    energy = snapshot.get_potential_energy(apply_constraint=False)
    assert frame.get_potential_energy(apply_constraint=False) == pytest.approx(energy)
    assert frame.info.keys() - ADDED == snapshot.info.keys() - LEFT_OUT
    for key in frame.info.keys() - ADDED:
        found, expected = plain(frame.info[key]), plain(snapshot.info[key])
        if isinstance(expected, str) and key not in ("indenter", "support"):
            found, expected = (
                field_of(each, key, grid.window) for each in (frame, snapshot)
            )
            assert found == pytest.approx(expected, **ROUNDING)
        elif isinstance(expected, (dict, str)):
            assert found == expected
        elif key == "history":
            assert set(found) == set(expected)
        else:
            assert found == pytest.approx(expected)
