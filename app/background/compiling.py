"""The kernels that the open rig does not need, compiled in a process of its own while the window is at work."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import threading
from collections.abc import Sequence

END_S = 5.0
"""How long closing waits for the process to be gone."""


class OtherKernels:
    """A process of low priority that leaves compiled code on disk, started at most once, by any thread."""

    def __init__(
        self, command: Sequence[str] = (sys.executable, "-m", "riglens.core.engine.warm_up")
    ) -> None:
        self._command = list(command)
        self._process: subprocess.Popen[bytes] | None = None
        self._is_over = False
        """Whether it has been started, or is not to be."""
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Start the process, unless all is on disk already; without it kernels are compiled when they are needed."""
        from riglens.core.engine.warm_up import is_everything_compiled  # the thread has loaded the compiler

        with self._lock:
            if self._is_over:
                return
            self._is_over = True
            nothing = subprocess.DEVNULL
            with contextlib.suppress(OSError):
                if not is_everything_compiled():
                    self._process = subprocess.Popen(
                        self._command, stdin=nothing, stdout=nothing, stderr=nothing
                    )

    @property
    def is_running(self) -> bool:
        """Whether the process is at work."""
        return self._process is not None and self._process.poll() is None

    def close(self) -> None:
        """End the process; what it has compiled by now stays on disk."""
        with self._lock:
            self._is_over = True
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait(END_S)
