"""nuScenes folders: annotations from the global frame into the ego frame of each sample's LiDAR sweep."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import BoxBatch, Progress, rotations_from_quaternions
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    BATCH_BOXES,
    BoxOptions,
    FileBoxSource,
    Tally,
    accepted_number,
    first_bad_box,
    readable,
    shown,
)
from riglens.core.scene.readers.json_records import Record
from riglens.core.scene.readers.nuscenes_tables import CHANNELS, NuscenesTables, Samples, Table
from riglens.core.scene.readers.spool import BoxSpool

REAR_AXLE_M: Vec3 = (-1.35, 0.0, 0.0)
"""Place of the ego frame's origin in the vehicle frame, about: the middle of the rear axle, projected onto the
ground (a maintainer in issue 161 of nuscenes-devkit)."""

_FIELDS = ("translation x", "translation y", "translation z", "size length", "size width", "size height")


@dataclass
class _Rows:
    """Annotations as they are in the file, until there are enough for a batch.

    numbers: centre, size (width, length, height) and quaternion (w, x, y, z) of each; record: its number.
    """

    sample: list[int] = field(default_factory=list)
    cls: list[int] = field(default_factory=list)
    numbers: list[list[float]] = field(default_factory=list)
    record: list[int] = field(default_factory=list)


class NuscenesSource(FileBoxSource):
    """The tables of one nuScenes version; a frame is a sample, with annotations or without."""

    def __init__(self, path: Path, folder: Path, options: BoxOptions) -> None:
        super().__init__(path, options)
        with readable(path):
            self._tables = NuscenesTables(folder)

    def _files(self) -> list[Path]:
        return self._tables.files()

    def _read(self, tally: Tally, progress: Progress) -> Iterator[BoxBatch]:
        samples = self._tables.samples(progress)
        if samples.channel != CHANNELS[0]:
            tally.notes.append(f"the boxes are those at the sweeps of {shown(samples.channel)}")
        names = self._tables.category_of_instance(progress)
        categories = sorted(set(names.values()))
        codes = dict(zip(categories, self.options.classes.codes(categories), strict=True))
        tally.frames, tally.sequences = len(samples.number), len(samples.scenes)
        for scene, count in samples.scenes:
            tally.name_frames(scene, np.arange(count))
        table, rows = self._tables.table("sample_annotation"), _Rows()
        with BoxSpool() as spool:
            for record in table.records(self._tables.share("sample_annotation", progress)):
                name = table.found(record, "instance_token", names)
                if codes[name] == UNMAPPED:
                    tally.miss([name], table.path)
                    continue
                _take(table, record, samples, codes[name], rows)
                if len(rows.sample) == BATCH_BOXES:
                    spool.put(_ego_boxes(table, rows, samples))
                    rows = _Rows()
            spool.put(_ego_boxes(table, rows, samples))
            yield from spool.batches()
        progress(1.0)


def _take(table: Table, record: Record, samples: Samples, cls: int, rows: _Rows) -> None:
    """Note one annotation."""
    rows.sample.append(table.found(record, "sample_token", samples.number))
    centre, size = table.numbers(record, "translation", 3), table.numbers(record, "size", 3)
    rows.numbers.append([*centre, *size, *table.quaternion(record, "rotation")])
    rows.cls.append(cls)
    rows.record.append(record.number)


def _ego_boxes(table: Table, rows: _Rows, samples: Samples) -> BoxBatch:
    """Return boxes in the ego frame of their samples, frames in any order; raise InputError for impossible numbers."""
    sample = np.asarray(rows.sample, dtype=np.int64)
    numbers = np.asarray(rows.numbers, dtype=np.float64).reshape(-1, 10)
    ego_R_global = samples.rotation[sample].transpose(0, 2, 1)
    offset = numbers[:, 0:3] - samples.place_m[sample]
    centre = np.einsum("nij,nj->ni", ego_R_global, offset)
    size = numbers[:, [4, 3, 5]]
    bad = first_bad_box(centre, size)
    if bad is not None:
        place = f"{table.path}: record {rows.record[bad.row]}: {_FIELDS[bad.column]}"
        raise InputError(f"{place}: must be {accepted_number(bad.column)} (got {bad.value:g})")
    rotation = ego_R_global @ rotations_from_quaternions(numbers[:, 6:10])
    return BoxBatch(sample, np.asarray(rows.cls, dtype=np.uint8), centre, size, rotation)
