"""Where things are kept that can be made again."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs


def cache_folder() -> Path:
    """The user's cache folder of RigLens; the environment variable RIGLENS_CACHE_DIR wins."""
    override = os.environ.get("RIGLENS_CACHE_DIR")
    return Path(override) if override else Path(platformdirs.user_cache_dir("riglens"))
