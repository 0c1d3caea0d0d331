"""CARLA leaderboard: the list that an agent's sensors() returns, in a Python file (import).

The file is parsed, never executed: what is written out as numbers and texts is read, also under a name of the agent
(`self.cam_config['width']`) or of config.py beside it (`self.config.camera_pos[0]`), as agents of TransFuser have it;
computed values are reported. Poses relative to the vehicle's actor, on the ground under its bounding box, in CARLA's
left-handed axes: x forward, y to the RIGHT, z up; positive pitch looks UP, positive yaw turns RIGHT; metres, degrees.
Source: CARLA leaderboard, autoagents/autonomous_agent.py and agent_wrapper.py (which fixes the LiDAR's rays).
"""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.carla_objects import KNOWN, RADAR_TYPE, lidar_fields
from riglens.core.formats.carla_toml import right_handed
from riglens.core.formats.mounts import ACTOR, Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

LIDAR_RAYS = {
    "range": 85.0,
    "rotation_frequency": 10.0,
    "channels": 64,
    "upper_fov": 10.0,
    "lower_fov": -30.0,
    "points_per_second": 600_000,
}
"""Attributes that the leaderboard gives to every LiDAR."""
_POSITION, _ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
_COMPUTED = object()
_CONFIG, _CONFIG_FILE = "config", "config.py"
_ARITHMETIC: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
}  # fmt: skip
_SIGNS = {ast.USub: -1, ast.UAdd: 1}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt")},
    **{name: getattr(math, name) for name in ("radians", "degrees", "floor", "ceil", "hypot")},
    "abs": abs, "min": min, "max": max, "float": float, "int": int,
}  # fmt: skip
_CONSTANTS = {"pi": math.pi, "e": math.e}
_Names = dict[str, Any]
"""Values of the names that an expression may use."""


def recognises(source: Source) -> bool:
    """Return whether this is a Python file that speaks of CARLA's sensors."""
    return "sensor." in source.text


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of one agent: that of the class `options.token`, or the first that has some."""
    notes = mounting.notes
    entries, agent = _entries(source, mounting.options.token, notes)
    notes.read(f"sensors of {agent}", field="token")
    config = _names_beside(source, notes)
    names = {"self": {**_names_in(_tree(source), of_self=True), _CONFIG: config}, _CONFIG: config}
    for entry in entries:
        _add(entry, names, source, mounting)
    notes.converted("left-handed axes to right-handed: y, pitch and yaw change sign")
    return mounting.rig(source.name)


def _entries(source: Source, token: str | None, notes: Notes) -> tuple[list[ast.Dict], str]:
    """Return the sensors in one function `sensors`, or without any in the whole file, and words that say where."""
    tree = _tree(source)
    found: dict[str, list[ast.Dict]] = {}
    for owner in (node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)):
        for function in owner.body:
            if isinstance(function, ast.FunctionDef) and function.name == "sensors":
                found[owner.name] = _sensors_in(function)
    if not found:
        found = {"the file": _sensors_in(tree)}
    if token is not None and token not in found:
        raise InputError(
            f"{source.where}: token: must be the name of a class with sensors() (got '{shortened(token)}')"
        )
    agent = token or next((name for name, sensors in found.items() if sensors), next(iter(found)))
    for name in found.keys() - {agent}:
        notes.ignored("another agent", shortened(name, 40))
    return found[agent], shortened(agent, 40)


def _tree(source: Source) -> ast.Module:
    try:
        with warnings.catch_warnings(action="ignore"):  # such as of `1or 2`
            return ast.parse(source.text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None) or 1
        raise InputError(f"{source.where}:{line}: not Python: {shortened(str(error), 80)}") from error


def _names_beside(source: Source, notes: Notes) -> _Names:
    """Return the literal values of config.py beside an agent that uses a configuration."""
    beside = source.sibling(_CONFIG_FILE) if f"{_CONFIG}." in source.text else None
    names = _names_in(_tree(beside)) if beside is not None else {}
    if names:
        notes.read(f"numbers of {_CONFIG_FILE} beside it")
    return names


def _names_in(tree: ast.Module, of_self: bool = False) -> _Names:
    """Return the literal values of names, or only of attributes of self; of none that is changed or given twice."""
    stored = Counter(
        _stored(node) for node in ast.walk(tree) if isinstance(getattr(node, "ctx", None), ast.Store)
    )
    names: _Names = {}
    for node in ast.walk(tree):
        targets = node.targets if isinstance(node, ast.Assign) else []
        target = node.target if isinstance(node, ast.AnnAssign) else targets[0] if len(targets) == 1 else None
        name = _stored(target)
        is_whole = isinstance(target, ast.Attribute if of_self else ast.Attribute | ast.Name)
        if name is not None and isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            names[name] = _value(node.value, {}) if is_whole and stored[name] == 1 else _COMPUTED
    return names


def _stored(node: ast.AST | None) -> str | None:
    """Return the name of a variable or attribute that is given a value, or one of its entries."""
    while isinstance(node, ast.Subscript):
        node = node.value
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", None)


def _sensors_in(tree: ast.AST) -> list[ast.Dict]:
    """Return the dictionaries whose type is a sensor's, in the order of the file."""
    written = [node for node in ast.walk(tree) if isinstance(node, ast.Dict) and _type_of(node)]
    return sorted(written, key=lambda node: (node.lineno, node.col_offset))


def _type_of(node: ast.Dict) -> str:
    kind = _fields(node, {}).get("type")
    return kind if isinstance(kind, str) and kind.startswith("sensor.") else ""


def _fields(node: ast.Dict, names: _Names) -> dict[str, Any]:
    """Return the literal values of a dictionary under text keys; _COMPUTED where the code would have to run."""
    pairs = zip(node.keys, node.values, strict=True)
    found = {
        key.value: _value(value, names)
        for key, value in pairs
        if isinstance(key, ast.Constant) and isinstance(key.value, str)
    }
    return {key: _COMPUTED if isinstance(value, Mapping) else value for key, value in found.items()}


def _value(node: ast.expr, names: _Names) -> Any:
    """Return the value of numbers and texts, lists of them, names, and sums and products of these; else _COMPUTED."""
    try:
        return _evaluated(node, names)
    except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError):
        return _COMPUTED


def _evaluated(node: ast.expr, names: _Names) -> Any:
    """Return the value of an expression, without calling anything but _FUNCTIONS; KeyError or TypeError for others."""
    match node:
        case ast.Constant(value=int() | float() | str() as value):
            return value
        case ast.Name(id=name):
            return names[name]
        case ast.Attribute(value=ast.Name(id="math"), attr=name):
            return _CONSTANTS[name]
        case ast.Attribute(value=inner, attr=name):
            return _entry(_evaluated(inner, names), name)
        case ast.Subscript(value=inner, slice=key):
            return _entry(_evaluated(inner, names), _evaluated(key, names))
        case ast.List(elts=parts) | ast.Tuple(elts=parts):
            return tuple(_evaluated(part, names) for part in parts)
        case ast.Dict(keys=keys, values=values):
            return {
                _key(key, names): _evaluated(value, names) for key, value in zip(keys, values, strict=True)
            }
        case ast.UnaryOp(op=sign, operand=inner):
            return _SIGNS[type(sign)] * _number(_evaluated(inner, names))
        case ast.BinOp(left=left, op=sign, right=right):
            first, second = _evaluated(left, names), _evaluated(right, names)
            if isinstance(sign, ast.Add) and isinstance(first, str) and isinstance(second, str):
                return first + second
            return _ARITHMETIC[type(sign)](_number(first), _number(second))
        case ast.Call(
            func=ast.Name(id=name) | ast.Attribute(value=ast.Name(id="math"), attr=name),
            args=parts,
            keywords=[],
        ):
            return _FUNCTIONS[name](*(_number(_evaluated(part, names)) for part in parts))
    raise TypeError


def _entry(inside: Any, key: Any) -> Any:
    """Return an entry of a dictionary or a list."""
    is_place = isinstance(inside, tuple) and isinstance(key, int) and not isinstance(key, bool)
    if not is_place and not isinstance(inside, Mapping):
        raise TypeError
    return inside[key]


def _key(node: ast.expr | None, names: _Names) -> float | int | str:
    """Return the key of a dictionary; TypeError for ** and for lists."""
    key = None if node is None else _evaluated(node, names)
    if not isinstance(key, (int, float, str)):
        raise TypeError
    return key


def _number(value: Any) -> float | int:
    """Return a number of ordinary size; products of larger ones could grow without end."""
    if not isinstance(value, (int, float)):
        raise TypeError
    if abs(value) > 1e12:
        raise OverflowError
    return value


def _add(node: ast.Dict, names: _Names, source: Source, mounting: Mounting) -> None:
    fields, notes = _fields(node, names), mounting.notes
    kind = _type_of(node)
    named = fields.get("id")
    name = named if isinstance(named, str) else f"line {node.lineno}"
    family = kind.removeprefix("sensor.").partition(".")[0]
    if family not in ("camera", "lidar") and kind != RADAR_TYPE:
        notes.ignored(f"neither camera nor LiDAR: {shortened(kind, 40)}", name)
        return
    if kind != RADAR_TYPE and kind.removeprefix(f"sensor.{family}.") not in KNOWN[family]:
        notes.approximated(f"unknown type '{shortened(kind, 40)}', read as a sensor.{family} of CARLA", name)
    computed = [key for key, value in fields.items() if value is _COMPUTED]
    placed = [key for key in computed if key in (*_POSITION, *_ANGLES, "width", "height", "fov")]
    if placed or any(key is None for key in node.keys):
        what = ", ".join(placed) or "**"
        notes.ignored(f"left out: {what} would have to be computed by running the code", name)
        return
    written = {key: part for key, part in fields.items() if part is not _COMPUTED}
    if family == "lidar":
        written = _with_rays(written, name, notes)
    value = source.value(written, f"line {node.lineno}")
    for key in computed:
        notes.ignored(f"'{shortened(key, 30)}' would have to be computed by running the code", name)
    place = [value.item(key, 0.0).number() for key in (*_POSITION, *_ANGLES)]
    pose = right_handed((place[0], place[1], place[2]), (place[3], place[4], place[5]))
    if family == "lidar":
        mounting.add("lidar", name, pose, **lidar_fields(value, name, notes))
        return
    if kind == RADAR_TYPE:
        mounting.add("radar", name, pose, **_radar_fields(value))
        return
    if kind != "sensor.camera.rgb":
        notes.read("camera of another kind, imported for its view", name)
    mounting.add("camera", name, pose, image=value.image(), hfov_deg=value.item("fov").number())


def _with_rays(fields: dict[str, Any], name: str, notes: Notes) -> dict[str, Any]:
    """Return the fields of a LiDAR with the rays of the leaderboard where the list has none of its own."""
    if LIDAR_RAYS.keys() - fields.keys():
        notes.approximated(
            "rays not in the list: as the leaderboard fixes them (64 beams, -30 to 10 degrees)", name
        )
    return LIDAR_RAYS | fields


def _radar_fields(value: Value) -> dict[str, Any]:
    """Return the scan of a radar, up to 100 m; the leaderboard's is as high as it is wide."""
    wide = value.get("horizontal_fov") or value.item("fov")
    high = value.get("vertical_fov") or wide
    azimuth, elevation = ((-half, half) for half in (one.number(1e-3, 180.0) / 2.0 for one in (wide, high)))
    return {"scans": ({"azimuth_deg": azimuth, "elevation_deg": elevation, "range_m": 100.0},)}


CARLA_AGENT = Format(
    "carla-agent", "CARLA leaderboard agent", (".py",), recognises, read, origin=ACTOR, harmless="type|id"
)
