"""`riglens list rigs` and `riglens list sensors`: built-in rigs, and sensor models with every figure."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from functools import singledispatch
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table
from rich.text import Text

from riglens.app.commands.kind_choices import KindChoice
from riglens.app.commands.options import Json, Libraries, command
from riglens.app.commands.output import deliver
from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.rig.library import Cuboid, Entry, Library, default_library, use_libraries
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.rig.presets import PRESETS, preset
from riglens.core.rig.yaml.file import dumps
from riglens.core.sensing.rays import farthest_m
from riglens.core.sensors.registry import AnyKind, kind_of, kinds

WIDTH = 100
_ANGLES_A_LINE = 8
_CAVEATS = {"unverified": "not confirmed by a source at hand", "assumed": "our choice, no source states it"}
Name = Annotated[str | None, Parameter(name="NAME")]


# ---------------------------------------------------------------- riglens list rigs


@command
def rigs(name: Name = None, /, *, out: Annotated[Path | None, Parameter(metavar="RIG.yaml")] = None) -> None:
    """List the built-in rigs, or print one as rig YAML, or write it to a file.

    Parameters
    ----------
    name
        Preset; by default all are listed.
    out
        Write the preset NAME to this file.
    """
    if name is None:
        if out is not None:
            raise InputError(f"must come with the preset to write: riglens list rigs NAME --out {out}", "out")
        made = table("preset", "cameras", "LiDARs", "description", words={0, 3}, wraps={1, 2, 3})
        for one in PRESETS.values():
            rig = one.rig()
            counts = (str(len(sensors)) for sensors in (rig.enabled_cameras(), rig.enabled_lidars()))
            made.add_row(Text(one.name, "bold"), *counts, Text(one.description))
        results().print(made)
        return
    text = dumps(preset(name))
    if out is None:
        sys.stdout.write(text)
        return
    write_file(out, text)
    results(out).print(f"{out}: preset {name}", soft_wrap=True)


# ---------------------------------------------------------------- riglens list sensors


@command
def sensors(
    name: Name = None,
    /,
    *,
    kind: Annotated[KindChoice | None, Parameter(metavar="KIND")] = None,
    libraries: Libraries = (),
    json: Json = None,
) -> None:
    """List the sensor models, or show one with its beams or lens and the source of its figures.

    Parameters
    ----------
    name
        Model; by default all are listed.
    kind
        Only sensors of one kind.
    json
        Also write all figures of the listed models as JSON to a file; with - to standard output, without the table.
    """
    if name is not None and kind is not None:
        raise InputError(f"chooses what is listed; leave it out to show the model {name}", "kind")
    use_libraries(libraries)
    models = default_library()
    entries = models.entries(kind) if name is None else (models.entry(name),)

    def show() -> None:
        if name is None:
            _list(models, kind)
        else:
            _print(_lines(entries[0], models))

    deliver(models.document(entries), json, show)


def _list(library: Library, kind: str | None) -> None:
    console = _console()
    for number, shown in enumerate(found for found in kinds() if kind in (None, found.name)):
        if number:
            console.print()
        console.print(_table(library, shown))
    console.print("\n`riglens list sensors NAME` shows every figure of a model and its source.")


def _table(library: Library, kind: AnyKind) -> Table:
    """Return the models of a kind, maker by maker."""
    made = Table(
        title=_title(kind.plural), title_justify="left", title_style="bold", box=None, pad_edge=False
    )
    made.add_column("model", no_wrap=True)
    made.add_column("description")
    for heading in (kind.size[0], "field of view", "range"):
        made.add_column(heading, justify="right", no_wrap=True)
    for maker, entries in library.by_maker(kind.name).items():
        made.add_row(Text(maker, "bold"))
        for entry in entries:
            what = entry.title.removeprefix(f"{maker} ")
            marked = Text.assemble(what, (f" ({entry.caveat()})" if entry.caveat() else "", "italic"))
            made.add_row(entry.name, marked, *_figures(entry))
    return made


def _figures(entry: Entry) -> tuple[str, str, str]:
    """Beams or pixels, field of view, range."""
    sensor = entry.example
    kind = kind_of(sensor)
    wide, high = kind.view_deg(sensor)
    return kind.size[1](sensor), f"{wide:.4g}° × {high:.3g}°", _range(sensor)


def _range(sensor: Sensor) -> str:
    low, high = sensor.range_m[0], farthest_m(sensor)
    return f"{low:g}–{high:g} m" if math.isfinite(high) else "—"


def _lines(entry: Entry, library: Library) -> Iterator[tuple[str, str]]:
    """Yield captions and values of every field of an entry."""
    sensor = entry.example
    yield "model", f"{entry.name} ({_title(kind_of(sensor).title)})"
    yield "title", entry.title
    yield "maker", entry.maker
    yield "source", entry.source
    if entry.note:
        yield "note", entry.note
    for part in filter(None, entry.caveat().split("; ")):
        word, _, figures = part.partition(": ")
        yield word, f"{figures}: {_CAVEATS[word]}"
    yield "file", library.origins[entry.name]
    if entry.body_m is not None:
        yield "body", _body(entry)
    yield from _own_lines(sensor, entry)
    yield "range", _range(sensor)
    for share, metres in entry.range_anchors():
        how = (
            "" if entry.range_probability is None else f", detected with {100 * entry.range_probability:g} %"
        )
        yield "", f"{metres:g} m at {100 * share:g} % reflectivity{how}"


def _body(entry: Entry) -> str:
    body = entry.body_m
    if isinstance(body, Cuboid):
        return f"{body.length * 1e3:g} × {body.width * 1e3:g} × {body.height * 1e3:g} mm"
    assert body is not None
    return f"{body.diameter * 1e3:g} mm across, {body.height * 1e3:g} mm high"


@singledispatch
def _own_lines(sensor: Sensor, _: Entry) -> Iterator[tuple[str, str]]:
    """Captions and values of what only sensors of this kind have."""
    return iter(kind_of(sensor).summary(sensor))


def _title(words: str) -> str:
    return words[:1].upper() + words[1:]


@_own_lines.register
def _lidar_lines(lidar: Lidar, entry: Entry) -> Iterator[tuple[str, str]]:
    if lidar.rays is not None:
        yield from kind_of(lidar).summary(lidar)
        return
    azimuths = lidar.azimuths()
    wide, high = kind_of(lidar).view_deg(lidar)
    yield "field of view", f"{wide:.4g}° × {high:.4g}°"
    yield "azimuths", f"{azimuths.size} from {azimuths[0]:g}° in steps of {wide / azimuths.size:.4g}°"
    for rate, step in (entry.azimuth_step_deg or {}).items():
        yield "", f"{rate} turns a second: steps of {step:g}°"
    yield "beams", f"{lidar.beam_count}, elevations in degrees"
    yield from (("", line) for line in _columns([f"{angle:.4g}" for angle in lidar.elevations()]))
    if lidar.azimuth_offsets_deg is not None:
        yield "offsets", "azimuth offsets of these beams in degrees, positive turns left"
        yield from (("", line) for line in _columns([f"{angle:.4g}" for angle in lidar.azimuth_offsets_deg]))


def _columns(words: Sequence[str]) -> Iterator[str]:
    for start in range(0, len(words), _ANGLES_A_LINE):
        yield "".join(f"{word:>9}" for word in words[start : start + _ANGLES_A_LINE])


@_own_lines.register
def _camera_lines(camera: Camera, entry: Entry) -> Iterator[tuple[str, str]]:
    wide, high = kind_of(camera).view_deg(camera)
    fx, fy, cx, cy = camera.intrinsics_px()
    yield "image", f"{camera.image[0]} × {camera.image[1]} pixels"
    yield "field of view", f"{wide:.4g}° × {high:.4g}°"
    yield "focal lengths", f"{fx:.6g} × {fy:.6g} pixels, principal point {cx:.6g}, {cy:.6g}"
    if camera.distortion is not None:
        lens = camera.distortion.model_dump()
        yield (
            "distortion",
            f"{lens.pop('model')}: " + ", ".join(f"{key} {value:g}" for key, value in lens.items()),
        )
    if entry.pixel_um is not None:
        yield "pixel", f"{entry.pixel_um:g} µm"
    if entry.lens is not None:
        yield "lens", entry.lens


def _print(lines: Iterator[tuple[str, str]]) -> None:
    made = Table(show_header=False, box=None, pad_edge=False)
    made.add_column(style="bold", no_wrap=True)
    made.add_column()
    for caption, value in lines:
        made.add_row(caption, value)
    _console().print(made)


def _console() -> Console:
    console = results()
    console.width = min(console.width, WIDTH)
    return console
