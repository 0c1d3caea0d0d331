"""Data that ships with RigLens: the sensor library, scenarios and the paper's published tables."""

from pathlib import Path


def asset_path(*parts: str) -> Path:
    """Return the path of a shipped file, e.g. asset_path("paper", "table1.csv")."""
    return Path(__file__).parent.joinpath(*parts)
