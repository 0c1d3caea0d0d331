"""Convert a rig between formats: read, report, write; nothing is dropped in silence."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from riglens.app.commands.console import note_report, results
from riglens.core.files import require_apart
from riglens.core.geometry import Vec3
from riglens.core.rig.formats.exchange import WRITABLE, format_called, format_for, read_rig, write_rig
from riglens.core.rig.formats.mounts import ReadOptions
from riglens.core.rig.formats.report import Report
from riglens.core.rig.model import Rig
from riglens.core.rig.opening import open_rig
from riglens.core.rig.presets import find_preset


@dataclass(frozen=True)
class Conversion:
    """What to convert to what, and what the user says about it; formats that are None are told by the files."""

    source: str
    target: Path
    source_format: str | None = None
    target_format: str | None = None
    vehicle: str | None = None
    rear_axle_x: float | None = None
    origin_m: Vec3 | None = None
    token: str | None = None


def convert(job: Conversion) -> None:
    """Read the rig, write it, and say what became of everything; nothing is written when the reading fails."""
    target_format = (
        format_called(job.target_format, WRITABLE) if job.target_format else format_for(job.target)
    )
    require_apart(job.target, (job.source,))
    rig, report = _read(job)
    exported = write_rig(rig, job.target, target_format.name)
    for found in (report, exported.report):
        note_report(found)
    count = len(rig.sensors)
    line = f"{job.target}: {count} sensor{'' if count == 1 else 's'} as {target_format.title}"
    results().print(line, soft_wrap=True, markup=False)


def _read(job: Conversion) -> tuple[Rig, Report | None]:
    """The rig to convert; a preset counts as a rig file."""
    vehicle = open_rig(job.vehicle).rig.vehicle if job.vehicle is not None else None
    options = ReadOptions(vehicle, job.rear_axle_x, job.origin_m, job.token)
    preset = find_preset(job.source) if job.source_format is None else None
    if preset is None:
        imported = read_rig(job.source, job.source_format, options)
        return imported.rig, imported.report
    rig = preset.rig()
    return rig.replace(vehicle=options.vehicle_or(rig.vehicle)), None
