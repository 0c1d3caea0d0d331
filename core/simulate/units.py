"""Simulate a piece of a data set: some frames of one sequence, on any worker, returned as plain bytes."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from typing import Any, NamedTuple

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
            drawn = [_drawn(picture, truth) for picture in pictures if unit.extras.pictures]
            files, inside = files_of_frame(stem, channels, unit.rig, truth, sweep, drawn)
            if unit.extras.points:
                files[_points_name(stem)] = _parquet(sweep, truth, unit.rig)
            for name, content in files.items():
                _put(archive, name, content)
            notes.append(_notes(frame, truth, sweep, inside, pictures))
        _put(archive, NOTES, json.dumps(notes, separators=(",", ":")).encode())
    return stream.getvalue()


def unpacked(
    content: bytes, frames: tuple[int, ...], names: set[str]
) -> tuple[dict[str, bytes], list[dict[str, Any]]]:
    """Return the files of a unit and the notes of its frames; ChildProcessError unless they have these names and
    numbers."""
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
        notes = json.loads(files.pop(NOTES))
        found = tuple(note["frame"] for note in notes)
    except Exception as error:  # damaged bytes make zipfile and json raise a dozen kinds of error
        raise ChildProcessError("a worker sent a damaged part; finished parts are kept") from error
    if files.keys() != names or found != frames:
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


class Drawn(NamedTuple):
    """Pixels of a camera's files: colours (rows, columns, 3), classes, and depths along its axis in centimetres."""

    rgb: NDArray[np.uint8]
    labels: NDArray[np.uint8]
    depth: NDArray[np.uint16]


def files_of_frame(
    stem: str,
    channels: Sequence[Channel],
    rig: Rig,
    truth: TrueBoxes,
    sweep: Sweep,
    drawn: Sequence[Drawn],
) -> tuple[dict[str, bytes], NDArray[np.int64]]:
    """Return the files of all channels by their paths in the data set, and the number of points (n,) in each object's
    box, of those in the file; drawn: by the cameras of the rig."""
    files, inside = dict[str, bytes](), np.zeros(len(truth.cls), np.int64)
    for channel in channels:
        name = file_name(stem, channel.name, channel.ending)
        if channel.modality == "lidar":
            records = records_of(sweep, channel, rig)
            files[name] = records.tobytes()
            if channel.sensor is None:
                points_m = channel.to_ego(records[:, :3].astype(np.float64)) + ego_origin_m(rig)
                count_inside(points_m, truth.centre_m, truth.size_m / 2.0, truth.rotation, inside)
        else:
            assert channel.sensor is not None
            rgb, labels, depth = drawn[channel.sensor]
            files[name] = _encoded(rgb, "JPEG", quality=JPEG_QUALITY)
            files[file_name(stem, channel.name, ".png", "labels")] = _encoded(labels, "PNG")
            files[file_name(stem, channel.name, ".png", "depth")] = _encoded(depth, "PNG")
    return files, inside


def _drawn(picture: CameraPicture, truth: TrueBoxes) -> Drawn:
    depth = np.where(np.isfinite(picture.depth_m), picture.depth_m * DEPTH_PER_M + 0.5, 0.0)
    depth = np.where((depth > 0.0) & (depth < 65536.0), depth, 0.0)  # fisheyes see behind
    return Drawn(picture.rgb, class_labels(picture.what, truth.cls), depth.astype(np.uint16))


def _encoded(pixels: NDArray[Any], form: str, **options: int) -> bytes:
    """Return pixels as the bytes of a picture file."""
    from PIL import Image

    stream = BytesIO()
    Image.fromarray(pixels).save(stream, format=form, **options)
    return stream.getvalue()


def _parquet(sweep: Sweep, truth: TrueBoxes, rig: Rig) -> bytes:
    """Return all points in the vehicle frame, with the LiDAR, the object and its class."""
    import pyarrow as pa
    from pyarrow import parquet

    lidars = pa.array([lidar.name for lidar in rig.enabled_lidars()], pa.string())
    surfaces = pa.array([*CLASSES, "static", "ground"], pa.string())
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
        "on": pa.DictionaryArray.from_arrays(pa.array(on), surfaces),
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
