"""Detectors: a small U-Net over pillars, or over a range image, that marks the centres of objects. The only module
that uses PyTorch.

PyTorch is an extra; it is imported when it is needed, and `require_torch` says what to install. Training on the CPU
is the same to the last bit for the same seed, samples and machine: one thread, deterministic algorithms, and no draw
but from the seed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.panorama import PLACE_M, RANGE, Panorama
from riglens.core.detect.pillars import (
    ACROSS_X,
    ACROSS_Y,
    FEATURES,
    Region,
    Sample,
    Samples,
    Target,
    wanted,
)
from riglens.core.detect.precision import Detections
from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES

Device = Literal["cpu", "cuda"]
State = dict[str, NDArray[Any]]
"""State of a training: weights, running means, moments of the optimiser, and progress."""

WIDTHS = (16, 32, 64)
ANSWERS = len(CLASSES) + 2
_MOST_PER_CLASS, _LEAST_SCORE = 50, 0.02
_APART_CELLS = (5, 3, 3)
"""Width in output cells of the window in which a peak is the highest: car, bicycle, pedestrian."""


@dataclass(frozen=True)
class Training:
    """Training settings: passes over the samples, samples per step, highest learning rate, and the seed of all
    draws."""

    epochs: int = 12
    batch: int = 8
    rate: float = 4e-3
    seed: int = 0


@dataclass(frozen=True)
class Machine:
    """Machine of a computation: never mixed in one comparison. bf16: whether products are taken in 16 bits."""

    device: Device
    bf16: bool
    torch: str


def require_torch() -> Any:
    """Return the module torch; raise InputError that names the package to install where it is missing."""
    try:
        import torch
    except ImportError:
        raise InputError(
            "training a detector needs PyTorch; install it with: pip install 'riglens[detect]' "
            "(without a GPU: pip install torch --index-url https://download.pytorch.org/whl/cpu)"
        ) from None
    return torch


def machine(device: Device | None = None) -> Machine:
    """Return the machine available: CUDA where it exists and is not refused; products in 16 bits where supported."""
    torch = require_torch()
    found = device or ("cuda" if torch.cuda.is_available() else "cpu")
    if found == "cuda" and not torch.cuda.is_available():
        raise InputError("must be cpu (got cuda): PyTorch finds no CUDA here", "device")
    has_bf16 = getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)  # not promised by PyTorch
    return Machine(found, found == "cpu" and bool(has_bf16()), str(torch.__version__))


def use_one_thread() -> None:
    """Make this process compute with one thread and deterministically; for a separate process."""
    os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")
    torch = require_torch()
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)


def train(
    sets: Sequence[Samples],
    region: Region,
    training: Training,
    on: Machine,
    state: State | None = None,
    until: int | None = None,
    panorama: Panorama | None = None,
) -> State:
    """Train one net on all samples of all sets and return it.

    state: start of a resumed training. until: after which pass it stops, None for the last one. panorama: of samples
    that are range images; None for pillars.
    """
    return train_task(_GroundTask(sets, region, panorama), training, on, state, until)


class Task(Protocol):
    """Task of a net: `count` items to learn from, a new net, batches of items as images and targets, and the answers
    to images, (n, classes and two figures, a, b) in single precision."""

    @property
    def count(self) -> int:
        """Number of items."""

    def net(self, seed: int) -> Any:
        """Return a new net whose first weights are drawn from the seed."""

    def batch(self, chosen: Sequence[int], mirrors: Sequence[int]) -> tuple[Any, list[Target]]:
        """Return items as images and targets; mirrors: 0 to 3, a draw for each."""

    def answer(self, net: Any, images: Any, on: Machine) -> Any:
        """Return the output of the net for images."""


def train_task(
    task: Task, training: Training, on: Machine, state: State | None = None, until: int | None = None
) -> State:
    """Train a net for a task, as `train` does."""
    run = _Run(task, training, on)
    if state is not None:
        run.restore(state)
    while run.epoch < (training.epochs if until is None else until):
        run.pass_over()
    return run.state()


def restored(net: Any, state: Mapping[str, NDArray[Any]], on: Machine) -> Any:
    """Return the net with trained weights, ready to detect."""
    torch = require_torch()
    weights = net.state_dict()
    net.load_state_dict({name: torch.from_numpy(state[f"net.{name}"].copy()) for name in weights})
    return net.to(on.device, memory_format=torch.channels_last).eval()


def detect(
    state: Mapping[str, NDArray[Any]],
    samples: Samples,
    region: Region,
    on: Machine,
    panorama: Panorama | None = None,
) -> Detections:
    """Return the detections of a trained net in all samples, frames numbered by their place among them."""
    torch = require_torch()
    net = restored(_net(0, samples.features.shape[1], panorama is not None), state, on)
    found, at_once = [], 16
    with torch.no_grad():
        for start in range(0, len(samples), at_once):
            part = [samples[place] for place in range(start, min(start + at_once, len(samples)))]
            answer = _answer(net, _images(part, panorama or region).to(on.device), on, region)
            found.append(_peaks(answer, region, start))
    return Detections.joined(found)


class _GroundTask:
    """Pillars or range images, and the objects on the ground."""

    def __init__(self, sets: Sequence[Samples], region: Region, panorama: Panorama | None) -> None:
        self.sets, self.region, self.panorama = sets, region, panorama
        self.items = [(s, i) for s, one in enumerate(sets) for i in range(len(one))]
        self.count = len(self.items)

    def net(self, seed: int) -> Any:
        return _net(seed, self.sets[0].features.shape[1], self.panorama is not None)

    def batch(self, chosen: Sequence[int], mirrors: Sequence[int]) -> tuple[Any, list[Target]]:
        grid = self.panorama or self.region
        samples = [self.sets[s][i] for s, i in (self.items[place] for place in chosen)]
        turned = [_mirrored(sample, mirror, grid) for sample, mirror in zip(samples, mirrors, strict=True)]
        return _images(turned, grid), [wanted(sample, self.region) for sample in turned]

    def answer(self, net: Any, images: Any, on: Machine) -> Any:
        return _answer(net, images, on, self.region)


class _Run:
    """Training in progress."""

    def __init__(self, task: Task, training: Training, on: Machine) -> None:
        self.torch = torch = require_torch()
        self.task, self.training, self.on = task, training, on
        self.net = task.net(training.seed).to(on.device, memory_format=torch.channels_last)
        self.optimiser = torch.optim.AdamW(self.net.parameters(), lr=training.rate, weight_decay=0.01)
        self.epoch = 0

    def pass_over(self) -> None:
        """Run one epoch: every sample once, in an order and mirrored as its own draws determine."""
        rng = np.random.default_rng((self.training.seed, self.epoch))
        order = rng.permutation(self.task.count)
        mirrors = rng.integers(0, 4, len(order))
        steps = range(0, len(order), self.training.batch)
        self.net.train()
        for number, start in enumerate(steps):
            chosen = slice(start, start + self.training.batch)
            done = (self.epoch + number / len(steps)) / self.training.epochs
            self._step(order[chosen].tolist(), mirrors[chosen].tolist(), done)
        self.epoch += 1

    def _step(self, chosen: list[int], mirrors: list[int], done: float) -> None:
        for group in self.optimiser.param_groups:
            group["lr"] = self.training.rate * _rate(done)
        images, targets = self.task.batch(chosen, mirrors)
        loss = _loss(self.task.answer(self.net, images.to(self.on.device), self.on), targets)
        self.optimiser.zero_grad()
        loss.backward()
        self.torch.nn.utils.clip_grad_norm_(self.net.parameters(), 10.0)
        self.optimiser.step()

    def state(self) -> State:
        """Return all that is needed to resume, as arrays."""
        state: State = {"epoch": np.array(self.epoch)}
        for name, value in self.net.state_dict().items():
            state[f"net.{name}"] = value.cpu().numpy().copy()
        for number, moments in self.optimiser.state_dict()["state"].items():
            for name, value in moments.items():
                state[f"optimiser.{number}.{name}"] = value.cpu().numpy().copy()
        return state

    def restore(self, state: State) -> None:
        """Go on from a state of `state`."""
        tensor = self.torch.from_numpy
        self.epoch = int(state["epoch"])
        self.net.load_state_dict(
            {name: tensor(state[f"net.{name}"].copy()) for name in self.net.state_dict()}
        )
        held: dict[int, dict[str, Any]] = {}
        for key, value in state.items():
            kind, _, rest = key.partition(".")
            if kind == "optimiser":
                number, _, name = rest.partition(".")
                held.setdefault(int(number), {})[name] = tensor(value.copy())
        self.optimiser.load_state_dict(self.optimiser.state_dict() | {"state": held})


def _rate(done: float) -> float:
    """Return the share of the highest learning rate: up over the first tenth, then down along a cosine."""
    if done < 0.1:
        return 0.1 + 9.0 * done
    return float(0.5 + 0.5 * np.cos(np.pi * (done - 0.1) / 0.9)) + 1e-3


def _net(seed: int, features: int = FEATURES, is_range: bool = False) -> Any:
    """Return a new net for `features` figures of each cell, or pixel of a range image; its first weights are drawn from
    the seed."""
    torch = require_torch()
    nn = torch.nn
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        a, b, c = WIDTHS
        net = nn.ModuleDict(
            {
                "near": nn.Sequential(*block(nn, features, a, 2), *block(nn, a, a)),
                "wide": nn.Sequential(*block(nn, a, b, 2), *block(nn, b, b)),
                "far": nn.Sequential(*block(nn, b, c, 2), *block(nn, c, c), *block(nn, c, c)),
                "up_wide": nn.ConvTranspose2d(c, b, 2, 2),
                "join_wide": nn.Sequential(*block(nn, 2 * b, b)),
                "up_near": nn.ConvTranspose2d(b, a, 2, 2),
                "join_near": nn.Sequential(*block(nn, 2 * a, a if is_range else b)),
                **(_ground(nn, a + features + 1, b) if is_range else {}),
                "head": nn.Conv2d(b, ANSWERS, 1),
            }
        )
        rarely_a_centre(net)
    return net


def rarely_a_centre(net: Any) -> None:
    """Start a net's head with the answer that almost no cell is a centre."""
    require_torch().nn.init.constant_(net["head"].bias[: len(CLASSES)], -4.0)


def block(nn: Any, into: int, out: int, stride: int = 1) -> tuple[Any, ...]:
    """Return the layers of a convolution."""
    return nn.Conv2d(into, out, 3, stride, 1, bias=False), nn.BatchNorm2d(out), nn.ReLU(inplace=True)


def _ground(nn: Any, into: int, out: int) -> dict[str, Any]:
    """Return the layers on the ground behind those on the range image."""
    deep = 3 * out // 2
    return {
        "ground": nn.Sequential(*block(nn, into, out)),
        "deep": nn.Sequential(*block(nn, out, deep, 2), *block(nn, deep, deep)),
        "up_deep": nn.ConvTranspose2d(deep, out, 2, 2),
    }


def _answer(net: Any, images: Any, on: Machine, region: Region) -> Any:
    """Return the net's output for images (n, features, x, y), or range images: (n, classes and two places, x / 2,
    y / 2), single precision."""
    torch = require_torch()
    with torch.autocast(on.device, torch.bfloat16, enabled=on.bf16):
        near = net["near"](images)
        wide = net["wide"](near)
        wide = net["join_wide"](torch.cat([net["up_wide"](net["far"](wide)), wide], 1))
        near = net["join_near"](torch.cat([net["up_near"](wide), near], 1))
        if "ground" in net:
            ground = net["ground"](_on_ground(images, near, region))
            near = torch.relu(ground + net["up_deep"](net["deep"](ground)))
        return net["head"](near).float()


def _on_ground(images: Any, context: Any, region: Region) -> Any:
    """Return what the net knows of each pixel, beside its own figures, as means over the cells of the answer that the
    points lie in: (n, features, x / 2, y / 2); the last feature is the log of the count."""
    torch = require_torch()
    rows, columns = (cells // 2 for cells in region.shape)
    frame, row, column = torch.nonzero(images[:, RANGE] > 0.0, as_tuple=True)
    pixel = images.permute(0, 2, 3, 1)[frame, row, column]
    held = context.permute(0, 2, 3, 1)
    block = (frame * held.shape[1] + row // 2) * held.shape[2] + column // 2
    about = torch.cat([held.reshape(-1, held.shape[3]).index_select(0, block).float(), pixel], 1)
    x, y = (pixel[:, which] * unit for which, unit in zip((ACROSS_X, ACROSS_Y), PLACE_M, strict=True))
    wide_m = 2.0 * region.cell_m
    at_x = ((x + region.length_m / 2) / wide_m).long().clamp(0, rows - 1)
    at_y = ((y + region.width_m / 2) / wide_m).long().clamp(0, columns - 1)
    cell = (frame * rows + at_x) * columns + at_y
    cells = len(images) * rows * columns
    sums = torch.zeros(cells, about.shape[1], device=about.device).index_add(0, cell, about)
    count = torch.zeros(cells, 1, device=about.device).index_add(0, cell, torch.ones_like(about[:, :1]))
    known = torch.cat([sums / count.clamp(min=1.0), torch.log1p(count) / 4.0], 1)
    return known.reshape(len(images), rows, columns, -1).permute(0, 3, 1, 2)


def _images(samples: Sequence[Sample], grid: Region | Panorama) -> Any:
    """Return samples as images, channels last in memory."""
    torch = require_torch()
    rows, columns = grid.shape
    figures = samples[0].features.shape[1]
    images = np.zeros((len(samples), rows * columns, figures), np.float32)
    for image, sample in zip(images, samples, strict=True):
        image[sample.cell] = sample.features
    return torch.from_numpy(images.reshape(len(samples), rows, columns, figures)).permute(0, 3, 1, 2)


def _mirrored(sample: Sample, mirror: int, grid: Region | Panorama) -> Sample:
    """Return the sample with x (bit 1) and y (bit 0) mirrored."""
    if not mirror:
        return sample
    features, centre_m = sample.features.copy(), sample.centre_m.copy()
    for axis, (bit, across) in enumerate(((2, ACROSS_X), (1, ACROSS_Y))):
        if mirror & bit:
            features[:, across] = -features[:, across]
            centre_m[:, axis] = np.nextafter(-centre_m[:, axis], -np.inf)
    return sample._replace(cell=grid.mirrored(sample.cell, mirror), features=features, centre_m=centre_m)


def _loss(answer: Any, parts: Sequence[Target]) -> Any:
    """Return focal loss of peaks plus absolute error of places, as in CenterNet (Zhou et al., Objects as Points,
    2019)."""
    torch = require_torch()
    peaks = torch.from_numpy(np.stack([part[0] for part in parts])).to(answer.device)
    said = torch.clamp(torch.sigmoid(answer[:, : len(CLASSES)]), 1e-4, 1.0 - 1e-4)
    centre = peaks == 1.0
    right = torch.where(centre, torch.log(said) * (1.0 - said) ** 2, 0.0)
    wrong = torch.where(centre, 0.0, torch.log(1.0 - said) * said**2 * (1.0 - peaks) ** 4)
    loss = -(right.sum() + wrong.sum()) / max(1, int(centre.sum()))
    places = torch.from_numpy(np.concatenate([part[1] for part in parts])).to(answer.device)
    if not len(places):
        return loss
    cells = [place * peaks[0, 0].numel() + part[2] for place, part in enumerate(parts)]
    where = torch.from_numpy(np.concatenate(cells)).to(answer.device)
    told = answer[:, len(CLASSES) :].permute(0, 2, 3, 1).reshape(-1, 2)[where]
    return loss + 2.0 * (told - places).abs().mean()


def _peaks(answer: Any, region: Region, first_frame: int) -> tuple[NDArray[Any], ...]:
    """Frame, class, centre and score of the highest peaks of each class in each frame."""
    torch = require_torch()
    columns = answer.shape[3]
    found = []
    for cls, (frame, cell, place, score) in enumerate(highest_peaks(answer)):
        corner = torch.stack([cell // columns, cell % columns], dim=1)
        centre = (corner + place).double().cpu().numpy() * (2.0 * region.cell_m)
        centre -= np.array([region.length_m, region.width_m]) / 2
        found.append(
            (
                frame.cpu().numpy() + first_frame,
                np.full(len(frame), cls, np.uint8),
                centre,
                score.double().cpu().numpy(),
            )
        )
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))


def highest_peaks(answer: Any) -> Iterator[tuple[Any, Any, Any, Any]]:
    """Yield of each class image (k,), cell (k,), the two figures (k, 2) and score (k,) of the highest peaks in each
    image."""
    torch = require_torch()
    scores = torch.sigmoid(answer[:, : len(CLASSES)])
    figures = answer[:, len(CLASSES) :].reshape(len(answer), 2, -1)
    for cls, apart in enumerate(_APART_CELLS):
        mine = scores[:, cls]
        highest = torch.nn.functional.max_pool2d(mine[:, None], apart, 1, apart // 2)[:, 0]
        peaks = torch.where(mine == highest, mine, 0.0).reshape(len(answer), -1)
        score, cell = peaks.topk(min(_MOST_PER_CLASS, peaks.shape[1]), dim=1)
        image, rank = torch.nonzero(score > _LEAST_SCORE, as_tuple=True)
        cell, score = cell[image, rank], score[image, rank]
        yield image, cell, figures[image, :, cell], score
