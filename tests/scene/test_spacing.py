"""Spacing of solids without a crystal, and numbers in units of it."""

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.description import bodies
from ase_roughcontact.fitting.parameters import changed
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import JKR
from ase_roughcontact.windows.regrid import GridChange

TEXT = """
[substrate]
{substrate}
[sphere]
unit = "a0"
radius = {radius}
[interaction]
kind = {kind}
[path]
values = ["100 nN"]
"""


def scene(substrate='material = "PDMS"', radius='"10 um"', kind='"hard"', more=""):
    text = TEXT.format(substrate=substrate, radius=radius, kind=kind)
    return Scene.parse(text + more)


@pytest.mark.parametrize(
    "substrate", ['material = "PDMS"', 'contact_modulus = "1.76 MPa"']
)
def test_the_contact_of_a_smooth_sphere_has_a_radius_of_about_60_spacings(substrate):
    soft = scene(substrate)
    radius = np.sqrt(soft.bodies.hertz_area(soft.targets[0]) / np.pi)
    assert 40.0 < radius / soft.spacing < 90.0
    assert soft.plan().steps[0].memory < 0.5e9
    assert "fits the contact" in bodies(soft)["solid"]
    (step,) = soft.relax()
    assert step.continuum_area == pytest.approx(
        soft.bodies.hertz_area(step.normal_force), rel=1e-3
    )


def test_the_spacing_fits_an_adhesive_contact_which_is_larger():
    wall = '"dugdale"\nwork_of_adhesion = 0.04\nattraction_range = "200 nm"'
    soft = scene(kind=wall)
    work = 0.04 * UNITS["J/m^2"]
    radius = JKR(soft.radius, soft.contact_modulus, work).contact_radius(
        soft.targets[0]
    )
    assert soft.spacing == pytest.approx(radius / 60.0, rel=0.2)
    assert not soft.warnings


def test_the_spacing_that_fits_a_scene_is_kept_where_other_values_are_changed():
    soft = scene()
    finer = soft.with_grid(GridChange(4))
    assert (finer.spacing, finer.grid_change) == (soft.spacing, GridChange(4))
    harder = changed(soft, {"contact_modulus": 0.2})
    assert harder.spacing == soft.spacing != scene("contact_modulus = 0.2").spacing


def test_the_spacing_fits_the_relaxed_contact_of_a_path_in_time():
    series = "relaxation_moduli = [0.99]\nrelaxation_times = [1.0]"
    text = TEXT.replace('["100 nN"]', '[0.0, 100.0]\nkind = "time"\ntimes = [0.0, 1.0]')
    solid = f"contact_modulus = 0.2\n{series}"
    creeping = Scene.parse(
        text.format(substrate=solid, radius='"10 um"', kind='"hard"')
    )
    assert creeping.spacing == scene("contact_modulus = 0.002").spacing
    assert creeping.planned.spacing == creeping.spacing


@pytest.mark.parametrize(
    "options",
    [
        {"substrate": 'material = "PDMS"\nspacing = "2 nm"'},
        {"substrate": 'material = "PDMS"\nrefine = 2'},
        {"substrate": 'material = "PDMS"\nshape = [64, 64]'},
        {"substrate": 'symbol = "Si"'},
        pytest.param(
            {"substrate": 'material = "Cu"\ncalculator = "emt"'}, marks=pytest.mark.slow
        ),
        {"radius": '"40000 a0"'},
        {"more": '[roughness]\nlong_wavelength = "4 nm"\nshort_wavelength = "1 nm"'},
    ],
)
def test_a_spacing_that_is_given_known_or_a_unit_is_kept(options):
    default = {"spacing = ": 20.0, "Si": 3.84, "emt": 2.54}
    text = options.get("substrate", "")
    known = next((v for k, v in default.items() if k in text), 2.34)
    assert scene(**options).spacing == pytest.approx(known, rel=0.01)
