"""What a terminal shows is what is printed into a pipe, above a bar that vanishes."""

import re

import numpy as np
import pytest
from command_cases import printed
from terminal import screen_of

pytest.importorskip("pyte")

SPHERE = """
[substrate]
spacing = "1 nm"
contact_modulus = 100.0
hardness = 3.0
[sphere]
radius = "30 nm"
[interaction]
kind = "hard"
"""
SCENES = {
    "run": SPHERE + "[path]\nvalues = [5.0, 50.0, 500.0, 2000.0]\n",
    "preview": SPHERE + "[path]\nfirst = 5.0\nlast = 2000.0\nsteps = 13\n",
    "time": SPHERE
    + 'relaxation_moduli = [0.5]\nrelaxation_times = ["1 s"]\n'.join(["", ""])
    + '[path]\nkind = "time"\ncontrol = "load"\nvalues = [100, 200]\nrate = 100\n',
}
