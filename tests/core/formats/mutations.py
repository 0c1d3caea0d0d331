"""Broken versions of valid files: bytes changed, pieces cut, doubled and swapped, nasty words and numbers put in."""

from __future__ import annotations

import random
import re

NASTY = (
    *(
        "NaN",
        "nan",
        ".nan",
        "inf",
        "-.inf",
        "Infinity",
        "1e999",
        "-1e400",
        "1e308",
        "5e-324",
        "-0.0",
        "9" * 400,
        "1_0",
    ),
    *(
        "null",
        "~",
        "true",
        '""',
        "''",
        "[]",
        "{}",
        "[[[]]]",
        "{a: 1}",
        "[0, 0, 0]",
        "0x10",
        "1.5.2",
        "--1",
        "1e",
    ),
    *(
        "&a ",
        "*a",
        "!!python/object:os.system ",
        "!!binary ",
        "---\n",
        "%YAML 1.1\n",
        "? ",
        "- ",
        ": ",
        "<<: *a",
    ),
    *(
        "<!DOCTYPE r [<!ENTITY a 'b'>]>",
        "&a;",
        "&#0;",
        "<a>",
        "</robot>",
        "${x}",
        "$(find x)",
        "]]>",
        "<![CDATA[",
    ),
    *("\x00", "\ufeff", "\u2028", "\\u0000", "\\ud800", "😀", "\r", "\t", "\x7f", "../../etc/passwd"),
    *("[" * 200, "{" * 200, "[" * 2000, '{"a":' * 300, "<a>" * 100, "a" * 300, "\n" * 100, "'" * 3, '"""'),
)
_NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")
_PIECE = 60


def mutated(content: bytes, chance: random.Random) -> bytes:
    """One to four changes to a file."""
    for _ in range(chance.randint(1, 4)):
        content = chance.choice(CHANGES)(content, chance)
    return content


def _flip(content: bytes, chance: random.Random) -> bytes:
    broken = bytearray(content or b" ")
    broken[chance.randrange(len(broken))] = chance.randrange(256)
    return bytes(broken)


def _cut(content: bytes, chance: random.Random) -> bytes:
    start = chance.randint(0, len(content))
    return content[:start] + content[start + chance.randint(1, _PIECE) :]


def _truncate(content: bytes, chance: random.Random) -> bytes:
    return content[: chance.randint(0, len(content))]


def _double(content: bytes, chance: random.Random) -> bytes:
    start = chance.randint(0, len(content))
    piece = content[start : start + chance.randint(1, 3 * _PIECE)]
    place = chance.randint(0, len(content))
    return content[:place] + piece + content[place:]


def _swap_lines(content: bytes, chance: random.Random) -> bytes:
    lines = content.split(b"\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def _insert_nasty(content: bytes, chance: random.Random) -> bytes:
    place = chance.randint(0, len(content))
    return content[:place] + chance.choice(NASTY).encode() + content[place:]


def _replace_number(content: bytes, chance: random.Random) -> bytes:
    text = content.decode("utf-8", "replace")
    numbers = list(_NUMBER.finditer(text))
    if not numbers:
        return content
    found = chance.choice(numbers)
    other = chance.choice(
        (chance.choice(NASTY), str(chance.uniform(-1e3, 1e3)), str(chance.randint(-9, 99999)))
    )
    return (text[: found.start()] + other + text[found.end() :]).encode("utf-8", "replace")


def _replace_word(content: bytes, chance: random.Random) -> bytes:
    text = content.decode("utf-8", "replace")
    words = list(re.finditer(r"[A-Za-z_]\w*", text))
    if not words:
        return content
    found, other = chance.choice(words), chance.choice(words)
    word = chance.choice((other.group(), chance.choice(NASTY)))
    return (text[: found.start()] + word + text[found.end() :]).encode("utf-8", "replace")


CHANGES = (
    _flip,
    _cut,
    _truncate,
    _double,
    _swap_lines,
    _insert_nasty,
    _replace_number,
    _replace_number,
    _replace_word,
)
