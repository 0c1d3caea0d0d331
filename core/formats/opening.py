"""Open anything that a user may name as a rig: a preset, a rig file, or a file or folder in a foreign format."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.formats.report import OpenedRig
from riglens.core.rig.presets import close_presets, find_preset
from riglens.core.rig.yaml.nodes import shortened


def open_rig(name_or_path: str | Path) -> OpenedRig:
    """Return a preset by its name, a rig file, or a rig in another format, which is detected.

    A preset takes precedence over a file of the same name; write ./W+T for the file. A rig file needs no report.
    Raise InputError when there is neither, or when the file is wrong.
    """
    name = os.fspath(name_or_path)
    found = find_preset(name)
    if found is not None:
        return OpenedRig(found.rig())
    from riglens.core.formats.exchange import endings, read_rig  # many formats: not needed for a preset

    if "/" in name or os.sep in name or os.path.exists(name) or name.lower().endswith(endings()):
        opened = read_rig(Path(name))
        return opened if opened.file is None else replace(opened, report=None)
    close = close_presets(name)
    hint = f"; did you mean {' or '.join(close)}?" if close else ""
    raise InputError(f"rig '{shortened(name)}': neither a rig file nor a preset{hint}")
