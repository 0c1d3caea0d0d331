"""Studies of the paper, of the metric and of the methods, as `riglens study` does them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from riglens.app.evaluation.names import option_of
from riglens.arguments import StrPath, warn
from riglens.core.errors import InputError
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.results import Listing
from riglens.rigs import save_rig

Study = Literal["table1", "accuracy", "stability", "targets", "external", "detection", "predicted"]
_SWITCHES = {"find_ground": "auto", "surroundings": "block"}
"""Options that are true or false here, and a word on the command line."""
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
    from riglens.app.commands.parsing import run
    from riglens.app.studies import (
        accuracy,
        detection,
        external,
        predicted,
        sensor_methods,
        stability,
        targets,
    )
    from riglens.app.studies.files import require_folder
    from riglens.app.terminal.console import called_from_python

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
        words = [_word(one, Path(rigs, f"{number}.yaml")) for number, one in enumerate(inputs)]
        for option, value in options.items():
            words += _words(option, value, Path(rigs, f"{option}.yaml"))
        if name == "table1":
            require_folder(folder, _TABLE1)
            places = ["--csv", str(folder / _TABLE1[0]), "--detection-csv", str(folder / _TABLE1[1])]
        else:
            places = ["--out", str(folder)]
        run(["study", name, *words, *places])
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


def _word(value: object, file: Path) -> str:
    """Return the word for a value; a rig is written into a file."""
    if isinstance(value, Rig):
        save_rig(value, file)
        return str(file)
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _words(option: str, value: object, file: Path) -> Iterator[str]:
    """Yield an option and its values; names are repeated with the option, numbers and pairs follow it."""
    if value is None or value is False:
        return
    if value is True:
        yield from (option_of(option), *filter(None, [_SWITCHES.get(option)]))
        return
    if isinstance(value, Mapping):
        value = [f"{name}={cls}" for name, cls in value.items()]
    several = (
        np.asarray(value, object).ravel().tolist()
        if isinstance(value, (list, tuple, np.ndarray))
        else [value]
    )
    is_repeated = isinstance(several[0], (str, os.PathLike)) and option != "occluders"
    for number, one in enumerate(several):
        yield from (*([option_of(option)] if is_repeated or number == 0 else ()), _word(one, file))


def _table(path: Path) -> list[dict[str, Any]]:
    from pyarrow.csv import read_csv

    rows: list[dict[str, Any]] = read_csv(path).to_pylist()
    return rows
