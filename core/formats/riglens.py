"""RigLens' own rig YAML as one of the formats."""

from __future__ import annotations

import re
from dataclasses import replace

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import YAML, Source
from riglens.core.rig.model import Rig
from riglens.core.rig.ray_file import reader_in
from riglens.core.rig.yaml.file import dumps, loads

_HEAD = re.compile(r"^['\"]?riglens['\"]?\s*:", re.MULTILINE)


def recognises(source: Source) -> bool:
    """Return whether this is a YAML file with the key riglens, or an unreadable one, for its error message."""
    try:
        return _HEAD.search(source.text) is not None
    except InputError:
        return True


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the rig unchanged, except for a vehicle or rear axle that the user names."""
    file = replace(loads(source.written, source.where, reader_in(source.folder)), path=source.path)
    mounting.file, rig, notes, options = file, file.rig, mounting.notes, mounting.options
    vehicle = options.vehicle_or(rig.vehicle)
    if vehicle != rig.vehicle:
        notes.converted("vehicle replaced by the one given")
    if options.origin_m is not None or options.token is not None:
        notes.ignored("origin and token: this format does not use them")
    notes.read("everything")
    return rig.replace(vehicle=vehicle)


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return the whole rig."""
    notes.written("everything")
    for sensor in rig.sensors:
        if sensor.table is not None:
            notes.ignored(f"rays of {sensor.table.file}: copy the file beside the new one", sensor.name)
    return {"rig.yaml": dumps(rig)}


RIGLENS = Format("riglens", "RigLens rig YAML", YAML, recognises, read, write, endings=YAML)
