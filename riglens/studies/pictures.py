"""Write charts as files. The same chart always gives the same bytes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import matplotlib as mpl

from riglens.core.files import write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PictureFormat = Literal["png", "svg"]
PICTURES: tuple[PictureFormat, ...] = ("png", "svg")


def picture(figure: Figure, form: PictureFormat = "png", dpi: int | None = None) -> bytes:
    """Return the bytes of a picture file, without a date or the program's version; `dpi` other than the figure's
    own."""
    stream = io.BytesIO()
    unnamed = {"Date": None} if form == "svg" else {"Software": None}
    with mpl.rc_context({"svg.hashsalt": "riglens"}):
        figure.savefig(stream, format=form, dpi=dpi or "figure", metadata=unnamed)
    return stream.getvalue()


def write_pictures(figure: Figure, folder: Path, name: str) -> None:
    """Put the chart into a folder in each of the formats, as NAME.svg and NAME.png."""
    for form in PICTURES:
        write_file(folder / f"{name}.{form}", picture(figure, form))


def write_picture(path: Path, figure: Figure) -> None:
    """Write the chart in the format that the ending names."""
    write_file(path, picture(figure, "svg" if path.suffix.lower() == ".svg" else "png"))
