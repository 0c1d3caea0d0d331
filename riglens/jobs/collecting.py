"""Collect a data set from a running CARLA simulator."""

from __future__ import annotations

from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.monitor import Monitor
from riglens.core.rig.model import Rig
from riglens.core.simulate.carla_collection import Collection, Wanted
from riglens.core.simulate.carla_collection import collect as collect_frames
from riglens.core.simulate.carla_session import Address, castable, session
from riglens.core.simulate.dataset import require_channels, require_own
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.units import Extras
from riglens.evaluation.loading import note_report


def collect(
    rig: Rig,
    out: Path,
    address: str,
    wanted: Wanted,
    settings: SimulationSettings,
    extras: Extras,
    monitor: Monitor,
) -> str:
    """Collect a data set and return a line on it.

    When it is interrupted, or the simulator goes away, the frames so far are kept as a data set."""
    at, notes = Address.of(address), Notes()
    settings = SimulationSettings(noise_m=settings.noise_m, dropout=settings.dropout)
    rig = castable(rig, notes)
    require_channels(rig, extras)
    if require_own(out):
        raise InputError(f"{out}: must be a new or an empty folder (holds a data set)")
    with session(at) as opened:
        note_report(notes.report("CARLA"), monitor)
        opened.mount(rig, settings.noise_m, settings.dropout, extras.pictures)
        town = "".join(sign if sign.isascii() and sign.isalnum() else "-" for sign in opened.map_name)[:40]
        to = Collection(rig, settings, extras, out, town or "town", wanted.every)
        try:
            with monitor.stage("Collecting") as progress:
                collect_frames(opened, to, wanted, progress)
        except KeyboardInterrupt as error:
            raise KeyboardInterrupt(*[_kept(out, to)] if to.ticks else ()) from error
        except Exception:
            if to.ticks:
                monitor.note(_kept(out, to))
            raise
        finally:
            if to.ticks:
                to.finish()
    return f"{out}: {len(to.ticks):,} frames of {to.sequence}, boxes also in boxes.csv"


def _kept(out: Path, to: Collection) -> str:
    return f"{out}: the {len(to.ticks)} frames so far are kept"
