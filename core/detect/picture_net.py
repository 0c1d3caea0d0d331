"""A detector on pictures alone: a small U-Net that marks objects in each picture and says how far away they are.

Nothing but pictures and lenses goes in; detections of several cameras are joined on the ground.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.net import (
    ANSWERS,
    WIDTHS,
    Machine,
    block,
    highest_peaks,
    rarely_a_centre,
    require_torch,
    restored,
)
from riglens.core.detect.pillars import Region, Target
from riglens.core.detect.precision import Detections
from riglens.core.detect.views import FEATURES, Views, places_of, wanted_in

_APART = (1.0, 0.05)
"""Detections of a class are one object where they are closer than this many metres, plus this share of the distance:
distances in pictures are uncertain in proportion."""
_AT_ONCE = 16


class PictureTask:
    """Pictures of rigs, and the objects in them; every picture is an item."""

    def __init__(self, sets: Sequence[Views]) -> None:
        self._sets = sets
        self._items = [
            (s, f, c)
            for s, one in enumerate(sets)
            for f in range(len(one))
            for c in range(one.pixels.shape[1])
        ]
        self.count = len(self._items)

    def net(self, seed: int) -> Any:
        """Return a new net."""
        return _net(seed)

    def batch(self, chosen: Sequence[int], mirrors: Sequence[int]) -> tuple[Any, list[Target]]:
        """Return pictures and targets; those with an odd mirror are mirrored."""
        images, targets = [], []
        for place, mirror in zip(chosen, mirrors, strict=True):
            number, frame, camera = self._items[place]
            views = self._sets[number]
            image = views.image(frame, camera)
            images.append(image[:, ::-1] if mirror & 1 else image)
            focal_px = float(views.focal_px[camera])
            targets.append(wanted_in(views.marks(frame, camera), focal_px, image.shape[:2], bool(mirror & 1)))
        return _tensor(images), targets

    def answer(self, net: Any, images: Any, on: Machine) -> Any:
        """Return the net's output."""
        return _answer(net, images, on)


def detect_in(state: Mapping[str, NDArray[Any]], views: Views, region: Region, on: Machine) -> Detections:
    """Return the detections of a trained net in all frames, numbered by their place; the best of those that are one
    object."""
    torch = require_torch()
    net = restored(_net(0), state, on)
    found = []
    with torch.no_grad():
        for camera in range(views.pixels.shape[1]):
            for start in range(0, len(views), _AT_ONCE):
                frames = range(start, min(start + _AT_ONCE, len(views)))
                images = _tensor([views.image(frame, camera) for frame in frames])
                answer = _answer(net, images.to(on.device), on)
                found += _places(answer, views, camera, start)
    every = Detections.joined(found)
    return joined(every.where(region.holds(every.centre_m)))


def joined(found: Detections) -> Detections:
    """Return the best of the detections that are one object."""
    kept = []
    order = np.lexsort((-found.score, found.cls, found.frame))
    metres, share = _APART
    group: list[int] = []
    last = (-1, -1)
    for place in order.tolist():
        key = int(found.frame[place]), int(found.cls[place])
        if key != last:
            last, group = key, []
        centre = found.centre_m[place]
        apart = np.hypot(*(found.centre_m[group] - centre).T) if group else np.full(1, np.inf)
        if apart.min() >= metres + share * np.hypot(*centre):
            group.append(place)
            kept.append(place)
    return found.where(np.array(sorted(kept), np.int64))


def _places(answer: Any, views: Views, camera: int, first: int) -> list[tuple[NDArray[Any], ...]]:
    found: list[tuple[NDArray[Any], ...]] = []
    for cls, columns in enumerate(highest_peaks(answer)):
        frame, cell, figures, score = (column.cpu().numpy() for column in columns)
        centre_m = places_of(views.lenses, camera, cell, figures.astype(np.float64))
        kinds = np.full(len(frame), cls, np.uint8)
        found.append((frame + first, kinds, centre_m, score.astype(np.float64)))
    return found


def _tensor(images: Sequence[NDArray[np.float32]]) -> Any:
    return require_torch().from_numpy(np.stack(images)).permute(0, 3, 1, 2)


def _net(seed: int) -> Any:
    torch = require_torch()
    nn = torch.nn
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        a, b, c = WIDTHS
        d = 3 * c // 2
        net = nn.ModuleDict(
            {
                "near": nn.Sequential(*block(nn, FEATURES, a, 2), *block(nn, a, a)),
                "wide": nn.Sequential(*block(nn, a, b, 2), *block(nn, b, b)),
                "far": nn.Sequential(*block(nn, b, c, 2), *block(nn, c, c)),
                "deep": nn.Sequential(*block(nn, c, d, 2), *block(nn, d, d), *block(nn, d, d)),
                "up_far": nn.ConvTranspose2d(d, c, 2, 2),
                "join_far": nn.Sequential(*block(nn, 2 * c, c)),
                "up_wide": nn.ConvTranspose2d(c, b, 2, 2),
                "join_wide": nn.Sequential(*block(nn, 2 * b, b)),
                "up_near": nn.ConvTranspose2d(b, a, 2, 2),
                "join_near": nn.Sequential(*block(nn, 2 * a, b)),
                "head": nn.Conv2d(b, ANSWERS, 1),
            }
        )
        rarely_a_centre(net)
    return net


def _answer(net: Any, images: Any, on: Machine) -> Any:
    """Return the net's output for pictures (n, FEATURES, rows, columns): (n, classes and two figures, rows / 2,
    columns / 2), single precision."""
    torch = require_torch()
    with torch.autocast(on.device, torch.bfloat16, enabled=on.bf16):
        near = net["near"](images)
        wide = net["wide"](near)
        far = net["far"](wide)
        far = net["join_far"](torch.cat([net["up_far"](net["deep"](far)), far], 1))
        wide = net["join_wide"](torch.cat([net["up_wide"](far), wide], 1))
        near = net["join_near"](torch.cat([net["up_near"](wide), near], 1))
        return net["head"](near).float()
