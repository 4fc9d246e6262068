"""Messages about scenes: short, quick, and in the words and units of the file."""

import pytest

from ase_roughcontact.scene import Scene

LONG = "a" * 1_000_000


@pytest.mark.parametrize(
    "text",
    [
        f'[substrate]\nmaterial = "Cu"\n[sphere]\nprofile = "{LONG}"',
        f"[sphere]\n{LONG} = 1",
        f"[{LONG}]",
        f"[path]\nvalues = [{'1.0,' * 100_000} nan]",
        f"[sphere]\nradius = -{'1' * 4000}",
    ],
    ids=range(5),
)
def test_long_words_and_lists_are_shortened(text):
    with pytest.raises(ValueError, match=r"got|unknown|must be") as error:
        Scene.parse(text).check()
    assert len(str(error.value)) < 300


SMALL_WINDOW = """
substrate = { material = "Cu", shape = [8, 8] }
sphere = { unit = "a0", radius = 60.0 }
path = { control = "penetration", values = [2.0] }
"""


def test_the_error_at_the_edge_of_a_window_names_only_what_a_scene_has():
    with pytest.raises(RuntimeError, match=r"give a larger shape.*'auto'\)$"):
        list(Scene.parse(SMALL_WINDOW).relax())


DOMAIN = """
substrate = { material = "Cu", shape = [40, 40], periodic = true }
roughness = { unit = "a0", long_wavelength = 8.0, domain = 32.0 }
path = { values = [1.0] }
"""


def test_a_domain_below_window_or_contact_is_an_error_with_the_length_needed():
    with pytest.raises(ValueError, match=r"a domain of at least 40 spacings$"):
        list(Scene.parse(DOMAIN).relax())
    assert len(list(Scene.parse(DOMAIN.replace("32.0", "40.0")).relax())) == 1
    text = DOMAIN.replace(", shape = [40, 40], periodic = true", "")
    with pytest.raises(ValueError, match=r"a domain of \d+ grid spacings, .* nm"):
        list(Scene.parse(text.replace("1.0", "1e4")).relax())


LOADS = """
substrate = { material = "Cu" }
roughness = { unit = "a0", long_wavelength = 16.0, domain = 64.0 }
path = { control = "load", values = %s }
"""


def test_loads_that_are_too_large_can_be_left_out():
    message = r"load of 1e\+06 to 1e\+08 nN: atoms .*; or leave out these 2 steps"
    with pytest.raises(ValueError, match=message):
        Scene.parse(LOADS % [1.0, 10.0, 1e6, 1e8]).check_path()


COARSE = """
substrate = { material = "Cu", model = "continuum", coarsen = %d }
roughness = { unit = "a0", long_wavelength = 64.0 }
path = { values = [5.0] }
"""


@pytest.mark.parametrize(
    ("coarsen", "message"),
    [
        (64, r"64 .* 64 a0: choose at most 32, or 2 "),
        (12, r"12 .* 256 a0: choose a domain of 264 a0, .* Å$"),
    ],
)
def test_a_grid_too_coarse_for_the_roughness_says_what_to_choose(coarsen, message):
    scene = Scene.parse(COARSE % coarsen)
    for run in (scene.plan, lambda: list(scene.relax(validity="ignore"))):
        with pytest.raises(ValueError, match=f"^coarsen = {message}"):
            run()


def test_a_grid_coarser_than_the_first_window_can_be_given():
    (step,) = Scene.parse(COARSE % 32).relax(validity="ignore")
    assert step.converged


@pytest.mark.parametrize(
    "keys, message",
    [
        ('domain = "12 nm"', r"long_wavelength = 20.48 nm, got 12 nm"),
        ('long_wavelength = "3 a0"', r"short_wavelength = 4 a0, got 3 a0"),
    ],
)
def test_lengths_of_roughness_in_the_wrong_order_have_the_unit_that_was_given(
    keys, message
):
    solid = '[substrate]\ncontact_modulus = "9 GPa"\nspacing = "0.04 nm"\n'
    text = f"{solid}[roughness]\n{keys}\n"
    with pytest.raises(ValueError, match=message):
        Scene.parse(text).check()
