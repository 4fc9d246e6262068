"""Units in print follow from the scene, and are the same in tables and figures."""

from unittest.mock import patch

import numpy as np
import pytest
from command_cases import keep_figure
from matplotlib.figure import Figure

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.scene import Results, Scene
from ase_roughcontact.scene.printed import units_in_print

GEL = """
substrate = { contact_modulus = "2 kPa", spacing = "0.5 um", model = "continuum" }
sphere.radius = "20 um"
interaction.kind = "hard"
path = { control = "penetration", values = ["0.1 um", "0.2 um"] }
"""


@pytest.mark.parametrize(
    "modulus, spacing, units",
    [
        ("70 GPa", "2.5 Å", ("nN", "nm²", "Å", "GPa")),
        ("70 GPa", "3 nm", ("nN", "nm²", "nm", "GPa")),
        ("70 GPa", "1 um", ("µN", "µm²", "nm", "GPa")),
        ("2 kPa", "0.5 um", ("nN", "µm²", "nm", "Pa")),
    ],
)
def test_units_suit_modulus_and_spacing(modulus, spacing, units):
    values = {"substrate.contact_modulus": modulus, "substrate.spacing": spacing}
    found = units_in_print(Scene.parse(GEL).with_values(values))
    names = "normal_force", "contact_area", "penetration", "largest_pressure"
    assert tuple(found[name] for name in names) == units


def test_figures_of_a_gel_have_the_units_of_its_table(tmp_path, capsys):
    (tmp_path / "gel.toml").write_text(GEL)
    out, figures = tmp_path / "out", {}
    with patch.object(Figure, "savefig", keep_figure(figures)):
        main(["run", str(tmp_path / "gel.toml"), "--out", str(out)])
    heads = capsys.readouterr().out
    assert "(nm)" in heads and "(µm²)" in heads and "(Å)" not in heads
    results = Results(out)
    area = results["continuum_area"] / UNITS["µm²"]
    upper = figures["curve.png"].axes[0]
    assert upper.get_ylabel() == "contact area (µm$^2$)"
    shown = [line for line in upper.lines if line.get_label().startswith("simulation")]
    np.testing.assert_allclose(shown[0].get_ydata(), area)
    (axes,) = figures["force.png"].axes
    assert axes.get_xlabel().endswith("(nm)")
    depths = np.unique(np.concatenate([line.get_xdata() for line in axes.lines]))
    for depth in results["penetration"] / UNITS["nm"]:
        assert np.isclose(depths, depth).any()
    (axes,) = results.figure().axes
    np.testing.assert_allclose(axes.lines[0].get_xdata()[-1], 200.0)
    assert axes.get_xlabel() == "penetration (nm)"
