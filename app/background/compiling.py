"""Compile kernels in another process: the slowest one during the first load, then those that the open rig does not
need."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence

END_S = 5.0
"""Seconds that closing waits for the process to exit."""
LOOK_S = 0.05
"""Seconds between checks whether the process has exited."""


class OtherKernels:
    """A process of low priority that leaves compiled code on disk, started at most once, by any thread."""

    def __init__(
        self, command: Sequence[str] = (sys.executable, "-m", "riglens.app.evaluation.every_kernel")
    ) -> None:
        self._command = list(command)
        self._process: subprocess.Popen[bytes] | None = None
        self._is_over = False
        """True once it has been started, or must not start."""
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Start the process, unless all is on disk already; without it kernels are compiled when they are needed."""
        self._start(())

    def begin_beside(self) -> None:
        """Start it at once, with fans first, where there is a second processor and they are not on disk; it then goes
        on with everything else."""
        from riglens.app.evaluation.kernel_steps import FANS_FIRST  # as below
        from riglens.core.engine.warm_up import are_fans_compiled

        if (os.cpu_count() or 1) > 1 and not are_fans_compiled():
            self._start((FANS_FIRST,))

    def wait_for_fans(
        self, is_unwanted: Callable[[], bool], sleep: Callable[[float], None] = time.sleep
    ) -> None:
        """Block until the process has written the fans to disk, has exited, or is no longer needed."""
        from riglens.core.engine.warm_up import are_fans_compiled  # as below

        while self.is_running and not are_fans_compiled() and not is_unwanted():
            sleep(LOOK_S)

    def _start(self, options: Sequence[str]) -> None:
        from riglens.app.evaluation.kernel_steps import (  # the thread has loaded the compiler
            STEPS,
            steps_done,
        )

        with self._lock:
            if self._is_over:
                return
            self._is_over = True
            nothing, command = subprocess.DEVNULL, [*self._command, *options]
            with contextlib.suppress(OSError):
                if steps_done() < len(STEPS):
                    self._process = subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)

    @property
    def is_running(self) -> bool:
        """Return whether the process is at work."""
        return self._process is not None and self._process.poll() is None

    def progress(self) -> tuple[int, int] | None:
        """Return how many steps are ready and of how many, None while no process is at work."""
        if not self.is_running:
            return None
        from riglens.app.evaluation.kernel_steps import (  # loaded by the thread that started it
            STEPS,
            steps_done,
        )

        return steps_done(), len(STEPS)

    def close(self) -> None:
        """End the process; kernels compiled so far stay on disk."""
        with self._lock:
            self._is_over = True
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait(END_S)
