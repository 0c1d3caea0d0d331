"""nuScenes folders: annotations from the global frame into the ego frame of each sample's LiDAR sweep."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np

from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import BoxBatch, Progress, rotations_from_quaternions
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    BATCH_BOXES,
    BoxOptions,
    FileBoxSource,
    ReadingTally,
    readable,
    require_boxes,
    shown,
)
from riglens.core.scene.readers.json_records import Record
from riglens.core.scene.readers.nuscenes_tables import CHANNELS, NuscenesTables, Samples, Table
from riglens.core.scene.readers.spool import BoxSpool

REAR_AXLE_M: Vec3 = (-1.35, 0.0, 0.0)
"""Place of the ego frame's origin in the vehicle frame, about: the middle of the rear axle, projected onto the
ground (a maintainer in issue 161 of nuscenes-devkit)."""

_FIELDS = ("translation x", "translation y", "translation z", "size length", "size width", "size height")


class NuscenesSource(FileBoxSource):
    """The tables of one nuScenes version; a frame is a sample, with annotations or without."""

    def __init__(self, path: Path, folder: Path, options: BoxOptions) -> None:
        super().__init__(path, options)
        with readable(path):
            self._tables = NuscenesTables(folder)

    def _files(self) -> list[Path]:
        return self._tables.files()

    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        samples = self._tables.samples(progress)
        if samples.channel != CHANNELS[0]:
            tally.notes.append(f"the boxes are those at the sweeps of {shown(samples.channel)}")
        names = self._tables.category_of_instance(progress)
        categories = sorted(set(names.values()))
        codes = dict(zip(categories, self.options.classes.codes(categories), strict=True))
        tally.frames, tally.sequences = len(samples.number), len(samples.scenes)
        for scene, count in samples.scenes:
            tally.name_frames(scene, np.arange(count))
        table, rows = self._tables.table("sample_annotation"), list[list[float]]()
        with closing(BoxSpool()) as spool:
            for record in table.records(self._tables.share("sample_annotation", progress)):
                name = table.found(record, "instance_token", names)
                if codes[name] == UNMAPPED:
                    tally.miss([name], table.path)
                    continue
                rows.append(_row(table, record, samples, codes[name]))
                if len(rows) == BATCH_BOXES:
                    spool.put(_ego_boxes(table, rows, samples))
                    rows = []
            spool.put(_ego_boxes(table, rows, samples))
            yield from spool.batches()
        progress(1.0)


def _row(table: Table, record: Record, samples: Samples, cls: int) -> list[float]:
    """Return the numbers of an annotation: its sample, class and record, centre, size (width, length, height), and
    quaternion (w, x, y, z)."""
    sample = table.found(record, "sample_token", samples.number)
    centre, size = table.numbers(record, "translation", 3), table.numbers(record, "size", 3)
    return [sample, cls, record.number, *centre, *size, *table.quaternion(record, "rotation")]


def _ego_boxes(table: Table, rows: list[list[float]], samples: Samples) -> BoxBatch:
    """Return boxes in the ego frame of their samples, frames in any order; raise InputError for impossible numbers."""
    numbers = np.asarray(rows, dtype=np.float64).reshape(-1, 13)
    sample, record = numbers[:, 0].astype(np.int64), numbers[:, 2].astype(np.int64)
    ego_R_global = samples.rotation[sample].transpose(0, 2, 1)
    offset = numbers[:, 3:6] - samples.place_m[sample]
    centre = np.einsum("nij,nj->ni", ego_R_global, offset)
    size = numbers[:, [7, 6, 8]]
    require_boxes(centre, size, lambda row, column: f"{table.path}: record {record[row]}: {_FIELDS[column]}")
    rotation = ego_R_global @ rotations_from_quaternions(numbers[:, 9:13])
    return BoxBatch(sample, numbers[:, 1].astype(np.uint8), centre, size, rotation)
