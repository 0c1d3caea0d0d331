"""Compile kernels in other processes: half of what the open rig needs during the first load, then all others."""

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
    """Processes of low priority that leave compiled code on disk, one for each share of the steps, each started at
    most once, by any thread."""

    def __init__(
        self, command: Sequence[str] = (sys.executable, "-m", "riglens.evaluation.every_kernel")
    ) -> None:
        self._command = list(command)
        self._processes: dict[int, subprocess.Popen[bytes] | None] = {}
        """By share; None where there was nothing to compile."""
        self._is_closed = False
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Start the processes, unless all is on disk; without them kernels are compiled when they are needed."""
        from riglens.evaluation.kernel_steps import shares_of  # the thread has loaded the compiler

        for share, steps in enumerate(shares_of(os.cpu_count() or 1)):
            self._start(share, steps)

    def begin_beside(self, half: str) -> None:
        """Start the first share at once, with half of what the open rig needs first, where there is a second processor
        and it is not on disk."""
        from riglens.core.engine.warm_up import is_compiled
        from riglens.evaluation.kernel_steps import first, shares_of  # as above

        processors = os.cpu_count() or 1
        if processors > 1 and not is_compiled(half):
            self._start(0, (first(half), *shares_of(processors)[0]))

    def wait_for(
        self, half: str, is_unwanted: Callable[[], bool], sleep: Callable[[float], None] = time.sleep
    ) -> None:
        """Block until the process has written its half to disk, has exited, or is no longer needed."""
        from riglens.core.engine.warm_up import is_compiled  # as above

        while self.is_running and not is_compiled(half) and not is_unwanted():
            sleep(LOOK_S)

    def _start(self, share: int, arguments: Sequence[str]) -> None:
        from riglens.evaluation.kernel_steps import STEPS, is_done  # as above

        with self._lock:
            if self._is_closed or share in self._processes:
                return
            self._processes[share] = None
            nothing, command = subprocess.DEVNULL, [*self._command, *arguments]
            with contextlib.suppress(OSError):
                if not all(is_done(step) for step in STEPS if step in arguments):
                    self._processes[share] = subprocess.Popen(
                        command, stdin=nothing, stdout=nothing, stderr=nothing
                    )

    def is_done(self, step: str) -> bool:
        """Return whether the kernels of a step are on disk."""
        from riglens.evaluation.kernel_steps import is_done  # as above

        return is_done(step)

    def _running(self) -> list[subprocess.Popen[bytes]]:
        with self._lock:
            return [one for one in self._processes.values() if one is not None and one.poll() is None]

    @property
    def is_running(self) -> bool:
        """Return whether a process is at work."""
        return bool(self._running())

    def progress(self) -> tuple[int, int] | None:
        """Return how many steps are ready and of how many, None while no process is at work."""
        if not self.is_running:
            return None
        from riglens.evaluation.kernel_steps import (  # loaded by the thread that started it
            STEPS,
            steps_done,
        )

        return steps_done(), len(STEPS)

    def close(self) -> None:
        """End the processes; kernels compiled so far stay on disk."""
        with self._lock:
            self._is_closed = True
        for one in self._running():
            one.kill()
            one.wait(END_S)
