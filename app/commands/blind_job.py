"""What `riglens blind` does: find blind zones, judge objects, and say it as tables, as JSON, as a map."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from riglens.app.commands.scores_job import missing_rays
from riglens.app.studies.files import csv_text, write_text
from riglens.app.terminal.blind import print_blind
from riglens.app.terminal.console import note, progress_bar
from riglens.app.terminal.scores import mesh_called, rig_called
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_writable
from riglens.core.kernels.runtime import jit
from riglens.core.review.blind import BlindEngine, BlindMap, BlindSettings, By
from riglens.core.review.blind_json import blind_document
from riglens.core.review.profiles import Profile, bundled_profiles, read_profiles
from riglens.core.review.verdicts import verdicts


class Asked(NamedTuple):
    """What to tell, of which profiles, with how many threads, and where to write it; "-" is standard output."""

    by: By
    sensors: int
    profiles: tuple[Path, ...]
    threads: int | None
    out: Path | None
    json: str | None


def blind(name: str, settings: BlindSettings, asked: Asked) -> None:
    """Print the blind zones of a rig, also written to files; with "-" as JSON alone."""
    rig = rig_called(name)
    mesh = mesh_called(name, rig)
    profiles = profiles_of(asked.profiles)
    if asked.out is not None and asked.out.suffix.lower() not in (".csv", ".png"):
        raise InputError(f"--out {asked.out}: found another ending, accepted are .csv and .png")
    for path in (asked.out, None if asked.json in (None, "-") else asked.json):
        if path is not None:
            require_writable(path, (name, *asked.profiles))
    for line in missing_rays(rig):
        note(line)
    with progress_bar("Casting rays") as progress:
        found = BlindEngine(rig.vehicle, settings, mesh, asked.threads).evaluate(rig)
        progress(0.5)
        judged = verdicts(rig, profiles, settings.body, mesh, jit.use_threads(asked.threads))
    if asked.out is not None:
        write_map(asked.out, found, asked.by, asked.sensors)
    text = to_text(blind_document(found, judged))
    if asked.json == "-":
        sys.stdout.write(text)
        return
    if asked.json is not None:
        write_text(Path(asked.json), text)
    print_blind(found, judged, asked.by, asked.sensors)


def profiles_of(files: Sequence[Path]) -> tuple[Profile, ...]:
    """The profiles of some files; those that ship with the program where none is named."""
    return tuple(p for path in files for p in read_profiles(path)) if files else bundled_profiles()


def write_map(path: Path, found: BlindMap, by: By, k: int) -> None:
    """Write the lowest visible heights as a table or as a picture, whichever the name ends in."""
    if path.suffix.lower() == ".csv":
        write_text(path, csv_text(list(_rows(found, by, k))))
        return
    from riglens.app.studies.blind_chart import blind_figure  # matplotlib
    from riglens.app.studies.pictures import picture

    with atomic_write(path) as stream:
        stream.write(picture(blind_figure(found, by, k)))


def _rows(found: BlindMap, by: By, k: int) -> Iterator[dict[str, object]]:
    """One row for every column that counts: where it is, and from what height on an object is seen; inf: never."""
    lowest, ground = found.lowest_m(by, k), found.ground
    for ix, iy in np.argwhere(ground.counts).tolist():
        x, y = (round(float(at), 6) for at in (ground.x_m[ix], ground.y_m[iy]))
        yield {"x_m": x, "y_m": y, f"lowest_{k}_{by}_m": round(float(lowest[ix, iy]), 6)}
