"""A process of the program for work beside the window, and the pipe to it.

Both ends are one program: what is unpickled comes from itself.
"""

from __future__ import annotations

import pickle
import signal
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from riglens.core.errors import InputError

LOOK_S = 0.2
"""Seconds between checks whether the work is still wanted."""
Tell = Callable[[float, str], None]
"""Takes the share done, and the stage, empty for the same as before; may raise to cancel."""


@dataclass(frozen=True)
class Failure:
    """Last message of a process that failed, in one line."""

    line: str


class OwnProcess:
    """Process that runs `module:function` on its end of `pipe`, from now on; it ends with the program at the latest."""

    def __init__(self, work: str) -> None:
        context = get_context("spawn")
        self.pipe, inside = context.Pipe()
        self._process = context.Process(target=_run, args=(work, inside), daemon=True)
        self._process.start()
        inside.close()  # the pipe ends with the process

    @property
    def is_alive(self) -> bool:
        """Return whether the process runs."""
        return self._process.is_alive()

    def receive(self, loads: Callable[[bytes], Any] = pickle.loads) -> Any:
        """Return the next message; raise EOFError or OSError when there is none, InputError for a failure."""
        try:
            message = loads(self.pipe.recv_bytes())
        except (EOFError, OSError):
            self._process.join(1.0)  # for its exit code
            raise
        if isinstance(message, Failure):
            self.end()
            raise InputError(message.line)
        return message

    def result(self, tell: Tell) -> Any:
        """Return the first message that is no progress, a pair of share and stage; `tell` takes those meanwhile.

        Raise as `receive`, and end the process in any case.
        """
        try:
            said: Any = (0.0, "")
            while isinstance(said, tuple):
                tell(*said)
                while not self.pipe.poll(LOOK_S):
                    tell(said[0], "")
                said = self.receive()
            return said
        finally:
            self.end()

    def lost(self, work: str) -> InputError:
        """Return what to say of work whose process ended by itself."""
        code = self._process.exitcode
        how = "" if code is None else f" (signal {-code})" if code < 0 else f" (exit code {code})"
        return InputError(f"{work} exited without a result{how}")

    def kill(self) -> None:
        """End the process at any moment: files appear whole or not at all.

        Do not wait for its end: on a busy computer it takes seconds to give back a gigabyte of memory.
        """
        self._process.kill()

    def end(self) -> None:
        """End the process, and wait for its end."""
        self.kill()
        self._process.join()


def _run(work: str, pipe: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the window, and this with it
    module, name = work.split(":")
    with pipe:
        try:
            getattr(import_module(module), name)(pipe)
        except Exception as error:
            traceback.print_exc()
            pipe.send(Failure(f"{type(error).__name__}: {error}"))
