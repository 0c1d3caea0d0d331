"""`riglens simulate`: data sets of simulated sweeps and pictures, each started only when all fit on the disk."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
    number,
)
from riglens.app.terminal.console import TERMINAL, show
from riglens.app.terminal.loading import load_rigs
from riglens.core.pieces.where import Where
from riglens.core.rig.library import use_libraries
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.units import Extras
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.jobs.simulating import DataSetJob, collect_in_carla, make_data_sets

SWEEPS = Group("Sweeps", sort_key=20)
FILES = Group("Files", sort_key=25)
CARLA = Group("CARLA", sort_key=40)
_Number = number(SWEEPS)
_Switch = Parameter(group=SWEEPS)


@Parameter(name="*")
@dataclass(frozen=True)
class SweepArguments:
    """Settings of the simulated measurements."""

    clutter: Annotated[int, _Number] = 60
    """Number of bushes, bins, poles and walls around the car in each frame, the same for every rig."""
    road: Annotated[Literal["uneven", "flat", "none"], _Switch] = "uneven"
    """uneven: with waves of a few centimetres; flat; or none."""
    noise: Annotated[float, Parameter(group=SWEEPS, metavar="M")] = 0.02
    """Standard deviation of a range, in metres."""
    dropout: Annotated[float, Parameter(group=SWEEPS, metavar="SHARE")] = 0.05
    """Share of returns lost at random."""
    shape: Annotated[Literal["class", "box"], _Switch] = "class"
    """class: cars have glass and a gap below, cyclists and pedestrians are slim; box: plain boxes."""
    range_law: Annotated[Literal["on", "off"], _Switch] = "on"
    """on: returns from far or oblique surfaces may get lost."""
    phase: Annotated[Literal["random", "0"], _Switch] = "random"
    """random: each LiDAR is rotated in each frame by a fraction of its azimuth step; 0: azimuths as listed."""
    seed: Annotated[int, _Number] = 0
    """Seed of all random draws."""

    @property
    def settings(self) -> SimulationSettings:
        """The settings of the simulation; raise InputError for numbers out of their limits."""
        range_law = self.range_law == "on"
        return SimulationSettings(
            self.seed, self.shape, range_law, self.phase, self.noise, self.dropout, self.clutter, self.road
        )


@command
def simulate(
    *rigs: RigNames,
    out: Annotated[Path, Parameter(metavar="DIR")],
    scene: TrafficArguments = SceneOptions(),
    surroundings: Surroundings = None,
    every: Annotated[Whole, Parameter(group=SCENE)] = None,
    sequences: Annotated[Whole, Parameter(group=SCENE)] = None,
    sweeps: SweepArguments = SweepArguments(),
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
    rigs
        Rig files or preset names.
    out
        A new or an empty folder; with several rigs, each gets a subfolder of its name.
    surroundings
        Let houses, walls and poles hide objects (block, where they are known).
    every
        Simulate every Nth frame of each sequence (1).
    sequences
        Number of sequences, the first of the data (all).
    pictures
        on: also draw the cameras' pictures, with labels and depth, at their native size.
    points
        parquet: also write the points of each frame with the object that each is on.
    workers
        Processes that simulate at the same time (as many as cores).
    carla
        Collect from the CARLA simulator at this address instead: --frames N (200), one in --every N ticks of 0.05 s.
    """
    extras, where = Extras(pictures == "on", points is not None), Where(workers, dask)
    job = DataSetJob(out, scene, sweeps.settings, extras, where, every, sequences)
    if carla is not None:
        use_libraries(reading.libraries)
        show([collect_in_carla(rigs, carla, job, TERMINAL).line])
        return
    job = replace(job, scene=scene.surrounded(surroundings, in_town=True))
    loaded = load_rigs(rigs, score, reading.libraries, reading.housings)
    show(made.line for made in make_data_sets(loaded, score, job, TERMINAL))
