"""Channels of files: one height is pressed."""

import numpy as np
import pytest
from microscope_files import write_h5, write_ibw, write_mi

from ase_roughcontact import HeightMap
from ase_roughcontact.topography.channels import Channel, chosen

RNG = np.random.default_rng(3)
HEIGHT, OTHER = RNG.standard_normal((2, 8, 6))


def block(name, values, unit, mark="# "):
    """A channel of a text, as Gwyddion writes it; sizes 16 nm x 12 nm."""
    head = f"Channel: {name}\nWidth: 16 nm\nHeight: 12 nm\nValue units: {unit}\n"
    lines = ("\t".join(f"{z:.17g}" for z in line) for line in values.T)
    return mark + head.replace("\n", f"\n{mark}", 3) + "\n".join(lines) + "\n"


def read(path, text=None, **options):
    if text is not None:
        path.write_text(text)
    return HeightMap.from_topography(path, "substrate", detrend="none", **options)


def assert_heights(surface, heights):
    """Assert that a map has heights in nm, with 2 nm between the points."""
    assert surface.shape == heights.shape
    assert surface.spacing == pytest.approx((20.0, 20.0))
    x, y = surface.center
    lower = surface.heights(heights.shape, 20.0, (-x, -y))
    np.testing.assert_allclose(lower, -10.0 * heights, rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("mark", ["# ", ""])
@pytest.mark.parametrize("between", ["", "\n"])
@pytest.mark.parametrize("first", [True, False])
def test_the_height_of_a_text_is_read_whatever_the_order_of_channels(
    tmp_path, mark, between, first
):
    parts = [block("Height", HEIGHT, "nm", mark), block("Phase", OTHER, "deg", mark)]
    text = between.join(parts if first else parts[::-1])
    assert_heights(read(tmp_path / "two.txt", text), HEIGHT)


def test_two_heights_of_a_text_are_an_error_that_lists_them(tmp_path):
    text = block("Height", HEIGHT, "nm") + "\n" + block("ZSensor", OTHER, "nm")
    file = tmp_path / "two.txt"
    with pytest.raises(ValueError, match=r"0 'Height' .*1 'ZSensor' \(nm, 8 x 6\)"):
        read(file, text)
    assert_heights(read(file, channel="ZSensor"), OTHER)
    assert_heights(read(file, channel=0), HEIGHT)
    with pytest.raises(ValueError, match="did you mean 'ZSensor'"):
        read(file, channel="Sensor")
    with pytest.raises(ValueError, match="no channel 2"):
        read(file, channel=2)


def test_a_matrix_after_a_blank_line_is_another_channel(tmp_path):
    matrix = "\n".join("\t".join(f"{z:.5e}" for z in line) for line in OTHER.T)
    with pytest.raises(ValueError, match=r"2 channels .*give channel"):
        read(tmp_path / "two.txt", block("Height", HEIGHT, "nm") + "\n" + matrix)


def test_blank_lines_between_all_rows_separate_nothing(tmp_path):
    rows = "\n\n".join(" ".join(f"{z:.17g}" for z in line) for line in HEIGHT.T)
    assert_heights(read(tmp_path / "one.txt", rows, spacing=2.0, unit="nm"), HEIGHT)


def test_comments_between_rows_separate_nothing(tmp_path):
    rows = [" ".join(f"{z:.17g}" for z in line) for line in HEIGHT.T]
    rows.insert(3, "# line 3 was measured again")
    text = "\n".join(rows)
    assert_heights(read(tmp_path / "one.txt", text, spacing=2.0, unit="nm"), HEIGHT)


def test_a_text_that_is_no_height_is_refused(tmp_path):
    file = tmp_path / "phase.txt"
    with pytest.raises(ValueError, match=r"no channel .* 0 'Phase' \(deg"):
        read(file, block("Phase", OTHER, "deg"))
    with pytest.raises(ValueError, match=r"'Phase' .* in deg"):
        read(file, channel="Phase")


def test_the_height_of_a_binary_file_is_read_and_friction_in_volt_refused(
    tmp_path, topography
):
    file = tmp_path / "scan.mi"
    write_mi(file, HEIGHT, (2.0, 2.0))
    assert_heights(read(file), HEIGHT)
    with pytest.raises(ValueError, match=r"2 channels .*'Friction'.* number"):
        read(file, channel="Friction")
    with pytest.raises(ValueError, match=r"'Friction' .* in V"):
        read(file, channel=2)


def test_the_phase_of_a_binary_file_is_no_height(tmp_path, topography):
    file = tmp_path / "scan.ibw"
    write_ibw(file, HEIGHT, (2.0, 2.0))
    assert_heights(read(file), HEIGHT)
    with pytest.raises(ValueError, match=r"'PhaseRetrace' .* in deg"):
        read(file, channel="PhaseRetrace")


def test_spacing_and_unit_are_given_for_files_without_them(tmp_path, topography):
    file = tmp_path / "scan.h5"
    write_h5(file, HEIGHT, None)
    assert_heights(read(file, spacing=2.0, unit="nm"), HEIGHT)
    with pytest.raises(ValueError, match="give unit"):
        read(file)
    with pytest.raises(ValueError, match="give spacing"):
        read(file, unit="nm")


def test_an_array_has_no_other_channel(tmp_path):
    np.save(tmp_path / "scan.npy", HEIGHT)
    options = {"spacing": 2.0, "unit": "nm"}
    assert_heights(read(tmp_path / "scan.npy", channel=0, **options), HEIGHT)
    with pytest.raises(ValueError, match="no channel 1"):
        read(tmp_path / "scan.npy", channel=1, **options)


@pytest.mark.parametrize(
    "name", ["Deflection", "AmplitudeError", "Lateral force", "LogDMTModulus"]
)
def test_names_of_other_quantities_are_no_heights(name):
    channels = [Channel(name, (4, 4), "nm"), Channel("ZSensor", (4, 4), "nm")]
    assert chosen(channels) == 1
    assert chosen(channels, name) == 0


@pytest.mark.parametrize("wanted", [None, 0, "Height"])
def test_a_file_without_channels_seems_cut_off(wanted):
    with pytest.raises(ValueError, match="cut off"):
        chosen([], wanted)
