"""Workers of a Dask scheduler: what the command connects to, and what may be killed."""

import json
import re
import signal
import subprocess
import sys
import types
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from importlib.metadata import PackageNotFoundError, version

import pytest
from ensemble_scenes import LONG, assert_same_states, finish, rows, wait_for

from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import product, read_ensemble

SCENE = LONG.with_values({"path.steps": 20})
VALUES = {"roughness.seed": range(3)}
COMMAND = ("ensemble", "my.toml", "--set", "roughness.seed=0,1,2", "--database", "e.db")


class FakeClient(ExitStack):
    """Client of a scheduler with one worker in this process."""

    dashboard_link = "http://host:8787/status"
    found = version("ase-roughcontact")
    addresses: list[str] = []

    def __init__(self, address, timeout):
        if address.startswith("tls://"):
            raise TypeError("TLS expects a context")
        super().__init__()
        self.addresses.append(address)
        self.pool = self.enter_context(ThreadPoolExecutor(1))

    def nthreads(self):
        return {"tcp://worker:1": 1}

    def run(self, *_, **__):
        return {"tcp://worker:1": self.found}

    def get_executor(self, pure):
        assert pure is False
        return self.pool


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Working folder with a scene and a module of Dask with the client above."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(LONG.with_values({"path.steps": 2}).toml)
    fake = types.SimpleNamespace(Client=FakeClient)
    monkeypatch.setitem(sys.modules, "dask.distributed", fake)
    monkeypatch.setattr(FakeClient, "addresses", [])
    return tmp_path


def test_command_calculates_with_the_workers_of_a_scheduler(folder, capsys):
    address = "tcp://host:8786"
    (folder / "scheduler.json").write_text(json.dumps({"address": address}))
    assert main([*COMMAND, "--scheduler", "scheduler.json"]) == 0
    assert FakeClient.addresses == [address]
    text = capsys.readouterr().out
    assert text.startswith(f"1 worker at {address}; dashboard: http://host:8787/status")
    assert len(read_ensemble("e.db")["step"]) == 6


@pytest.mark.parametrize("contents", ["{}", "[]", "abc", ""])
def test_a_file_without_an_address_is_named(folder, capsys, contents):
    (folder / "scheduler.json").write_text(contents)
    assert main([*COMMAND, "--scheduler", "scheduler.json"]) == 2
    error = capsys.readouterr().err
    assert "scheduler.json has no address" in error and "Traceback" not in error


@pytest.mark.parametrize("error", [True, False])
def test_no_worker_of_another_version_is_used(folder, capsys, monkeypatch, error):
    found = PackageNotFoundError("ase-roughcontact") if error else "0.0.1"
    monkeypatch.setattr(FakeClient, "found", found)
    assert main([*COMMAND, "--scheduler", "tcp://host:8786"]) == 2
    got = "none" if error else "0.0.1"
    pattern = rf"worker at tcp://worker:1 must have ase-roughcontact .*; got {got}\n"
    assert re.search(pattern, capsys.readouterr().err)


@pytest.mark.parametrize(
    "address, message",
    [
        ("no.json", "no.json"),
        ("tls://host:1", "can't connect to tls://host:1: TLS expects"),
    ],
)
def test_what_is_no_scheduler_is_a_line_on_stderr(folder, capsys, address, message):
    assert main([*COMMAND, "--scheduler", address]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


def test_a_missing_dask_is_named_with_its_extra(folder, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    assert main([*COMMAND, "--scheduler", "tcp://host:8786"]) == 2
    assert "install the extra distributed" in capsys.readouterr().err


@pytest.mark.slow  # a scheduler and its processes
@pytest.mark.parametrize("killed", ["client", "scheduler"])
def test_an_ensemble_continues_though_client_or_scheduler_are_killed(
    tmp_path, killed, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(SCENE.toml)
    started = []

    def start(module, *arguments):
        run = f"from {module} import main; raise SystemExit(main())"
        process = subprocess.Popen([sys.executable, "-c", run, *arguments])
        started.append(process)
        return process

    def start_cluster(name):
        options = "--host=127.0.0.1", "--port=0", "--dashboard-address=:0"
        start("distributed.cli.dask_scheduler", *options, f"--scheduler-file={name}")
        wait_for((tmp_path / name).exists, 120)
        options = f"--scheduler-file={name}", "--nthreads=1", "--no-dashboard"
        start("distributed.cli.dask_worker", *options)
        return ["--scheduler", name]

    try:
        scheduler = start_cluster("one.json")
        client = start("ase_roughcontact.cli", *COMMAND, *scheduler)
        database = tmp_path / "e.db"
        wait_for(lambda: database.exists() and database.stat().st_size, 120)
        wait_for(lambda: rows(database, record="step"), 120)
        before = {row.unique_id for row in rows("e.db", record="step")}
        if killed == "client":
            client.send_signal(signal.SIGKILL)
        else:
            started[0].send_signal(signal.SIGKILL)
            assert client.wait(120) == 2
            scheduler = start_cluster("two.json")
        assert main([*COMMAND, *scheduler]) == 0
    finally:
        for process in started:
            process.terminate()
        for process in started:
            process.wait(60)
    assert before <= {row.unique_id for row in rows("e.db", record="step")}
    columns = read_ensemble("e.db")
    assert len(columns["step"]) == 60
    finish(product(SCENE, VALUES), "whole.db")
    assert_same_states(columns, read_ensemble("whole.db"))
