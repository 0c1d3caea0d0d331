"""Find wording that the style of this project excludes, in docstrings, messages and pages; part of `make check`.

Messages state subject, fact and remedy ("voxel_m must be above 0 (got -1)"); docstrings begin with an imperative or a
noun phrase. Patterns are few and literal, so that a hit is worth a look each time.

    python tools/check_words.py [FILE.py|FILE.md ...]     (all sources and pages)
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ("app", "core", "widgets", "riglens", "tools")
QUESTION = re.compile(r"(What|Where|Whether|How|Who|Whose|Which|Why|When|That)\b")
"""First words of summaries that describe nothing: "What a sensor sees"."""
EXCLUDED = {
    re.compile(r"\baccepted (is|are)\b"): "state what the value must be",
    re.compile(r"\bfound [^,;.]{1,60}[,;] which (is|are)\b"): "state what the value must be, and (got ...)",
    re.compile(r"\bwhich (is|are) no\b"): "say 'not a ...'",
    re.compile(r"\breckon\w*\b"): "compute",
    re.compile(r"\b(nobody|anybody|whoever)\b"): "name the subject, or use the passive",
    re.compile(r"\bgets? onto\b"): "hits, points on, figures for",
    re.compile(r"\bnext to no\b"): "almost no",
    re.compile(r"\bas it is now\b"): "current",
    re.compile(r"\bcontestants?\b"): "methods compared",
    re.compile(r"\bmay be given many times\b"): "may be repeated",
    re.compile(r"\bstands? where nothing may\b"): "is in the keep-out zone",
}
"""Wording that reads like a translation, and what to write instead."""
Hit = tuple[int, str]


def hits_in(text: str, line: int = 1) -> Iterator[Hit]:
    """Yield line and advice of every excluded wording in a text that starts at a line."""
    for pattern, advice in EXCLUDED.items():
        for found in pattern.finditer(text):
            yield line + text.count("\n", 0, found.start()), f"'{found[0]}': {advice}"


def hits_in_source(text: str) -> Iterator[Hit]:
    """Yield the hits in the strings of a Python source, and its docstrings that begin with a question word."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from hits_in(node.value, node.lineno)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            summary = QUESTION.match(str(node.value.value))
            if summary:
                yield node.lineno, f"'{summary[0]} ...': begin with an imperative or a noun"


def files() -> list[Path]:
    """Return all sources and pages of the project."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]
    own = Path(__file__).resolve()  # which quotes what it excludes
    sources = (path for folder in SOURCES for path in (ROOT / folder).rglob("*.py") if path != own)
    return sorted((*pages, *sources))


def main(names: Sequence[str]) -> int:
    """Print every hit as FILE:LINE: advice; return 1 when there are any."""
    count = 0
    for path in [Path(name) for name in names] or files():
        text = path.read_text(encoding="utf-8")
        found = hits_in_source(text) if path.suffix == ".py" else hits_in(text)
        for line, advice in sorted(set(found)):
            print(f"{path}:{line}: {advice}")
            count += 1
    return int(count > 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
