"""What a terminal shows of a command, its lines that were scrolled away included."""

import fcntl
import os
import struct
import subprocess
import sys
import termios
from contextlib import redirect_stdout, suppress
from threading import Thread

import pyte

from ase_roughcontact.cli import main

# Height of the screen, less than most outputs have.
_HEIGHT = 24


class Terminal:
    """A pseudo-terminal of some columns; its output is read as it is written."""

    def __init__(self, columns):
        self._master, self.slave = os.openpty()
        size = struct.pack("4H", _HEIGHT, columns, 0, 0)
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, size)
        self._screen = pyte.HistoryScreen(columns, _HEIGHT, history=10_000)
        self._reader = Thread(target=self._read)
        self._reader.start()

    def _read(self):
        stream = pyte.ByteStream(self._screen)
        with suppress(OSError):  # the end of the output
            while part := os.read(self._master, 65536):
                stream.feed(part)
        os.close(self._master)

    def lines(self):
        """Close it and return its lines, from the first one that was printed."""
        os.close(self.slave)
        self._reader.join()
        places = range(self._screen.columns)
        above = self._screen.history.top
        lines = ["".join(line[k].data for k in places) for line in above]
        lines = [line.rstrip() for line in (*lines, *self._screen.display)]
        while lines and not lines[-1]:
            lines.pop()
        return lines


def screen_of(arguments, columns, monkeypatch):
    """Return exit status and output of a command on a terminal of some columns."""
    terminal = Terminal(columns)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("COLUMNS", raising=False)
    # the size of the terminal of the tests
    size = os.terminal_size((columns, _HEIGHT))
    monkeypatch.setattr(os, "get_terminal_size", lambda *_: size)
    with (
        open(os.dup(terminal.slave), "w", encoding="utf-8") as stream,
        redirect_stdout(stream),
    ):
        status = main(list(map(str, arguments)))
    return status, terminal.lines()


def screen_of_process(arguments, columns):
    """Return the same of a new process, which asks the terminal for its size."""
    terminal = Terminal(columns)
    environment = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES")}
    done = subprocess.run(
        [sys.executable, "-m", "ase_roughcontact", *map(str, arguments)],
        stdin=terminal.slave,
        stdout=terminal.slave,
        stderr=terminal.slave,
        env=environment | {"TERM": "xterm-256color"},
    )
    return done.returncode, terminal.lines()
