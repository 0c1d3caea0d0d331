"""Options that several commands share, and how words become values."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, Literal, ParamSpec, TypeVar, get_args, get_type_hints

from cyclopts import Group, Parameter, Token

from riglens.app.terminal.console import is_standard_output
from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.option_help import OptionHelp
from riglens.evaluation.names import option_of
from riglens.evaluation.options import (
    DASK,
    GRID,
    LIBRARY,
    PROFILES,
    READING,
    WORKERS,
    CountOptions,
    SceneOptions,
    ScoreOptions,
)

SCENE = Group("Scene: boxes and grid", sort_key=10)
SCORE = Group("Score", sort_key=20)
COUNT = Group("Objects", sort_key=25)
BUILD = Group("Workers", sort_key=30)
MAX_DIGITS = 40
ON_OFF, WIDTH_HEIGHT = "on|off", "WxH"
P = ParamSpec("P")
R = TypeVar("R")


# ---------------------------------------------------------------- words to values


def whole_number(_: Any, tokens: Sequence[Token]) -> int:
    """Return an integer as written; 1.5 is not rounded."""
    found = tokens[0].value
    digits = found.strip().lstrip("+-")
    if not digits.isdecimal() or len(digits) > MAX_DIGITS:
        shown = found if len(found) <= MAX_DIGITS else f"{found[:MAX_DIGITS]}…"
        raise ValueError(f"must be an integer (got {shown})")
    return int(found)


def _edge_or_auto(_: Any, tokens: Sequence[Token]) -> float | str:
    found = tokens[0].value
    try:
        return found if found == "auto" else float(found)
    except ValueError:
        raise ValueError(f"must be an edge in metres, or auto (got {found})") from None


def _is_word(word: str) -> Callable[..., bool]:
    """Return a converter for an option whose value is a word."""

    def converted(_: Any, tokens: Sequence[Token]) -> bool:
        if tokens[0].value != word:
            raise ValueError(f"must be {word} (got {tokens[0].value})")
        return True

    return converted


def _size(_: Any, tokens: Sequence[Token]) -> tuple[int, int]:
    found = tokens[0].value
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", found.strip().lower())
    if match is None:
        raise ValueError(f"must be WIDTHxHEIGHT in pixels, such as 1280x800 (got {found})")
    return int(match[1]), int(match[2])


def _json_target(_: Any, tokens: Sequence[Token]) -> str:
    """Return a file name, or - for standard output; reject a probable misspelt option."""
    found = tokens[0].value
    if found.startswith("-") and found != "-":
        raise ValueError(f"must be a file name, or - for standard output (got '{found}')")
    return "-" if found == "-" or is_standard_output(found) else found


def shown_default(value: object) -> str | None:
    """Return a default for --help; a switch that is off and an empty list need none."""
    if value is None or value is False or value == ():
        return None
    parts = value if isinstance(value, tuple) else (value,)
    return " ".join(f"{one:g}" if isinstance(one, float) else str(one) for one in parts)


# ---------------------------------------------------------------- options by themselves


def number(group: Group | None = None, metavar: str = "N") -> Parameter:
    """Return how an integer is read."""
    if group is None:  # given as None, it would hide the option from --help
        return Parameter(converter=whole_number, metavar=metavar)
    return Parameter(converter=whole_number, group=group, metavar=metavar)


RigName = Annotated[str, Parameter(name="RIG", help="Rig file or preset name.")]
RigNames = Annotated[str, Parameter(name="RIG", required=True, help="Rig files or preset names.")]
AnyRigs = Annotated[tuple[str, ...], Parameter(name="RIG", negative=(), help="Rig files or preset names.")]
Out = Annotated[Path, Parameter(metavar="FILE")]
Whole = Annotated[int | None, number()]
Json = Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-", converter=_json_target)]
JsonFigures = Annotated[
    Json,
    Parameter(
        help="Also write the figures as JSON to a file; with - to standard output, instead of the tables."
    ),
]
Profiles = Annotated[
    tuple[Path, ...],
    Parameter(name="--profile", metavar=PROFILES.metavar, help=PROFILES.help, show_default=False),
]
Surroundings = Annotated[
    Literal["ignored", "block"] | None,
    Parameter(
        name="--surroundings",
        group=SCENE,
        help="block: houses, walls and poles of the bundled scenario hide objects too (ignored).",
    ),
]
Libraries = Annotated[
    tuple[Path, ...],
    Parameter(
        name="--library",
        metavar="FILE",
        show_default=False,
        help=LIBRARY.help,
    ),
]
Workers = Annotated[int | None, number(BUILD), Parameter(help=WORKERS.help)]
Dask = Annotated[
    str | None,
    Parameter(
        group=BUILD,
        metavar=DASK.metavar,
        help=DASK.help,
    ),
]


# ---------------------------------------------------------------- options that travel together


@dataclass(frozen=True)
class Taken:
    """Fields of a class of options that a command takes, and their groups in --help."""

    groups: Mapping[str, Group | None]


def taken(group: Group | None, *names: str) -> Taken:
    """Return some fields in one group."""
    return Taken(dict.fromkeys(names, group))


def all_of(
    options: type, group: Group | None = None, others: Mapping[str, Group | None] | None = None
) -> Taken:
    """Return all fields of a class of options in one group, but for some in others."""
    return Taken({one.name: (others or {}).get(one.name, group) for one in fields(options)})


def command(function: Callable[P, R]) -> Callable[P, R]:
    """Let the command line see each field of a command's options, `Annotated` with `Taken`, as an option of its own."""
    hints = get_type_hints(function, include_extras=True)
    options = dict[str, tuple[Any, Sequence[str], set[str]]]()
    parameters = list[inspect.Parameter]()
    for name, parameter in inspect.signature(function).parameters.items():
        hint = hints[name]
        how = next((one for one in getattr(hint, "__metadata__", ()) if isinstance(one, Taken)), None)
        if how is None:
            parameters.append(parameter.replace(annotation=hint))
            continue
        options[name] = parameter.default, tuple(how.groups), _switches(hint.__origin__)
        parameters += _parameters(name, parameter.default, how)

    @wraps(function)
    def run(*inputs: P.args, **given: P.kwargs) -> R:
        for name, (usual, names, switches) in options.items():
            said = {one: given.pop(f"{name}_{one}") for one in names if f"{name}_{one}" in given}
            said |= {one: said[one] == "on" for one in said.keys() & switches}
            if said:
                with naming_options(type(usual)):
                    given[name] = replace(usual, **said)
        return function(*inputs, **given)

    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run


@contextmanager
def naming_options(owner: type) -> Iterator[None]:
    """Raise InputErrors of a class's fields under the names that their options have."""
    try:
        yield
    except InputError as error:
        said = _helps(owner).get(error.field)
        raise InputError(
            error.message, said.option or error.field if said else error.field, error.other
        ) from None


def _helps(options: type) -> dict[str, OptionHelp]:
    """Return the help of each field of a class of options that has some."""
    hints = get_type_hints(options, localns={"Rig": object}, include_extras=True)
    said = {name: one for name, hint in hints.items() for one in getattr(hint, "__metadata__", ())}
    return {name: one for name, one in said.items() if isinstance(one, OptionHelp)}


def _switches(options: type) -> set[str]:
    """Return the fields that are said by the words on and off."""
    return {name for name, one in _helps(options).items() if one.metavar == ON_OFF}


def _parameters(owner: str, usual: Any, how: Taken) -> Iterator[inspect.Parameter]:
    """Yield the options of a command, with the defaults that its function states."""
    hints = get_type_hints(type(usual), localns={"Rig": object}, include_extras=True)
    for name, group in how.groups.items():
        kind, said = get_args(hints[name])
        default = getattr(usual, name)
        if said.metavar == ON_OFF:
            kind, said = Literal["on", "off"], said._replace(metavar="")
            default = "on" if default else "off"
        hint = _annotated(kind, said, name, group)
        yield inspect.Parameter(
            f"{owner}_{name}", inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint
        )


def _annotated(kind: Any, said: OptionHelp, name: str, group: Group | None) -> Any:
    shown: Callable[[Any], str | None] = shown_default
    converter: Callable[..., Any] | None = whole_number if int in (kind, *get_args(kind)) else None
    if name == "voxel_m":
        converter = _edge_or_auto
    elif said.metavar == WIDTH_HEIGHT:
        converter, shown = _size, "{0[0]}x{0[1]}".format
    elif kind is bool and said.metavar:  # said by a word
        kind, converter = Literal[said.metavar, True, False], _is_word(said.metavar)
    described = Annotated[
        kind,
        Parameter(
            name=f"--{said.option}" if said.option else option_of(name),
            metavar=said.metavar or None,
            help=said.help,
            converter=converter,
            n_tokens=1 if said.metavar == WIDTH_HEIGHT else None,
            consume_multiple=kind == tuple[float, ...],
            negative=f"--{said.negative}" if said.negative else (),
            show_default=shown,
            show_choices=converter is None,
        ),
    ]
    if group is None:  # given as None, it would hide the option
        return described
    return Annotated[described, Parameter(group=group)]


_STORED = ("pog", "tolerance_pp")
_RUN = ("threads", "body")
ReadingArguments = Annotated[SceneOptions, taken(SCENE, *READING)]
GridArguments = Annotated[SceneOptions, taken(SCENE, *GRID)]
BoxArguments = Annotated[SceneOptions, taken(SCENE, "boxes", *READING)]
SourceArguments = Annotated[
    SceneOptions, taken(SCENE, "boxes", *(name for name in READING if name != "frames"))
]
TrafficArguments = Annotated[SceneOptions, taken(SCENE, "boxes", *READING, "occluders")]
SceneArguments = Annotated[SceneOptions, taken(SCENE, "boxes", *GRID, *_STORED)]
EverythingArguments = Annotated[SceneOptions, taken(SCENE, "boxes", *GRID, *_STORED, "occluders")]
ScoreArguments = Annotated[ScoreOptions, taken(SCORE, "method", "reading", "camera_weight", *_RUN)]
RunArguments = Annotated[ScoreOptions, taken(SCORE, *_RUN)]
WindowArguments = Annotated[ScoreOptions, taken(SCORE, "camera_weight", *_RUN)]
BodyArguments = Annotated[ScoreOptions, taken(SCORE, "body")]
ThreadArguments = Annotated[ScoreOptions, taken(SCORE, "threads")]
CountArguments = Annotated[CountOptions, all_of(CountOptions, COUNT)]


@Parameter(name="*")
@dataclass(frozen=True)
class RigArguments:
    """Options of reading rigs."""

    libraries: Libraries = ()
    housings: Annotated[
        Body | None,
        Parameter(
            metavar="NAME",
            help="Rays pass through the housings of other sensors or end at them, wherever they end at the car "
            "(as set in each rig).",
        ),
    ] = None
