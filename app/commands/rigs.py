"""`riglens presets`, `convert` and `library`: rigs and sensor models to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import LibraryArguments
from riglens.app.evaluation.options import Triple
from riglens.core.errors import InputError


def presets(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    /,
    *,
    out: Annotated[Path | None, Parameter(metavar="RIG.yaml")] = None,
) -> None:
    """List the built-in rigs, or print one as rig YAML, or write it to a file.

    Parameters
    ----------
    name
        One preset; without it all are listed.
    out
        Write the preset NAME to this file.
    """
    if name is None and out is not None:
        raise InputError("--out: name the preset to write as well: riglens presets NAME --out RIG.yaml")
    from riglens.app.commands import rigs_job

    rigs_job.presets(name, out)


def convert(
    source: Annotated[str, Parameter(name="IN")],
    out: Annotated[Path, Parameter(name="OUT")],
    /,
    *,
    from_: Annotated[str | None, Parameter(name="--from", metavar="FORMAT")] = None,
    to: Annotated[str | None, Parameter(name="--to", metavar="FORMAT")] = None,
    vehicle: Annotated[str | None, Parameter(metavar="RIG")] = None,
    rear_axle_x: Annotated[float | None, Parameter(metavar="M")] = None,
    origin: Annotated[Triple | None, Parameter(metavar="X Y Z")] = None,
    token: Annotated[str | None, Parameter(metavar="TEXT")] = None,
    report: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> None:
    """Convert a rig between formats, and say what was converted, approximated or left out.

    Formats: riglens, nuscenes, autoware, urdf, carla, carla-toml, driveworks both ways; pandaset, argoverse,
    kalibr, opencv, kitti, carla-agent read only; osi written only.

    Parameters
    ----------
    source
        Rig file, preset name, or a file or folder of another program.
    out
        File to write; a folder for nuscenes and autoware.
    from_
        Format of IN, where it cannot be told by the file.
    to
        Format of OUT, where its ending does not say it.
    vehicle
        Take the vehicle of this rig file, where IN does not know its car.
    rear_axle_x
        Where the rear axle is, in metres from the body centre (-1.35).
    origin
        Where the origin of IN lies in the vehicle frame, in metres.
    token
        Which rig of several: a token of nuScenes, the id of a CARLA vehicle, the class of a CARLA agent.
    report
        Write what became of everything to this file as well, sensor by sensor.
    """
    from riglens.app.commands import rigs_job

    rigs_job.convert(rigs_job.Conversion(source, out, from_, to, vehicle, rear_axle_x, origin, token, report))


def library(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    /,
    *,
    kind: Annotated[Literal["lidar", "camera"] | None, Parameter(metavar="KIND")] = None,
    json: bool = False,
    libraries: LibraryArguments = LibraryArguments(),
) -> None:
    """List the sensor models, or show one with its beams or lens and where its figures come from.

    Parameters
    ----------
    name
        One model; without it all are listed.
    kind
        Only LiDARs or only cameras.
    json
        Print JSON, with every figure of every model listed.
    """
    if name is not None and kind is not None:
        raise InputError(f"--kind {kind} chooses what is listed; leave it out to show the model {name}")
    libraries.use()
    from riglens.app.commands import rigs_job

    rigs_job.library(name, kind, json)
