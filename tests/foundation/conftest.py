"""Crystal surfaces, each calculated once."""

import pytest
from pair_crystal import pair_surface


@pytest.fixture(scope="session")
def surface():
    return pair_surface()


@pytest.fixture(scope="session")
def hexagonal_surface():
    return pair_surface("fcc111")
