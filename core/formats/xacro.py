"""Expand xacro with ROS's package `xacro`, in a process of its own (`xacro_process`).

Files are included, and YAML is loaded, from the folder of the rig's file and below it, or from its ROS package, and
only from there: of `$(find package)/urdf/wheel.xacro` the end that lies there; or else from the ROS package of that
name beside its own, as in a workspace. The environment is not read: of $(optenv NAME DEFAULT) the default is taken.
Source: ROS wiki "xacro".
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source
from riglens.core.formats.xml_tree import Attributes, Element
from riglens.core.limited_process import answer_of
from riglens.core.rig.yaml.nodes import shortened, shown_path

TIME_LIMIT_S = 10.0
MOST_BESIDE = 200
"""Folders beside that of the package in which others are looked for."""
MAX_PARENTS = 4
"""Number of folders searched for the description of the package, starting with that of the rig's file."""


def is_xacro(root: Element) -> bool:
    """Return whether a document has macros or expressions in it."""
    return any(
        element.tag.startswith("xacro:")
        or any("${" in value or "$(" in value for value in element.attributes.values())
        for element in root.walk()
    )


def expanded(source: Source, notes: Notes) -> Element:
    """Return the document without macros and expressions; raise InputError for unsupported ones."""
    folder = source.path.parent.resolve()
    file = str(folder / source.path.name)
    package = _package(folder)
    answer = answer_of(
        "riglens.core.formats.xacro_process", file, str(folder), str(package), *_workspace(package),
        where=source.where, time_limit_s=TIME_LIMIT_S, still_wanted=source.time.check, given=source.text.encode(),
    )  # fmt: skip
    result = json.loads(answer)

    def where(place: str) -> str:
        return source.where if place == file else shown_path(place)

    if "error" in result:
        place, line, tag, said = result["error"]
        said = shortened(said, 250)
        if not tag:
            raise InputError(f"{where(place)}:{line}: {said}")
        raise Element(tag, Attributes({}), line, where(place)).error(said)
    if result["unset"]:
        notes.ignored(
            "environment variables are not read: their defaults are taken, which may leave sensors out; for others "
            "expand the file with ROS's xacro",
            *(shortened(said, 40) for said in result["unset"]),
        )
    for said in result["missing"]:
        named = PurePosixPath(said).parts[1:2]
        whose = f" (package {shortened(named[0])})" if said.startswith("/") and named else ""
        notes.ignored(f"included file that is not in the rig's folder{whose}", shortened(said, 80))
    for said in result["unknown"]:
        notes.ignored("macro that no file in the rig's folder defines", shortened(said))
    notes.read(f"xacro, expanded here: {result['steps']} elements, {result['files']} files included")
    return _tree(
        (depth, Element(tag, Attributes(attributes), line, where(place), words=text))
        for depth, tag, attributes, text, place, line in result["elements"]
    )


def _tree(elements: Iterable[tuple[int, Element]]) -> Element:
    """Return the first element with the others in it, each given with its depth, in the order of the document."""
    branch: list[Element] = []
    for depth, element in elements:
        del branch[depth:]
        if branch:
            branch[-1].children.append(element)
        branch.append(element)
    return branch[0]


def _package(folder: Path) -> Path:
    """Return the folder of the ROS package that a folder lies in, or the folder itself."""
    for place in (folder, *folder.parents)[:MAX_PARENTS]:
        if (place / "package.xml").is_file():
            return place
    return folder


def _workspace(package: Path) -> list[str]:
    """Return the folders in which other ROS packages may be: that around the package, the one around it, and the
    repositories in that, as in the `src` of a workspace."""
    if not (package / "package.xml").is_file():
        return []
    around = package.parent
    try:
        beside = [place for place in sorted(around.parent.iterdir())[:MOST_BESIDE] if place.is_dir()]
    except OSError:
        beside = []
    return [str(place) for place in dict.fromkeys((around, around.parent, *beside))]
