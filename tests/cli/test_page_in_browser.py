"""The page of a run in a browser: chart, maps, sorted table, downloads, no network."""

import csv
import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.scene import Results

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not CHROMIUM, reason="there is no Chromium"),
]
# What a person does on the page; `found` is what comes of it.
ACTIONS = """{
const found = {}, saved = {};
save = (parts, name) => { saved[name] = parts[0]; };
const chart = document.querySelector(".chart"), maps = document.querySelector(".maps");
const canvas = maps.querySelector("canvas");
const slider = maps.querySelector("[type=range]");
const press = (root, name) => root.querySelector(`[name=${name}]`).click();
const key = (target, name) =>
  target.dispatchEvent(new KeyboardEvent("keydown", { key: name }));

found.title = document.querySelector("h1").textContent;
document.documentElement.style.width = "390px";
found.width = Math.max(...[...document.querySelectorAll("body *")]
  .filter(each => !each.closest(".wide, pre, svg"))
  .map(each => each.getBoundingClientRect().right));
found.hidden = [...document.querySelectorAll(".needs-script")].map(each => each.hidden);

press(chart, "csv");
press(chart, "svg");
key(chart.querySelector("svg"), "ArrowRight");
found.first = chart.querySelector("output").value;
const ticks = () =>
  [...chart.querySelectorAll("svg text")].map(each => each.textContent);
const whole = ticks().join();
press(chart, "closer");
found.closer = ticks().join() !== whole;
for (let i = 0; i < 2; i++) press(chart, "closer");
key(chart.querySelector("svg"), "ArrowRight");
const position = (point, name) => Number(point.getAttribute(name));
const marked = chart.querySelector("circle[r='6']");
const frame = chart.querySelector("svg > rect");
found.inside = [["x", "width"], ["y", "height"]].every(([axis, side]) => {
  const low = position(frame, axis), high = low + position(frame, side);
  const middle = position(marked, `c${axis}`);
  return low <= middle && middle <= high;
});
press(chart, "whole");
found.whole = ticks().join() === whole;
data.failed = [1];
press(chart, "whole");
found.hollow = [...chart.querySelectorAll("circle")]
  .map(each => each.getAttribute("fill") === "white");
data.failed = [];

found.label = maps.querySelector(".title").value;
const before = canvas.toDataURL();
slider.value = 0;
slider.dispatchEvent(new Event("input"));
found.moved = canvas.toDataURL() !== before;
found.moved_label = maps.querySelector(".title").value;
const box = canvas.getBoundingClientRect();
const pixel = box.width / canvas.width;
found.pixels = [canvas.width, canvas.height];
canvas.dispatchEvent(new PointerEvent("pointermove", {
  clientX: box.left + 3.5 * pixel, clientY: box.top + 5.5 * pixel }));
found.value = maps.querySelector(".value").value;
press(maps, "csv");
press(maps, "svg");
document.querySelectorAll("figcaption button").forEach(button => button.click());
for (const [name, part] of Object.entries(saved))
  if (typeof part !== "string") saved[name] = part.length;
key(canvas, "ArrowRight");
found.next = maps.querySelector(".value").value;

const cells = () => [...document.querySelectorAll("table.steps tr")].slice(1)
  .map(row => row.cells[0].textContent);
found.steps = cells();
const head = document.querySelector("table.steps th button");
head.click();
head.click();
found.sorted = cells();

found.loaded = performance.getEntriesByType("resource").map(each => each.name)
  .filter(name => !/^(data|blob):/.test(name));
const request = fetch("file:///etc/hostname").then(() => "sent", () => "refused");
request.then(text => {
  found.request = text;
  document.title = "done";
  const shown = document.createElement("pre");
  shown.id = "found";
  shown.textContent = JSON.stringify({ found, saved });
  document.body.append(shown);
});
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("browser")
    (folder / "scene.toml").write_text(SMALL)
    results = folder / "<b>bold"
    main(["run", str(folder / "scene.toml"), "--out", str(results), "--quiet"])
    assert main(["report", str(results)]) == 0
    return results


@pytest.fixture(scope="module")
def page(folder):
    """What is found on the page after some actions, and files that were saved."""
    text = (folder / "report.html").read_text()
    copy = folder / "acted.html"
    copy.write_text(text.replace("</body>", f"<script>{ACTIONS}</script></body>"))
    shown = subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom",
         "--window-size=390,900", "--virtual-time-budget=5000", copy.as_uri()],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    (found,) = re.findall(r'<pre id="found">(.*?)</pre>', shown, re.S)
    both = json.loads(
        found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    )
    return both["found"], both["saved"]


def test_names_with_markup_are_text(page):
    assert page[0]["title"] == "<b>bold"


def test_the_page_fits_a_telephone(page):
    assert page[0]["width"] <= 390


def test_all_parts_are_shown(page):
    assert page[0]["hidden"] == [False, False]


def test_nothing_is_loaded_from_elsewhere(page):
    assert page[0]["loaded"] == []
    assert page[0]["request"] == "refused"


def test_the_saved_chart_has_the_numbers_of_the_table(page, folder):
    (name,) = [name for name in page[1] if name.startswith("normal_force")
               and name.endswith(".csv")]  # fmt: skip
    head, *rows = csv.reader(page[1][name].splitlines())
    assert head[:3] == ["step", "penetration (Å)", "normal force (nN)"]
    steps = list(table_rows((folder / "curve.csv").read_text().splitlines()))
    for row, step in zip(rows, steps, strict=True):
        assert float(row[1]) == pytest.approx(float(step["penetration"]), rel=1e-12)
        force = float(step["normal_force"]) / UNITS["nN"]
        assert float(row[2]) == pytest.approx(force, rel=1e-12)


def test_the_saved_picture_has_a_point_for_each_step(page):
    (text,) = [text for name, text in page[1].items() if re.match("normal.*svg", name)]
    assert text.startswith("<svg") and text.count("<circle") == 2


def test_points_that_did_not_converge_are_hollow(page):
    assert page[0]["hollow"] == [False, True]


def test_a_point_that_keys_choose_is_brought_into_the_frame(page):
    assert page[0]["inside"]


def test_the_saved_map_has_its_scales(page):
    text = page[1]["pressure-step-0.svg"]
    assert "<image" in text and "pressure (GPa)" in text
    assert re.search(r">\d+ nm</text>", text)


def test_figures_are_saved(page, folder):
    for name in ("curve.png", "force.png", "contact.png"):
        assert page[1][name] == (folder / name).stat().st_size


def test_keys_choose_points_of_the_chart(page, folder):
    step = Results(folder)[0]
    force = step.normal_force / UNITS["nN"]
    assert page[0]["first"].startswith("step 0: penetration")
    assert f"normal force {float(f'{force:.5g}'):.5g}" in page[0]["first"]


def test_buttons_show_a_part_of_the_chart_and_the_whole(page):
    assert page[0]["closer"] and page[0]["whole"]


def test_the_slider_moves_through_the_steps(page):
    assert page[0]["label"].startswith("step 1: ")
    assert page[0]["moved"] and page[0]["moved_label"].startswith("step 0: ")


def test_the_value_under_the_pointer_is_the_value_of_the_frame(page, folder):
    seen = Results(folder).map(0)
    _, height = page[0]["pixels"]
    for name, column in (("value", 3), ("next", 4)):
        place, _, value = page[0][name].partition(": ")
        row = height - 6
        pressure = seen.pressure[column, row] / UNITS["GPa"]
        x, y = seen.x[column] / 10.0, seen.y[row] / 10.0
        numbers = re.findall(r"[\d.]+", place.replace("−", "-"))
        np.testing.assert_allclose(
            [float(each) for each in numbers], np.abs([x, y]), rtol=1e-4
        )
        assert float(value.split()[0].replace("−", "-")) == pytest.approx(
            pressure, rel=1e-4
        )


def test_the_saved_map_has_the_pressures_of_the_frame(page, folder):
    head, *rows = csv.reader(page[1]["pressure-step-0.csv"].splitlines())
    assert head == ["x (nm)", "y (nm)", "pressure (GPa)"]
    seen = Results(folder).map(0)
    values = np.array(rows, dtype=float)[:, 2]
    np.testing.assert_allclose(
        values, seen.pressure.T.ravel() / UNITS["GPa"], rtol=1e-6
    )


def test_a_heading_sorts_the_table(page):
    assert page[0]["steps"] == ["0", "1"] and page[0]["sorted"] == ["1", "0"]
