"""The page on the formats names all of them."""

from pathlib import Path

from riglens.core.formats.exchange import FORMATS, readable, writable

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "formats-exchange.md").read_text(encoding="utf-8")


def test_every_format_has_its_row_in_both_tables() -> None:
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in PAGE.splitlines()
        if line[:3] == "| `"
    ]
    formats = [row for row in rows if row[0].strip("`") in FORMATS]
    for name in FORMATS:
        first, second = (row for row in formats if row[0] == f"`{name}`")
        assert (bool(first[2]), bool(first[3])) == (name in readable(), name in writable())
        assert all(second[:4])
