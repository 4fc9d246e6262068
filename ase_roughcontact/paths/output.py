"""Output of a path: its results, and its restart file, table and frames."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from ase_roughcontact._util.files import PathName, check_different
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import boolean, instance_of, one_of
from ase_roughcontact.paths.kept_frames import KEPT, Keep
from ase_roughcontact.paths.restart import restart_file
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.stepping.relaxed import RelaxedStep

# Attributes of `Output` by the endings of their files.
_ENDINGS = {".csv": "csv", ".traj": "trajectory", ".npz": "restart"}


class Frames(Protocol):
    """Makes the frames of a trajectory, and writes them."""

    def frame(self, relaxed: RelaxedStep, **info: Any) -> Any:
        """Return the frame of a step as it leaves the surface."""
        ...

    def writer(
        self, file: PathName, keep: str, finished: int | None
    ) -> AbstractContextManager[Callable[[Any], None]]:
        """Open a file for the frames that it is to keep, after some finished steps."""
        ...


@dataclass(frozen=True, kw_only=True)
class Output(Summarized):
    """Results of a path, and the files to which they are written.

    Attributes
    ----------
    csv : path, optional
        CSV file of the results, one line per step, which is on disk before the next
        step begins.
    trajectory : path, optional
        File of frames for looking at the path, in single precision; see `read_frames`.
    keep : {"thinned", "all", "last"}
        Frames that the trajectory keeps: at most about a hundred at equal distances and
        the last one, one of each step, or the last one alone.
    restart : path, optional
        File of the finished steps and of the state after the last one, in double
        precision, which is replaced after each step. By default it is beside the
        trajectory: ``sweep.restart.npz`` for ``sweep.traj``.
    resume : bool
        Resume after the steps in the restart file: they are yielded, but not
        calculated, again. The path may have been extended at its end. The surface must
        have the history (plastic shape, creep, friction) with which the path began or
        ended. Steps from the first one on that did not converge are calculated again if
        `max_steps` is larger, or the optimizer another one.
    record : type
        Class of the results: `LoadStep`, or a subclass with more columns.
    columns : sequence of str, optional
        Names of columns that are calculated on request only, such as
        ``["conductance"]``; by default the columns of the class. Steps that are resumed
        have the columns with which they were calculated.
    frames : Frames, optional
        The object that makes the frames of a trajectory; `load_path` sets it.

    Raises
    ------
    ValueError
        If `resume` is set without a file to resume from, two files are one, or `keep`
        is unknown.
    TypeError
        If `record` is not a dataclass of columns, or a file no path.

    Examples
    --------
    >>> from ase_roughcontact import Output
    >>> output = Output(trajectory='sweep.traj', csv='curve.csv', resume=True)
    """

    csv: PathName | None = None
    trajectory: PathName | None = None
    keep: Keep = "thinned"
    restart: PathName | None = None
    resume: bool = False
    record: type[LoadStep] = LoadStep
    columns: Sequence[str] | None = None
    frames: Frames | None = None

    def __post_init__(self) -> None:
        """Check the options."""
        if self.resume and self.restart_file is None:
            raise ValueError("resume=True needs a restart file or a trajectory")
        one_of(KEPT, keep=self.keep)
        boolean(resume=self.resume)
        files = {name: getattr(self, name) for name in ("csv", "trajectory", "restart")}
        given = {name: file for name, file in files.items() if file is not None}
        for name, file in given.items():
            instance_of((str, os.PathLike), **{name: file})
        instance_of(type, record=self.record)
        check_different(**given)
        columns_of(self.record)  # raises if it is not a class of results

    @classmethod
    def of(cls, given: OutputLike | None) -> Output:
        """Return the output that an argument of a path stands for.

        Parameters
        ----------
        given : Output or path, optional
            A path is a folder for the files ``curve.csv`` and ``sweep.traj`` and for
            the restart file, from which the path is resumed. None: no files.

        Returns
        -------
        Output

        Raises
        ------
        TypeError
            If it is something else.
        ValueError
            If it is the name of a file of results.
        OSError
            If the folder can't be created.
        """
        if given is None:
            return cls()
        if isinstance(given, str | os.PathLike):
            folder = Path(given)
            if folder.suffix in _ENDINGS:
                raise ValueError(
                    f"output must be an Output or a folder, got {os.fspath(given)!r}: "
                    f"for a file give Output({_ENDINGS[folder.suffix]}=...)"
                )
            folder.mkdir(parents=True, exist_ok=True)
            return cls(
                csv=folder / "curve.csv",
                trajectory=folder / "sweep.traj",
                resume=True,
            )
        instance_of((Output, str, os.PathLike), output=given)
        return given

    @property
    def restart_file(self) -> PathName | None:
        """File from which the path is resumed; None without one."""
        if self.restart is None and self.trajectory is not None:
            return restart_file(self.trajectory)
        return self.restart


#: The argument `output` of a path; see `Output.of`.
OutputLike: TypeAlias = Output | PathName
