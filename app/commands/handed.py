"""The other end of `riglens.app.background.own_process`: takes a request and runs a function on it."""

from __future__ import annotations

import json
import os
import pickle
import sys
from importlib import import_module

from riglens.app.commands.running import guarded
from riglens.app.evaluation.names import label_of


def main(work: str) -> int:
    """Run `module:function` on the request of standard input; return the exit code."""
    return guarded(lambda: _run(work), label_of)


def _run(work: str) -> None:
    told = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())  # what a command prints is not told
    request = pickle.load(sys.stdin.buffer)  # by the window, which is the same program
    module, name = work.split(":")

    def tell(share: float, line: str) -> None:
        print(json.dumps([share, line]), file=told, flush=True)

    getattr(import_module(module), name)(request, tell)
