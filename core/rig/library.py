"""The library of sensor models: published beam angles and camera lenses that a rig names by `model:`.

It holds the models that ship with the program and a user's own: those of `library.yaml` in the user's
configuration folder, and those of the files that RIGLENS_LIBRARY names (the option --library sets it). A name
means one model: an own entry never takes the name of another.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from platformdirs import user_config_path

from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library_file import Entry as Entry
from riglens.core.rig.library_file import library_path, read_entries
from riglens.core.rig.library_store import stored_entries
from riglens.core.rig.model import Sensor
from riglens.core.rig.text_file import shown_path
from riglens.core.rig.yaml_nodes import shortened

LENS_MATRIX = ("fx", "fy", "cx", "cy")
LIBRARY_VARIABLE = "RIGLENS_LIBRARY"
BUNDLED = "bundled"


class Library:
    """The sensor models by name, in the order of the files; `origins` says for each name which file it is from."""

    def __init__(self, entries: Iterable[Entry], origins: dict[str, str] | None = None) -> None:
        self._entries = {entry.name: entry for entry in entries}
        self.origins = origins or dict.fromkeys(self._entries, BUNDLED)

    def entries(self, kind: Literal["lidar", "camera"] | None = None) -> tuple[Entry, ...]:
        """All entries, or those of one kind."""
        return tuple(entry for entry in self._entries.values() if kind in (None, entry.kind))

    def by_maker(self, kind: Literal["lidar", "camera"]) -> dict[str, tuple[Entry, ...]]:
        """The entries of a kind, maker by maker, both in the order of the files."""
        makers = dict.fromkeys(entry.maker for entry in self.entries(kind))
        return {maker: tuple(e for e in self.entries(kind) if e.maker == maker) for maker in makers}

    def entry(self, model: str) -> Entry:
        """The entry of that name; InputError with the nearest names when there is none."""
        if model in self._entries:
            return self._entries[model]
        close = [name for name in self._entries if model.lower() in name]
        close = close or difflib.get_close_matches(model.lower(), self._entries, n=1)
        hint = f"did you mean {' or '.join(repr(name) for name in close[:3])}? " if close else ""
        raise InputError(
            f"model: unknown sensor model '{shortened(model)}'; {hint}`riglens library` lists all {len(self._entries)}"
        )


def default_library() -> Library:
    """The bundled models and the user's own; InputError when a file of the user's is wrong."""
    return _library(user_library_files())


def user_library_files() -> tuple[Path, ...]:
    """The user's own library files: that of the configuration folder if there is one, then those of RIGLENS_LIBRARY."""
    own = _own_library(os.environ.get("XDG_CONFIG_HOME"))
    named = os.environ.get(LIBRARY_VARIABLE, "")
    files = [*([own] if own.is_file() else []), *(Path(part) for part in named.split(os.pathsep) if part)]
    return tuple(dict.fromkeys(files))


def supplied_fields(sensor: dict[str, Any]) -> dict[str, Any]:
    """Fields that the library gives to a sensor with these fields.

    A lens is said in one way: a field of view leaves out the model's focal lengths and distortion. Azimuth offsets
    belong to beams: with another number of beams they are left out.
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
    offsets, beams = fields.get("azimuth_offsets_deg"), sensor.get("elevations_deg")
    if offsets is not None and beams is not None and _beam_count(beams) != len(offsets):
        del fields["azimuth_offsets_deg"]
    return fields


def _beam_count(beams: Any) -> Any:
    """Number of beams that a field says, if it says one."""
    if isinstance(beams, dict):
        return beams.get("count")
    return len(beams) if isinstance(beams, tuple) else None


def use_libraries(files: Iterable[Path]) -> None:
    """Add library files for this process and those it starts; they stand in RIGLENS_LIBRARY from then on."""
    named = [str(path.absolute()) for path in files]
    if named:
        before = os.environ.get(LIBRARY_VARIABLE, "")
        os.environ[LIBRARY_VARIABLE] = os.pathsep.join([*([before] if before else []), *named])


def load_library(path: Path) -> Library:
    """Read and check one library file; InputError with file, line and model when an entry is wrong."""
    return Library(read_entries(path, path.name))


def sensor_from_model(model: str, name: str, pose: Pose) -> Sensor:
    """A sensor called `name` of a library model at that pose; InputError for an unknown model."""
    return default_library().entry(model).sensor(name, pose)


@lru_cache(maxsize=8)
def _own_library(_config_home: str | None) -> Path:
    """Where the configuration folder's library would be; asked for every sensor, so looked up once."""
    return library_path(user_config_path("riglens", appauthor=False))


@lru_cache(maxsize=8)
def _library(files: tuple[Path, ...]) -> Library:
    """The bundled library and these files; each is read once."""
    entries = list(stored_entries(asset_path("library.yaml")))
    origins = {entry.name: BUNDLED for entry in entries}
    for path in files:
        where = shown_path(path)
        for entry in read_entries(path, where):
            if entry.name in origins:
                raise InputError(
                    f"{where}: {entry.name}: this name belongs to a model of the library ({origins[entry.name]}); "
                    f"accepted is a name of its own, such as my-{entry.name}"
                )
            entries.append(entry)
            origins[entry.name] = where
    return Library(entries, origins)
