"""Studies of the paper, of the metric and of the methods, as `riglens study` does them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import fields
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import TypeAdapter, ValidationError

from riglens.arguments import StrPath, warn
from riglens.core.errors import InputError
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.results import Listing
from riglens.rigs import save_rig

Study = Literal["table1", "accuracy", "stability", "targets", "external", "detection", "predicted"]
_RENAMED = {"libraries": "library"}
"""Arguments of the commands that are called otherwise here."""
_TABLE1 = ("table1.csv", "table1-detection.csv")


def study(name: Study, *inputs: StrPath | Rig, out: StrPath = "out", **options: object) -> Listing:
    """Run a study, write its tables and charts into the folder `out`, and return its main table.

    Parameters
    ----------
    name
        "table1", "accuracy", "stability", "targets", "external", "detection" or "predicted".
    inputs
        Rigs or files, as for `riglens study NAME`; a rig whose car is a mesh file by the path of its rig file.
    out
        Folder of the files; an interrupted study of detection resumes there.
    options
        Options of `riglens study NAME`, with units in their names: `quick=True`, `voxel_m=0.5`, `boxes="boxes.csv"`.

    Returns
    -------
    Listing
        `rows()` of the first table; `to_dict()` is the JSON that the study writes, or else every table by its file.
    """
    from riglens.app.commands import study as commands
    from riglens.app.terminal.console import called_from_python
    from riglens.studies import (
        accuracy,
        detection,
        external,
        predicted,
        sensor_methods,
        stability,
        targets,
    )
    from riglens.studies.files import require_folder

    if name not in get_args(Study):
        raise InputError(f"must be one of {', '.join(get_args(Study))} (got '{name}')", "name")
    folder = Path(out)
    files = {
        "table1": _TABLE1,
        "accuracy": sensor_methods.FILES if options.get("sensor") else accuracy.FILES,
        "stability": stability.FILES,
        "targets": targets.NAMES,
        "external": (external.NAME,),
        "detection": detection.NAMES,
        "predicted": predicted.NAMES,
    }
    with called_from_python(warn), tempfile.TemporaryDirectory(prefix="riglens-") as rigs:
        words = [_plain(one, Path(rigs, f"{number}.yaml")) for number, one in enumerate(inputs)]
        given = {key: _plain(value, Path(rigs, f"{key}.yaml")) for key, value in options.items()}
        if name == "table1":
            require_folder(folder, _TABLE1)
            places = {"csv": folder / _TABLE1[0], "detection_csv": folder / _TABLE1[1]}
        else:
            places = {"out": folder}
        _call(name, getattr(commands, name), words, {**given, **places})
    paths = [path for file in files[name] if (path := folder / file).exists()]
    tables = {path.name: _table(path) for path in paths if path.suffix == ".csv"}
    document = next(
        (json.loads(path.read_text()) for path in paths if path.suffix == ".json"),
        {"riglens": FORMAT_VERSION, "study": name, "tables": tables},
    )
    return Listing(
        f"Study {name}: {', '.join(path.name for path in paths)} in {folder}",
        document,
        next(iter(tables.values())),
    )


def _plain(value: object, file: Path) -> object:
    """Return a value as the options have it: a rig as the path of a file, arrays and mappings as lists."""
    if isinstance(value, Rig):
        save_rig(value, file)
        return str(file)
    if isinstance(value, Mapping):
        return [f"{name}={cls}" for name, cls in value.items()]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def _call(name: str, command: Callable[..., None], words: list[object], given: dict[str, object]) -> None:
    """Call the function of a study's command with its inputs, and its options as the objects that it has them in."""
    hints, keywords = get_type_hints(command, include_extras=True), {}
    inputs: list[object] = []
    for key, parameter in signature(command).parameters.items():
        known = _RENAMED.get(key, key)
        if isinstance(parameter.default, SceneOptions | ScoreOptions):
            of = {one.name: one.type for one in fields(hints[key]) if given.get(one.name) is not None}
            keywords[key] = hints[key](**{one: _checked(one, given[one], kind) for one, kind in of.items()})
            given = {one: value for one, value in given.items() if one not in of}
        elif parameter.kind is not Parameter.KEYWORD_ONLY:
            inputs += [_checked(key, word, hints[key]) for word in words[len(inputs) :]]
        elif given.get(known) is not None:
            keywords[key] = _checked(known, given.pop(known), hints[key])
    for key, value in given.items():
        if value is not None:
            raise InputError(f"is not an option of the study {name}", key)
    try:
        signature(command).bind(*(inputs or words), **keywords)
    except TypeError as error:
        raise InputError(f"study {name}: {error}") from error
    command(*inputs, **keywords)


def _checked(name: str, value: object, kind: Any) -> Any:
    """Return a value of the type of an option; raise InputError for another one."""
    kind = get_args(kind)[0] if get_origin(kind) is Annotated else kind
    if get_origin(kind) is tuple and isinstance(value, str):
        value = [value]
    try:
        return TypeAdapter(kind).validate_python(value)
    except ValidationError as error:
        wanted = error.errors()[0]["msg"].replace("Input should be", "must be")
        raise InputError(f"{wanted} (got {value!r})", name) from error


def _table(path: Path) -> list[dict[str, Any]]:
    from pyarrow.csv import read_csv

    rows: list[dict[str, Any]] = read_csv(path).to_pylist()
    return rows
