"""A simulated data set on the disk: planned, simulated unit by unit, resumed when interrupted, finished with tables.

While it is being made, the folder holds what is planned (riglens.json) and, in .riglens, notes of the units whose
files are complete, with a checksum of each file. When the tables are written, .riglens goes.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import atomic_write, open_regular, write_files
from riglens.core.pieces.folder import PieceFolder, count_kept
from riglens.core.pieces.work import Piece
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.occluders import MapPose
from riglens.core.shown_text import visible
from riglens.core.simulate.channels import Channel, channels_of
from riglens.core.simulate.pictures import LABELS
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.tables import MAP_FILE, Record, Scene, Tables
from riglens.core.simulate.units import Extras, Notes, Unit, file_names, part_of, simulate_unit, unpacked
from riglens.core.simulate.world import Worlds
from riglens.core.targets.traffic import Traffic

VERSION = "v1.0-trainval"
"""Folder of the tables: programs that read nuScenes know this name."""
PLAN, WORK, _LAST = "riglens.json", ".riglens", "splits.json"
UNIT_FRAMES = 20
TABLE_BYTES, TABLE_BYTES_2D = 1400, 700
"""Approximate size of an object in the tables, and of one in a picture."""
SPARE = 1.1
"""So many times the estimate has to be free."""


class Span(NamedTuple):
    """Frames of one scene that are simulated together, and what their files are called."""

    frames: tuple[int, ...]
    stems: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Dataset:
    """Data set to make: a rig in scenes of traffic; `poses` of the car by frame, where they are known."""

    rig: Rig
    settings: SimulationSettings
    extras: Extras
    traffic: Traffic
    scenes: Sequence[Scene]
    poses: Mapping[int, MapPose] = field(default_factory=dict)

    @cached_property
    def channels(self) -> list[Channel]:
        """Return the sources of files; InputError for a rig without sensors."""
        return require_channels(self.rig, self.extras)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return sum(len(scene.frames) for scene in self.scenes)

    @cached_property
    def spans(self) -> dict[str, Span]:
        """The units in which it is made, by the names of their notes."""
        spans = (
            Span(
                scene.frames[first : first + UNIT_FRAMES],
                tuple(scene.stem(place) for place in scene.places[first : first + UNIT_FRAMES]),
            )
            for scene in self.scenes
            for first in range(0, len(scene.frames), UNIT_FRAMES)
        )
        return {f"unit-{number:06d}": span for number, span in enumerate(spans)}

    @cached_property
    def _place_of(self) -> NDArray[np.int64]:
        return np.argsort(self.traffic.frame, kind="stable")

    def unit(self, span: Span) -> Unit:
        """Return a span with all that is needed to simulate it."""
        traffic = part_of(self.traffic, self._place_of[list(span.frames)])
        return Unit(self.rig, self.settings, self.extras, traffic, *span)

    def file_names(self, span: Span) -> set[str]:
        """Return the files of a span, by their paths in the data set."""
        return file_names(span.stems, self.channels, self.extras)

    def piece(self, key: str) -> Piece:
        """Return a span as work for anyone."""
        return Piece(key, simulate_unit, lambda: (self.unit(self.spans[key]),))

    @cached_property
    def plan(self) -> dict[str, Any]:
        """Return the inputs of the folder, for riglens.json."""
        data, splits = self.traffic.data, self._tables({}).splits()
        mesh = self.rig.vehicle.body_mesh
        return {
            "riglens": 1,
            "simulated": {
                **self.settings.as_dict(),
                **{"pictures": self.extras.pictures, "points": self.extras.points},
            },
            "rig": {
                **identity_of(self.rig),
                "body_mesh": "" if mesh is None else mesh.sha256,
            },
            "data": {
                "source": data.short_source,
                "sha256": data.sha256,
                "surroundings_sha256": self.traffic.surroundings_sha256,
                "frames": self.frames,
                "frames_sha256": hashlib.sha256(
                    repr([scene.frames for scene in self.scenes]).encode()
                ).hexdigest(),
                "poses": bool(self.poses),
            },
            "channels": [channel.name for channel in self.channels],
            "labels": list(LABELS),
            "depth": "centimetres along the axis of the camera, 0: none",
            "classes": list(CLASSES),
            "splits": {name: len(scenes) for name, scenes in splits.items()},
        }

    def _tables(self, notes: Mapping[int, Notes]) -> Tables:
        worlds = Worlds(self.traffic, self.settings)
        key = f"{self.rig.name} {self.settings.seed}"
        return Tables(key, self.rig, self.channels, self.scenes, worlds, self.poses, notes)


def require_channels(rig: Rig, extras: Extras) -> list[Channel]:
    """Return the sources of a rig's files; InputError for a rig without sensors."""
    found = channels_of(rig, extras.pictures)
    if not found:
        more = " while no pictures are drawn" if rig.enabled_cameras() else ""
        raise InputError(
            f"rig {visible(rig.name)}: needs an enabled LiDAR, or cameras with pictures (no LiDAR{more})"
        )
    return found


def scenes_of(traffic: Traffic, every: int = 1, most: int | None = None) -> list[Scene]:
    """Return the sequences of the data, the first `most` of them with one in `every` frames."""
    labels = traffic.data.labels
    if labels is None:
        groups = {0: list(range(traffic.frames))}
        names: Sequence[str] = ("all",)
    else:
        groups, names = dict[int, list[int]](), labels.names
        for frame, sequence in enumerate(labels.sequence.tolist()):
            groups.setdefault(sequence, []).append(frame)
    found = []
    for number, (sequence, frames) in enumerate(islice(groups.items(), most)):
        name = "".join(sign if sign.isascii() and sign.isalnum() else "-" for sign in names[sequence])[-40:]
        places = range(0, len(frames), every)
        found.append(
            Scene(number, f"sim-{number:04d}-{name}", tuple(frames[place] for place in places), tuple(places))
        )
    return found


# ---------------------------------------------------------------- room on the disk


def bytes_needed(dataset: Dataset, keys: Sequence[str]) -> int:
    """Estimate the size of spans and tables: three frames are simulated as a sample."""
    frames = [frame for key in keys for frame in dataset.spans[key].frames]
    if not frames:
        return 0
    tried = sorted({frames[0], frames[len(frames) // 2], frames[-1]})
    one = [len(simulate_unit(dataset.unit(Span((frame,), ("s__{}__0",))))) for frame in tried]
    users = int(np.count_nonzero(dataset.traffic.cls < len(CLASSES))) / max(1, dataset.traffic.frames)
    tables = users * (
        TABLE_BYTES + TABLE_BYTES_2D * bool(dataset.rig.enabled_cameras() and dataset.extras.pictures)
    )
    return int(sum(one) / len(one) * len(frames) + tables * dataset.frames)


def require_room(needed: int, folder: Path) -> None:
    """Raise InputError when the disk of a folder, which may not exist yet, has too little room."""
    place = folder.absolute()
    while not place.exists():
        place = place.parent
    free = shutil.disk_usage(place).free
    if needed * SPARE > free:
        raise InputError(
            f"{folder}: needs about {_size(needed * SPARE)}, but only {_size(free)} are free: simulate fewer frames, "
            "leave the pictures out, or name another disk"
        )


def _size(count: float) -> str:
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.1f} MB"


# ---------------------------------------------------------------- the folder


def require_own(path: Path) -> bool:
    """Return whether a folder holds a data set; InputError when it is a file, or holds something else."""
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: must be a folder, not a file")
    held = sorted(entry.name for entry in path.iterdir()) if path.exists() else []
    held = [name for name in held if not name.startswith(WORK)]  # ours, of a run killed at its very beginning
    if held and PLAN not in held:
        raise InputError(f"{path}: must be a new or an empty folder (holds {held[0]!r})")
    return bool(held)


class DatasetFolder:
    """The folder of a data set, which is a store of its spans; InputError when it holds another data set or else.

    work: the folder of the notes while the data set is being made.
    """

    def __init__(self, path: Path, dataset: Dataset) -> None:
        self.path, self.work, self._dataset = path, path / WORK, dataset
        self._kept = PieceFolder(self.work, self._read)
        self._text = json.dumps(dataset.plan, indent=1) + "\n"
        self._check()

    def _check(self) -> None:
        if require_own(self.path) and self._said() != self._text:
            raise InputError(
                f"{self.path}: the folder holds another data set ({self._difference()}); name a new folder, or repeat "
                "the command that made it"
            )

    def _said(self) -> str:
        try:
            return (self.path / PLAN).read_bytes()[: 1 << 20].decode("utf-8", "replace")
        except OSError as error:
            raise InputError(f"{self.path / PLAN}: cannot be read ({error.strerror})") from error

    def _difference(self) -> str:
        """Name the first difference between the plans."""
        try:
            there, here = json.loads(self._said()), json.loads(self._text)
            for group in ("rig", "simulated", "data"):
                for name, value in here[group].items():
                    if there[group].get(name) != value:
                        return f"{group} {name}"
        except (ValueError, KeyError, TypeError, AttributeError):
            return f"its {PLAN} cannot be read"
        return "channels"

    @property
    def is_complete(self) -> bool:
        """Return whether everything is complete, without remains of an interrupted run."""
        ends = (self.path / PLAN, self.path / VERSION / _LAST)
        if count_kept(self.work) or not all(path.exists() for path in ends):
            return False
        spans = self._dataset.spans.values()
        return all((self.path / name).exists() for span in spans for name in self._dataset.file_names(span))

    def begin(self) -> None:
        """Write the plan."""
        with atomic_write(self.path / PLAN, "w") as stream:
            stream.write(self._text)

    def missing(self, progress: Progress = lambda _: None) -> list[str]:
        """Return the spans that are not complete; the files of the others are compared with their checksums."""
        keys, found = list(self._dataset.spans), list[str]()
        for done, key in enumerate(keys, 1):
            if self.load(key) is None:
                found.append(key)
            progress(done / len(keys))
        return found

    def load(self, key: str) -> Sequence[Notes] | None:
        """Return the notes of a span whose files are complete and unchanged."""
        kept = self._kept.load(key)
        if kept is None or not all(_is_as_written(self.path / name, kept.files[name]) for name in kept.files):
            return None
        return kept.notes

    def keep(self, key: str, content: bytes) -> Sequence[Notes]:
        """Write the files of a span, then that it is complete."""
        span = self._dataset.spans[key]
        files, notes = unpacked(content, span.frames, self._dataset.file_names(span))
        write_files(self.path, files)
        digests = {name: hashlib.sha256(file).hexdigest() for name, file in files.items()}
        self._kept.keep(key, json.dumps([notes, digests], separators=(",", ":")).encode())
        return notes

    def finish(self) -> int:
        """Write the tables, delete the progress, and return the number of points."""
        notes = dict[int, Notes]()
        for key in self._dataset.spans:
            kept = self._kept.load(key)
            if kept is None:
                raise InputError(f"{self.work}: a finished part is missing; run the same command again")
            notes |= {note["frame"]: note for note in kept.notes}
        write_tables(self.path, self._dataset._tables(notes))
        shutil.rmtree(self.work, ignore_errors=True)
        return sum(note["points"] for note in notes.values())

    def _read(self, key: str, content: bytes) -> _Kept:
        """Return the notes of a span; ValueError when they are those of other frames or files."""
        kept, span = _Kept(*json.loads(content)), self._dataset.spans[key]
        if tuple(note["frame"] for note in kept.notes) != span.frames:
            raise ValueError("notes of other frames")
        if kept.files.keys() != self._dataset.file_names(span):
            raise ValueError("notes of other files")
        return kept


class _Kept(NamedTuple):
    """Record of a complete span: notes of its frames, and the SHA-256 of each of its files."""

    notes: Sequence[Notes]
    files: dict[str, str]


def _is_as_written(path: Path, digest: str) -> bool:
    try:
        with open_regular(path, "a file of the data set") as file:
            return hashlib.sha256(file.read()).hexdigest() == digest
    except (OSError, InputError):
        return False


def write_tables(path: Path, tables: Tables) -> None:
    """Write the tables of a data set, its splits and its map."""
    write_files(path, {MAP_FILE: _plain_map()})
    folder = path / VERSION
    folder.mkdir(exist_ok=True)
    for name, records in tables.all():
        with atomic_write(folder / f"{name}.json", "w") as stream:
            for text in _json_array(records):
                stream.write(text)
    with atomic_write(folder / _LAST, "w") as stream:
        json.dump(tables.splits(), stream, indent=1)


def _json_array(records: Iterator[Record]) -> Iterator[str]:
    """Return the text of a list of records, one a line."""
    before = "[\n"
    for record in records:
        yield before + json.dumps(record)
        before = ",\n"
    yield "[]\n" if before == "[\n" else "\n]\n"


def _plain_map() -> bytes:
    """Return a map on which everything is road: the real one is unknown."""
    from io import BytesIO

    from PIL import Image

    stream = BytesIO()
    Image.new("L", (2000, 2000), 255).save(stream, format="PNG")
    return stream.getvalue()
