"""Expand a xacro file with ROS's package `xacro`: the part of reading that runs in a process of its own.

xacro evaluates expressions as Python. Here they can neither reach Python's internals nor, by an audit hook, anything
outside the process but the files that belong to the rig; time and memory are limited by `limited_process`. Run as
`python -m riglens.core.formats.xacro_process FILE FOLDER PACKAGE PLACE...` with the text of the file on standard input:
it and all that it includes must lie in the folder or its ROS package, or in a package that it names and that lies in
one of the places. The answer is JSON, see `Expansion.answer`.
"""

from __future__ import annotations

import ast
import contextlib
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any
from xml.dom import expatbuilder, minidom
from xml.parsers import expat

import xacro
from xacro import XacroException, substitution_args

from riglens.core.limited_process import serve

MAX_STEPS, MAX_FILES = 20_000, 60
"""Elements expanded, and files included or loaded."""
MAX_XML_BYTES, MAX_YAML_BYTES, MAX_ANSWER_BYTES = 1_000_000, 200_000, 16_000_000
MAX_MEMORY_BYTES = 1 << 30
PLACE = "file and line"
_ADVICE = "expand the file first, with ROS's xacro"
_INTERNALS = {"format", "format_map", "gi_frame", "gi_code", "cr_frame", "cr_code", "ag_frame", "ag_code"}
"""Attributes without an underscore that lead to Python's internals: of texts, generators and coroutines."""
_NEEDED_EVENTS = ("compile", "exec", "builtins.id")


class _Builder(expatbuilder.ExpatBuilderNS):
    """Builder of a document whose elements, and their copies, know their file and line."""

    def __init__(self, file: str) -> None:
        super().__init__()
        self._place_of = lambda: (file, self.getParser().CurrentLineNumber)

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        super().start_element_handler(name, attributes)
        self.curNode.setUserData(PLACE, self._place_of(), _Builder)  # type: ignore[no-untyped-call]

    def start_doctype_decl_handler(self, *_: object) -> None:
        raise XacroException("document types are not accepted")

    @staticmethod
    def handle(_: int, key: str, place: object, __: object, copy: Any) -> None:
        """Give a copied element the place of the original (a DOM user data handler)."""
        copy.setUserData(key, place, _Builder)


class Expansion:
    """Expansion of one file; takes the place of the functions of `xacro` that open files and evaluate Python."""

    def __init__(self, file: Path, folders: list[Path], places: list[Path]) -> None:
        self._file, self._folders, self._places = str(file), folders, places
        self._unset: dict[str, None] = {}
        self._node: Any = None
        self._steps = 0
        self.readable: set[str] = set()
        self._missing: list[str] = []
        self._unknown: list[str] = []
        self._evaluate, self._call, self._check = xacro.eval_all, xacro.handle_macro_call, xacro.check_attrs
        xacro.eval_all, xacro.handle_macro_call, xacro.check_attrs = self.evaluate, self.call, self.check
        xacro.get_include_files, xacro.abs_filename_spec, xacro.parse = self.included, self.found, self.parsed
        xacro.root_dir = str(file.parent)  # $(cwd)
        xacro.safe_eval = _checked_eval
        for name in ("type", "vars"):
            dict.pop(xacro._global_symbols["python"], name)
        substitution_args._eval_find = "/{}".format  # of a path in a package only its end is looked up
        substitution_args._eval_env = _refuse_environment
        substitution_args._eval_optenv = self._without_environment
        substitution_args._eval = _evaluated_arguments

    def answer(self, text: bytes) -> bytes:
        """Return JSON: `elements`, each with depth, tag, attributes, text, file and line, in the order of the document;
        `steps` and `files`: numbers of elements expanded and of files read; `missing` and `unknown`: files and macros
        left out, `unset`: environment variables whose default was taken. Or `error`: file, line, tag or "", and
        complaint.
        """
        try:
            elements = list(self._expanded(text))
            counts = {"steps": self._steps, "files": len(self.readable)}
            left_out = {"missing": self._missing, "unknown": self._unknown, "unset": list(self._unset)}
            answer = json.dumps({"elements": elements, **counts, **left_out}).encode()
            if len(answer) <= MAX_ANSWER_BYTES:
                return answer
            place, said = (self._file, 1), f"expands to more than {MAX_ANSWER_BYTES / 1e6:g} MB"
        except expat.ExpatError as error:
            self._node = None
            place, said = (xacro.filestack[-1], error.lineno), expat.ErrorString(error.code)
            said = f"not valid XML: {said}"
        except Exception as error:
            place = self._node.getUserData(PLACE) if self._node else (xacro.filestack[-1], 1)
            said = self._said(error)
        return json.dumps({"error": [*place, self._node.tagName if self._node else "", said]}).encode()

    def _expanded(self, text: bytes) -> Iterator[tuple[int, str, dict[str, str], str, str, int]]:
        xacro.init_stacks(self._file)
        xacro.substitution_args_context["arg"] = {}
        root = self.parsed(text, self._file).documentElement
        symbols = xacro.Table(xacro._global_symbols)
        name = root.getAttribute("name")
        if name:
            root.removeAttribute("name")
        self.evaluate(root, xacro.Table(), symbols)
        self._node = root
        if name:  # only now: the arguments that it may use are declared inside the root
            root.setAttribute("name", str(xacro.eval_text(name, symbols)))
        waiting = [(0, root)]
        while waiting:
            depth, node = waiting.pop()
            inner = [child for child in node.childNodes if child.nodeType == child.ELEMENT_NODE]
            words = (child.data for child in node.childNodes if isinstance(child, minidom.Text))
            yield depth, node.tagName, dict(node.attributes.items()), "".join(words), *node.getUserData(PLACE)
            waiting.extend((depth + 1, child) for child in reversed(inner))

    def _said(self, error: Exception) -> str:
        """Return an error of xacro, of an expression or of a file in words."""
        cause: object = error
        while isinstance(cause, XacroException) and cause.exc is not None:
            cause = cause.exc
        if isinstance(cause, MemoryError):
            return f"needs more memory than a rig may take ({MAX_MEMORY_BYTES >> 20} MiB)"
        if isinstance(cause, RecursionError):
            return "macros, properties, includes or an expression are nested too deeply, or without end"
        if isinstance(cause, substitution_args.ArgException):
            return f"argument '{cause}' has no default; {_ADVICE}"
        if isinstance(cause, (XacroException, substitution_args.SubstitutionException)):
            return str(cause)
        left_out = f"; left out: {self._missing[0]}" if isinstance(cause, NameError) and self._missing else ""
        return f"{type(cause).__name__}: {cause} {getattr(error, 'suffix', None) or ''}{left_out}"

    # ------------------------------------------------------------------ in place of xacro's functions
    def evaluate(self, node: Any, macros: Any, symbols: Any) -> None:
        """Expand what is in an element, up to MAX_STEPS elements in all."""
        self._node = node
        self._steps += 1
        if self._steps > MAX_STEPS:
            raise XacroException(f"xacro expands to more than {MAX_STEPS} elements")
        self._evaluate(node, macros, symbols)

    def check(self, node: Any, *names: list[str]) -> Any:
        """Return attributes of an element of xacro's own."""
        self._node = node
        return self._check(node, *names)

    def call(self, node: Any, macros: Any, symbols: Any) -> bool:
        """Expand the call of a macro; leave it out if no file defines the macro."""
        if node.tagName.startswith("xacro:") and node.tagName != "xacro:call":
            self._node = node
            name = node.tagName.removeprefix("xacro:")
            try:
                xacro.resolve_macro(name, macros, symbols)
            except KeyError:
                self._unknown.append(name)
                xacro.replace_node(node, by=None)
                return True
        return bool(self._call(node, macros, symbols))

    def included(self, said: str, symbols: Any) -> Iterator[str]:
        """Yield the file of an include, unless it is missing."""
        name = str(xacro.eval_text(said, symbols))
        file = self._found(name)
        if file is None:
            self._missing.append(name)
        else:
            yield file

    def found(self, said: str) -> str:
        """Return the path of a YAML file to load."""
        file = self._found(said)
        if file is None:
            raise XacroException(f"load_yaml: '{said}' is not in the rig's folder or package; {_ADVICE}")
        return file

    def _found(self, said: str) -> str | None:
        """Return the file of that name beside the present one, or else the one that the end of the name leads to in one
        of the folders, None when there is none."""
        parts = [part for part in PurePosixPath(said).parts if part != "/"]
        ends = [Path(*parts[start:]) for start in range(len(parts))]
        beside = Path(xacro.filestack[-1]).parent / said
        for place in (beside, *(folder / end for end in ends for folder in self._folders)):
            try:
                file = Path(os.path.realpath(place))
                if file.is_file() and any(file.is_relative_to(folder) for folder in self._folders):
                    return self._permitted(file)
            except (OSError, ValueError):  # a name that no file can have
                continue
        return self._in_another_package(said, parts)

    def _in_another_package(self, said: str, parts: list[str]) -> str | None:
        """Return the file of a path that begins with the name of a ROS package in one of the places."""
        if not said.startswith("/") or len(parts) < 2 or parts[0] == self._folders[-1].name:
            return None
        for place in self._places:
            try:
                package = Path(os.path.realpath(place / parts[0]))
                file = Path(os.path.realpath(package.joinpath(*parts[1:])))
                is_inside = file.is_relative_to(package) and package.parent == Path(os.path.realpath(place))
                if is_inside and (package / "package.xml").is_file() and file.is_file():
                    return self._permitted(file)
            except (OSError, ValueError):
                continue
        return None

    def _without_environment(self, name: str, default: str = "") -> str:
        """Return the default of $(optenv NAME DEFAULT)."""
        self._unset[name] = None
        return default

    def _permitted(self, file: Path) -> str:
        self.readable.add(str(file))
        if len(self.readable) > MAX_FILES:
            raise XacroException(f"too many included files (at most {MAX_FILES})")
        limit = MAX_YAML_BYTES if file.suffix in (".yaml", ".yml") else MAX_XML_BYTES
        if file.stat().st_size > limit:
            raise XacroException(f"{file}: too large for a file of a rig (at most {limit / 1e3:g} kB)")
        return str(file)

    def parsed(self, text: bytes | None, file: str) -> Any:
        """Return the document in a text, or else in a file."""
        return _Builder(file).parseString(Path(file).read_bytes() if text is None else text)


def _checked_eval(expression: str, symbols: Any, inner: Any = None) -> Any:
    """Return the value of a Python expression that cannot reach Python's internals."""
    expression = expression.strip()
    for node in ast.walk(ast.parse(expression, mode="eval")):
        name = node.attr if isinstance(node, ast.Attribute) else ""
        if name.startswith("_") or name in _INTERNALS:
            raise XacroException(f"'.{name}' is not accepted in an expression")
    symbols.update(__builtins__={})
    return eval(compile(expression, "<expression>", "eval"), symbols, inner)


def _evaluated_arguments(expression: str, context: dict[str, dict[str, str]]) -> str:
    """Return the value of $(eval ...), where the arguments of the file are known by name."""
    arguments = {name: xacro.Table._eval_literal(said) for name, said in context["arg"].items()}
    return str(_checked_eval(expression, dict(xacro._global_symbols), arguments))


def _refuse_environment(name: str) -> str:
    raise XacroException(f"$(env {name}): the environment is not read; {_ADVICE}")


def guard(readable: set[str]) -> None:
    """Let this process do nothing any more but evaluate expressions, and read these files."""
    writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND

    def check(event: str, arguments: tuple[Any, ...]) -> None:
        is_read = event == "open" and arguments[0] in readable and not arguments[2] & writing
        if not is_read and event not in _NEEDED_EVENTS:
            raise PermissionError(f"{event} is not permitted in a xacro file")

    sys.addaudithook(check)


def main(file: str, folder: str, package: str, *places: str) -> bytes:
    """Return the answer for a file whose text is on standard input."""
    text = sys.stdin.buffer.read()
    os.environ.clear()  # for what asks for it in another way
    expansion = Expansion(Path(file), [Path(folder), Path(package)], [Path(place) for place in places])
    with (
        open(os.devnull, "w", encoding="utf-8") as nothing,
        contextlib.redirect_stderr(nothing),
    ):  # xacro's warnings
        guard(expansion.readable)
        return expansion.answer(text)


if __name__ == "__main__":
    sys.exit(serve(lambda: main(*sys.argv[1:]), MAX_MEMORY_BYTES))
