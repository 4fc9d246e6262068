"""Crystal surfaces, each calculated once."""

import pytest
from pair_crystal import diamond_surface, pair_surface


@pytest.fixture(scope="session")
def surface():
    return pair_surface()


@pytest.fixture(scope="session")
def hexagonal_surface():
    return pair_surface("fcc111")


@pytest.fixture(scope="session", name="diamond_surface")
def diamond():
    return diamond_surface()
