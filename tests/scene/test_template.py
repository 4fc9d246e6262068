"""The built-in scene file has the default values unless a comment says otherwise."""

import re
from itertools import takewhile

import pytest

from ase_roughcontact.interactions import WALLS
from ase_roughcontact.scene import Scene, default_text

LINES = default_text().splitlines()


def key_lines(mark):
    """Return line numbers and comments of the keys outside of [path]."""
    found, title = {}, None
    for number, line in enumerate(LINES):
        title = (re.match(r"\[(\w+)\]", line) or [None, title])[1]
        key = re.match(rf"{mark}(\w+) = ", line)
        if key and title != "path":
            more = takewhile(lambda line: line[:1] == " ", LINES[number + 1 :])
            comments = [each.partition("# ")[2] for each in (line, *more)]
            found[f"{title}.{key[1]}"] = number, " ".join(comments)
    return found


GIVEN, COMMENTED = key_lines(""), key_lines("#")


def scene_with(number, line, changes=()):
    """Return the scene of the file with a line and some words replaced."""
    text = "\n".join([*LINES[:number], line, *LINES[number + 1 :]])
    for old, new in dict(changes).items():
        text = text.replace(old, new)
    return Scene.parse(text)


def wall_with(key):
    """Return the changes that make a wall with a parameter."""
    name = key.partition(".")[2]
    kind = next(kind for kind, wall in WALLS.items() if name in wall.parameters)
    changes = {'kind = "repulsive"': f'kind = "{kind}"'}
    if "work_of_adhesion" in WALLS[kind].parameters:
        changes["#work_of"] = "work_of"
    return changes


@pytest.mark.parametrize("key", GIVEN)
def test_values_are_the_defaults_or_the_comment_gives_the_default(key):
    number, comment = GIVEN[key]
    stated = re.search(r"default (\"[^\"]*\"|[\w.]+)", comment)
    line = f"{key.partition('.')[2]} = {stated[1]}" if stated else LINES[number]
    without, given = scene_with(number, ""), scene_with(number, line)
    if key == "sphere.radius":  # its default depends on the rest of the scene
        assert without.radius == given.radius
    else:
        assert not without.changes_from(given)
    assert bool(stated) == (scene_with(number, line) != Scene.default())


@pytest.mark.parametrize("key", COMMENTED)
def test_commented_keys_are_valid_and_the_comment_gives_the_default(key):
    number, comment = COMMENTED[key]
    changes = wall_with(key) if key.startswith("interaction") else {}
    given = scene_with(number, LINES[number][1:], changes)
    given.check()
    stated = re.search(r"default (true|false|\d+(?! times)|\"\w+\")", comment)
    if stated:
        line = f"{key.partition('.')[2]} = {stated[1]}"
        usual, absent = (scene_with(number, x, changes) for x in (line, ""))
        assert (usual.surface, usual.wall) == (absent.surface, absent.wall)


@pytest.mark.parametrize("key", ["spacing", "contact_modulus", "elastic_constants"])
def test_commented_material_parameters_agree_with_the_crystal(key):
    number, _ = COMMENTED[f"substrate.{key}"]
    usual, given = Scene.default(), scene_with(number, LINES[number][1:])
    assert given.substrate != usual.substrate
    assert given.spacing == pytest.approx(usual.spacing, rel=0.01)
    assert given.contact_modulus == pytest.approx(usual.contact_modulus, rel=0.01)
