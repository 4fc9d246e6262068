"""The API reference is built from the docstrings without a warning."""

import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1] / "examples" / "reference"


def test_reference_is_built_without_warnings(tmp_path):
    command = [sys.executable, "-m", "sphinx", "-q", "-W", str(SOURCE), str(tmp_path)]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    page = (tmp_path / "index.html").read_text()
    for name in ("load_path", "RoughContact", "adhesion_loop", "run_ensemble"):
        assert f"{name}</span>" in page
