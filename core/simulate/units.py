"""Simulate a piece of a data set: some frames of one sequence, on any worker, returned as plain bytes."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects.sweeps import count_inside
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.simulate.channels import Channel, channels_of, ego_origin_m
from riglens.core.simulate.pictures import CameraPicture, Cameras, class_labels
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import Simulator, Sweep
from riglens.core.simulate.world import TrueBoxes, Worlds
from riglens.core.targets.traffic import Traffic

JPEG_QUALITY = 92
DEPTH_PER_M = 100
"""Depth pictures hold centimetres, 0 where there is none and beyond 655.35 m."""
NOTES = "notes.json"
Notes = Mapping[str, Any]
"""Properties of a frame's objects beyond their boxes, see `_notes`."""


@dataclass(frozen=True)
class Extras:
    """Optional files besides sweeps and tables: pictures of the cameras with labels and depth; points as Parquet."""

    pictures: bool = True
    points: bool = False


@dataclass(frozen=True)
class Unit:
    """Frames of one sequence: stems[k] is the stem of the file names of frames[k], `{}` is the channel.

    traffic: of these frames alone, with their numbers in the data.
    """

    rig: Rig
    settings: SimulationSettings
    extras: Extras
    traffic: Traffic
    frames: tuple[int, ...]
    stems: tuple[str, ...]

    def file_names(self) -> set[str]:
        """Return every file that the unit writes, by its path in the data set."""
        return file_names(self.stems, channels_of(self.rig, self.extras.pictures), self.extras)


def part_of(traffic: Traffic, places: NDArray[np.int64]) -> Traffic:
    """Return some frames of traffic, by their places in it; they keep their numbers in the data."""
    return replace(traffic.frames_alone(places), data=replace(traffic.data, labels=None, notes=()))


def simulate_unit(unit: Unit) -> bytes:
    """Return files of a unit, and notes of each frame for the tables, as a ZIP archive; the same bytes each time."""
    worlds = Worlds(unit.traffic, unit.settings)
    simulator = Simulator(unit.rig, worlds)
    cameras = Cameras(unit.rig, worlds, is_native=unit.extras.pictures)
    channels, notes, stream = channels_of(unit.rig, unit.extras.pictures), [], BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for frame, stem in zip(unit.frames, unit.stems, strict=True):
            truth, sweep = worlds.truth(frame), simulator.sweep(frame)
            pictures = [cameras.picture(number, frame) for number in range(len(unit.rig.enabled_cameras()))]
            merged = np.zeros((0, 5), np.float32)
            for channel in channels:
                name = file_name(stem, channel.name, channel.ending)
                if channel.modality == "lidar":
                    records = records_of(sweep, channel, unit.rig)
                    merged = records if channel.sensor is None else merged
                    _put(archive, name, records.tobytes())
                else:
                    assert channel.sensor is not None
                    _put_picture(archive, stem, channel, pictures[channel.sensor], truth)
            if unit.extras.points:
                _put(archive, _points_name(stem), _parquet(sweep, truth, unit.rig))
            notes.append(
                _notes(frame, truth, sweep, counted_inside(truth, merged, channels, unit.rig), pictures)
            )
        _put(archive, NOTES, json.dumps(notes, separators=(",", ":")).encode())
    return stream.getvalue()


def unpacked(content: bytes, unit: Unit) -> tuple[dict[str, bytes], list[dict[str, Any]]]:
    """Return the files of a unit and the notes of its frames; ChildProcessError when they are not those of the unit."""
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
        notes = json.loads(files.pop(NOTES))
        frames = tuple(note["frame"] for note in notes)
    except Exception as error:  # damaged bytes make zipfile and json raise a dozen kinds of error
        raise ChildProcessError("a worker sent a damaged part; finished parts are kept") from error
    if files.keys() != unit.file_names() or frames != unit.frames:
        raise ChildProcessError("a worker returned another part than requested; finished parts are kept")
    return files, notes


# ---------------------------------------------------------------- files of a frame


def file_name(stem: str, channel: str, ending: str, folder: str = "samples") -> str:
    """Return the path of a file of a channel in the data set."""
    return f"{folder}/{channel}/{stem.format(channel)}{ending}"


def _points_name(stem: str) -> str:
    return f"points/{stem.format('POINTS')}.parquet"


def file_names(stems: Sequence[str], channels: list[Channel], extras: Extras) -> set[str]:
    """Return every file of frames, by its path in the data set."""
    return {name for stem in stems for name in _names(stem, channels, extras)}


def _names(stem: str, channels: list[Channel], extras: Extras) -> list[str]:
    names = [file_name(stem, channel.name, channel.ending) for channel in channels]
    for channel in channels:
        if channel.modality == "camera":
            names += [file_name(stem, channel.name, ".png", folder) for folder in ("labels", "depth")]
    return [*names, _points_name(stem)] if extras.points else names


def _put(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    archive.writestr(zipfile.ZipInfo(name), content)


def records_of(sweep: Sweep, channel: Channel, rig: Rig) -> NDArray[np.float32]:
    """Return x, y, z, intensity, ring (n, 5) in the frame of a channel; of all LiDARs, rings are numbered
    consecutively."""
    ring = sweep.ring.astype(np.float32)
    if channel.sensor is None:
        beams = np.concatenate([[0], np.cumsum([lidar.beam_count for lidar in rig.enabled_lidars()])])
        ring = ring + beams[sweep.sensor].astype(np.float32)
    else:
        mine = sweep.sensor == channel.sensor
        sweep, ring = sweep.of(channel.sensor), ring[mine]
    places = channel.to_sensor(sweep.points_m.astype(np.float64) - ego_origin_m(rig))
    return np.column_stack([places, sweep.intensity, ring]).astype(np.float32)


def counted_inside(
    truth: TrueBoxes, records: NDArray[np.float32], channels: list[Channel], rig: Rig
) -> NDArray[np.int64]:
    """Return the number of points (n,) in each object's box, of those in the file."""
    counts = np.zeros(len(truth.cls), np.int64)
    if len(records):
        points_m = channels[0].to_ego(records[:, :3].astype(np.float64)) + ego_origin_m(rig)
        count_inside(points_m, truth.centre_m, truth.size_m / 2.0, truth.rotation, counts)
    return counts


def _put_picture(
    archive: zipfile.ZipFile, stem: str, channel: Channel, picture: CameraPicture, truth: TrueBoxes
) -> None:
    """Add the picture, the class of each pixel and its depth along the camera's axis in centimetres."""
    depth = np.where(np.isfinite(picture.depth_m), picture.depth_m * DEPTH_PER_M + 0.5, 0.0)
    depth = np.where((depth > 0.0) & (depth < 65536.0), depth, 0.0).astype(np.uint16)  # fisheyes see behind
    _put(archive, file_name(stem, channel.name, ".jpg"), encoded(picture.rgb, "JPEG", quality=JPEG_QUALITY))
    labels = class_labels(picture.what, truth.cls)
    _put(archive, file_name(stem, channel.name, ".png", "labels"), encoded(labels, "PNG"))
    _put(archive, file_name(stem, channel.name, ".png", "depth"), encoded(depth, "PNG"))


def encoded(pixels: NDArray[Any], form: str, **options: int) -> bytes:
    """Return pixels as the bytes of a picture file."""
    from PIL import Image

    stream = BytesIO()
    Image.fromarray(pixels).save(stream, format=form, **options)
    return stream.getvalue()


@lru_cache(maxsize=64)
def _names_array(names: tuple[str, ...]) -> Any:
    import pyarrow as pa

    return pa.array(list(names), pa.string())


def _parquet(sweep: Sweep, truth: TrueBoxes, rig: Rig) -> bytes:
    """Return all points in the vehicle frame, with the LiDAR, the object and its class."""
    import pyarrow as pa
    from pyarrow import parquet

    lidars = _names_array(tuple(lidar.name for lidar in rig.enabled_lidars()))
    on = np.where(sweep.object >= 0, np.append(truth.cls, 0)[np.maximum(sweep.object, -1)], len(CLASSES))
    on = np.where(sweep.object < 0, len(CLASSES) + (sweep.object == -1), on).astype(np.int8)
    columns = {
        "x": sweep.points_m[:, 0],
        "y": sweep.points_m[:, 1],
        "z": sweep.points_m[:, 2],
        "intensity": sweep.intensity,
        "ring": sweep.ring,
        "lidar": pa.DictionaryArray.from_arrays(pa.array(sweep.sensor), lidars),
        "object": sweep.object,
        **({"time_s": sweep.time_s} if any(lidar.rays is not None for lidar in rig.enabled_lidars()) else {}),
        "on": pa.DictionaryArray.from_arrays(pa.array(on), _names_array((*CLASSES, "static", "ground"))),
    }
    stream = BytesIO()
    parquet.write_table(pa.table(columns), stream)
    return stream.getvalue()


# ---------------------------------------------------------------- notes for the tables


def _notes(
    frame: int, truth: TrueBoxes, sweep: Sweep, inside: NDArray[np.int64], pictures: list[CameraPicture]
) -> dict[str, Any]:
    """Return for each object: points in its box, rays that returned from it, share that cameras see, or LiDARs where no
    camera looks (None: unknown); for each camera the objects in its picture: index, bounds in pixels, pixels, visible
    share."""
    pixels = sum((picture.pixels for picture in pictures), np.zeros(len(truth.cls), np.int64))
    alone = sum((picture.alone for picture in pictures), np.zeros(len(truth.cls), np.int64))
    shown = np.where(alone > 0, pixels, sweep.reached), np.where(alone > 0, alone, sweep.alone)
    seen = [round(a / b, 4) if b else None for a, b in zip(*(part.tolist() for part in shown), strict=True)]
    boxes = [
        [
            [user, *picture.bounds_px[user].tolist(), int(picture.pixels[user]), int(picture.alone[user])]
            for user in np.flatnonzero(picture.pixels).tolist()
        ]
        for picture in pictures
    ]
    hits = sweep.hits(len(truth.cls))
    return {
        "frame": frame,
        "points": len(sweep.object),
        "inside": inside.tolist(),
        "hits": hits.tolist(),
        "visible": seen,
        "boxes_2d": boxes,
    }
