"""SDFormat: a model of Gazebo with sensors on its links, alone or in a world, .sdf and .world (import).

Poses of links are in the model's frame, or in that of the link that `relative_to` names; those of sensors on their
link; x forward, y left, z up; metres, radians. The model's origin is taken for the ground under the body centre.
Nested models are read, and those included as `model://NAME`, from `NAME/model.sdf` or `NAME/NAME.sdf` in the folder
around that of the file or in its `models`; their poses are in the frame of the model that holds them. Where a world
has its model does not matter.
Source: SDFormat specification 1.9, <world>, <model>, <include>, <link>, <pose>.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import FrameTree, Matrix
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.sdf_sensor import add_sdf_sensor, pose_of, sensor_kind
from riglens.core.formats.source import Source
from riglens.core.formats.unread import note_comments
from riglens.core.formats.xml_tree import Element
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_MODEL = "model frame"
_IN_FOLDER = re.compile(r"(?:model://)?([A-Za-z0-9_][A-Za-z0-9_. -]*)/?")
MAX_DEPTH = 6
MAX_INCLUDED = 60


def recognises(source: Source) -> bool:
    """Return whether this is an XML file whose root is <sdf>."""
    return source.xml.tag == "sdf"


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of one model: that of the name `options.token`, or the first that has some."""
    root, notes = source.xml, mounting.notes
    if root.tag != "sdf":
        raise root.error("the root must be <sdf>")
    note_comments(source.text, notes)
    library = _Library(source, notes)
    name, model = _chosen(root, library, mounting)
    _Reading(library, mounting).add(model, np.eye(4), 0)
    notes.converted("angles from radians to degrees")
    return mounting.rig(name)


class _Library:
    """The models around a file, which it may include; `missing` are the URIs that name none of them."""

    def __init__(self, source: Source, notes: Notes) -> None:
        self._source, self._notes = source, notes
        self._around = source.path.parent.resolve().parent
        self._included = 0
        self.missing = list[str]()

    def included(self, holder: Element) -> Iterator[tuple[Element, Element]]:
        """Yield each <include> of a model or world with its model; those that are not there are reported."""
        for include in holder.all("include"):
            uri = include.first("uri")
            said = shortened("?" if uri is None else uri.text.strip(), 60)
            found = self._model_of(said)
            if found is None:
                self.missing.append(said)
                self._notes.ignored("included model that is not beside the model's folder", said)
            else:
                yield include, found

    def _model_of(self, uri: str) -> Element | None:
        """Return the model that a URI names, None if it is missing."""
        named = _IN_FOLDER.fullmatch(uri)
        if named is None or self._included >= MAX_INCLUDED:
            return None
        name = named[1]
        for folder in (self._around / name, self._around / "models" / name):
            for file in (folder / "model.sdf", folder / f"{name}.sdf"):
                if _is_inside(file, self._around):
                    self._included += 1
                    root = self._source.another(file).xml
                    return root.first("model") if root.tag == "sdf" else None
        return None


class _Reading:
    """The sensors of a model, and of those that it holds."""

    def __init__(self, library: _Library, mounting: Mounting) -> None:
        self._library, self._mounting = library, mounting

    def add(self, model: Element, root_SE3_model: Matrix, depth: int) -> None:
        """Add the sensors of one model at that place."""
        tree = _links(model)
        for link in model.all("link"):
            name = link.attribute("name")
            for sensor in link.all("sensor"):
                kind = sensor_kind(sensor, self._mounting.notes)
                if kind is not None:
                    add_sdf_sensor(sensor, kind, name, root_SE3_model @ tree.root_SE3(name), self._mounting)
        for nested in model.all("model"):
            self._add_nested(nested, nested, root_SE3_model, tree, depth)
        for include, found in self._library.included(model):
            placed = found if include.first("pose") is None else include
            self._add_nested(found, placed, root_SE3_model, tree, depth)

    def _add_nested(
        self, model: Element, placed: Element, root_SE3_model: Matrix, tree: FrameTree, depth: int
    ) -> None:
        """Add a model where `placed` has it: in the frame of the one that holds it, or of a link of that."""
        name = shortened(model.attributes.get("name", "?"), 40)
        if depth >= MAX_DEPTH:
            raise model.error(f"models are nested too deeply (at most {MAX_DEPTH})")
        pose = placed.first("pose")
        frame = "" if pose is None else pose.attributes.get("relative_to", "")
        if frame and frame not in tree.frames():
            self._mounting.notes.approximated(
                f"its pose is relative to '{shortened(frame, 40)}': taken in the model", name
            )
        if placed.first("placement_frame") is not None or "placement_frame" in model.attributes:
            self._mounting.notes.approximated(
                "placement_frame: its pose is taken for that of its origin", name
            )
        held = tree.root_SE3(frame) if frame in tree.frames() else np.eye(4)
        self.add(model, root_SE3_model @ held @ pose_of(placed), depth + 1)


def _is_inside(file: Path, folder: Path) -> bool:
    try:
        return file.is_file() and file.resolve().is_relative_to(folder)
    except (OSError, ValueError):
        return False


def _chosen(root: Element, library: _Library, mounting: Mounting) -> tuple[str, Element]:
    """Return the model to read and its name; others of the file are reported."""
    models = [
        (shortened(said, 40), model)
        for holder in (root, *root.all("world"))
        for said, model in (
            *((model.attributes.get("name", "?"), model) for model in holder.all("model")),
            *((_name(include, model), model) for include, model in library.included(holder)),
        )
    ]
    token = mounting.options.token
    fitting = [(name, model) for name, model in models if token in (None, name)]
    some = [one for one in fitting if any(part.tag in ("sensor", "include") for part in one[1].walk())]
    if not models and library.missing:
        raise InputError(
            f"{mounting.where}: include: uri: must name a model in the folder above the file's, as NAME/model.sdf "
            f"(got '{library.missing[0]}')"
        )
    if not fitting:
        known = shortened(", ".join(name for name, _ in models), 120) or "none"
        raise InputError(f"{mounting.where}: token: must be the name of a model (known: {known})")
    chosen = (some or fitting)[0]
    mounting.notes.read(f"model {chosen[0]}", field="token")
    for other in models:
        if other is not chosen:
            mounting.notes.ignored("another model", other[0])
    return chosen


def _name(include: Element, model: Element) -> str:
    """Return the name of an included model, which the <include> may give."""
    own = include.first("name")
    return model.attributes.get("name", "?") if own is None else own.text.strip()


def _links(model: Element) -> FrameTree:
    """Return the links, attached to the model or to the link that their pose is relative to."""
    tree = FrameTree(model.where)
    for link in model.all("link"):
        pose = link.first("pose")
        parent = "" if pose is None else pose.attributes.get("relative_to", "")
        place: Matrix = pose_of(link)
        tree.add(parent or _MODEL, link.attribute("name"), place)
    return tree


SDF = Format(
    "sdf",
    "SDFormat model",
    (".sdf", ".world"),
    recognises,
    read,
    origin=Origin("the model's origin", lambda _: (0.0, 0.0, 0.0)),
)
