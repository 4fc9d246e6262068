"""Direction, segments, calibration and formats of measured force curves."""

import sys
import zipfile
from unittest.mock import patch

import numpy as np
import pytest
from fitting import curve_formats as formats

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.curve_files import read_curve, read_in_time
from ase_roughcontact.fitting.formats.curve_format import FORMATS, CurveFormat
from ase_roughcontact.fitting.formats.table import (
    ArrayColumn,
    CurveTable,
    Position,
    Segment,
)

NM, NN, N_M = UNITS["nm"], UNITS["nN"], UNITS["N/m"]
# An adhesive curve on a stiff sample: a long ramp (nm), setpoint and pull-off (nN).
STIFFNESS, RAMP, SETPOINT, ADHESION = 1.0, 1000.0, 2.0, 20.0
DOWN, UP = np.linspace(RAMP, 0.0, 501), np.linspace(0.0, RAMP, 501)
NOISE = np.random.default_rng(0).normal(0.0, 0.05, (2, 501))
PUSH = np.where(SETPOINT > DOWN, SETPOINT - DOWN, 0.0) + NOISE[0]
PULL = np.where(SETPOINT + ADHESION > UP, SETPOINT - UP, 0.0) + NOISE[1]
# The same in m and N, as segments.
APPROACH, RETRACTION = (1e-9 * DOWN, 1e-9 * PUSH), (1e-9 * UP, 1e-9 * PULL)


def table(file, name="height (nm)", sign=1.0, force=1.0):
    height, values = np.append(DOWN, UP), np.append(PUSH, PULL)
    columns = np.column_stack([sign * height, force * values])
    head = f"{name},force (nN)"
    np.savetxt(file, columns, delimiter=",", header=head, comments="")


def table_towards(file):
    table(file, sign=-1.0)


def instrument(file):
    formats.afm_hdf5(
        file,
        "force-distance",
        [APPROACH, RETRACTION],
        **{"spring constant": STIFFNESS, "sensitivity": 60e-9},
    )


def nanoscope(file, names="Height_Sensor_nm_Ex\tHeight_Sensor_nm_Rt", sign=1.0):
    columns = sign * DOWN, sign * UP, 1e3 * PUSH, 1e3 * PULL
    head = f"{names}\tDefl_pN_Ex\tDefl_pN_Rt"
    rows = np.column_stack(columns)
    np.savetxt(file, rows, delimiter="\t", header=head, comments="")


def nanoscope_ramp(file):
    nanoscope(file, "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm", -1.0)


def jpk(file, pause=False):
    text = ""
    segments = [("extend", *APPROACH), ("retract", *RETRACTION)]
    if pause:
        rest = np.full(7, APPROACH[0][-1]), np.full(7, APPROACH[1][-1])
        segments.insert(1, ("pause", *rest))
    for name, height, force in segments:
        text += f"# segment: {name}\n# columns: measuredHeight vDeflection\n"
        text += "# units: m N\n# springConstant: 1.0\n# sensitivity: 4e-8\n#\n"
        rows = zip(height, force, strict=True)
        text += "".join(f"{z:.9e} {f:.9e}\n" for z, f in rows) + "\n"
    file.write_text(text)


CURVE = (DOWN, PUSH), (UP, PULL)  # nm, and nN or nm


def nanoscope_binary(file):
    formats.nano_scope(file, [CURVE])


def nanoscope_binary_ramp(file):
    formats.nano_scope(file, [CURVE], sensor=False)


def uff(file):
    approach = 1e-9 * DOWN[::-1], PUSH[::-1] / 60.0
    formats.uff(file, (approach, (1e-9 * UP, PULL / 60.0)), STIFFNESS, 60e-9)


@pytest.mark.parametrize(
    "write",
    [
        table,
        table_towards,
        instrument,
        nanoscope,
        nanoscope_ramp,
        nanoscope_binary,
        nanoscope_binary_ramp,
        uff,
        jpk,
    ],
)
def test_an_adhesive_curve_on_a_stiff_sample_comes_down_and_goes_up(tmp_path, write):
    write(file := tmp_path / "curve.h5")
    curve = read_curve(file, stiffness=STIFFNESS * N_M)
    np.testing.assert_allclose(curve.force, np.append(PUSH, PULL) * NN, atol=1e-6)
    np.testing.assert_allclose(np.diff(curve.base / NM)[:500], -2.0, atol=1e-5)
    np.testing.assert_allclose(np.diff(curve.base / NM)[501:], 2.0, atol=1e-5)
    assert curve.doubts == []


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("height, force", [(DOWN, PUSH), (UP, PULL)])
def test_a_single_branch_is_nearest_where_the_force_is_largest(
    tmp_path, sign, height, force
):
    rows = np.column_stack([sign * height, force])
    head, file = "height (nm),force (nN)", tmp_path / "curve.csv"
    np.savetxt(file, rows, delimiter=",", header=head, comments="")
    curve = read_curve(file, stiffness=STIFFNESS * N_M)
    np.testing.assert_allclose(np.diff(curve.base), np.diff(height) * NM, atol=1e-4)


@pytest.mark.parametrize("name", ["height (nm)", "distance (nm)"])
def test_negated_forces_are_doubted(tmp_path, name):
    table(file := tmp_path / "curve.csv", name, force=-1.0)
    (doubt,) = read_curve(file, stiffness=STIFFNESS * N_M).doubts
    assert "is it negative in tension" in doubt


def test_two_curves_in_one_table_are_doubted(tmp_path):
    table(file := tmp_path / "curve.csv")
    once = file.read_text()
    file.write_text(once + once.partition("\n")[2])
    (doubt,) = read_curve(file, stiffness=STIFFNESS * N_M).doubts
    assert "comes down 2 times" in doubt


def test_branches_that_are_swapped_are_named(tmp_path):
    swapped = [RETRACTION, APPROACH]
    keys = {"spring constant": STIFFNESS, "sensitivity": 60e-9}
    formats.afm_hdf5(file := tmp_path / "c.h5", "force-distance", swapped, **keys)
    (remark,) = read_curve(file).remarks
    assert "are the branches swapped?" in remark


REST = np.full(50, 1e-9 * RAMP), 1e-9 * NOISE[0][:50]
SINKING = -1e-9 * np.linspace(0.0, 20.0, 50), np.full(50, 1e-9 * SETPOINT)
LOWER = RETRACTION[0] - 20e-9, RETRACTION[1]


@pytest.mark.parametrize(
    "mode, segments",
    [
        ("creep-compliance", [APPROACH, SINKING, LOWER]),
        ("stress-relaxation", [REST, APPROACH, SINKING, LOWER]),
    ],
)
def test_holds_are_neither_approach_nor_retraction(tmp_path, mode, segments):
    keys = {"spring constant": STIFFNESS, "sensitivity": 60e-9}
    formats.afm_hdf5(file := tmp_path / "curve.h5", mode, segments, **keys)
    curve = read_curve(file)
    down, up = curve.branches
    np.testing.assert_allclose(curve.base[down.points], DOWN * NM, atol=1e-4)
    np.testing.assert_allclose(curve.base[up.points], (UP - 20.0) * NM, atol=1e-4)
    assert curve.force.min() == pytest.approx(PULL.min() * NN)
    assert len(curve.remarks) == len(segments) - 2
    assert "a hold of 50 points between the branches is left out" in curve.remarks[-1]
    alone = read_curve(file, "retraction")
    np.testing.assert_array_equal(alone.force, curve.force[up.points])


def test_holds_are_kept_over_time(tmp_path):
    keys = {"spring constant": STIFFNESS, "sensitivity": 60e-9}
    parts = [APPROACH, SINKING, LOWER]
    formats.afm_hdf5(file := tmp_path / "c.h5", "creep-compliance", parts, **keys)
    time, force = read_in_time(file, "force")
    np.testing.assert_allclose(time, 1e-3 * np.arange(501 + 50 + 501))
    np.testing.assert_allclose(force[501:551], SETPOINT * NN)
    time, depth = read_in_time(file, "depth")
    np.testing.assert_allclose(np.ptp(depth[501:551]), 20.0 * NM, rtol=1e-6)


def test_an_indentation_is_a_depth_where_there_is_no_other(tmp_path):
    text = "time (s),indentation (nm),force (nN)\n0,1,2\n1,3,4\n2,4,9\n"
    (file := tmp_path / "curve.csv").write_text(text)
    np.testing.assert_allclose(read_curve(file).depth / NM, [1.0, 3.0, 4.0])
    np.testing.assert_allclose(read_in_time(file, "depth")[1] / NM, [1.0, 3.0, 4.0])


def test_pauses_of_a_jpk_text_are_holds(tmp_path):
    jpk(file := tmp_path / "curve.txt", pause=True)
    curve = read_curve(file)
    assert len(curve.force) == 1002
    assert "a hold of 7 points between" in curve.remarks[0]


def test_points_in_one_segment_are_split_at_the_turn(tmp_path):
    both = np.append(APPROACH[0], RETRACTION[0]), np.append(APPROACH[1], RETRACTION[1])
    keys = {"spring constant": STIFFNESS, "sensitivity": 60e-9}
    formats.afm_hdf5(file := tmp_path / "curve.h5", "force-distance", [both], **keys)
    approach = read_curve(file, "approach")
    np.testing.assert_allclose(approach.base, DOWN * NM, atol=1e-4)
    retraction = read_curve(file, "retraction")
    assert retraction.force.min() == pytest.approx(PULL.min() * NN)


def test_another_sensitivity_changes_deflections_and_forces(tmp_path):
    instrument(file := tmp_path / "curve.h5")
    old, new = read_curve(file), read_curve(file, sensitivity="120 nm/V")
    np.testing.assert_allclose(new.force, 2.0 * old.force)
    np.testing.assert_allclose(new.base, old.base, atol=1e-6)
    assert new.stiffness == old.stiffness
    assert new.remarks == ("sensitivity 120 nm/V in place of 60 nm/V in the file",)


def test_another_spring_constant_changes_forces_alone(tmp_path):
    instrument(file := tmp_path / "curve.h5")
    old, new = read_curve(file), read_curve(file, stiffness=1.2 * N_M)
    np.testing.assert_allclose(new.force, 1.2 * old.force)
    np.testing.assert_allclose(new.depth, old.depth, atol=1e-6)
    assert new.remarks == ("spring constant 1.2 N/m in place of 1 N/m in the file",)


def test_another_sensitivity_of_a_signal_in_volts_replaces_the_one_in_the_header(
    tmp_path,
):
    volts = PUSH / 40.0  # of 40 nm/V
    lines = ["\\@Sens. DeflSens: V 40 nm/V", "\\Spring Constant: 1"]
    lines += ["Height_Sensor_nm_Ex\tDefl_V_Ex"]
    rows = zip(DOWN, volts, strict=True)
    lines += [f"{z:.9f}\t{v:.12f}" for z, v in rows]
    (file := tmp_path / "curve.txt").write_text("\n".join(lines))
    curve = read_curve(file, sensitivity="80 nm/V")
    np.testing.assert_allclose(curve.force, 2.0 * PUSH * NN, atol=1e-6)


def test_a_sensitivity_that_can_not_be_replaced_is_an_error(tmp_path):
    table(file := tmp_path / "curve.csv")
    with pytest.raises(ValueError, match="leave out --sensitivity"):
        read_curve(file, stiffness=N_M, sensitivity="40 nm/V")


def test_a_missing_calibration_is_asked_for(tmp_path):
    pytest.importorskip("afmformats")
    columns = {
        "Extend Z-Sense(nm)": -DOWN,
        "Extend T-B(V)": PUSH / 40.0,
        "Retract Z-Sense(nm)": -UP,
        "Retract T-B(V)": PULL / 40.0,
    }
    formats.afm_workshop(file := tmp_path / "curve.csv", columns)
    with pytest.raises(ValueError, match="sensitivity and no spring"):
        read_curve(file)
    with pytest.raises(ValueError, match="spring constant"):
        read_curve(file, sensitivity="40 nm/V")
    curve = read_curve(file, None, STIFFNESS * N_M, "40 nm/V")
    np.testing.assert_allclose(curve.force, np.append(PUSH, PULL) * NN, atol=1e-6)
    np.testing.assert_allclose(curve.base, np.append(DOWN, UP) * NM, atol=1e-4)


def test_waves_of_asylum_have_segments_and_a_calibration(tmp_path):
    pytest.importorskip("igor2")
    dwell = np.full(20, APPROACH[0][-1]), np.full(20, APPROACH[1][-1])
    height, force = (
        np.concatenate(x) for x in zip(APPROACH, dwell, RETRACTION, strict=True)
    )
    columns = {"Raw": -0.9 * height, "Defl": force / STIFFNESS, "ZSnsr": -height}
    note = f"SpringConstant: {STIFFNESS}\nInvOLS: 4e-08\nIndexes: 0,501,521,1021\n"
    note += "Direction: NaN,1,0,-1,\nTime:10:47:31\n"
    formats.igor_wave(file := tmp_path / "curve.ibw", columns, note, 5e-4)
    curve = read_curve(file)
    np.testing.assert_allclose(curve.force, np.append(PUSH, PULL) * NN, atol=1e-6)
    np.testing.assert_allclose(curve.base, np.append(DOWN, UP) * NM, atol=1e-4)
    assert "a hold of 20 points" in curve.remarks[0]
    twice = read_curve(file, sensitivity="80 nm/V")
    np.testing.assert_allclose(twice.force, 2.0 * curve.force)
    assert read_in_time(file, "force")[0][-1] == pytest.approx(1021 * 5e-4)


def test_chiaro_texts_have_piezo_load_and_stiffness(tmp_path):
    bend = np.append(PUSH, PULL) / 0.02  # nm
    piezo = -np.append(DOWN, UP) * 10.0
    time = np.linspace(0.0, 1.0, len(piezo))
    formats.chiaro(file := tmp_path / "c.txt", time, 0.02e-3 * bend, piezo, 0.02)
    curve = read_curve(file)
    assert curve.stiffness == pytest.approx(0.02 * N_M)
    np.testing.assert_allclose(curve.force, np.append(PUSH, PULL) * NN, atol=1e-5)
    np.testing.assert_allclose(curve.base, -piezo * NM, atol=1e-4)


def test_both_signals_of_an_nt_mdt_text_are_read(tmp_path):
    pytest.importorskip("afmformats")
    # heights rise towards the end of the file, away from the surface
    formats.nt_mdt(file := tmp_path / "c.txt", UP, PUSH[::-1] / 0.05, PULL / 0.05)
    curve = read_curve(file, None, STIFFNESS * N_M, "0.05 nm/nA")
    np.testing.assert_allclose(curve.force, np.append(PUSH, PULL) * NN, atol=1e-6)
    np.testing.assert_allclose(curve.base, np.append(DOWN, UP) * NM, atol=1e-4)


def test_an_archive_has_curves_by_names_and_numbers(tmp_path):
    for number, scale in ((1, 1.0), (2, 3.0)):
        table(tmp_path / f"c{number}.csv", force=scale)
    with zipfile.ZipFile(file := tmp_path / "all.zip", "w") as archive:
        archive.write(tmp_path / "c2.csv", "b/c2.csv")
        archive.write(tmp_path / "c1.csv", "a/c1.csv")
    with pytest.raises(ValueError, match=r"2 files \(a/c1.csv, b/c2.csv\)"):
        read_curve(file, stiffness=N_M)
    for curve in (2, "b/c2.csv"):
        read = read_curve(file, stiffness=N_M, curve=curve)
        assert read.force.min() == pytest.approx(3.0 * PULL.min() * NN)
    with pytest.raises(ValueError, match="from 1 to 2, got 3"):
        read_curve(file, stiffness=N_M, curve=3)


def test_errors_in_an_archive_name_the_file_in_it(tmp_path):
    with zipfile.ZipFile(file := tmp_path / "all.zip", "w") as archive:
        archive.writestr("c.csv", "0,0\n1,1\n")
    with pytest.raises(ValueError, match=r"all.zip/c.csv"):
        read_curve(file, stiffness=N_M)


def test_heads_may_have_line_breaks(tmp_path):
    text = '"distance\n(nm)","force\n(nN)"\n0,1\n1,2\n-2,y\n'
    (file := tmp_path / "curve.csv").write_text(text.replace("y", "5"))
    curve = read_curve(file, stiffness=N_M)
    np.testing.assert_allclose(curve.base / NM, [0.0, 1.0, -2.0], atol=1e-9)
    file.write_text(text)
    with pytest.raises(ValueError, match=r"line 6: force \(nN\)"):
        read_curve(file, stiffness=N_M)


def test_an_approach_that_ends_early_has_the_points_of_a_nanoscope_file(tmp_path):
    early = (DOWN[100:], PUSH[100:]), (UP, PULL)
    file = tmp_path / "curve.000"
    formats.nano_scope(file, [early], sensor=False, stored=501)
    curve = read_curve(file)
    assert curve.turn == 401
    np.testing.assert_allclose(curve.force[:401], PUSH[100:] * NN, atol=1e-6)
    assert curve.base[400] == pytest.approx(curve.base[401])


@pytest.mark.parametrize("empty", [0, 1])
def test_a_branch_without_points_in_a_nanoscope_file_is_an_error(empty, tmp_path):
    curve = [(DOWN, PUSH), (UP, PULL)]
    curve[empty] = (np.empty(0), np.empty(0))
    formats.nano_scope(file := tmp_path / "curve.000", [curve], sensor=False)
    with pytest.raises(ValueError, match="export it as text"):
        read_curve(file)


def test_a_force_volume_of_nanoscope_has_numbered_curves(tmp_path):
    raised = (DOWN, PUSH + 1.0), (UP, PULL + 1.0)
    formats.nano_scope(file := tmp_path / "map.spm", [CURVE, raised], size=2)
    with pytest.raises(ValueError, match=r"2 force curves.*--curve.* 1 to 2"):
        read_curve(file)
    first, second = (read_curve(file, curve=number) for number in (1, 2))
    np.testing.assert_allclose(second.force - first.force, NN, atol=2e-3)
    assert second.position == Position(0.0, 1e4, 0, 1)


def test_a_nanoscope_file_has_the_times_of_its_ramp(tmp_path):
    formats.nano_scope(file := tmp_path / "curve.000", [CURVE])
    time, _ = read_in_time(file, "force")
    # 2 nm per point at 5 V/s and 10 V/s, of 60 nm/V
    np.testing.assert_allclose(
        np.diff(time)[[0, 499, 501, -1]], [1 / 150] * 2 + [1 / 300] * 2
    )


@pytest.mark.parametrize(
    "change, message",
    [
        ((b"Samps/line: 501", b"Samps/line: 499"), "as if it had holds: export it"),
        ((b"[DeflectionError]", b"[AmplitudeError]"), "no channel of the deflection"),
        ((b"@4:Ramp Size", b"@4:Ramp Part"), "neither heights nor a ramp"),
        ((b"@Sens. DeflSens: V", b"@Sens. DeflSens: U"), "no Sens. DeflSens in nm/V"),
        ((b"\\Hold Time: 0", b"\\PeakForce Capture: Allow"), "PeakForce"),
    ],
)
def test_a_nanoscope_file_that_is_not_read_names_the_reason(tmp_path, change, message):
    formats.nano_scope(file := tmp_path / "curve.000", [CURVE], sensor=False)
    file.write_bytes(file.read_bytes().replace(*change, 1))
    with pytest.raises(ValueError, match=message):
        read_curve(file)


def test_a_format_of_ones_own_is_found_by_what_it_recognises(tmp_path):
    def read(file):
        words = [line.split() for line in file.lines.values()]
        height, force = np.array(words[1:], float).T
        columns = [
            ArrayColumn("height", "nm", True, height),
            ArrayColumn("force", "nN", None, force),
        ]
        return CurveTable([Segment("approach", columns)], STIFFNESS * N_M)

    own = CurveFormat(lambda file: file.text.startswith("my curve"), read)
    (file := tmp_path / "curve.mine").write_text("my curve\n2 0\n1 0\n0 3\n")
    with patch.dict(FORMATS, mine=own):
        curve = read_curve(file)
    np.testing.assert_allclose(curve.base / NM, [2.0, 1.0, 0.0], atol=1e-12)


def test_heights_that_are_not_finite_are_an_error(tmp_path):
    missing = np.full(501, np.nan), APPROACH[1]
    keys = {"spring constant": STIFFNESS, "sensitivity": 60e-9}
    formats.afm_hdf5(file := tmp_path / "c.h5", "force-distance", [missing], **keys)
    with pytest.raises(ValueError, match=r"501 of 501 .* height \(measured\)"):
        read_curve(file)


def test_formats_of_instruments_without_their_packages_name_the_extra(
    tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "afmformats", None)
    (file := tmp_path / "curve.jpk-force").write_bytes(b"PK\0\0")
    with pytest.raises(ImportError, match="extra curves"):
        read_curve(file)


def test_a_folder_is_not_a_curve(tmp_path):
    with pytest.raises(ValueError, match=r"is a folder: .*command curves"):
        read_curve(tmp_path)
