"""Messages about scenes: short, quick, and in the words and units of the file."""

import time

import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene

LONG = "a" * 1_000_000
DOTS = ".".join("a" * 100_000)


@pytest.mark.parametrize(
    "text",
    [
        f'sphere = "{LONG}"',
        f'[sphere]\nprofile = "{LONG}"',
        f"[sphere]\n{LONG} = 1",
        f"[{LONG}]",
        f"{LONG} = 1",
        f"[path]\nvalues = [{'1.0,' * 100_000} nan]",
        f"[sphere]\nradius = -{'1' * 4000}",
    ],
    ids=range(7),
)
def test_long_words_and_lists_are_shortened(text):
    with pytest.raises(ValueError, match=r"got|unknown|must be") as error:
        Scene.parse(text).check()
    assert len(str(error.value)) < 300


@pytest.mark.parametrize(
    "text",
    [f"[roughness]\n{DOTS} = 1", f"[{DOTS}]", f"sphere = {{ {DOTS} = 1 }}"],
    ids=["key", "section", "inline"],
)
def test_a_key_of_many_parts_is_refused_at_once(text):
    start = time.perf_counter()
    with pytest.raises(ValueError, match="a key has 100000 parts"):
        Scene.parse(text)
    assert time.perf_counter() - start < 2.0


@pytest.mark.parametrize(
    "option", [f"{DOTS}=1", f"roughness.{DOTS}=1", f"sphere.radius={{{DOTS}=1}}"]
)
def test_a_key_of_many_parts_in_an_option_is_refused_at_once(option, capsys):
    start = time.perf_counter()
    assert main(["ensemble", "--set", option]) == 2
    assert time.perf_counter() - start < 2.0
    assert len(capsys.readouterr().err) < 500


def test_dots_in_values_and_comments_are_no_keys():
    numbers = ", ".join(["1.5"] * 2000)
    scene = Scene.parse(f"# {'.' * 500}\n[path]\nvalues = [{numbers}]")
    assert len(scene.steps) == 2000


SMALL_WINDOW = """
substrate = { shape = [8, 8] }
sphere = { radius = 60.0 }
path = { control = "penetration", values = [2.0] }
"""


def test_the_error_at_the_edge_of_a_window_names_only_what_a_scene_has():
    with pytest.raises(RuntimeError, match=r"give a larger shape or 'auto'$"):
        list(Scene.parse(SMALL_WINDOW).relax())


DOMAIN = """
substrate = { shape = [40, 40], periodic = true }
roughness = { long_wavelength = 8.0, domain = 32.0 }
path = { values = [1.0] }
"""


def test_a_domain_below_the_window_is_an_error_in_spacings_as_the_key_is():
    with pytest.raises(ValueError, match=r"a domain of at least 40 spacings$"):
        list(Scene.parse(DOMAIN).relax())
    assert len(list(Scene.parse(DOMAIN.replace("32.0", "40.0")).relax())) == 1


def test_a_domain_below_the_contact_is_an_error_in_spacings_as_the_key_is():
    text = DOMAIN.replace("shape = [40, 40], periodic = true", "")
    with pytest.raises(ValueError, match=r"a domain of \d+ spacings or more$"):
        list(Scene.parse(text.replace("1.0", "1e4")).relax())
