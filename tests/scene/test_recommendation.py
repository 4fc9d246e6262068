"""What a trade-off recommends, on both sides of every rule."""

import pytest

from ase_roughcontact.scene.tradeoff import Choice, Tradeoff, Trial

WANTED = 1e-3


def trial(error=0.0, accuracy=1e-4, work=1.0, **options):
    given = {
        "choice": Choice(accuracy),
        "force_error": error,
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


# What is safe, and what is just not.
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
    "named accuracy, too": ({"accuracy": "normal"}, {"accuracy": "fast"}),
    "converged": ({}, {"converged": False}),
}


@pytest.mark.parametrize("rule", RULES)
def test_only_what_is_safe_is_recommended(rule):
    safe, unsafe = (trial(**given) for given in RULES[rule])
    assert study(unsafe, safe).best is safe
    assert study(unsafe).best is None


def test_the_error_of_the_reference_counts_as_one_of_the_trial():
    one = trial(0.2 * WANTED)
    assert study(one, reference_error=0.099 * WANTED).best is one
    assert study(one, reference_error=0.101 * WANTED).best is None


def test_a_tolerance_in_place_of_an_accuracy_is_judged_by_its_error_alone():
    given = trial(0.1 * WANTED, choice=Choice(0.5, fmax=1e-6))
    assert study(given).best is given


def test_the_least_work_is_recommended_whatever_time_it_took():
    slow, fast = trial(work=1.0, seconds=9.0), trial(work=2.0, seconds=1.0)
    assert study(fast, slow).best is slow


def test_the_table_has_a_line_for_each_trial_in_gigabytes_and_seconds():
    lines = str(study(trial(), trial(accuracy="high", memory=2.5e9))).splitlines()
    columns = lines[0].split()
    assert columns[-4:] == ["time", "(s)", "memory", "(GB)"]
    assert lines[1].split()[0] == "1e-04" and lines[1].split()[-2:] == ["1", "1.00"]
    assert lines[2].split()[0] == "high" and lines[2].split()[-1] == "2.50"


@pytest.mark.parametrize(
    "choice, keys",
    [
        (Choice(1e-4), ["accuracy = 0.0001"]),
        (Choice("high", "FIRE2"), ['accuracy = "high"', 'optimizer = "FIRE2"']),
        (Choice(1e-4, fmax=1e-6), ["fmax = 1e-06"]),
        (Choice(1e-4, cutoff=5.0), ["accuracy = 0.0001", "cutoff = 5.0"]),
    ],
    ids=str,
)
def test_the_recommendation_has_the_keys_of_the_choice_and_no_others(choice, keys):
    text = str(study(trial(choice=choice)))
    assert f"error of {WANTED:g}" in text
    assert [line for line in text.splitlines() if " = " in line] == keys
