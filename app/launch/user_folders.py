"""Locate the folders of the user's settings and of the state of running windows."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs


def config_folder() -> Path:
    """Return the folder of the settings; the environment variable RIGLENS_CONFIG_DIR wins."""
    override = os.environ.get("RIGLENS_CONFIG_DIR")
    return Path(override) if override else Path(platformdirs.user_config_dir("riglens"))


def state_folder() -> Path:
    """Return the folder of unsaved work and of the log; the environment variable RIGLENS_STATE_DIR wins."""
    override = os.environ.get("RIGLENS_STATE_DIR")
    return Path(override) if override else Path(platformdirs.user_state_dir("riglens"))
