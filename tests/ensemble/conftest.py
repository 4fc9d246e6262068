"""An ensemble that several tests compare with."""

import pytest
from ensemble_scenes import SCENES, STEPS, finish


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    """Database of all cases, calculated one after the other."""
    database = tmp_path_factory.mktemp("undisturbed") / "e.db"
    assert finish(SCENES, database).steps == STEPS
    return database
