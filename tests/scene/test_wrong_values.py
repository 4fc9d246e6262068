"""Values that no key of a scene can have: each is refused in words of the file."""

import json

import pytest

from ase_roughcontact.interactions import WALLS
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.file import SECTIONS
from ase_roughcontact.scene.path_kind import PATHS

KINDS = {"path": PATHS, "interaction": WALLS}


def all_keys():
    """Yield section, kind (if it has kinds) and key."""
    for title, section in SECTIONS.items():
        for kind in KINDS.get(title, [None]):
            own = KINDS[title][kind] if kind else section
            keys = own.parameters if title == "interaction" else own.types()
            for key in (*keys, "kind") if kind else keys:
                yield title, kind, key


def refusal(title, kind, key, value):
    """Return the message about a value of TOML; empty if it is accepted."""
    lines = {} if kind is None else {"kind": json.dumps(kind)}
    entries = "\n".join(f"{k} = {v}" for k, v in (lines | {key: value}).items())
    try:
        Scene.parse(f"[{title}]\n{entries}")
    except ValueError as error:
        return str(error)
    return ""


def accepting(value):
    """Return the keys that accept a value; the others are named in one sentence."""
    found = set()
    for title, kind, key in all_keys():
        message = refusal(title, kind, key, value)
        if message:
            assert message.startswith(f"scene: [{title}] ")
            named = message.replace("unknown kind", "kind")
            assert key in named.replace("relative_error", "accuracy, relative_error")
            assert "\n" not in message and len(message) < 400
        else:
            found.add(f"{title}.{key}")
    return found


def of_all_bodies(keys):
    """Return keys, those of roughness and scans also for tip and substrate."""
    found = set(keys)
    for key in keys:
        if key.startswith(("roughness.", "topography.")):
            found |= {f"tip.{key}", f"substrate.{key}"}
    return found


#: Keys with words as values, or perhaps; the calculation knows which.
WORDS = {
    *("substrate.calculator", "substrate.potential", "substrate.crystal"),
    *("substrate.surface", "substrate.model", "substrate.shape", "substrate.spacing"),
    "substrate.grid",
    *("sphere.material", "indenter.material", "tip.material", "study.over"),
    *("sphere.profile", "roughness.normalise", "topography.file"),
    *("roughness.file", "roughness.convention", "roughness.series"),
    *("topography.role", "topography.unit", "topography.detrend", "topography.center"),
    *("topography.channel", "heterogeneity.file"),
    *("friction.coupling", "solver.optimizer"),
    *("solver.accuracy", "solver.engine", "output.keep"),
}
#: Those that are not given by default.
MAY_BE_EMPTY = {
    *("substrate.material", "substrate.calculator", "sphere.unit", "roughness.unit"),
    *("substrate.potential", "substrate.crystal", "substrate.surface"),
    *("substrate.model", "sphere.material", "indenter.material", "tip.material"),
    *("heterogeneity.unit", "substrate.grid"),
    *("topography.file", "topography.role", "heterogeneity.file", "study.over"),
    *("roughness.file", "roughness.convention", "roughness.series"),
}
INFINITE = {"sphere.radius", "substrate.hardness", "tip.hardness"}
LISTS = {
    *("substrate.elastic_constants", "substrate.relaxation_moduli"),
    *("substrate.relaxation_times", "substrate.shape", "topography.spacing"),
    *("topography.center", "path.loads", "path.penetrations", "path.heights"),
    *("path.displacements", "path.forces", "path.bases", "path.times", "path.rate"),
}
SWITCHES = {
    *(
        "substrate.anisotropic",
        "substrate.rigid_base",
        "substrate.frictionless_interface",
    ),
    *("substrate.periodic", "roughness.random_amplitudes", "topography.periodic"),
    *("topography.transpose", "topography.remove_outliers", "heterogeneity.periodic"),
    *("topography.remove_bad_lines", "topography.extrude"),
    *("heterogeneity.random_amplitudes", "interaction.permanent"),
    "friction.exponential",
    "friction.slip_law",
}


@pytest.mark.parametrize(
    ("value", "keys"),
    [
        ('"abc"', WORDS),
        ('""', MAY_BE_EMPTY),
        ("nan", set()),
        ("inf", INFINITE),
        ("1e300", set()),
        ("-1e-300", set()),
        ('"1e999 nm"', WORDS),
        ('"3\\u0000 nm"', set()),
        ("[1.0, 2.0]", LISTS),
        ("[nan]", set()),
        ("[[1.0]]", set()),
        ("true", SWITCHES),
        ("{}", {"path.loads", "path.penetrations", "path.heights"}),
        ("1979-05-27", set()),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
def test_only_keys_of_its_type_accept_a_value(value, keys):
    known = {f"{title}.{key}" for title, _, key in all_keys()}  # kinds may be deleted
    assert accepting(value) == of_all_bodies(keys) & known


def test_numbers_without_a_unit_are_said_to_have_none():
    text = '[substrate]\ncontact_modulus = 1.0\nrelaxation_moduli = ["1 MPa"]\n'
    text += "relaxation_times = [1.0]"
    with pytest.raises(ValueError, match=r"relaxation_moduli .*without a unit"):
        Scene.parse(text).check()
    message = refusal("interaction", "power-law", "exponent", '"3 nm"')
    assert "exponent must be a number" in message
