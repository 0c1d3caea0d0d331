"""Results of commands: files that are checked before the work, tables, and JSON in their place."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from riglens.core.files import require_writable, write_file
from riglens.core.plain import to_text

Part = tuple[dict[str, Any], Callable[[], None]]
"""The JSON of a part of a review, and what prints its tables."""


def require_outputs(reads: Iterable[str | Path], *paths: str | Path | None) -> None:
    """Raise InputError when a file that is named cannot be written, or is one of those that are read."""
    kept = tuple(reads)
    for path in paths:
        if path not in (None, "-"):
            require_writable(path, kept)


def deliver(document: dict[str, Any], json: str | None, show: Callable[[], None]) -> None:
    """Print tables by `show`, and write the JSON to a file too; with "-" print the JSON alone."""
    text = to_text(document)
    if json == "-":
        sys.stdout.write(text)
        return
    if json is not None:
        write_file(json, text)
    show()
