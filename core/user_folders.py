"""Locate the folders of the user: settings, the state of running windows, and where the system keeps its cache."""

from __future__ import annotations

import os
from pathlib import Path

from platformdirs import PlatformDirs


def config_folder() -> Path:
    """Return the folder of settings and of the user's library; the environment variable RIGLENS_CONFIG_DIR wins."""
    return Path(os.environ.get("RIGLENS_CONFIG_DIR") or system_folders().user_config_dir)


def state_folder() -> Path:
    """Return the folder of unsaved work and of the log; the environment variable RIGLENS_STATE_DIR wins."""
    return Path(os.environ.get("RIGLENS_STATE_DIR") or system_folders().user_state_dir)


def system_folders() -> PlatformDirs:
    """Return the folders that the system gives a program of this name."""
    return PlatformDirs("riglens", appauthor=False)  # Windows would have a folder of the author around it
