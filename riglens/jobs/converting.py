"""Convert rigs between the formats of programs."""

from __future__ import annotations

import os
from typing import NamedTuple

from riglens.core.formats.exchange import read_rig, write_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.report import Report
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import find_preset


class Converted(NamedTuple):
    """A rig that was converted, and the reports on reading (None for a rig in memory or a preset) and writing it."""

    rig: Rig
    read: Report | None
    written: Report


def converted(
    source: str | os.PathLike[str] | Rig,
    source_format: str | None,
    out: str | os.PathLike[str],
    target_format: str | None,
    options: ReadOptions,
) -> Converted:
    """Write a rig in another format; formats are told by the files where they are None."""
    rig, read = _read(source, source_format, options)
    return Converted(rig, read, write_rig(rig, out, target_format).report)


def _read(
    source: str | os.PathLike[str] | Rig, source_format: str | None, options: ReadOptions
) -> tuple[Rig, Report | None]:
    """Return the rig to convert, and the report on a file; a preset counts as a rig file."""
    if isinstance(source, Rig):
        rig = source
    elif source_format is None and (preset := find_preset(os.fspath(source))) is not None:
        rig = preset.rig()
    else:
        opened = read_rig(source, source_format, options)
        return opened.rig, opened.report
    return rig.replace(vehicle=options.vehicle_or(rig.vehicle)), None
