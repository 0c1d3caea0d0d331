"""Open anything that a user may name as a rig: a preset, a rig file, or a file or folder in a foreign format."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import close_presets, find_preset
from riglens.core.rig.yaml.file import RigFile, load_rig
from riglens.core.rig.yaml.nodes import shortened

if TYPE_CHECKING:
    from riglens.core.formats.report import Report


@dataclass(frozen=True)
class OpenedRig:
    """A rig; `file` when it is a rig file, for saving; `report` when it comes from another program."""

    rig: Rig
    file: RigFile | None = None
    report: Report | None = None


def open_rig(name_or_path: str | Path) -> OpenedRig:
    """Return a preset by its name, a rig file, or a rig in another format, which is detected.

    A preset takes precedence over a file of the same name; write ./W+T for the file. Raise InputError when there is
    neither, or when the file is wrong.
    """
    name = os.fspath(name_or_path)
    found = find_preset(name)
    if found is not None:
        return OpenedRig(found.rig())
    from riglens.core.formats.exchange import endings  # imported late: formats are not needed for a preset

    if "/" in name or os.sep in name or os.path.exists(name) or name.lower().endswith(endings()):
        return open_rig_file(Path(name))
    close = close_presets(name)
    hint = f"; did you mean {' or '.join(close)}?" if close else ""
    raise InputError(f"rig '{shortened(name)}': neither a rig file nor a preset{hint}")


def open_rig_file(path: Path) -> OpenedRig:
    """Return a rig file, or a rig in another format; raise InputError when it cannot be read."""
    from riglens.core.formats.exchange import (
        detect,
    )  # imported late: the many formats are not needed for a preset
    from riglens.core.formats.mounts import ReadOptions
    from riglens.core.formats.riglens import RIGLENS
    from riglens.core.formats.source import Source

    source = Source(path)
    format_ = detect(source)
    if format_ is RIGLENS:
        file = load_rig(path)
        return OpenedRig(file.rig, file)
    imported = format_.read(source, ReadOptions())
    return OpenedRig(imported.rig, report=imported.report)
