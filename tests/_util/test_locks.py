"""Locks of files."""

from ase_roughcontact._util.locks import lock


def test_a_lock_does_not_remove_the_one_that_has_replaced_it(tmp_path):
    name = tmp_path / "a.lock"
    with lock(name) as first:
        name.unlink()
        with lock(name) as second, lock(name) as third:
            assert first and second and not third
            inner = name.stat().st_ino
            with lock(name):
                pass
            assert name.stat().st_ino == inner
    assert not name.exists()
