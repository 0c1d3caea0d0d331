"""Memory of this process: what it holds, and the most it held since a moment (Linux)."""

from __future__ import annotations

import gc
import re
import subprocess
import sys
from pathlib import Path

MEGABYTE = 1e6
_STATUS = Path("/proc/self/status")
_CLEAR_REFS = Path("/proc/self/clear_refs")
_ROOT = Path(__file__).resolve().parents[2]


def start_peak() -> int:
    """Forget the peak so far; returns the bytes held now."""
    gc.collect()
    _CLEAR_REFS.write_text("5", encoding="utf-8")
    return _status_bytes("VmRSS")


def peak() -> int:
    """Most bytes held since `start_peak`; unlike `ru_maxrss` it knows nothing of the parent process."""
    return _status_bytes("VmHWM")


def _status_bytes(name: str) -> int:
    found = re.search(rf"^{name}:\s+(\d+) kB$", _STATUS.read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None, name
    return int(found[1]) * 1024


def run_script(name: str, *arguments: object) -> list[int]:
    """Run a script of this folder in a fresh interpreter; the whole numbers that it prints."""
    command = [sys.executable, "-m", f"tests.bench.{name}", *map(str, arguments)]
    done = subprocess.run(command, cwd=_ROOT, capture_output=True, encoding="utf-8", timeout=1200)
    assert done.returncode == 0, done.stderr
    return [int(number) for number in done.stdout.split()]
