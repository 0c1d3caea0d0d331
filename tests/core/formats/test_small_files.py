"""Every line, key and number of the small files of a format means what it did, and what may be left out still may."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from riglens.core.formats.report import KINDS
from tests.core.formats.cases import SMALL, read_files
from tests.core.small_changes import Files, compare, keep, outcomes

KEPT = Path(__file__).with_name("small_files.json")


def read(files: Files) -> Iterator[object]:
    """Yield the rig in some files, and the number of remarks of each kind."""
    opened = read_files(dict(files))
    remarks = opened.report.remarks if opened.report else ()
    yield opened.rig
    yield [sum(1 + len(one.about) for one in remarks if one.kind == kind) for kind in KINDS]


@pytest.mark.parametrize("case", SMALL)
def test_every_line_key_and_number_means_what_it_did(case: str) -> None:
    compare(KEPT, case, outcomes(SMALL[case], read))


if __name__ == "__main__":
    keep(KEPT, {case: outcomes(SMALL[case], read) for case in SMALL})
