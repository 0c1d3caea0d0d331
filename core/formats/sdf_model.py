"""SDFormat: a model of Gazebo with sensors on its links, .sdf (import).

Poses of links are in the model's frame, or in that of the link that `relative_to` names; those of sensors on their
link; x forward, y left, z up; metres, radians. The model's origin is taken for the ground under the body centre. Nested
and included models are not read. Source: SDFormat specification 1.9, <model>, <link>, <pose>.
"""

from __future__ import annotations

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import FrameTree, Matrix
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.sdf_sensor import add_sdf_sensor, pose_of, sensor_kind
from riglens.core.formats.source import Element, Source
from riglens.core.formats.unread import note_comments
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_MODEL = "model frame"


def recognises(source: Source) -> bool:
    """Return whether this is an XML file whose root is <sdf>."""
    return source.xml.tag == "sdf"


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of one model: that of the name `options.token`, or the first that has some."""
    root, notes = source.xml, mounting.notes
    if root.tag != "sdf":
        raise root.error("the root must be <sdf>")
    note_comments(source.text, notes)
    model = _chosen(root, mounting)
    for part in ("include", "model"):
        for nested in model.all(part):
            notes.ignored(f"<{part}> in the model is not read", nested.attributes.get("name", "?"))
    tree = _links(model)
    for link in model.all("link"):
        name = link.attribute("name")
        for sensor in link.all("sensor"):
            kind = sensor_kind(sensor, notes)
            if kind is not None:
                add_sdf_sensor(sensor, kind, name, tree.root_SE3(name), mounting)
    notes.converted("angles from radians to degrees")
    return mounting.rig(model.attributes.get("name", source.name))


def _chosen(root: Element, mounting: Mounting) -> Element:
    """Return the model to read; others of the file are reported."""
    worlds = [root, *root.all("world")]
    models = [model for world in worlds for model in world.all("model")]
    token = mounting.options.token
    fitting = [one for one in models if token in (None, one.attributes.get("name"))]
    some = [one for one in fitting if any(link.first("sensor") for link in one.all("link"))]
    if not fitting:
        known = shortened(", ".join(one.attributes.get("name", "?") for one in models), 120) or "none"
        raise InputError(f"{mounting.where}: token: must be the name of a model (known: {known})")
    chosen = (some or fitting)[0]
    mounting.notes.read(f"model {shortened(chosen.attributes.get('name', '?'), 40)}", field="token")
    for other in models:
        if other is not chosen:
            mounting.notes.ignored("another model", shortened(other.attributes.get("name", "?"), 40))
    return chosen


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
    (".sdf",),
    recognises,
    read,
    origin=Origin("the model's origin", lambda _: (0.0, 0.0, 0.0)),
)
