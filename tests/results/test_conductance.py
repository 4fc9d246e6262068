"""Conductance of every wall and solid, against a dense punch of the contact region."""

import numpy as np
import pytest
from built import atoms_under
from solids import CONTINUA, spring_crystal

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap, conductance
from ase_roughcontact.elasticity import Isotropic

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

WALLS = {
    "hard": rc.HardWall(),
    "plastic": rc.PlasticWall(0.05),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.02),
    "full": rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.02),
    "exponential": rc.ExponentialWall(0.02, 0.5),
    "power-law": rc.PowerLawWall(0.02, 0.5),
    "dugdale": rc.DugdaleWall(0.02, 0.5),
}
SOLIDS = {
    "two bodies": Isotropic(1.0, 0.3, dundurs=0.1),
    "spring crystal": spring_crystal,
    **CONTINUA,
}
ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, domain=128.0, seed=1)
SPHERE = rc.RoughSphere(100.0, ROUGH)
ASKED = rc.Output(columns=["conductance"])


def love(x, y):
    """Displacement at x, y by a unit pressure on a unit cell, with E* = 1."""
    total = 0.0
    for i in (-0.5, 0.5):
        for j in (-0.5, 0.5):
            a, b = x + i, y + j
            term = a * np.arcsinh(b / abs(a)) + b * np.arcsinh(a / abs(b))
            total = total + np.sign(i * j) * term
    return total / np.pi


def of_cells(cells):
    """Conductance of some cells of a half space, in units of the spacing."""
    i, j = cells.nonzero()
    compliance = love(np.subtract.outer(i, i), np.subtract.outer(j, j))
    return 2.0 * np.linalg.solve(compliance, np.ones(i.size)).sum()


def of_periodic_cells(cells):
    """Conductance of some cells of a periodic one, with the mean plane at zero."""
    n, m = cells.shape
    q = 2.0 * np.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(m))
    waves = np.divide(2.0, q, where=q > 0.0, out=np.zeros_like(q))
    kernel = np.fft.ifft2(waves).real
    i, j = cells.nonzero()
    compliance = kernel[np.subtract.outer(i, i) % n, np.subtract.outer(j, j) % m]
    return 2.0 * np.linalg.solve(compliance, np.ones(i.size)).sum()


def pressed(wall=None, depth=0.6, **options):
    """Step and contact region of a rough sphere that is pressed in."""
    atoms = atoms_under(SPHERE, wall or rc.HardWall(), (32, 32), **options)
    window = "fixed" if options.get("periodic") else "auto"
    (step,) = rc.load_path(atoms, penetrations=[depth], window=window, output=ASKED)
    seen = ContactMap.from_atoms(atoms)
    assert step.converged and seen.contact_area == step.contact_area
    assert seen.contact.sum() > 30
    return step, seen


@pytest.mark.parametrize("name", WALLS)
def test_conductance_under_every_wall_agrees_with_a_dense_punch(name):
    step, seen = pressed(WALLS[name])
    assert step.conductance == pytest.approx(of_cells(seen.contact), rel=1e-6)


@pytest.mark.parametrize("name", WALLS)
def test_conductance_of_a_periodic_cell_agrees_with_a_dense_punch(name):
    step, seen = pressed(WALLS[name], 0.3, periodic=True)
    expected = of_periodic_cells(seen.contact)
    assert step.conductance == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", SOLIDS)
def test_conductance_of_every_solid_agrees_with_an_isotropic_half_space(name):
    solid = SOLIDS[name]
    step, seen = pressed(solid=solid() if callable(solid) else solid)
    assert step.conductance == pytest.approx(of_cells(seen.contact), rel=1e-6)


def test_conductance_of_a_solid_that_creeps_follows_from_each_contact():
    solid = rc.Viscoelastic(1.0, rc.Creep.standard_solid(relaxed=0.2, time=1.0))
    atoms = atoms_under(SPHERE, rc.HardWall(), (32, 32), solid=solid, fixed=False)
    loads = rc.Schedule(0.0).step(1.0).hold(2.0)
    for step in rc.time_path(atoms, loads=loads, tolerance=0.1, output=ASKED):
        seen = ContactMap.from_atoms(atoms).contact
        assert step.conductance == pytest.approx(of_cells(seen), rel=1e-6)
    assert seen.sum() > 30


@pytest.mark.parametrize("radius, part", [(8, 0.9891), (16, 0.9935), (30, 0.9965)])
def test_conductance_of_a_circle_is_what_cells_leave_of_its_diameter_times_two(
    radius, part
):
    x = np.arange(-radius - 2, radius + 3)
    circle = np.hypot(x[:, None], x) <= radius
    seen = ContactMap(1.0 * circle, circle, 1.0, (x[0], x[0]), periodic=False)
    a = np.sqrt(circle.sum() / np.pi)
    assert conductance(seen) / (4.0 * a) == pytest.approx(part, abs=1e-4)
    if radius < 20:
        assert conductance(seen) == pytest.approx(of_cells(circle), rel=1e-6)


def test_a_full_periodic_contact_has_an_infinite_conductance():
    flat = rc.RoughSphere(np.inf)
    atoms = atoms_under(flat, rc.HardWall(), (8, 8), periodic=True, fixed=False)
    (step,) = rc.load_path(atoms, loads=[1.0], output=ASKED)
    assert step.repulsive_atoms == 64
    assert step.conductance == np.inf


def test_without_contact_there_is_no_conductance():
    atoms = atoms_under(SPHERE, rc.HardWall(), (32, 32))
    (step,) = rc.load_path(atoms, penetrations=[-0.5], output=ASKED)
    assert step.conductance == 0.0


def test_conductance_of_a_map_agrees_with_its_step():
    step, seen = pressed(spacing=0.5)
    assert conductance(seen, resistivity=4.0) == pytest.approx(step.conductance / 4.0)
    step, seen = pressed(WALLS["adhesive"], 0.3, periodic=True)
    assert conductance(seen) == pytest.approx(step.conductance)


def test_a_plastic_contact_does_not_lose_its_conductance():
    """All atoms at the hardness: no force would change, but a current flows."""
    step, seen = pressed(rc.PlasticWall(1e-4))
    assert step.plastic_atoms == step.repulsive_atoms
    assert step.contact_stiffness == 0.0
    assert step.conductance == pytest.approx(of_cells(seen.contact), rel=1e-6)
