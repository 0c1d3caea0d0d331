"""`riglens simulate`: data sets of simulated sweeps and pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    BUILD,
    SCENE,
    BoxArguments,
    LibraryArguments,
    Whole,
    whole_number,
)
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.core.errors import InputError

SWEEPS = Group("Sweeps", sort_key=20)
FILES = Group("Files", sort_key=25)
CARLA = Group("CARLA", sort_key=40)
_TwoFiles = Parameter(group=SCENE, metavar="OCCLUDERS POSES", show_default=False)
_Number = Parameter(converter=whole_number, group=SWEEPS, metavar="N")
_Switch = Parameter(group=SWEEPS)
_Body = Parameter(name="--body", group=SWEEPS, metavar="NAME", show_default=False)


def simulate(
    *rigs: Annotated[str, Parameter(name="RIG", required=True)],
    out: Annotated[Path, Parameter(metavar="DIR")],
    boxes: Annotated[Path | None, Parameter(group=SCENE, metavar="PATH", show_default=False)] = None,
    how: BoxArguments = BoxArguments(),
    surroundings: Annotated[Literal["ignored", "block"] | None, Parameter(group=SCENE)] = None,
    occluders: Annotated[tuple[Path, Path] | None, _TwoFiles] = None,
    every: Annotated[Whole, Parameter(group=SCENE)] = None,
    sequences: Annotated[Whole, Parameter(group=SCENE)] = None,
    clutter: Annotated[int, _Number] = 60,
    road: Annotated[Literal["uneven", "flat", "none"], _Switch] = "uneven",
    noise: Annotated[float, Parameter(group=SWEEPS, metavar="M")] = 0.02,
    dropout: Annotated[float, Parameter(group=SWEEPS, metavar="SHARE")] = 0.05,
    shape: Annotated[Literal["class", "box"], _Switch] = "class",
    range_law: Annotated[Literal["on", "off"], _Switch] = "on",
    phase: Annotated[Literal["random", "0"], _Switch] = "random",
    seed: Annotated[int, _Number] = 0,
    body: Annotated[Literal["ignored", "blocks"] | None, _Body] = None,
    pictures: Annotated[Literal["on", "off"], Parameter(group=FILES)] = "on",
    points: Annotated[Literal["parquet"] | None, Parameter(group=FILES)] = None,
    workers: Annotated[Whole, Parameter(group=BUILD)] = None,
    dask: Annotated[str | None, Parameter(group=BUILD, metavar="ADDRESS")] = None,
    carla: Annotated[str | None, Parameter(group=CARLA, metavar="HOST:PORT")] = None,
    libraries: LibraryArguments = LibraryArguments(),
) -> None:
    """Simulate what rigs measure in traffic, as data sets in nuScenes' format.

    Sweeps of all LiDARs together and of each, pictures of the cameras with labels and depth, and the tables that the
    official development kit loads and evaluates. When it is interrupted, the same command goes on where it was, and
    the files are the same. See docs/simulate.md.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    out
        A new or an empty folder; with several rigs, each gets a folder of its name in it.
    boxes
        Box data set, as for `riglens evaluate`. Without it: the bundled scenario.
    surroundings
        Whether what was given around the streets hides road users (block, where it is known).
    occluders
        What stands around your own --boxes, and where the car is in each frame.
    every
        Simulate one in so many frames of each sequence (1).
    sequences
        Only so many sequences, the first of the data (all).
    clutter
        So many bushes, bins, poles and walls are strewn around the car in each frame, the same for every rig.
    road
        uneven: with waves of a few centimetres; flat; or none.
    noise
        Standard deviation of a range, in metres.
    dropout
        Share of returns that get lost, whatever they are on.
    shape
        class: cars have glass and a gap below, cyclists and pedestrians are slim; box: plain boxes.
    range_law
        on: rays that come from far, or meet a face at a slant, may get lost.
    phase
        random turns each LiDAR in each frame by a part of its azimuth step; 0 casts azimuths as listed.
    seed
        What all random draws follow from.
    body
        Whether rays pass through the car's own body or end at it, for this run (as each rig says).
    pictures
        on: also draw what the cameras see, with labels and depth, at their native size.
    points
        parquet: also write the points of each frame with the road user that each is on.
    workers
        Processes that simulate at the same time (as many as cores).
    dask
        Simulate on the Dask cluster whose scheduler listens there, such as tls://10.0.0.1:8786. It is trusted: whoever
        takes part in it can run code here (docs/security.md).
    carla
        Collect from the CARLA simulator that listens there instead: --frames N (200), one in --every N ticks of 0.05 s.
    """
    libraries.use()
    if carla is not None:
        _refuse_with_carla({"--boxes": boxes, "--occluders": occluders, "--dask": dask, "--workers": workers})
        from riglens.app.commands import carla_job

        at = carla_job.Asked(carla, how.frames, every, noise, dropout, pictures == "on")
        carla_job.collect(rigs, out, at)
        return
    from riglens.app.commands import simulate_job
    from riglens.core.pieces.where import Where
    from riglens.core.simulate.settings import SimulationSettings
    from riglens.core.simulate.units import Extras

    settings = SimulationSettings(seed, shape, range_law == "on", phase, noise, dropout, clutter, road)
    extras = Extras(pictures == "on", points is not None)
    frames = simulate_job.Frames(1 if every is None else every, sequences)
    scene = _scene(boxes, how, surroundings, occluders)
    asked = simulate_job.Asked(scene, frames, settings, extras, ScoreOptions(body=body))
    simulate_job.simulate(rigs, out, asked, Where(workers, dask))


def _refuse_with_carla(said: Mapping[str, object]) -> None:
    """Raise InputError for the first option that was said and has no meaning with --carla."""
    for name, value in said.items():
        if value is not None:
            raise InputError(f"{name} and --carla: the simulator has its own traffic; leave {name} out")


def _scene(
    boxes: Path | None,
    how: BoxArguments,
    surroundings: Literal["ignored", "block"] | None,
    occluders: tuple[Path, Path] | None,
) -> SceneOptions:
    """The traffic, with what stands around it where that is known and not refused."""
    known = boxes is None or occluders is not None
    if surroundings == "block" and not known:
        raise InputError(
            "--surroundings block: found no table of what stands there; give it with --occluders"
        )
    scene = SceneOptions(boxes, how.origin, how.frames, how.classes, find_ground=how.ground == "auto")
    return replace(scene, surroundings=known and surroundings != "ignored", occluders=occluders)
