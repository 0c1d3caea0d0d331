"""The entries of the bundled library, kept in the user's cache folder: reading its YAML would delay every start."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path
from typing import Any

from riglens.core.cache_folder import cache_folder
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.rig.library_file import Entry, read_entries

NAME = "library.json"


def stored_entries(path: Path) -> tuple[Entry, ...]:
    """What `read_entries` gives for a library file; from the cache if the same code has read the same text before.

    The file holds a checksum and the entries as JSON; one that is damaged is made again.
    """
    kept, maker = cache_folder() / NAME, _maker(path)
    with contextlib.suppress(
        OSError, ValueError, TypeError
    ):  # not there, damaged, or of other code: all the same
        return _entries_of(kept.read_bytes(), maker)
    entries = read_entries(path, path.name)
    with contextlib.suppress(OSError, InputError):  # no place to keep it
        kept.parent.mkdir(parents=True, exist_ok=True)
        body = json.dumps([entry.model_dump(mode="json") for entry in entries]).encode()
        with atomic_write(kept) as file:
            file.write(_check(maker, body).encode() + b"\n" + body)
    return entries


def _entries_of(content: bytes, maker: str) -> tuple[Entry, ...]:
    check, _, body = content.partition(b"\n")
    if check.decode() != _check(maker, body):
        raise ValueError("damaged, or made by other code")
    return tuple(Entry(**{**found, "fields": _frozen(found["fields"])}) for found in json.loads(body))


def _frozen(value: Any) -> Any:
    """JSON as it was before: lists of the library are tuples."""
    if isinstance(value, dict):
        return {key: _frozen(part) for key, part in value.items()}
    return tuple(_frozen(part) for part in value) if isinstance(value, list) else value


def _maker(path: Path) -> str:
    """Checksum of everything that the entries follow from: the text, and the modules of this package that read it."""
    digest = hashlib.sha256(path.read_bytes())
    for module in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(module.read_bytes())
    return digest.hexdigest()


def _check(maker: str, body: bytes) -> str:
    return hashlib.sha256(maker.encode() + body).hexdigest()
