"""Words from outside (names, classes, notes, files) made safe to show: in a terminal, in a cell of a spreadsheet."""

from __future__ import annotations

import re
from collections.abc import Sequence

_UNSEEN = re.compile(
    r"[\x00-\x1f\x7f-\x9f\xad\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ud800-\udfff\ufeff\ufff9-\ufffb\ufffe\uffff]"
)
"""Control characters, line ends, direction marks, characters without width, and halves of characters."""
_LONGEST_REMARK = 400
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "＝", "＋", "－", "＠")


def visible(text: str) -> str:
    r"""Return the text on one line, with what would steer a terminal written out: \x1b."""
    return _UNSEEN.sub(_escaped, text)


def remark_text(text: str) -> str:
    """Return a remark as `visible` does, cut at a few hundred letters: files may hold names without end."""
    shown = visible(text)
    return shown if len(shown) <= _LONGEST_REMARK else f"{shown[: _LONGEST_REMARK - 1]}…"


def visible_lines(text: str) -> str:
    """Return the text as `visible` does, but with its line ends."""
    return "\n".join(map(visible, text.split("\n")))


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, in the plural unless it is 1."""
    return f"{count:,} {noun}" + "s" * (count != 1)


def numbered(names: Sequence[str], files: Sequence[str] = ()) -> tuple[str, ...]:
    """Return names that differ: of equal ones each with its file, or its number among them, in parentheses."""
    if files:
        names = [
            f"{name} ({file})" if names.count(name) > 1 and file != name else name
            for name, file in zip(names, files, strict=True)
        ]
    found = list[str]()
    for place, name in enumerate(names):
        number, unique = names[:place].count(name) + 1, name
        while names.count(name) > 1 and (unique == name or unique in names or unique in found):
            unique, number = f"{name} ({number})", number + 1
        found.append(unique)
    return tuple(found)


def spreadsheet_cell(value: object) -> object:
    """Return a cell of a table that no spreadsheet takes for a formula; numbers stay, also when they are texts.

    An apostrophe is put in front, as the OWASP advises against CSV injection.
    """
    if not isinstance(value, str) or not value.startswith(_FORMULA_STARTS):
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def _escaped(found: re.Match[str]) -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
