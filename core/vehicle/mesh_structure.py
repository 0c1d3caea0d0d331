"""Refuse a mesh by its structure, before a parser walks it: too many parts, nodes in circles, compressed points."""

from __future__ import annotations

import json
import re
import struct
from itertools import chain
from typing import Any

from riglens.core.errors import InputError
from riglens.core.rig.yaml.nodes import shortened

GLTF = (".gltf", ".glb")
MAX_NODES = 10_000
MAX_GROUPS = 10_000
MAX_LEVELS = 100
"""Of nodes below each other, far above those of a car: parsers walk up from every node."""
_LOOKS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "MSFT_texture_")
"""Extensions of glTF that change how a mesh looks, not where it is; quantized points are read as they are."""
_GROUP = re.compile(rb"^[ \t]*(?:usemtl|o|g)[ \t]", re.MULTILINE)


def require_readable_structure(content: bytes, suffix: str) -> None:
    """Raise InputError where the structure of a mesh file cannot be read, or would take too long."""
    if suffix in GLTF:
        _check_tree(_tree(content))
    elif suffix == ".obj" and sum(1 for _ in _GROUP.finditer(content)) > MAX_GROUPS:
        raise InputError(f"has more than {MAX_GROUPS:,} groups; join them first")


def _tree(content: bytes) -> dict[str, Any]:
    """Return the tree of a glTF file; an empty one where there is none, which the parser reports."""
    if content[:4] == b"glTF" and len(content) >= 20:
        (length,) = struct.unpack_from("<I", content, 12)
        content = content[20 : 20 + length]
    try:
        tree = json.loads(content)
    except ValueError:
        return {}
    return tree if isinstance(tree, dict) else {}


def _check_tree(tree: dict[str, Any]) -> None:
    required = _list(tree, "extensionsRequired")
    unread = [name for name in map(str, required) if not name.startswith((*_LOOKS, "KHR_mesh_quantization"))]
    if unread:
        raise InputError(
            f"requires the extension {shortened(unread[0], 40)}, which is not read; export it without"
        )
    nodes = [node if isinstance(node, dict) else {} for node in _list(tree, "nodes")]
    groups = sum(len(_list(mesh, "primitives")) for mesh in _list(tree, "meshes"))
    for what, count, most in (("nodes", len(nodes), MAX_NODES), ("groups", groups, MAX_GROUPS)):
        if count > most:
            raise InputError(f"has more than {most:,} {what}; join them first")
    for number, node in enumerate(nodes):
        rotation = _list(node, "rotation")
        if rotation and not any(rotation):
            raise InputError(f"node {number}: rotation must be a quaternion other than zero")
    _check_trees([_list(node, "children") for node in nodes])


def _check_trees(children: list[list[Any]]) -> None:
    """Raise InputError unless the nodes are flat trees; a node below two others may be drawn very many times."""
    below = list(chain.from_iterable(children))
    for child in below:
        if not isinstance(child, int) or not 0 <= child < len(children):
            raise InputError(
                f"children of nodes must be 0 to {len(children) - 1} (got {shortened(str(child), 20)})"
            )
    level, met = sorted({*range(len(children))} - {*below}), 0
    if len(below) == len({*below}):
        for _ in range(MAX_LEVELS):
            met += len(level)
            level = [child for node in level for child in children[node]]
        if level:
            raise InputError(f"nodes must be at most {MAX_LEVELS} levels deep")
    if met != len(children):
        raise InputError("nodes must be trees: one is below itself, or below two others")


def _list(owner: Any, name: str) -> list[Any]:
    found = owner.get(name) if isinstance(owner, dict) else None
    return found if isinstance(found, list) else []
