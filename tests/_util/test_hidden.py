"""Packages that imports do not find for a while."""

import sys
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module

import pytest

from ase_roughcontact._util.hidden import hidden

# Name of an empty module.
MODULE = "module_of_a_test"


@pytest.fixture
def module(tmp_path, monkeypatch):
    (tmp_path / f"{MODULE}.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    yield MODULE
    sys.modules.pop(MODULE, None)


def test_a_hidden_package_is_not_found_until_the_end(module):
    before = list(sys.meta_path)
    with pytest.raises(ModuleNotFoundError, match=module), hidden(module):
        import_module(module)
    assert sys.meta_path == before
    assert import_module(module).__name__ == module


def test_another_thread_finds_a_hidden_package(module):
    with hidden(module), ThreadPoolExecutor(1) as threads:
        assert threads.submit(import_module, module).result().__name__ == module


def test_a_package_that_is_loaded_stays(module):
    loaded = import_module(module)
    with hidden(module):
        assert import_module(module) is loaded


def test_other_packages_are_found(module):
    with hidden("no_package_of_this_name"):
        assert import_module(module).__name__ == module
