"""Rig files, YAML version 1: validated, with one-line errors; comments and layout survive a save."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.rig.model import Rig, Sensor
from riglens.core.rig.plausible import implausible
from riglens.core.rig.ray_file import reader_in
from riglens.core.rig.yaml.check import check_rig, read_again, rig_from_nodes
from riglens.core.rig.yaml.edit import edited_text
from riglens.core.rig.yaml.nodes import MAX_BYTES, MAX_VALUES, Plain, parse_yaml, read_text, shown_path
from riglens.core.rig.yaml.text import plain_fields, rig_text, same_value, vehicle_fields
from riglens.core.sensors.scan import Reader

LATER_FIELDS = ("mirror_of", "fails_with", "azimuth_offsets_deg", "distortion", "rays", "blocked")
_BOM = "\ufeff"


@dataclass(frozen=True)
class RigFile:
    """A rig with the text it was read from; `path` is None until it has been loaded or saved."""

    rig: Rig
    text: str
    path: Path | None = None

    def updated(self, rig: Rig) -> RigFile:
        """Return the same file with another rig: changed values are rewritten, everything else stays.

        Raise InputError that names the field when the rig is not valid.
        """
        rig = check_rig(rig)
        if same_rig(rig, self.rig):
            return self
        bom = _BOM if self.text.startswith(_BOM) else ""
        text = edited_text(self.text.removeprefix(_BOM), self.rig, rig)
        if not _says(text, rig):
            text = rig_text(rig)
        return RigFile(rig, bom + text, self.path)

    def save(self, path: str | os.PathLike[str], rig: Rig | None = None) -> RigFile:
        """Write the file, with that rig if one is given, and return the saved file.

        Raise InputError when the rig is not valid, too large to be read again, names a table of rays that its folder
        does not hold, or the file cannot be written; the old file then stays.
        """
        file = self if rig is None else self.updated(rig)
        for sensor in file.rig.sensors:
            if sensor.table is not None and not (Path(path).parent / sensor.table.file).is_file():
                raise InputError(
                    f"{shown_path(path)}: its folder must hold {sensor.table.file}, the rays of {sensor.name}"
                )
        content = file.text.encode("utf-8")
        _require_readable(file.text, len(content), shown_path(path))
        with atomic_write(path) as stream:
            stream.write(content)
        return RigFile(file.rig, file.text, Path(path))


def new_rig_file(rig: Rig) -> RigFile:
    """Return a file for a rig that has none yet, in the layout of the documentation."""
    rig = check_rig(rig)
    return RigFile(rig, rig_text(rig))


def dumps(rig: Rig) -> str:
    """Return a rig as YAML text that reads back to the same rig, bit for bit; raise InputError when it is not valid."""
    return rig_text(check_rig(rig))


def loads(text: str, where: str = "rig.yaml", reader: Reader | None = None) -> RigFile:
    """Read YAML text, called `where` in messages; raise InputError `where:line: field: ...` when it is wrong.

    `reader` reads the files with rays that it names; without one they are refused.
    """
    return RigFile(rig_from_nodes(parse_yaml(text.removeprefix(_BOM), where), where, reader), text)


def load_rig(path: str | os.PathLike[str]) -> RigFile:
    """Read a rig file; raise InputError with file, line and field when it is missing, unreadable or wrong."""
    text = read_text(path, "a rig YAML file")
    file = loads(text, shown_path(path), reader_in(Path(path).parent))
    return RigFile(file.rig, file.text, Path(path))


def rig_sha256(rig: Rig) -> str:
    """Return the SHA-256 (hex) of a rig's content, whatever the layout of its file: canonical JSON of its fields.

    Fields added after the first version are left out at their defaults, so that a rig keeps its hash. A file with rays
    counts with the hash of its content.
    """
    return valid_rig_sha256(check_rig(rig))


def identity_of(rig: Rig) -> dict[str, Any]:
    """Return what a document says of a rig: its name, its hash, that housings block where they do, and what is
    implausible about it, if anything is."""
    found: dict[str, Any] = {"name": rig.name, "sha256": rig_sha256(rig)}
    found |= {"housings": rig.housings} if rig.housings == "blocks" else {}
    return found | ({"notes": notes} if (notes := implausible(rig)) else {})


def valid_rig_sha256(rig: Rig) -> str:
    """Return `rig_sha256` of a rig that is known to be valid."""
    fields = plain_fields(rig.model_copy(update={"sensors": ()}))
    fields |= {"vehicle": vehicle_fields(rig.vehicle), "sensors": tuple(map(_hashed_fields, rig.sensors))}
    later = (
        ("keep_out", not rig.keep_out),
        ("self_occlusion", rig.self_occlusion),
        ("housings", rig.housings == "ignored"),
    )
    hashed = {key: value for key, value in fields.items() if (key, True) not in later}
    content = json.dumps(hashed, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(content.encode("ascii")).hexdigest()


def _hashed_fields(sensor: Sensor) -> dict[str, Plain]:
    fields = plain_fields(sensor).items()
    hashed = {key: value for key, value in fields if key not in LATER_FIELDS or value not in (None, ())}
    return hashed if sensor.table is None else hashed | {"rays_sha256": sensor.table.ray_rows().sha256}


def same_rig(one: Rig, other: Rig) -> bool:
    """Return whether two rigs are the same to the last bit."""
    return same_value(one, other)


def _require_readable(text: str, size_bytes: int, where: str) -> None:
    """Raise InputError for what exceeds the limits of reading."""
    if size_bytes > MAX_BYTES:
        raise InputError(f"{where}: would be larger than {MAX_BYTES / 1e6:g} MB, which no rig file may be")
    if size_bytes > MAX_VALUES:  # each value takes two characters or more
        parse_yaml(text.removeprefix(_BOM), where)


def _says(text: str, rig: Rig) -> bool:
    try:
        return same_rig(loads(text, reader=read_again(rig)).rig, rig)
    except InputError:
        return False
