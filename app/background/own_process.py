"""Run a function of the program in a separate process, on a request object.

The request goes to the process pickled; what comes back are lines of JSON, a share and a word about it. Both ends are
one program.
"""

from __future__ import annotations

import json
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import IO

from riglens.core.errors import InputError

Tell = Callable[[float, str], None]
"""Takes the share done, and a line about what was done, empty for none."""
PROGRAM = "import sys; from riglens.app.commands.handed import main; sys.exit(main(sys.argv[1]))"
_WAIT_S = 0.2


def run_in_process(work: str, request: object, tell: Tell, program: str = PROGRAM) -> None:
    """Run `module:function` on a request and wait for it.

    `tell` gets the progress of the function, and repeats the last share; it may raise to cancel, which ends the
    process. Raise InputError with the line that the command line would give.
    """
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen(
            [sys.executable, "-c", program, work], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said
        ) as process:
            assert process.stdin is not None and process.stdout is not None
            try:
                with suppress(BrokenPipeError), process.stdin:  # it says itself why it ended
                    process.stdin.write(pickle.dumps(request))
                _follow(process.stdout, tell)
            except BaseException:
                process.terminate()  # at any moment: files appear whole or not at all
                raise
        if process.returncode != 0:
            said.seek(0)
            lines = said.read().decode("utf-8", errors="replace").split("\n")
            last = next((line for line in reversed(lines) if line.strip()), "")
            raise InputError(last.removeprefix("riglens: ") or "the process exited without a message")


def _follow(stream: IO[bytes], tell: Tell) -> None:
    """Forward the progress of the process until it ends."""
    lines: queue.Queue[bytes | None] = queue.Queue()
    threading.Thread(target=_read, args=(stream, lines), daemon=True).start()
    share = 0.0
    while True:
        tell(share, "")
        try:
            line = lines.get(timeout=_WAIT_S)
        except queue.Empty:
            continue
        if line is None:
            return
        share, told = json.loads(line)
        tell(share, told)


def _read(stream: IO[bytes], lines: queue.Queue[bytes | None]) -> None:
    for line in stream:
        lines.put(line)
    lines.put(None)
