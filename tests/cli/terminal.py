"""What a terminal shows of a command, its lines that were scrolled away included."""

import fcntl
import os
import struct
import subprocess
import sys
import termios
from contextlib import suppress

import pyte

# Height of the screen, less than that of most outputs.
HEIGHT = 24
COMMAND = [sys.executable, "-m", "ase_roughcontact"]


def screen_of(arguments, columns, **options):
    """Return exit status and lines of a command on a terminal of some columns."""
    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("4H", HEIGHT, columns, 0, 0))
    environment = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES")}
    with subprocess.Popen(
        [*COMMAND, *map(str, arguments)],
        stdin=slave,
        stdout=slave,
        stderr=slave,
        env=environment | {"TERM": "xterm-256color"},
        **options,
    ) as process:
        os.close(slave)
        screen = pyte.HistoryScreen(columns, HEIGHT, history=10_000)
        stream = pyte.ByteStream(screen)
        with suppress(OSError):  # the end of the output
            while part := os.read(master, 65536):
                stream.feed(part)
    os.close(master)
    above = [
        "".join(line[column].data for column in range(columns))
        for line in screen.history.top
    ]
    lines = [line.rstrip() for line in (*above, *screen.display)]
    while lines and not lines[-1]:
        lines.pop()
    return process.returncode, lines
