"""Executors of workers on other machines, with a Dask scheduler."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ase_roughcontact._util.extras import imported

# Longest time to wait for the scheduler (s).
_TIMEOUT = 30


@contextmanager
def scheduler_executor(address: str) -> Iterator[tuple[Executor, str]]:
    """Connect to a scheduler of Dask until the end of the context.

    Parameters
    ----------
    address : str
        Address ``tcp://host:8786`` or ``tls://host:8786``, or the JSON file that ``dask
        scheduler --scheduler-file`` writes. Dask's configuration names the certificates
        for TLS.

    Yields
    ------
    executor : Executor
        Executor for `run_ensemble`.
    workers : str
        Words for the number of connected workers and the address of the dashboard.

    Raises
    ------
    ImportError
        If Dask is not installed.
    OSError
        If there is no scheduler at the address, or the file can't be read.
    ValueError
        If the address needs certificates, and the configuration has none, or a worker
        has another version of this package.
    """
    dask = imported("dask.distributed", "distributed", "a scheduler needs Dask")
    if address.endswith(".json"):
        address = _address_in(Path(address))
    try:
        client = dask.Client(address, timeout=_TIMEOUT)
    except TypeError as error:  # tls:// without certificates
        raise ValueError(f"can't connect to {address}: {error}") from error
    with client:
        _check_versions(client)
        count = len(client.nthreads())
        workers = f"{count} worker{'' if count == 1 else 's'} at {address}"
        if not count:
            workers = f"no workers at {address} yet: waiting for them"
        # not pure: Dask calculates a case again if it is submitted again
        executor = client.get_executor(pure=False)
        yield executor, f"{workers}; dashboard: {client.dashboard_link}"


def _address_in(file: Path) -> str:
    """Return the address in a scheduler file of Dask."""
    try:
        return str(json.loads(file.read_text(encoding="utf-8"))["address"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(
            f"{file} has no address of a scheduler: let dask scheduler "
            "--scheduler-file write it again"
        ) from error


def _check_versions(client: Any) -> None:
    """Raise `ValueError` if a connected worker has another version of this package.

    Without this check, a worker without the package would end when it gets a case, and
    the client would not notice.
    """
    name = "ase-roughcontact"
    for worker, found in client.run(version, name, on_error="return").items():
        if found != version(name):
            raise ValueError(
                f"the worker at {worker} must have {name} {version(name)}, as this "
                f"process; got {found if isinstance(found, str) else 'none'}"
            )
