"""`riglens simulate`: data sets of simulated sweeps and pictures, each started only when all fit on the disk."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    SCENE,
    BodyArguments,
    Dask,
    RigArguments,
    RigNames,
    Surroundings,
    TrafficArguments,
    Whole,
    Workers,
    command,
    taken,
)
from riglens.app.terminal.console import TERMINAL, show
from riglens.core.pieces.backend import Backend
from riglens.core.rig.library import use_libraries
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.units import Extras
from riglens.evaluation.loading import load_rigs
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.jobs.simulating import DataSetJob, collect_in_carla, make_data_sets

SWEEPS = Group("Sweeps", sort_key=20)
FILES = Group("Files", sort_key=25)
CARLA = Group("CARLA", sort_key=40)
_SWEEP_FIELDS = ("clutter", "ground", "noise_m", "dropout", "shape", "range_law", "phase", "seed")
SweepArguments = Annotated[SimulationSettings, taken(SWEEPS, *_SWEEP_FIELDS)]


@command
def simulate(
    *rigs: RigNames,
    out: Annotated[Path, Parameter(metavar="DIR")],
    scene: TrafficArguments = SceneOptions(),
    surroundings: Annotated[
        Surroundings,
        Parameter(help="Let houses, walls and poles hide objects (block, where they are known)."),
    ] = None,
    every: Annotated[Whole, Parameter(group=SCENE)] = None,
    sequences: Annotated[Whole, Parameter(group=SCENE)] = None,
    sweeps: SweepArguments = SimulationSettings(),
    score: BodyArguments = ScoreOptions(),
    pictures: Annotated[Literal["on", "off"], Parameter(group=FILES)] = "on",
    points: Annotated[Literal["parquet"] | None, Parameter(group=FILES)] = None,
    workers: Workers = None,
    dask: Dask = None,
    carla: Annotated[str | None, Parameter(group=CARLA, metavar="HOST:PORT")] = None,
    reading: RigArguments = RigArguments(),
) -> None:
    """Simulate what rigs measure in traffic, as data sets in nuScenes' format.

    Parameters
    ----------
    out
        A new or an empty folder; with several rigs, each gets a subfolder of its name.
    every
        Simulate every Nth frame of each sequence (1).
    sequences
        Number of sequences, the first of the data (all).
    pictures
        on: also draw the cameras' pictures, with labels and depth, at their native size.
    points
        parquet: also write the points of each frame with the object that each is on.
    carla
        Collect from the CARLA simulator at this address instead: --frames N (200), one in --every N ticks of 0.05 s.
    """
    extras, backend = Extras(pictures == "on", points is not None), Backend(workers, dask)
    job = DataSetJob(out, scene, sweeps, extras, backend, every, sequences)
    if carla is not None:
        use_libraries(reading.libraries)
        show([collect_in_carla(rigs, carla, job, TERMINAL).line])
        return
    job = replace(job, scene=scene.surrounded(surroundings, in_town=True))
    loaded = load_rigs(rigs, score, TERMINAL, reading.libraries, reading.housings)
    show(made.line for made in make_data_sets(loaded, score, job, TERMINAL))
