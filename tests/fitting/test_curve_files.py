"""Force curves as instruments write them: the same curve in each of their formats."""

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.curve_files import read_curve

STIFFNESS, SENSITIVITY = 5.0, 40.0  # N/m, nm/V
NM, NN = UNITS["nm"], UNITS["nN"]


def measured():
    """Distances of the base (nm) and forces (nN) of approach and retraction."""
    down, up = np.linspace(4.0, -1.0, 26), np.linspace(-1.0, 5.0, 31)
    pull = np.where(up < 2.0, -2.0 * up, 0.0)
    return (down, np.where(down < 0.0, -2.0 * down, 0.0)), (up, pull)


def rows(separator, *columns):
    return "\n".join(
        separator.join(f"{x:.10g}" for x in row) for row in zip(*columns, strict=True)
    )


def joined(*columns):
    """Values of approach and retraction, one after the other."""
    return [np.concatenate(pair) for pair in columns]


def whole():
    """Distances of the base (nm) and forces (nN), approach before retraction."""
    return joined(*zip(*measured(), strict=True))


def piezo_csv(file):
    """Columns of a table in SI units, the piezo positive towards the surface."""
    base, force = whole()
    file.write_text(f"Piezo (m),Force (N)\n{rows(',', -1e-9 * base, 1e-9 * force)}\n")


def volts(file):
    base, force = whole()
    table = rows("\t", base / 1e3, force / STIFFNESS / SENSITIVITY)
    file.write_text(f"Height [µm]\tDeflection [V]\n{table}\n", encoding="latin-1")


def din(file):
    """Table of a spreadsheet: units behind strokes, decimal commas, UTF-16."""
    base, force = whole()
    table = rows("\t", base / 1e3, 1e3 * force / STIFFNESS / SENSITIVITY)
    text = f"z / µm\tDeflection / mV\n{table}\n".replace(".", ",")
    file.write_text(text, encoding="utf-16")


def savetxt(file):
    """Names in a comment, columns between blanks, as numpy writes them."""
    np.savetxt(file, np.transpose(whole()), header="distance (nm) force (nN)")


def separation(file):
    """Distance of tip and surface, written by Excel."""
    base, force = whole()
    table = rows(";", base + force / STIFFNESS, force)
    file.write_text(f"sep=;\nSeparation (nm);Force (nN);\n{table}\n")


def nanoscope(file):
    """ASCII export of NanoScope: quoted header, branches side by side."""
    (down, push), (up, pull) = measured()
    names = ("Calc_Ramp_Ex_nm", "Calc_Ramp_Rt_nm", "Defl_V_Ex", "Defl_V_Rt")
    names += ("Defl_Lsb_Ex", "Defl_Lsb_Rt", "Defl_pN_Ex", "Defl_pN_Rt")
    short = len(up) - len(down)
    columns = [
        [*(f"{x:.9e}" for x in values), *([""] * (short if i % 2 == 0 else 0))]
        for i, values in enumerate(
            (
                *(-down, -up),
                *(push / STIFFNESS / SENSITIVITY, pull / STIFFNESS / SENSITIVITY),
                *(push * 7, pull * 7),
                *(1e3 * push, 1e3 * pull),
            )
        )
    ]
    lines = ['"\\*Force file list"', '"\\@Sens. DeflSens: V 40 nm/V"']
    lines += ['"\\Spring Constant: 5"', '"\\*Force file list end"', "\t".join(names)]
    lines += ["\t".join(row) for row in zip(*columns, strict=True)]
    file.write_text("\n".join(lines) + "\n")


def nanoscope_in_volts(file):
    """The same without forces, and the retraction in the other order."""
    (down, push), (up, pull) = measured()
    count = len(down)
    scale = STIFFNESS * SENSITIVITY
    table = rows(
        "\t", -down, push / scale, -up[count - 1 :: -1], pull[count - 1 :: -1] / scale
    )
    lines = ["\\@Sens. DeflSens: V 40 nm/V", "\\Spring Constant: 5"]
    heads = "Height_Sensor_nm_Ex\tDefl_V_Ex\tHeight_Sensor_nm_Rt\tDefl_V_Rt"
    file.write_text("\n".join([*lines, heads, table, ""]))


def jpk(file):
    """Text export of JPK: segments with a header each, in SI units."""
    text = "# TEXT EXPORT\n# index: -1\n"
    pause = np.array([5.0, 5.0]), np.array([0.0, 0.0])
    for name, (base, force) in zip(
        ("extend", "retract", "pause"), (*measured(), pause), strict=True
    ):
        text += (
            f"# segment: {name}\n"
            "# columns: verticalTipPosition vDeflection strainGaugeHeight height time\n"
            '# fancyNames: "Vertical Tip Position" "Vertical Deflection" "Height"\n'
            "# sensitivity: 4.0E-8\n# springConstant: 5.0\n# units: m N m m s\n#\n"
        )
        columns = 1e-9 * base, 1e-9 * force, 1e-9 * base, 0.6e-9 * base, 0 * base
        text += rows(" ", *columns) + "\n\n"
    file.write_text(text)


def afm_hdf5(file):
    """File that afmformats has written."""
    pytest.importorskip("afmformats")
    from afmformats.mod_force_distance import AFMForceDistance

    bases, forces = zip(*measured(), strict=True)
    height, force = joined(bases, forces)
    segment = np.repeat([0, 1], [len(base) for base in bases])
    data = {
        "force": 1e-9 * force,
        "height (measured)": 1e-9 * height,
        "segment": segment.astype(np.uint8),
    }
    keys = {"spring constant": STIFFNESS, "imaging mode": "force-distance"}
    keys |= {"enum": 0, "path": file}
    AFMForceDistance(data, keys).export_data(file, fmt="hdf5")


@pytest.mark.parametrize(
    "write, options",
    [
        (piezo_csv, {"stiffness": STIFFNESS * UNITS["N/m"]}),
        (volts, {"stiffness": STIFFNESS * UNITS["N/m"], "sensitivity": "40 nm/V"}),
        (din, {"stiffness": STIFFNESS * UNITS["N/m"], "sensitivity": "40 nm/V"}),
        (savetxt, {"stiffness": STIFFNESS * UNITS["N/m"]}),
        (separation, {"stiffness": STIFFNESS * UNITS["N/m"]}),
        (nanoscope, {}),
        (jpk, {}),
        (afm_hdf5, {}),
    ],
)
def test_a_curve_is_the_same_in_each_format(tmp_path, write, options):
    file = tmp_path / "curve.h5"
    write(file)
    curve = read_curve(file, **options)
    base, force = whole()
    assert curve.stiffness == pytest.approx(STIFFNESS * UNITS["N/m"], rel=1e-6)
    np.testing.assert_allclose(curve.force, force * NN, atol=1e-8)
    np.testing.assert_allclose(curve.base, base * NM, atol=1e-6)
    assert [branch.direction for branch in curve.branches] == [-1.0, 1.0]
    assert curve.doubts == []


def test_branches_of_nanoscope_may_be_in_either_order(tmp_path):
    file = tmp_path / "curve.txt"
    nanoscope_in_volts(file)
    curve = read_curve(file)
    (down, push), (up, pull) = measured()
    count = len(down)
    force = np.append(push, pull[:count]) * NN
    np.testing.assert_allclose(curve.force, force, atol=1e-8)
    np.testing.assert_allclose(curve.base, np.append(down, up[:count]) * NM, atol=1e-6)
    retraction = read_curve(file, "retraction")
    np.testing.assert_array_equal(retraction.force, curve.force[count:])


def test_distance_and_deflection_of_a_cantilever_give_the_depth(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text(
        "branch,distance (nm),deflection (Å),Force (pN)\n"
        "approach,5,1,250\nretraction,4,-2,-500\nretraction,6,0,0\n"
    )
    curve = read_curve(file, "retraction")
    np.testing.assert_allclose(curve.depth, [-38.0, -60.0])
    np.testing.assert_allclose(curve.force, [-0.5 * NN, 0.0])
    np.testing.assert_allclose(curve.base, [40.0, 60.0])
    file.write_text("distance (nm),deflection (nm)\n5,1\n4,2\n6,0\n")
    np.testing.assert_allclose(read_curve(file, None, 0.3).force, [3.0, 6.0, 0.0])
    file.write_text("distance (nm),force (nN)\n5,1\n4,2\n6,0\n")
    np.testing.assert_allclose(read_curve(file, None, 0.3).base, [50.0, 40.0, 60.0])
    with pytest.raises(ValueError, match='--cantilever "5 N/m"'):
        read_curve(file)
    # noise, and another zero of the forces, do not change the stiffness: 1 N/m
    rows = "0,-1,-1.0\n0,-1,0\n0,1,1.0\n0,1,2.0\n"
    file.write_text(f"distance (nm),deflection (nm),force (nN)\n{rows}")
    assert read_curve(file).stiffness == pytest.approx(UNITS["N/m"])
    near = 1.018 * UNITS["N/m"]
    assert read_curve(file, None, near).stiffness == pytest.approx(near)
    message = r"cantilever of 1 N/m, .* 1\.04 N/m"
    with pytest.raises(ValueError, match=message):
        read_curve(file, None, 1.04 * UNITS["N/m"])


def test_a_table_has_depths_and_forces(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text("penetration (Å),normal_force (eV/Å)\n1.5,0.2\n2.0,0.3\n")
    curve = read_curve(str(file))  # as in a table of results
    np.testing.assert_allclose([curve.depth, curve.force], [[1.5, 2.0], [0.2, 0.3]])
    for rows, line, cell in (("1,2\n\n2,NaN\n", 6, "'NaN'"), ("5\n", 4, "None")):
        file.write_text(f"# tip 3\n\ndepth (nm),force (nN)\n{rows}")
        message = rf"line {line}: force \(nN\) .* {cell}"
        with pytest.raises(ValueError, match=message):
            read_curve(file)


def test_a_table_without_branches_may_have_the_retraction_first(tmp_path):
    up = np.linspace(-100.0, 300.0, 401)
    adhesive = np.where((up > -10.0) & (up < 20.0), -5.0, np.maximum(-up, 0.0))
    pressed = np.maximum(-up, 0.0)
    rows = np.column_stack([[*up, *up[::-1]], [*adhesive, *pressed[::-1]]])
    file = tmp_path / "curve.csv"
    head = "distance (nm),force (nN)"
    np.savetxt(file, rows, delimiter=",", header=head, comments="")
    curve = read_curve(file, stiffness=2.0 * UNITS["N/m"])
    approach, retraction = curve.branches
    assert (approach.direction, approach.points) == (-1.0, slice(0, 401))
    assert (retraction.direction, retraction.points) == (1.0, slice(401, 802))
    np.testing.assert_allclose(curve.force[approach.points] / NN, pressed[::-1])
    np.testing.assert_allclose(curve.base[retraction.points] / NM, up, atol=1e-9)
    assert len(curve.remarks) == 1


def test_times_of_a_force_curve_may_be_times_of_the_day(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text("time,depth (nm),force (nN)\n12:00:01,0,0\n12:00:02,1,2\n,2,3\n")
    np.testing.assert_allclose(read_curve(file).force, [0.0, 2 * NN, 3 * NN])


def test_missing_names_units_and_sensitivities_are_asked_for(tmp_path):
    file, stiffness = tmp_path / "curve.csv", STIFFNESS * UNITS["N/m"]
    numbers = "0,0\n-1,1\n-2,2\n"
    for text, message in (
        ("Height,Deflection (nm)\n", "Height has no unit"),
        ("Height (nm),Defl (ft)\n", "unknown unit 'ft'"),
        ("Height (nm),Deflection (V)\n", r'\(V\) needs the sens.*--sensitivity "50 nm'),
        ("", "names of columns"),
        ("Z,pulse\n", r"Z has no unit"),
        ("Z (nm),F (nN)\n1,5,2\n", "line 2: 3 values for the 2 columns"),
        ("Z (nm),Z (nm)\n", r"Z \(nm\) twice: .* --columns \"Height_nm_Ex"),
        ("time,pulse\n", "got time, pulse"),
    ):
        file.write_text(text + numbers)
        with pytest.raises(ValueError, match=message):
            read_curve(file, stiffness=stiffness)
    for text in ("", "Height,Deflection\n"):
        file.write_text(text + numbers)
        names = ["height (nm)", "deflection (nm)"]
        curve = read_curve(file, stiffness=stiffness, heads=names)
        np.testing.assert_allclose(curve.base, [0.0, -10.0, -20.0])
    with pytest.raises(ValueError, match="unknown unit of sensitivity 'nm'"):
        read_curve(file, stiffness=stiffness, heads=names, sensitivity="50 nm")


def test_a_file_that_is_not_text_needs_a_package_that_reads_it(tmp_path):
    pytest.importorskip("afmformats")
    (tmp_path / "curve.h5").write_bytes(b"\0\1\2")
    with pytest.raises(ValueError, match=r"curve\.h5"):
        read_curve(tmp_path / "curve.h5")
