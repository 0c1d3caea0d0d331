"""Lay out build/static/riglens, the package as a wheel holds it, in links: for tools that read code without running it.

They look for `riglens.core` in a folder riglens/core, which a checkout has only by the `__path__` of
riglens/__init__.py. Where links are not allowed, as on Windows outside its developer mode, the files are copied: run
it again after each change. Usage: static_tree.py; prints the folder to search.
"""

import os
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STATIC = ROOT / "build" / "static"
ROOMS = ("app", "assets", "core", "widgets")
"""As in `sources` of pyproject.toml."""


def wanted_links() -> dict[Path, Path]:
    """Each link and what it leads to."""
    package = STATIC / "riglens"
    files = {package / path.name: path for path in (ROOT / "riglens").iterdir() if path.is_file()}
    return files | {package / room: ROOT / room for room in ROOMS}


def lay_out() -> None:
    """Make the links that are missing or lead elsewhere, and remove what is not wanted."""
    links = wanted_links()
    (STATIC / "riglens").mkdir(parents=True, exist_ok=True)
    for found in (STATIC / "riglens").iterdir():
        if not (found.is_symlink() and found.resolve() == links.get(found)):
            remove(found)
    for link, target in links.items():
        if not link.is_symlink():
            link_or_copy(link, target)


def remove(path: Path) -> None:
    """Delete a link, a file or a folder."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink()


def link_or_copy(link: Path, target: Path) -> None:
    """Make a link, or a copy where links are not allowed."""
    try:
        link.symlink_to(os.path.relpath(target, link.parent), target_is_directory=target.is_dir())
    except OSError:
        if target.is_dir():
            shutil.copytree(target, link, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copyfile(target, link)


if __name__ == "__main__":
    lay_out()
    sys.stdout.write(f"{STATIC}\n")
