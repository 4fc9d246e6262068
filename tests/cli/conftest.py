"""Runs that several tests compare with."""

import pytest
from command_cases import CASES, run_case


@pytest.fixture(scope="session", params=CASES.values(), ids=CASES.keys())
def case(request, tmp_path_factory):
    return run_case(tmp_path_factory.mktemp("run"), *request.param)
