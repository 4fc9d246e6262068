"""Crystals from ASE calculators, as elastic solids."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from ase.build import bulk
from ase.calculators.emt import EMT
from ase.units import GPa
from matscipy.elasticity import fit_elastic_constants
from spring_crystal import OtherSlabs, Softer, Springs, fcc_springs

from ase_roughcontact.elasticity import (
    Crystal,
    Cubic,
    PeriodicHalfSpace,
    StressField,
)
from ase_roughcontact.elasticity.crystals.force_constants import relaxed_slab

A = 3.6
SPACING = A / np.sqrt(2)


def make(calculator=None, crystal=None, **options):
    calculator = calculator or fcc_springs(A)[0]
    options = {"layers": 11, "size": 5, **options}
    return Crystal.from_calculator(calculator, crystal or bulk("Cu", a=A), **options)


@pytest.fixture(scope="module")
def springs():
    return make()


@pytest.fixture(scope="module")
def continuum():
    return Cubic(*fcc_springs(A)[1])


def test_figures_and_lattice_constant(springs):
    assert springs.spacing == pytest.approx(SPACING, rel=1e-9)
    assert abs(springs.stress) < 1e-8
    assert max(springs.figures.values()) < 2e-6
    assert springs.figures["interpolation"] < 1e-8


def test_stress_at_another_lattice_constant_agrees_with_layers_of_a_slab():
    springs, (c11, c12, _) = fcc_springs(A)
    with pytest.warns(UserWarning, match="1.14 GPa"):
        strained = make(springs, lattice_constant=1.01 * A)
    assert strained.spacing == pytest.approx(1.01 * SPACING)
    biaxial = (c11 + c12 - 2 * c12**2 / c11) * 0.01
    assert strained.stress == pytest.approx(biaxial, rel=0.01)
    assert strained.figures["long_waves"] < 1e-5

    energies, change = [], 1e-4
    for layers in (7, 9):
        for stretch in (1.01 - change, 1.01 + change):
            slab = relaxed_slab(springs, "Cu", "fcc100", stretch * A, layers)
            slab.calc = springs
            energies.append(slab.get_potential_energy())
    two_layers = energies[3] - energies[2] - energies[1] + energies[0]
    volume = 2 * np.ptp(slab.positions[3:5, 2]) * strained.spacing**2
    # both sides of a cell are stretched, each by 2 change/1.01
    work = 2 * (2 * change / 1.01) * volume
    assert strained.stress == pytest.approx(two_layers / work, rel=1e-3)


def test_bcc_surface():
    a = 2.9
    calculator = Springs({a * 3**0.5 / 2: 1.0, a: 0.4})
    crystal = make(calculator, bulk("Fe", "bcc", a=a), surface="bcc100")
    # a spring k at r has r_i r_j r_k r_l k/(2 V r^2) in C_ijkl, two atoms in a^3
    first, second = 1.0 / a, 0.4 / a
    continuum = Cubic(
        4 * 2 * first / 12 + 2 * second, 2 * first / 3, 2 * first / 3, x="100"
    )
    assert crystal.spacing == pytest.approx(a)
    assert crystal.contact_modulus == pytest.approx(continuum.contact_modulus, rel=1e-5)


def test_free_half_space_is_the_limit_of_large_periodic_cells(springs):
    at = np.array([0, 1, 3, 12, 40]), np.array([0, 0, 2, 11, 5])
    kernel = springs.cell_compliance(*at, SPACING)
    errors = []
    for n in (256, 512):
        pressure = np.zeros((n, n))
        pressure[0, 0] = 1.0
        half = PeriodicHalfSpace((n, n), SPACING, springs)
        large = np.diff(half.displacement(pressure)[at])
        errors.append(abs(large + np.diff(kernel)).max() / kernel[0])
    assert errors[1] < 0.15 * errors[0] < 1e-4


def test_tabulated_and_distant_kernels_meet(springs):
    i = np.array([44, 45, 46, 47, 48, 49, 50, 51])
    kernel = springs.cell_compliance(i, np.array(20), SPACING)
    assert abs(np.diff(kernel, 4)).max() < 1e-5 * kernel[0]
    far = np.array([4000]), np.array([1000])
    continuum = Cubic(*fcc_springs(A)[1]).cell_compliance(*far, SPACING)
    assert springs.cell_compliance(*far, SPACING) == pytest.approx(continuum, rel=1e-4)


def test_without_dispersion_it_is_the_continuum(springs, continuum):
    # the modulus of the longest waves for all of them
    table = np.zeros_like(springs.table)
    table[0] = (-1.0) ** np.arange(len(table)) @ springs.table
    flat = replace(springs, table=table)
    q = np.array([[1.0, 0.7, 0.2], [0.1, 0.7, -0.9]])
    expected = continuum.wave_compliance(*q)
    np.testing.assert_allclose(flat.wave_compliance(*q), expected, rtol=2e-5)
    i = np.array([0, 8, 30, 60]), np.array([0, 6, 30, 10])
    kernel = flat.cell_compliance(*i, SPACING)
    expected = continuum.cell_compliance(*i, SPACING)
    # pressure on an atom, not on a cell: an effect of (a0/r)^2/24
    np.testing.assert_allclose(kernel[1:], expected[1:], rtol=2e-3)
    np.testing.assert_allclose(kernel[3:], expected[3:], rtol=5e-5)
    assert kernel[0] == pytest.approx(expected[0], rel=0.05)
    # the coarse grids of the solvers
    kernels = [s.cell_compliance(*i, 2 * SPACING) for s in (springs, continuum)]
    np.testing.assert_allclose(*kernels, rtol=1e-5)


def test_a_grid_finer_than_the_atoms_is_refused(springs):
    with pytest.raises(ValueError, match=r"2\.5.*spacing=solid.spacing"):
        PeriodicHalfSpace((8, 8), 0.9 * SPACING, springs).compliance  # noqa: B018
    with pytest.raises(ValueError, match=r"2\.5.*spacing=solid.spacing"):
        springs.lateral_cell_compliance(1, 0, 2.0 * SPACING)


def test_file(springs, tmp_path):
    springs.write(tmp_path / "springs.json")
    same = Crystal.read(tmp_path / "springs.json")
    assert same.todict() == springs.todict()
    assert same.figures == springs.figures
    np.testing.assert_array_equal(same.table, springs.table)
    np.testing.assert_array_equal(same.lateral, springs.lateral)
    json.dumps(springs.todict())
    (tmp_path / "other.json").write_text('{"format": "other"}')
    with pytest.raises(ValueError, match=r"other.json .* format"):
        Crystal.read(tmp_path / "other.json")


@pytest.mark.parametrize(
    "change, message",
    [
        ({"table": [[1.0, 2.0], [3.0, 4.0]]}, r"table .* \(28, 20\)"),
        ({"table": np.zeros((28, 20)).tolist()}, "table .* positive"),
        ({"stress": np.nan}, "stress"),
        ({"symbol": 29}, "29"),
        ({"spacing": -1.0}, "spacing"),
        ({"surface": "fcc111"}, "fcc111"),
    ],
)
def test_a_changed_file_is_refused(springs, tmp_path, change, message):
    file = tmp_path / "springs.json"
    springs.write(file)
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(ValueError, match=f"springs.json.*{message}"):
        Crystal.read(file)


RNG = np.random.default_rng(1)


class Faulty(Springs):
    """Springs with results that a function of the atoms and the results changes."""

    def __init__(self, shells, change):
        super().__init__(shells)
        self.change = change

    def calculate(self, *args, **kwargs):
        super().calculate(*args, **kwargs)
        self.change(self.atoms, self.results)


def noise(atoms, results, size=1e-5):
    if len(atoms) > 50:
        results["forces"] += size * RNG.normal(size=(len(atoms), 3))


def springs_to_sites(atoms, results):
    if len(atoms) > 50:
        layers = atoms.positions[:, :2]
        away = layers - np.round(layers / SPACING * 2) * SPACING / 2
        results["forces"][:, :2] -= 0.1 * away


def no_energy_of_shear(atoms, results):
    sheared = abs(atoms.cell.angles() - 90.0).max() > 1e-6
    if atoms.pbc.all() and len(atoms) == 2 and sheared:
        results["energy"] = np.nan


def without_slabs(atoms, results):
    if not atoms.pbc.all():
        raise NotImplementedError("crystals only")


def faulty(change):
    return partial(Faulty, change=change)


def slabs(change):
    return partial(OtherSlabs, change=change)


@pytest.mark.parametrize(
    "kind, options, message",
    [
        (faulty(noise), {}, "'repetition'"),
        (faulty(partial(noise, size=1e-7)), {}, "increase displacement"),
        (faulty(springs_to_sites), {}, "'sum_rule'"),
        (Softer, {}, "'long_waves' .* larger displacement"),
        (slabs(lambda springs: springs[:1]), {}, "'long_waves'"),
        (slabs(lambda springs: springs * [1.001, 1.0]), {}, "'rest'"),
        (Springs, {"size": 3}, "'reach' .* increase size"),
        (faulty(lambda _, results: results["forces"].fill(0.0)), {}, "displacement"),
        (faulty(no_energy_of_shear), {}, "'long_waves' .* nan"),
        (faulty(lambda _, results: results.pop("forces")), {}, "no forces"),
        (faulty(without_slabs), {}, "no forces .* 11 layers.*crystals only"),
        (faulty(lambda _, results: results.pop("energy")), {}, "no energy"),
        (Springs, {"surface": "fcc111"}, "fcc111"),
        (Springs, {"layers": 12}, "odd"),
        (Springs, {"layers": 7}, "layers .* 9"),
        (Springs, {"displacement": 0.0}, "Springs .* get_hessian"),
        (Springs, {"displacement": 0.3}, "decrease displacement"),
        (Springs, {"lattice_constant": 1.2 * A}, "omit lattice_constant"),
        (Springs, {"crystal": "Xx"}, "Xx"),
        (Springs, {"crystal": "Fe"}, "surface='bcc100'"),
        (Springs, {"crystal": bulk("NaCl", "rocksalt", a=A)}, "one element"),
        (Springs, {"crystal": bulk("Cu", a=2 * A)}, "give lattice_constant"),
        (Springs, {"crystal": bulk("Cu", "hcp", a=SPACING)}, "Cubic"),
        (Springs, {"crystal": bulk("Cu", "bcc", a=2.9)}, "surface='bcc100'"),
    ],
)
def test_unsuitable_calculators_and_crystals_are_found_out(kind, options, message):
    calculator = kind(dict(fcc_springs(A)[0].shells))
    with pytest.raises(ValueError, match=message):
        make(calculator, **options)


@pytest.mark.slow
def test_copper_of_emt():
    copper = Crystal.from_calculator(EMT(), "Cu")
    assert copper.spacing * np.sqrt(2) == pytest.approx(3.5898, abs=1e-4)
    assert copper.contact_modulus / GPa == pytest.approx(152.99, rel=5e-4)
    assert copper.figures["thickness"] < 1e-5
    crystal = bulk("Cu", cubic=True, a=copper.spacing * np.sqrt(2))
    crystal.calc = EMT()
    fitted, _ = fit_elastic_constants(
        crystal, symmetry="cubic", delta=1e-4, verbose=False
    )
    continuum = Cubic(fitted[0, 0], fitted[0, 1], fitted[3, 3])
    assert copper.contact_modulus == pytest.approx(continuum.contact_modulus, rel=1e-3)
    for wavelength, expected in ((400, 163.20), (4, 182.4)):
        q = 2 * np.pi / (wavelength * copper.spacing)
        modulus = 2 / (q * copper.wave_compliance(q, 0.0)) / GPa
        assert modulus == pytest.approx(expected, rel=5e-4)
    q = 2 * np.pi / np.array([400.0, 800.0]) / copper.spacing
    at_400, at_800 = 2 / (q * copper.wave_compliance(q, 0.0))
    expected = 2 / (q[0] * continuum.wave_compliance(q[0], 0.0))
    assert 2 * at_800 - at_400 == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_copper_under_stress():
    with pytest.warns(UserWarning, match="0.704 GPa .* 3.61 Å"):
        copper = Crystal.from_calculator(EMT(), "Cu", lattice_constant=3.61)
    # a continuum under this stress; 3 % below the crystal without it
    assert copper.contact_modulus / GPa == pytest.approx(148.725, rel=1e-4)
    assert copper.figures["long_waves"] < 1e-5


def test_stress_below_the_surface_is_the_stress_of_the_continuum(springs, continuum):
    x = SPACING * np.arange(32)
    pressure = np.exp(
        -((x[:, None] - x[16]) ** 2 + (x - x[14]) ** 2) / (8 * SPACING**2)
    )
    found, expected = (
        StressField(solid, SPACING, pressure) for solid in (springs, continuum)
    )
    depth = 3.0 * SPACING
    np.testing.assert_allclose(found.stress(depth), expected.stress(depth), atol=2e-5)
    moved = expected.displacement(depth)
    size = abs(moved).max()
    np.testing.assert_allclose(found.displacement(depth), moved, atol=1e-4 * size)


def test_crystal_of_an_earlier_file_has_no_stress_below_its_surface(springs, tmp_path):
    springs.write(tmp_path / "crystal.json")
    again = Crystal.read(tmp_path / "crystal.json")
    assert again.has_subsurface
    np.testing.assert_array_equal(again.moduli, springs.moduli)
    earlier = replace(springs, moduli=None)
    assert not earlier.has_subsurface
    with pytest.raises(NotImplementedError, match="from_calculator"):
        StressField(earlier, SPACING, np.ones((8, 8))).stress(1.0)
