"""What `riglens simulate --carla` does: collect a data set from a running CARLA simulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from riglens.app.terminal.console import note, note_report, progress_bar, results
from riglens.app.terminal.scores import rig_called
from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.simulate.carla_collection import Collection, Wanted
from riglens.core.simulate.carla_collection import collect as collect_frames
from riglens.core.simulate.carla_session import Address, castable, session
from riglens.core.simulate.dataset import require_channels, require_own
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.units import Extras

USUAL_FRAMES, USUAL_EVERY = 200, 10


@dataclass(frozen=True)
class Asked:
    """Where the simulator listens, and what to collect."""

    address: str
    frames: int | None
    every: int | None
    noise_m: float
    dropout: float
    pictures: bool


def collect(names: Sequence[str], out: Path, asked: Asked) -> None:
    """Collect a data set; when it is interrupted, or the simulator goes away, the frames so far are kept as one."""
    if len(names) != 1:
        raise InputError(f"--carla: found {len(names)} rigs, accepted is one")
    address = Address.of(asked.address)
    every = USUAL_EVERY if asked.every is None else asked.every
    wanted = Wanted(USUAL_FRAMES if asked.frames is None else asked.frames, every)
    settings, extras = (
        SimulationSettings(noise_m=asked.noise_m, dropout=asked.dropout),
        Extras(asked.pictures),
    )
    notes = Notes()
    rig = castable(rig_called(names[0]), notes)
    require_channels(rig, extras)
    if require_own(out):
        raise InputError(f"--out {out}: the folder holds a data set; accepted is a new or an empty one")
    with session(address) as opened:
        note_report(notes.report("CARLA"))
        opened.mount(rig, asked.noise_m, asked.dropout, asked.pictures)
        to = Collection(rig, settings, extras, out, _plain(opened.map_name), every)
        try:
            with progress_bar("Collecting") as progress:
                collect_frames(opened, to, wanted, progress)
        finally:
            if to.ticks:
                to.finish()
                if len(to.ticks) < wanted.frames:
                    note(f"{out}: the {len(to.ticks)} frames so far are kept")
    results().print(
        f"{out}: {len(to.ticks):,} frames of {to.sequence}, boxes also in boxes.csv",
        soft_wrap=True,
        markup=False,
    )


def _plain(name: str) -> str:
    return "".join(sign if sign.isascii() and sign.isalnum() else "-" for sign in name)[:40] or "town"
