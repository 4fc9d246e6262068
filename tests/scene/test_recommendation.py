"""Recommendation of a trade-off, on both sides of every rule."""

import pytest

from ase_roughcontact.scene.tradeoff import Tradeoff, Trial

WANTED = 1e-3


def trial(error=0.0, accuracy=1e-4, work=1.0, **options):
    given = {
        "settings": {"solver.accuracy": accuracy},
        "nominal_error": accuracy,
        "compared": "force",
        "response_error": error,
        "area_error": 0.0,
        "atoms": 0,
        "pairs": 10.0,
        "work": work,
        "seconds": 1.0,
        "memory": 1e9,
        "converged": True,
    }
    return Trial(**given | options)


def study(*trials, reference_error=0.0):
    return Tradeoff(WANTED, ("1 nN",), 0, trials, reference_error)


# Options of a trial that is recommended, and of one that is just not.
RULES = {
    "error of the force below 0.3 of that wanted": (
        {"error": 0.299 * WANTED},
        {"error": 0.301 * WANTED},
    ),
    "error of the area, too": (
        {"area_error": 0.299 * WANTED},
        {"area_error": 0.301 * WANTED},
    ),
    "accuracy that allows no larger error": (
        {"accuracy": WANTED},
        {"accuracy": 1.001 * WANTED},
    ),
    "converged": ({}, {"converged": False}),
}


@pytest.mark.parametrize("rule", RULES)
def test_only_sufficient_trials_are_recommended(rule):
    sufficient, insufficient = (trial(**given) for given in RULES[rule])
    assert study(insufficient, sufficient).best is sufficient
    assert study(insufficient).best is None


def test_the_error_of_the_reference_is_added_to_that_of_the_trial():
    one = trial(0.2 * WANTED)
    assert study(one, reference_error=0.099 * WANTED).best is one
    assert study(one, reference_error=0.101 * WANTED).best is None


def test_the_trial_of_least_work_is_recommended_whatever_its_time():
    slow, fast = trial(work=1.0, seconds=9.0), trial(work=2.0, seconds=1.0)
    assert study(fast, slow).best is slow


@pytest.mark.parametrize("work, gains", [(0.8, True), (0.95, False), (1.0, False)])
def test_other_settings_are_recommended_only_if_they_save_a_tenth(work, gains):
    own, other = trial(settings={"solver.accuracy": "normal"}), trial(work=work)
    found = study(own, other)
    assert found.best is (other if gains else own)
    assert ("Recommended" in str(found)) == gains
    assert (
        "settings of the scene suffice for an error of 0.001" in str(found)
    ) != gains


def test_the_table_has_a_line_for_each_trial_in_gigabytes_and_seconds():
    lines = str(
        study(trial(), trial(settings={"solver.accuracy": "high"}, memory=2.5e9))
    ).splitlines()
    columns = lines[0].split()
    assert columns[-4:] == ["time", "(s)", "memory", "(GB)"]
    first, second = (line.split() for line in lines[1:3])
    assert first[:2] == ["accuracy", "0.0001"] and first[-2:] == ["1", "1.00"]
    assert second[:2] == ["accuracy", "high"] and second[-1] == "2.50"


@pytest.mark.parametrize(
    "settings, lines",
    [
        ({"solver.accuracy": 1e-4}, ["[solver]", "accuracy = 0.0001"]),
        (
            {"solver.accuracy": "high", "solver.optimizer": "FIRE2"},
            ["[solver]", 'accuracy = "high"', 'optimizer = "FIRE2"'],
        ),
        (
            {"solver.fmax": 1e-6, "interaction.cutoff": 5.0},
            ["[solver]", "fmax = 1e-06", "", "[interaction]", "cutoff = 5.0"],
        ),
    ],
    ids=str,
)
def test_the_recommendation_is_written_as_sections_of_a_scene_file(settings, lines):
    text = str(study(trial(error=1.0), trial(settings=settings)))
    assert text.endswith(
        "\n".join([f"Recommended for an error of {WANTED:g}:", "", *lines])
    )
