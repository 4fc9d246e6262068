"""Locks of files."""

from ase_roughcontact._util.files import lock


def test_one_of_two_locks_a_file_and_the_file_is_removed(tmp_path):
    name = tmp_path / "a.lock"
    with lock(name) as first:
        with lock(name) as second:
            assert first and not second
        assert name.exists()
    assert not name.exists()
