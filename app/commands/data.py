"""`riglens pog` and `riglens data`: box data, built into a POG or described."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import BUILD, BoxArguments, Out, ReadingArguments, Whole, check_json


def pog(
    *boxes: Annotated[Path, Parameter(name="BOXES", required=True)],
    out: Out,
    reading: ReadingArguments = ReadingArguments(),
    workers: Annotated[Whole, Parameter(group=BUILD)] = None,
    dask: Annotated[str | None, Parameter(group=BUILD, metavar="ADDRESS")] = None,
) -> None:
    """Build the POG of one or more box data sets together and store it for --pog.

    A build of many logs or tables works on several of them at once. When it is interrupted, the same command goes
    on where it was.

    Parameters
    ----------
    boxes
        Box data sets: tables, nuScenes, Argoverse 2, KITTI or CARLA folders.
    out
        Where to store it (.npz). Finished parts are kept beside it, in FILE.parts, until all is done.
    workers
        Processes that build parts at the same time (as many as cores, parts and memory allow).
    dask
        Build the parts on the Dask cluster whose scheduler listens there, such as tls://10.0.0.1:8786. It is trusted:
        whoever takes part in it can run code here (docs/security.md).
    """
    options = reading.options(boxes[0])
    from riglens.app.commands import data_job
    from riglens.core.pieces.where import Where

    data_job.build_pog_file(options, boxes, out, Where(workers, dask))


def data(
    *boxes: Annotated[Path, Parameter(name="BOXES", required=True)],
    how: BoxArguments = BoxArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Say what box data hold: classes, directions, distances, sizes, the ground, and what is not mapped.

    Parameters
    ----------
    boxes
        Box data sets: tables, nuScenes, Argoverse 2, KITTI or CARLA folders.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the tables.
    """
    check_json(json)
    options = ReadingArguments(how).options(boxes[0])
    from riglens.app.commands import data_job

    data_job.describe(options, boxes, json)
