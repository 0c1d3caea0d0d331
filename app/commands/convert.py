"""`riglens convert`: rigs from and to the formats of other programs; nothing is dropped in silence."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import command
from riglens.app.terminal.console import TERMINAL, results
from riglens.core.errors import InputError
from riglens.core.files import require_apart, write_file
from riglens.core.formats.exchange import format_called, format_for, readable, writable
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.opening import open_rig
from riglens.evaluation.loading import note_doubts, note_report
from riglens.evaluation.names import option_of
from riglens.evaluation.options import Triple
from riglens.jobs.converting import converted

_FROM = f"Format of IN, where it cannot be detected: {', '.join(readable())}."
_TO = f"Format of OUT, where its extension does not determine it: {', '.join(writable())}."


@command
def convert(
    source: Annotated[str, Parameter(name="IN")],
    out: Annotated[Path, Parameter(name="OUT")],
    /,
    *,
    from_: Annotated[str | None, Parameter(name="--from", metavar="FORMAT", help=_FROM)] = None,
    to: Annotated[str | None, Parameter(name="--to", metavar="FORMAT", help=_TO)] = None,
    vehicle: Annotated[str | None, Parameter(metavar="RIG")] = None,
    rear_axle_x: Annotated[float | None, Parameter(metavar="M")] = None,
    origin: Annotated[Triple | None, Parameter(metavar="X Y Z")] = None,
    token: Annotated[str | None, Parameter(metavar="TEXT")] = None,
    kit: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    report: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> None:
    """Convert a rig between formats, reporting everything converted, approximated or left out.

    Parameters
    ----------
    source
        Rig file, preset name, or a file or folder of another program.
    out
        File to write; a folder for nuscenes and autoware.
    vehicle
        Rig file with the vehicle to use, where IN has none.
    rear_axle_x
        Position of the rear axle, in metres from the body centre (-1.35).
    origin
        Origin of IN in the vehicle frame, in metres.
    token
        Which rig of several: token (nuScenes), id (CARLA), class (CARLA agent), name (AirSim, SDF), index (mmdet3d).
    kit
        Folder of an Autoware kit's description, where its xacro is not beside the calibration (individual_params).
    report
        Also write the conversion report to this file, sensor by sensor.
    """
    target = format_called(to, writable()) if to else format_for(out)
    require_apart(out, (source,))
    if report is not None:
        require_apart(report, (source,))
        if report.absolute() == out.absolute():
            raise InputError(f"must be another file than OUT (got {report})", "report")
    known = open_rig(vehicle).rig.vehicle if vehicle is not None else None
    options = ReadOptions(known, rear_axle_x, origin, token, kit)
    rig, read, written = converted(source, from_, out, target.name, options)
    for found in (read, written):
        note_report(found, TERMINAL)
    note_doubts(rig, TERMINAL)
    if report is not None:
        texts = (found.text(option_of) for found in (read, written) if found is not None)
        write_file(report, "\n".join(texts))
    count = len(rig.sensors)
    line = f"{out}: {count} sensor{'' if count == 1 else 's'} as {target.title}"
    results(out).print(line, soft_wrap=True)
