"""The entry point: errors, signals and warnings of a command become lines."""

from __future__ import annotations

import argparse
import io
import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import metadata
from typing import NoReturn

from ase_roughcontact._util.printing import write, write_error
from ase_roughcontact.cli.messages import ERRORS, print_error
from ase_roughcontact.cli.parser import function_of, make_parser

# Packages with versions that matter to results and files.
_DEPENDENCIES = (
    "ase",
    "numpy",
    "scipy",
    "pyfftw",
    "ducc0",
    "matscipy",
    "matplotlib",
    "SurfaceTopography",
    "distributed",
)


class _Terminated(KeyboardInterrupt):
    """SIGTERM was received; all is left as after Ctrl-C."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    _prepare_streams()
    parser = make_parser()
    options, unknown = parser.parse_known_args(arguments)
    if unknown:
        options.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    try:
        if options.version:
            _print_versions(options.verbose)
            return 0
        if options.command is None:
            parser.print_help()
            return 0
        with _signals_and_warnings():
            return function_of(options.function)(options)
    except ERRORS as error:
        print_error(error)
        return 2
    except _Terminated:
        write_error(f"\nterminated{_kept_results(options)}")
        return 128 + signal.SIGTERM
    except KeyboardInterrupt:
        write_error(f"\ninterrupted{_kept_results(options)}")
        return 128 + signal.SIGINT


def _prepare_streams() -> None:
    """Replace characters that streams can't encode, and closed streams.

    Files that are opened later would have the numbers of closed streams.
    """
    closed = sys.stdout is None
    for number, name in (1, "stdout"), (2, "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            nothing = os.open(os.devnull, os.O_WRONLY)
            if nothing != number:
                os.dup2(nothing, number)
                os.close(nothing)
            setattr(sys, name, open(number, "w", encoding="utf-8"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    if closed:
        print_error("the standard output is closed: going on without printing")


def _print_versions(verbose: bool) -> None:
    """Print the version, if wanted with the versions of Python and the dependencies."""
    write(f"ase-roughcontact {metadata.version('ase-roughcontact')}")
    if not verbose:
        return
    write(f"Python {sys.version.split()[0]} on {sys.platform}")
    for name in _DEPENDENCIES:
        try:
            write(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            write(f"{name}: not installed")


@contextmanager
def _signals_and_warnings() -> Iterator[None]:
    """Raise `_Terminated` on SIGTERM, and print warnings as lines.

    It also replaces an error after a signal to stop: NumPy raises a `TypeError` if the
    handler raises while it writes an array to a file.
    """
    kinds: dict[int, type[KeyboardInterrupt]] = {signal.SIGTERM: _Terminated}
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        kinds[signal.SIGINT] = KeyboardInterrupt  # else it is ignored
    received = list[type[KeyboardInterrupt]]()

    def stop(number: int, _: object) -> NoReturn:
        received.append(kinds[number])
        raise kinds[number]

    with warnings.catch_warnings():
        warnings.showwarning = lambda warning, *_, **__: _print_warning(warning)
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, stop) for number in kinds}
        try:
            yield
        except Exception:
            if received:
                raise received[0] from None
            raise
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def _print_warning(warning: Warning | str) -> None:
    """Print a warning as a line, with the name of the library that issued it."""
    frame, skipped = sys._getframe(1), (__name__, warnings.__name__)
    while frame.f_back and frame.f_globals["__name__"] in skipped:
        frame = frame.f_back
    source = frame.f_globals["__name__"].partition(".")[0]
    kind = "warning"
    if source not in ("ase_roughcontact", "__main__"):
        kind += f" of {source}"
    print_error(f"{kind}: {warning}")


def _kept_results(options: argparse.Namespace) -> str:
    """Return which results of an interrupted command are kept, and how to continue."""
    if options.command not in ("run", "ensemble"):
        return ""
    again = "to continue, give the same command again"
    if options.command == "ensemble":
        from ase_roughcontact.ensemble.database import without_password

        database = without_password(options.database)
        return f"; finished steps are saved in {database}; {again}"
    if not (options.out / "sweep.traj").exists():
        return "; no step was finished"
    return (
        f"; finished steps are saved in {options.out}; {again}; to draw them: "
        f"ase-roughcontact figure {options.out}"
    )
