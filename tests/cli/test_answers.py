"""The sentence at the head of a page: the result of a run, with its error."""

from dataclasses import replace

import pytest
from loop_scene import LOOP
from small_scene import SMALL

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.answers import answer, answer_of_places
from ase_roughcontact.ensemble.places import Place
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.path_result import results_of
from ase_roughcontact.scene.reference import reference_for


@pytest.fixture(scope="module")
def small():
    scene = Scene.parse(SMALL)
    return reference_for(scene), list(scene.relax([1.0], validity="ignore"))


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    scene = Scene.parse(LOOP)
    folder = tmp_path_factory.mktemp("loop")
    return reference_for(scene), list(scene.run(folder, validity="ignore"))


def test_the_force_at_a_depth_has_its_error(small):
    reference, (step,) = small
    changed = replace(step, normal_force=2.0 * UNITS["nN"], force_error=UNITS["nN"])
    assert "the normal force is 2.000 ± 1.0 nN" in answer(reference, [changed])


def test_an_area_with_an_error_that_is_not_known_has_the_reason(small):
    reference, (step,) = small
    unknown = {"area_error": float("nan"), "unknown_errors": "a jump"}
    text = answer(reference, [replace(step, **unknown)])
    assert "nm² (error not known: a jump)" in text


def test_steps_that_did_not_converge_are_no_answer(small):
    reference, (step,) = small
    failed = replace(step, converged=False, normal_force=1e6)
    assert answer(reference, [step, failed]) == answer(reference, [step])
    assert "no step has converged" in answer(reference, [failed])


def test_a_path_without_contact_says_so(small):
    reference, (step,) = small
    text = answer(reference, [replace(step, repulsive_atoms=0)])
    assert text.startswith("Nothing is pressed")


def test_the_answer_of_a_loop_is_its_pull_off_force_beside_theory(loop):
    reference, steps = loop
    scene = reference.scene
    force = results_of(scene.path, scene.bodies, steps)["pull_off_force"]
    smooth = reference.smooth.pull_off_force
    expected = (
        f"The pull-off force is {force / UNITS['nN']:.4g} nN "
        f"({smooth / UNITS['nN']:.4g} nN of a smooth sphere)"
    )
    assert answer(reference, steps).startswith(expected)


def test_the_first_half_of_a_loop_has_no_pull_off_force(loop):
    reference, steps = loop
    unfinished = [*steps[:3], replace(steps[3], converged=False)]
    assert "pull-off" not in answer(reference, unfinished)


def test_the_answer_of_places_is_the_median_of_those_with_a_result():
    scene = Scene.parse(SMALL)
    areas = 200.0, 300.0, 400.0, 500.0, 600.0
    places = [Place(x=0.0, y=0.0, area=area, converged=True) for area in areas]
    places.append(Place(x=0.0, y=0.0, area=9e9))
    assert answer_of_places(scene, places) == (
        "The median contact area is 4.000 nm², half of the places are between 3.000 "
        "and 5.000 nm²; 1 of 6 places have no result."
    )
    assert "no result in any of 1 places" in answer_of_places(scene, places[-1:])
