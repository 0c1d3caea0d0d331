"""Studies of the paper, of the metric and of the methods, as `riglens study` does them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import TypeAdapter, ValidationError

from riglens.arguments import StrPath, Warnings
from riglens.core.errors import InputError
from riglens.core.files import read_csv
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.results import Listing
from riglens.rigs import save_rig

Study = Literal["table1", "accuracy", "stability", "targets", "external", "detection", "predicted"]
T = TypeVar("T")


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
    from riglens.studies.files import require_folder
    from riglens.studies.running import STUDIES, TABLE1_FILES, Job, files_of

    if name not in get_args(Study):
        raise InputError(f"must be one of {', '.join(get_args(Study))} (got '{name}')", "name")
    folder = Path(out)
    with tempfile.TemporaryDirectory(prefix="riglens-") as rigs:
        words = [_plain(one, Path(rigs, f"{number}.yaml")) for number, one in enumerate(inputs)]
        given = {key: _plain(value, Path(rigs, f"{key}.yaml")) for key, value in options.items()}
        if name == "table1":
            require_folder(folder, TABLE1_FILES)
            given |= dict(
                zip(("csv", "detection_csv", "sheet"), (folder / file for file in TABLE1_FILES), strict=True)
            )
        asked = STUDIES[name]
        own: Any = _taken(asked.options, [one.name for one in fields(asked.options)], given)
        job = Job(
            _taken(SceneOptions, asked.scene, given),
            _taken(ScoreOptions, asked.score, given),
            folder,
            Warnings(),
        )
        for key, value in given.items():
            if value is not None:
                raise InputError(f"is not an option of the study {name}", key)
        asked.run(own, job, *_inputs(name, asked.run, words))
    paths = [path for file in files_of(name, own) if (path := folder / file).exists()]
    tables = {path.name: _table(path) for path in paths if path.suffix == ".csv"}
    document = next(
        (json.loads(path.read_text(encoding="utf-8")) for path in paths if path.suffix == ".json"),
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


def _taken(options: type[T], names: Sequence[str], given: dict[str, object]) -> T:
    """Return options of a class with those that are given; they are taken from `given`."""
    hints = get_type_hints(options, localns={"Rig": object}, include_extras=True)
    known = {one: given.pop(one) for one in names if given.get(one) is not None}
    return options(**{one: _checked(one, value, hints[one]) for one, value in known.items()})


def _inputs(name: str, run: Callable[..., Any], words: list[object]) -> list[object]:
    """Return what a study is given by place, in the types of its parameters."""
    try:
        bound = signature(run).bind(None, None, *words)
    except TypeError as error:
        raise InputError(f"study {name}: {error}") from error
    hints, found = get_type_hints(run), list[object]()
    for key, value in [*bound.arguments.items()][2:]:
        several = signature(run).parameters[key].kind is Parameter.VAR_POSITIONAL
        found += [_checked(key, word, hints[key]) for word in (value if several else [value])]
    return found


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
    rows: list[dict[str, Any]] = read_csv(path).to_pylist()
    return rows
