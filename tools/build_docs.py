"""Build the pages of docs/ as a site in build/site, with search, pictures, notebooks and the Python interface.

    python -m tools.build_docs            (needs the extra "docs"; no network)

Menus follow the list under "More" in README.md. Warnings, of dead links too, end the build.
"""

from __future__ import annotations

import json
import logging
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGES, SITE = ROOT / "build" / "docs", ROOT / "build" / "site"
LINK = re.compile(r"\[([^\]]+)\]\(([^)\s]+)\)")
SECTION = re.compile(r"^- \*\*(.+?)\*\*: (.*(?:\n  .*)*)", re.MULTILINE)
PICTURE = re.compile(r"!\[([^\]]*)\]\((images/[^)]+)\)")
BESIDE = re.compile(r"\]\(\.\./(assets/[^)#]+)")
REPORT = "example-report.html"
AT_TOP = {"README.md": "index.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
API = """# Python interface

Everything that `import riglens as rl` gives; [examples](scripting.md).

::: riglens.api
    options:
      show_root_heading: false
      show_root_toc_entry: false
      show_source: false
      members_order: source
      heading_level: 2
"""


def main() -> int:
    """Gather the pages and build the site; return the exit code."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(ROOT / "docs", PAGES)
    for name, page in AT_TOP.items():
        write(page, from_below_docs((ROOT / name).read_text(encoding="utf-8")))
    for path in PAGES.glob("*.md"):
        write(path.name, to_top((PAGES / path).read_text(encoding="utf-8")))
    for notebook in sorted((PAGES / "notebooks").glob("*.ipynb")):
        write(
            f"notebooks/{notebook.stem}.md", notebook_page(json.loads(notebook.read_text(encoding="utf-8")))
        )
    write_report()
    write("gallery.md", gallery())
    write("api.md", API)
    return build(menu((ROOT / "README.md").read_text(encoding="utf-8")))


def write_report() -> None:
    """Make the report of the gallery."""
    options = ("--voxel", "0.25", "--out", str(PAGES / REPORT))
    subprocess.run([sys.executable, "-m", "riglens", "report", "nuScenes car", "W+T", *options], check=True)


def write(name: str, text: str) -> None:
    """Write a page of the site."""
    (PAGES / name).write_text(text, encoding="utf-8", newline="\n")


def from_below_docs(text: str) -> str:
    """Return a page of the top folder with links as they are within docs/."""
    text = re.sub(r"\]\(docs/", "](", text)
    return to_top(re.sub(r"\]\((?=(?:README|CHANGELOG|CONTRIBUTING)\.md)", "](../", text))


def to_top(text: str) -> str:
    """Return a page with its links to files of the top folder as they are on the site, and take those along."""
    for name, page in AT_TOP.items():
        text = text.replace(f"](../{name}", f"]({page}")
    for place in BESIDE.findall(text):
        (PAGES / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / place, PAGES / place)
    return BESIDE.sub(r"](\1", text)


def notebook_page(notebook: dict[str, Any]) -> str:
    """Return a notebook as a page: its texts, and its code to copy."""
    parts = []
    for cell in notebook["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
    return "\n\n".join(parts) + "\n"


def gallery() -> str:
    """Return the page of a report, the notebooks and all pictures, each with the page that explains it."""
    parts = [f"# Gallery\n\n- [A report on two rigs]({REPORT}) ([how to write one](report.md))"]
    parts += [
        f"- [Notebook: {titled(path)}](notebooks/{path.name})"
        for path in sorted(PAGES.glob("notebooks/*.md"))
    ]
    parts.append("")
    for path in sorted(PAGES.glob("*.md"), key=lambda page: (page.name != "index.md", page.name)):
        pictures = PICTURE.findall(path.read_text(encoding="utf-8"))
        words_of = ((words, image, f"([{titled(path)}]({path.name}))") for words, image in pictures)
        parts += (f"![{words}]({image})\n\n{words} {page}\n" for words, image, page in words_of)
    return "\n".join(parts) + "\n"


def titled(path: Path) -> str:
    """Return the title of a page."""
    return path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def menu(readme: str) -> list[dict[str, Any]]:
    """Return the menus of the site: the sections of the list in README.md, with the pages that this adds."""
    menus: list[dict[str, Any]] = [{"Home": "index.md"}]
    for title, text in SECTION.findall(readme):
        links = [(words, place.removeprefix("docs/")) for words, place in LINK.findall(text)]
        pages = [{words: AT_TOP.get(place, place)} for words, place in links if place.endswith(".md")]
        menus.append(
            {title: [{words[0].upper() + words[1:]: page for words, page in one.items()} for one in pages]}
        )
    menus[1]["Start"] += [{"Gallery": "gallery.md"}]
    return [*menus, {"Python interface": "api.md"}]


def build(menus: list[dict[str, Any]]) -> int:
    """Run MkDocs; any warning fails."""
    from mkdocs.commands.build import build as build_site
    from mkdocs.config import load_config
    from mkdocs.exceptions import Abort
    from pymdownx.slugs import slugify

    options = {"docstring_style": "numpy", "extensions": ["tools.docs_arguments"]}
    config = {
        "site_name": "RigLens",
        "docs_dir": str(PAGES),
        "site_dir": str(SITE),
        "nav": menus,
        "use_directory_urls": False,
        "theme": {
            "name": "material",
            "font": False,
            "features": ["navigation.sections", "content.code.copy"],
        },
        "plugins": [
            "material/search",
            {"mkdocstrings": {"handlers": {"python": {"paths": [str(ROOT)], "options": options}}}},
        ],
        "validation": {"anchors": "warn", "omitted_files": "ignore"},
    }
    (PAGES.parent / "mkdocs.yml").write_text(json.dumps(config), encoding="utf-8")
    extensions = ["tables", "fenced_code", "admonition", {"toc": {"slugify": slugify(case="lower")}}]
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        build_site(load_config(str(PAGES.parent / "mkdocs.yml"), markdown_extensions=extensions, strict=True))
    except Abort as error:
        print(f"the site has warnings: {error}", file=sys.stderr)
        return 1
    print(f"Written: {SITE}; to search it: python -m http.server --bind 127.0.0.1 --directory {SITE}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
