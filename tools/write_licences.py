"""Writes docs/licences.md: every package that RigLens needs to run, directly or not, with its licence.

    python -m tools.write_licences

It reads what is installed here; versions are left out, so that the page changes with the packages alone.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

TARGET = Path(__file__).resolve().parents[1] / "docs" / "licences.md"
HEAD = """# Licences

RigLens is under the MIT licence. These packages are installed with it on Linux; each keeps its own licence.
`python -m tools.write_licences` makes this page from what they say about themselves.

| package | licence |
|---|---|
"""
_CLASSIFIER = "License :: "
_LONGEST = 80
_IN_FULL = {"xacro": "BSD-3-Clause"}
"""Licences of packages that give their whole text instead of its name."""


@dataclass(frozen=True)
class Package:
    """A package, where it comes from, and its licence in its own words."""

    name: str
    home: str
    licence: str


def name_of(package: str) -> str:
    """Return the normalised name of a package (PEP 503)."""
    return re.sub(r"[-_.]+", "-", package).lower()


def packages() -> list[Package]:
    """Return what RigLens needs, directly or not, by name; without its own extras, with those that packages name."""
    found: dict[str, Package] = {}
    ahead, met = [("riglens", "")], set[tuple[str, str]]()
    while ahead:
        name, extra = ahead.pop()
        try:
            one = distribution(name)
        except PackageNotFoundError:  # for other systems
            continue
        if (name, extra) in met:
            continue
        met.add((name, extra))
        found[name] = Package(name, _home_of(one), _IN_FULL.get(name) or _licence_of(one))
        for need in map(Requirement, one.requires or ()):
            if need.marker is None or need.marker.evaluate({"extra": extra}):
                ahead += [(name_of(need.name), wanted) for wanted in ("", *need.extras)]
    del found["riglens"]
    return sorted(found.values(), key=lambda package: package.name)


def _licence_of(one: Distribution) -> str:
    """Return the licence of a package as it says itself: SPDX, a classifier, or a first line."""
    said = one.metadata
    classifiers = [
        line.rpartition(" :: ")[2] for line in said.get_all("Classifier", []) if line.startswith(_CLASSIFIER)
    ]
    line = (said.get("License") or "").strip().partition("\n")[0]
    return said.get("License-Expression") or ", ".join(classifiers) or line[:_LONGEST]


def _home_of(one: Distribution) -> str:
    links = [line.partition(", ") for line in one.metadata.get_all("Project-URL", [])]
    named = {words.strip().lower(): link.strip() for words, _, link in links}
    wanted = ("homepage", "home", "source", "source code", "repository", "github", "code")
    return one.metadata.get("Home-page") or next((named[word] for word in wanted if word in named), "")


def main() -> None:
    """Write the page."""
    rows = (
        f"| {f'[{one.name}]({one.home})' if one.home else one.name} | {one.licence} |\n" for one in packages()
    )
    TARGET.write_text(HEAD + "".join(rows), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
