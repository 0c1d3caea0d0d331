"""Broken versions of valid files: bytes changed, pieces cut, doubled and swapped, nasty words and numbers put in."""

import random
import re

WORDS = (
    b"nan", b"NaN", b".nan", b"inf", b"-.inf", b"Infinity", b"1e999", b"-1e308", b"1e-320", b"5e-324", b"-0.0", b"-1",
    b"9" * 30, b"9" * 400, b"1_0", b"0x10", b"1.5.2", b"--1", b"1e", b"2147483648", b"9223372036854775808",
    b"null", b"~", b"true", b"", b'"', b'""', b"''", b"'" * 3, b'"""', b",,,,", b":", b": ", b"- ", b"? ", b"[]", b"{}",
    b"]", b"}", b"[[[]]]", b"{a: 1}", b"[0, 0, 0]", b"[" * 300, b"[" * 2000, b"{" * 200, b'{"a":' * 300,
    b"&a ", b"*a", b"<<: *a", b"!!python/object:os.system ", b"!!binary ", b"---\n", b"%YAML 1.1\n",
    b"<!DOCTYPE r [<!ENTITY a 'b'>]>", b"&a;", b"&#0;", b"<a>", b"<a>" * 100, b"</robot>", b"${x}", b"$(find x)",
    b"]]>", b"<![CDATA[", b"a" * 300, b"../../etc/passwd", b"Car", b"car", b"DontCare",
    b"\n", b"\n" * 100, b"\r", b"\r\n", b"\t", b" ", b"\x00", b"\x7f", b"\\u0000", b"\\ud800", b"\xff\xfe",
    b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\xe2\x80\xa8", b"\xf0\x9f\x98\x80", b"cos\nsystem\n(S'x'\ntR.", b"\x80\x04\x95",
    b"\x1f\x8b", b"PAR1", b"ARROW1", b"|O8", b"<f8", b"(8, 999999999)", b"\xff\xff\xff\x7f", b"\xff" * 8, b"\x00" * 8,
)  # fmt: skip
"""Input that parsers trip over: extreme numbers, quotes, nesting, entities, tags, other encodings, pickles, marks of
other formats."""
_NUMBER = re.compile(rb"-?\d+(\.\d+)?([eE][-+]?\d+)?")
_NAME = re.compile(rb"[A-Za-z_]\w*")


def mutated(content: bytes, chance: random.Random) -> bytes:
    """One to four changes to a file, mostly one, so that some files can still be read."""
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        content = chance.choice(CHANGES)(content, chance)
    return content


def _length(chance: random.Random) -> int:
    """A few bytes, or some fields or lines."""
    return chance.randint(1, chance.choice((4, 60)))


def _flip(content: bytes, chance: random.Random) -> bytes:
    broken = bytearray(content or b" ")
    broken[chance.randrange(len(broken))] = chance.randrange(256)
    return bytes(broken)


def _cut(content: bytes, chance: random.Random) -> bytes:
    start = chance.randint(0, len(content))
    return content[:start] + content[start + _length(chance) :]


def _truncate(content: bytes, chance: random.Random) -> bytes:
    return content[: chance.randint(0, len(content))]


def _double(content: bytes, chance: random.Random) -> bytes:
    start = chance.randint(0, len(content))
    piece = content[start : start + _length(chance)]
    place = chance.randint(0, len(content))
    return content[:place] + piece + content[place:]


def _swap_lines(content: bytes, chance: random.Random) -> bytes:
    lines = content.split(b"\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def _overwrite(content: bytes, chance: random.Random) -> bytes:
    place = chance.randint(0, len(content))
    return content[:place] + chance.randbytes(chance.randint(1, 8)) + content[place + chance.randint(0, 8) :]


def _insert_word(content: bytes, chance: random.Random) -> bytes:
    place = chance.randint(0, len(content))
    return content[:place] + chance.choice(WORDS) + content[place + chance.choice((0, 0, 4)) :]


def _replace_number(content: bytes, chance: random.Random) -> bytes:
    numbers = list(_NUMBER.finditer(content))
    if not numbers:
        return content
    found = chance.choice(numbers)
    number = chance.choice((f"{chance.uniform(-1e3, 1e3)}", f"{chance.randint(-9, 99999)}"))
    return (
        content[: found.start()]
        + chance.choice((chance.choice(WORDS), number.encode()))
        + content[found.end() :]
    )


def _replace_name(content: bytes, chance: random.Random) -> bytes:
    names = list(_NAME.finditer(content))
    if not names:
        return content
    found, other = chance.choice(names), chance.choice(names)
    return (
        content[: found.start()]
        + chance.choice((other.group(), chance.choice(WORDS)))
        + content[found.end() :]
    )


CHANGES = (
    _flip,
    _cut,
    _truncate,
    _double,
    _swap_lines,
    _overwrite,
    _insert_word,
    _replace_number,
    _replace_number,
    _replace_name,
)
