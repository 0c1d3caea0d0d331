"""A report as a tagged PDF: the page itself, laid out by WeasyPrint for A4, with its figures attached."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import matplotlib
from weasyprint import CSS, HTML, Attachment
from weasyprint.text.fonts import FontConfiguration
from weasyprint.urls import URLFetcher

MADE = datetime(2000, 1, 1)
"""The date of what is attached: that of its making would make two of the same report differ."""
FONTS = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
_FACES = (
    ("DejaVu Sans", "DejaVuSans", "normal"), ("DejaVu Sans", "DejaVuSans-Bold", "bold"),
    ("DejaVu Sans Mono", "DejaVuSansMono", "normal"),
)  # fmt: skip
_TYPES = {".json": "application/json", ".yaml": "text/yaml"}


class _OwnFiles(URLFetcher):  # type: ignore[misc]
    """Give a page the pictures within it and our fonts, and nothing else: no network and no files."""

    def fetch(self, url: str, headers: Any = None) -> Any:
        if not url.startswith(("data:", FONTS.as_uri())):
            raise ValueError(f"{url}: not part of the page")
        return super().fetch(url, headers)


def pdf_of(page: str, attached: Mapping[str, bytes]) -> bytes:
    """Return a page (HTML) as a PDF after PDF/UA-1 with files attached, by name (.json or .yaml).

    Equal input gives equal bytes with the same libraries: fonts are those that matplotlib brings, and there is no date.
    """
    fetcher, fonts = _OwnFiles(), FontConfiguration()
    faces = (
        f'@font-face {{ font-family: "{family}"; font-weight: {weight}; src: url("{(FONTS / file).as_uri()}.ttf") }}'
        for family, file, weight in _FACES
    )
    style = CSS(string="".join(faces), font_config=fonts, url_fetcher=fetcher)
    files = [
        Attachment(
            url=f"data:{_TYPES[Path(name).suffix]};base64,{base64.b64encode(content).decode('ascii')}",
            name=name, created=MADE, modified=MADE, url_fetcher=fetcher,
        )
        for name, content in attached.items()
    ]  # fmt: skip
    return bytes(
        HTML(string=page, url_fetcher=fetcher).write_pdf(
            stylesheets=[style],
            font_config=fonts,
            attachments=files,
            pdf_variant="pdf/ua-1",
            pdf_identifier=True,
        )
    )
