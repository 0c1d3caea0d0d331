"""The pages lead where they say, each of them is in the list in README.md, and the lists of packages are complete."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tools.build_docs import LINK, menu
from tools.write_licences import TARGET, name_of, packages

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
CODE = re.compile(r"^(`{3,}|~{3,}).*?^\1|`[^`\n]+`", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#{1,6} (.+)$", re.MULTILINE)
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def anchors_of(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    text = re.sub(
        r"^(`{3,}|~{3,}).*?^\1", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
    )
    found: dict[str, int] = {}
    for heading in HEADING.findall(text):
        plain = re.sub(r"[^\w\- ]", "", LINK.sub(r"\1", heading).lower()).replace(" ", "-")
        found[plain] = found.get(plain, -1) + 1
        if found[plain]:
            found[f"{plain}-{found[plain]}"] = 0
    return set(found)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    dead = []
    for _, link in LINK.findall(CODE.sub("", page.read_text(encoding="utf-8"))):
        place, _, anchor = link.partition("#")
        target = (page.parent / place) if place else page
        if "://" in link or link.startswith("mailto:"):
            continue
        if not target.exists() or (anchor and anchor not in anchors_of(target)):
            dead.append(link)
    assert dead == []


def test_every_page_is_in_the_list_of_the_readme() -> None:
    menus = menu((ROOT / "README.md").read_text(encoding="utf-8"))
    listed = {
        page
        for one in menus
        for pages in one.values()
        if isinstance(pages, list)
        for p in pages
        for page in p.values()
    }
    assert {path.name for path in (ROOT / "docs").glob("*.md")} <= listed


def test_licences_of_all_packages_are_listed() -> None:
    listed = set(
        re.findall(r"^\| \[?([^\]|]+?)\]?(?:\([^)]*\))? \|", TARGET.read_text(encoding="utf-8"), re.MULTILINE)
    )
    assert {name_of(Requirement(one).name) for one in PROJECT["dependencies"]} <= listed
    assert all(found.licence for found in packages())


def test_locked_packages_are_within_the_ranges_and_those_of_all_dependencies() -> None:
    lines = (ROOT / "constraints-dev.txt").read_text(encoding="utf-8").splitlines()
    locked = [Requirement(line) for line in lines if line and not line.startswith("#")]
    versions = {name_of(one.name): str(one.specifier).removeprefix("==") for one in locked}
    for line in (*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["dev"]):
        needed = Requirement(line)
        assert needed.specifier.contains(versions[name_of(needed.name)]), line
