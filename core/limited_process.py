"""Run a module on foreign input in a process of its own, with limits of time and memory.

A parser that loops, eats memory or crashes ends only that process.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil

from riglens.core.errors import InputError

_POLL_S = 0.05
_BUSY_MACHINE = 10.0
"""Wall time allowed, as a multiple of the limit of processor time: other programs may keep the processors busy."""


def answer_of(
    module: str,
    *arguments: str,
    where: str,
    time_limit_s: float,
    still_wanted: Callable[[], object],
    given: bytes = b"",
) -> bytes:
    """Return what `python -m MODULE ARGUMENTS` answers through `serve`; `given` is its standard input.

    `still_wanted` is called repeatedly in the meantime; an exception from it stops the process. Raises InputError
    `where: ...` with the complaint of the process, after `time_limit_s` of its processor time, and when the process
    crashes.
    """
    beside_package = str(Path(__file__).parents[2])
    known = os.pathsep.join(filter(None, (beside_package, os.environ.get("PYTHONPATH"))))
    environment = {
        "PYTHONPATH": known,
        "PYTHONUTF8": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
    }
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", module, *arguments],  # -P: the current folder may hold a stranger's numpy.py
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ | environment,
    )  # fmt: skip
    ends_s, waiting = time.monotonic() + _BUSY_MACHINE * time_limit_s, given
    try:
        while True:
            with contextlib.suppress(subprocess.TimeoutExpired):
                answer, complaint = process.communicate(waiting, timeout=_POLL_S)
                break
            waiting = b""
            still_wanted()
            if _used_s(process.pid) > time_limit_s or time.monotonic() > ends_s:
                raise InputError(f"{where}: reading took more than {time_limit_s:g} s")
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
    if process.returncode == 0:
        return answer
    said = complaint.decode("utf-8", "replace").strip().splitlines() or ["no message"]
    if process.returncode == 2:
        raise InputError(f"{where}: {said[-1]}")
    how = f"signal {-process.returncode}" if process.returncode < 0 else _one_line(said[-1])
    raise InputError(f"{where}: cannot be read: the reading process ended with {how}")


def _used_s(pid: int) -> float:
    """Return the processor time of a process, 0 once it has ended."""
    with contextlib.suppress(psutil.Error):
        times = psutil.Process(pid).cpu_times()
        return float(times.user + times.system)
    return 0.0


def _one_line(text: str) -> str:
    from riglens.core.rig.yaml.nodes import shortened  # late: the process itself starts without a YAML parser

    return shortened(text, 160)


def serve(answer: Callable[[], bytes], most_memory_bytes: int) -> int:
    """Limit the memory of this process and write an answer to standard output; return the exit code.

    Anything else that is printed goes to standard error, as does the line of an InputError (code 2).
    """
    _limit_memory(most_memory_bytes)
    with open(os.dup(1), "wb") as stream:
        os.dup2(2, 1)
        try:
            stream.write(answer())
        except InputError as error:
            print(str(error), file=sys.stderr)
            return 2
    return 0


def _limit_memory(most_bytes: int) -> None:
    """Lower the limit of the address space, where the system has one and allows it: macOS may not, Windows has none."""
    try:
        import resource
    except ImportError:
        return
    limits = (most_bytes, *resource.getrlimit(resource.RLIMIT_AS))
    lowest = min(limit for limit in limits if limit != resource.RLIM_INFINITY)
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_AS, (lowest, lowest))
