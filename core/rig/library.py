"""The library of sensor models: published beam angles and camera lenses that a rig names by `model:`.

It holds the models that ship with the program and a user's own: those of `library.yaml` in the user's
configuration folder, and those of the files that RIGLENS_LIBRARY names. A name means one model: a user's own entry
never takes the name of another.
"""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Collection, Iterable
from functools import cached_property, lru_cache
from itertools import chain, pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pydantic
from pydantic import BaseModel, Field, ValidationError
from ruamel.yaml.nodes import Node

from riglens.assets import asset_path
from riglens.core.cache_folder import digest_of_files, stored
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.plain import Frozen, to_plain
from riglens.core.rig.model import FORMAT_VERSION, Length, LinearAngles, Positive, Sensor
from riglens.core.rig.yaml.nodes import (
    Plain,
    line_of,
    parse_yaml,
    plain_value,
    read_text,
    shortened,
    shown_path,
)
from riglens.core.rig.yaml.problems import problem_text, problems
from riglens.core.sensors.registry import KindName, kind_of, kinds
from riglens.core.user_folders import config_folder

MAX_ENTRIES = 500
OTHER_MAKER = "Other"
Text = Annotated[str, Field(min_length=3, max_length=100)]
LongText = Annotated[str, Field(min_length=10, max_length=2_000)]
Rate = Annotated[str, Field(pattern=r"^[0-9]{1,3}(\.[0-9]{1,3})?$")]
Share = Annotated[str, Field(pattern=r"^(0\.[0-9]{1,3}|1(\.0)?)$")]
MAX_ANCHORS = 8


class Cylinder(Frozen):
    """The body of a spinning sensor in metres, its axis upright."""

    diameter: Length
    height: Length


class Cuboid(Frozen):
    """The body of a sensor in metres: along its view, across, upright."""

    length: Length
    width: Length
    height: Length


class Entry(Frozen):
    """Sensor model: its description, the source of its figures and the sensor fields it supplies.

    `azimuth_step_deg`: revolutions per second to degrees between neighbouring azimuths; `pixel_um`: edge of a pixel;
    `range_at`: reflectivity of a diffuse target to the metres at which the maker still states a return, with the
    probability `range_probability` (one half unless stated);
    `unverified`: figures of this entry that no source at hand bears out; `assumed`: those that are our choice.
    `other_names`: usual ones in rigs of other programs, letters and digits alone and without the maker.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9.+-]*$", max_length=60)]
    kind: KindName
    title: Text
    source: LongText
    maker: Text = OTHER_MAKER
    other_names: tuple[Annotated[str, Field(pattern=r"^[a-z0-9]{2,40}$")], ...] = ()
    note: LongText | None = None
    body_m: Cylinder | Cuboid | None = None
    azimuth_step_deg: dict[Rate, Positive] | None = None
    range_at: dict[Share, Positive] | None = None
    range_probability: Annotated[float, Field(ge=0.5, le=0.99)] | None = None
    unverified: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    pixel_um: Positive | None = None
    lens: Text | None = None
    fields: dict[str, Any]

    @cached_property
    def example(self) -> Sensor:
        """A sensor of this model at the origin, under the model's name."""
        return self.sensor(self.name, Pose())

    def sensor(self, name: str, pose: Pose) -> Sensor:
        """Return a sensor of this model; raise pydantic's ValidationError when the entry's fields are wrong."""
        placed: dict[str, Any] = {"position": pose.position_m, "rpy_deg": pose.rpy_deg, "model": self.name}
        sensor: Sensor = kind_of(self.kind).model(name=name, **placed, **self.fields)
        return sensor

    def range_anchors(self) -> tuple[tuple[float, float], ...]:
        """Return `range_at` as pairs of reflectivity (0 to 1) and metres, both rising; empty when none is stated."""
        return tuple(sorted((float(share), metres) for share, metres in (self.range_at or {}).items()))

    def caveat(self) -> str:
        """Return "unverified: beams; assumed: range", or nothing when every figure has its source.

        A LiDAR without `range_at` is assumed to reach its maximum range at the reflectivity of the range law.
        """
        assumed = self.assumed
        if kind_of(self.kind).has_range_law and not self.range_at:
            assumed = (*assumed, "range_at")
        lists = {"unverified": self.unverified, "assumed": assumed}
        told = {word: _figure_names(figures, {*self.unverified, *assumed}) for word, figures in lists.items()}
        return "; ".join(f"{word}: {', '.join(names)}" for word, names in told.items() if names)

    def origin(self) -> str:
        """Return where the figures come from, and on a line of its own which of them are unverified or assumed."""
        return "\n".join(part for part in (self.source, self.caveat()) if part)


FIGURES = {
    "range_m": "range",
    "range_at": "range by reflectivity",
    "range_probability": "probability of its ranges",
    "elevations_deg": "beams",
    "azimuths_deg": "azimuths",
    "azimuth_offsets_deg": "azimuth offsets",
    "azimuth_step_deg": "azimuths",
    "rays": "scan pattern",
    "body_m": "size",
    "hfov_deg": "field of view",
    "image": "image size",
    "reference_dbsm": "reference cross section",
    "azimuth_deg": "azimuth",
    "elevation_deg": "elevation",
    "pole_range_m": "range",
    "wall_range_m": "range",
}
"""Names of an entry's figures in sentences."""


def _figure_names(figures: Iterable[str], marked: Collection[str]) -> tuple[str, ...]:
    """Return the names for a sentence, each once; without the range by reflectivity where the range is named."""
    told = (figure for figure in figures if figure != "range_at" or "range_m" not in marked)
    return tuple(dict.fromkeys(FIGURES.get(figure, figure) for figure in told))


_ABOUT = tuple(name for name in Entry.model_fields if name not in ("name", "fields"))
_WORDS = ("kind", "title", "source", "maker", "other_names", "note", "unverified", "assumed")
_ANGLES = ("elevations_deg", "azimuths_deg", "azimuth_offsets_deg")
_OWN = ("name", "model", "position", "rpy_deg", "enabled", "mirror_of", "fails_with", "blocked")
"""Fields of a sensor on a car that a model never has."""


def read_entries(path: str | os.PathLike[str], where: str) -> tuple[Entry, ...]:
    """Return the entries of a library file; `where` names it in messages.

    Raise InputError `where:line: model: field: ...` for the first thing that is wrong.
    """
    root = parse_yaml(read_text(path, "a sensor library in YAML"), where)
    data = plain_value(root)
    if not isinstance(data, dict):
        raise InputError(f"{where}:1: a sensor library must be a mapping of model names to sensor fields")
    if len(data) > MAX_ENTRIES:
        raise InputError(f"{where}: must have at most {MAX_ENTRIES} models (got {len(data)})")
    return tuple(_entry(name, data[name], root, where) for name in data)


def _entry(name: str, values: Any, root: Node, where: str) -> Entry:
    place = f"{where}:{line_of(root, (name,))}: {shortened(name)}"
    if not isinstance(values, dict):
        raise InputError(f"{place}: must be a mapping of the fields of a sensor model")
    for key in _OWN:
        if key in values:
            raise InputError(f"{place}: {key}: not a field of a model; it belongs in the rig")
    for key in _ANGLES:
        if isinstance(values.get(key), str):
            values[key] = _numbers(values[key], f"{place}: {key}")
    about = {key: values[key] for key in _ABOUT if key in values}
    fields = {key: value for key, value in values.items() if key not in _ABOUT}
    try:
        entry = Entry(name=name, fields=fields, **about)
        sensor = entry.sensor(name, Pose())
    except ValidationError as error:
        data = {"name": name, **values}
        problem = problems(error, data)[0]
        line = line_of(root, (name, *problem.path))
        raise InputError(f"{where}:{line}: {shortened(name)}: {problem_text(problem, data)}") from error
    _check_about(entry, place)
    return entry.model_copy(update={"fields": _complete(fields, sensor)})


def _numbers(text: str, place: str) -> tuple[float, ...]:
    """Return numbers separated by blanks, commas or line ends, the form of long lists of angles."""
    numbers: list[float] = []
    for word in text.replace(",", " ").split():
        try:
            numbers.append(float(word))
        except ValueError:
            raise InputError(f"{place}: must be angles in degrees (got '{shortened(word)}')") from None
    return tuple(numbers)


def _check_about(entry: Entry, place: str) -> None:
    figures = {kind.name: kind.library_figures for kind in kinds()}
    for key in dict.fromkeys(chain.from_iterable(figures.values())):
        if key not in figures[entry.kind] and getattr(entry, key) is not None:
            raise InputError(f"{place}: {key}: not a figure of a {entry.kind}")
    anchors = entry.range_anchors()
    if len(anchors) > MAX_ANCHORS or any(
        near[1] > far[1] or near[0] == far[0] for near, far in pairwise(anchors)
    ):
        raise InputError(
            f"{place}: range_at must be at most {MAX_ANCHORS} ranges that rise with reflectivity"
        )
    if entry.range_probability is not None and not anchors:
        raise InputError(f"{place}: range_probability is that of range_at, which is missing")
    stated = {*entry.fields, *(key for key in _ABOUT if getattr(entry, key) is not None)}
    for key in ("unverified", "assumed"):
        for figure in getattr(entry, key):
            if figure not in stated or figure in _WORDS:
                raise InputError(
                    f"{place}: {key} must be figures that the entry states (got '{shortened(figure)}')"
                )


def _complete(fields: dict[str, Any], sensor: Sensor) -> dict[str, Any]:
    """Return the fields with every part of a lens or a scan filled in, so that they compare equal to a sensor's."""
    found = dict(fields)
    for name in fields:
        part = getattr(sensor, name)
        if isinstance(part, BaseModel) and not isinstance(part, LinearAngles):
            found[name] = part.model_dump()
        elif isinstance(part, tuple) and isinstance(part[0], BaseModel):
            found[name] = tuple(each.model_dump() for each in part)
    return found


NAME = "library.json"


def stored_entries(path: Path) -> tuple[Entry, ...]:
    """Return `read_entries` of a library file, from the cache if the same code has read the same text before."""
    folder = Path(__file__).parent
    places = (folder, folder / "yaml", folder.parent / "sensors")
    sources = sorted(module for place in places for module in place.glob("*.py"))
    maker = f"{pydantic.VERSION} {digest_of_files((path, *sources))}"
    content = stored(NAME, maker, lambda: _packed(read_entries(path, path.name)))
    return tuple(Entry(**_frozen(found)) for found in json.loads(content))


def _packed(entries: Iterable[Entry]) -> bytes:
    return json.dumps([entry.model_dump(mode="json") for entry in entries]).encode()


def _frozen(value: Any) -> Any:
    """Return JSON as it was before: lists of the library are tuples."""
    if isinstance(value, dict):
        return {key: _frozen(part) for key, part in value.items()}
    return tuple(_frozen(part) for part in value) if isinstance(value, list) else value


LENS_MATRIX = ("fx", "fy", "cx", "cy")
LIBRARY_VARIABLE = "RIGLENS_LIBRARY"
BUNDLED = "bundled"


class Library:
    """The sensor models by name, in the order of the files; `origins` gives the file of each name."""

    def __init__(self, entries: Iterable[Entry], origins: dict[str, str] | None = None) -> None:
        self._entries = {entry.name: entry for entry in entries}
        self.origins = origins or dict.fromkeys(self._entries, BUNDLED)

    def entries(self, kind: str | None = None) -> tuple[Entry, ...]:
        """Return all entries, or those of one kind."""
        return tuple(entry for entry in self._entries.values() if kind in (None, entry.kind))

    def by_maker(self, kind: str) -> dict[str, tuple[Entry, ...]]:
        """Return the entries of a kind, maker by maker, both in the order of the files."""
        makers = dict.fromkeys(entry.maker for entry in self.entries(kind))
        return {maker: tuple(e for e in self.entries(kind) if e.maker == maker) for maker in makers}

    def entry(self, model: str) -> Entry:
        """Return the entry of that name; raise InputError with the nearest names when there is none."""
        if model in self._entries:
            return self._entries[model]
        close = [name for name in self._entries if model.lower() in name]
        close = close or difflib.get_close_matches(model.lower(), self._entries, n=1)
        hint = f"did you mean {' or '.join(repr(name) for name in close[:3])}? " if close else ""
        raise InputError(
            f"model: unknown sensor model '{shortened(model)}'; {hint}the library has {len(self._entries)}"
        )

    def document(self, entries: Iterable[Entry]) -> dict[str, Any]:
        """Return entries as plain data, each under the names of its file."""
        return {"riglens": FORMAT_VERSION, "models": [self._plain(entry) for entry in entries]}

    def _plain(self, entry: Entry) -> dict[str, Any]:
        about = entry.model_dump(exclude={"fields", "other_names"}, exclude_none=True)
        sensor = entry.example
        figures: dict[str, Any] = to_plain({key: getattr(sensor, key) for key in entry.fields})
        return about | figures | {"file": self.origins[entry.name]}


def default_library() -> Library:
    """Return the bundled models and the user's own; raise InputError when one of the user's files is wrong."""
    return _library(user_library_files())


def body_of(model: str | None) -> Cylinder | Cuboid | None:
    """Return the size of a model's housing, None if unknown."""
    try:
        return None if model is None else default_library().entry(model).body_m
    except InputError:
        return None


def user_library_files() -> tuple[Path, ...]:
    """Return the user's library files: that of the configuration folder, if any, then those of RIGLENS_LIBRARY."""
    own = config_folder() / "library.yaml"
    named = os.environ.get(LIBRARY_VARIABLE, "")
    files = [*([own] if own.is_file() else []), *(Path(part) for part in named.split(os.pathsep) if part)]
    return tuple(dict.fromkeys(files))


def supplied_fields(sensor: dict[str, Plain]) -> dict[str, Plain]:
    """Return the fields that the library gives to a sensor with these fields.

    A lens is given in one way: a field of view replaces the model's focal lengths and distortion. Azimuth offsets
    belong to beams: with another number of beams they are left out. Beams replace the model's scan pattern, and a scan
    pattern its beams.
    """
    model = sensor.get("model")
    if not isinstance(model, str):
        return {}
    fields = dict(default_library().entry(model).fields)
    if any(sensor.get(key) is not None for key in LENS_MATRIX):
        fields.pop("hfov_deg", None)
    if sensor.get("hfov_deg") is not None:
        for key in (*LENS_MATRIX, "distortion"):
            fields.pop(key, None)
    if sensor.get("rays") is not None:
        for key in _ANGLES:
            fields.pop(key, None)
    elif any(sensor.get(key) is not None for key in _ANGLES):
        fields.pop("rays", None)
    offsets, beams = fields.get("azimuth_offsets_deg"), sensor.get("elevations_deg")
    if offsets is not None and beams is not None and _beam_count(beams) != len(offsets):
        del fields["azimuth_offsets_deg"]
    return fields


def _beam_count(beams: Plain) -> Plain:
    """Return the number of beams that a field defines, if it does."""
    if isinstance(beams, dict):
        return beams.get("count")
    return len(beams) if isinstance(beams, tuple) else None


def use_libraries(files: Iterable[Path]) -> None:
    """Add library files for this process and those it starts, through the variable RIGLENS_LIBRARY."""
    named = [str(path.absolute()) for path in files]
    if named:
        before = os.environ.get(LIBRARY_VARIABLE, "")
        os.environ[LIBRARY_VARIABLE] = os.pathsep.join([*([before] if before else []), *named])


def sensor_from_model(model: str, name: str, pose: Pose) -> Sensor:
    """Return a sensor called `name` of a library model at that pose; raise InputError for an unknown model."""
    return default_library().entry(model).sensor(name, pose)


def changed_fields(sensor: Sensor) -> tuple[str, ...]:
    """Return the fields in which a sensor differs from the library model that it names.

    Empty for a sensor as the library has it, for one without a model, and for a model that the library does not know.
    """
    try:
        model = None if sensor.model is None else default_library().entry(sensor.model).example
    except InputError:
        return ()
    if model is None or model.kind != sensor.kind:
        return ()
    names = (name for name in type(sensor).model_fields if name not in _OWN)
    return tuple(name for name in names if not _same_field(name, sensor, model))


def _same_field(name: str, one: Sensor, other: Sensor) -> bool:
    """Return whether a field is equal in two sensors of a kind; angles may be listed or evenly spaced."""
    if getattr(one, name) == getattr(other, name):
        return True
    spelled_out = kind_of(one).spelled_out.get(name)
    return spelled_out is not None and np.array_equal(spelled_out(one), spelled_out(other))


@lru_cache(maxsize=8)
def _library(files: tuple[Path, ...]) -> Library:
    """Return the bundled library and these files; each is read once."""
    entries = list(stored_entries(asset_path("library.yaml")))
    origins = {entry.name: BUNDLED for entry in entries}
    for path in files:
        where = shown_path(path)
        for entry in read_entries(path, where):
            if entry.name in origins:
                raise InputError(
                    f"{where}: {entry.name}: name already used in the library ({origins[entry.name]}): "
                    f"choose another, such as my-{entry.name}"
                )
            entries.append(entry)
            origins[entry.name] = where
    return Library(entries, origins)
