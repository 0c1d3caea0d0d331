"""RigLens: how well the LiDARs and cameras of a car look at traffic.

What is imported is `riglens.core`, `riglens.widgets`, `riglens.app` and `riglens.assets`. A wheel holds these folders
in this one; a checkout has them beside it, where its files are easier to reach.
"""

from pathlib import Path

_HERE = Path(__file__).resolve().parent
if not (_HERE / "core").is_dir():
    __path__.append(str(_HERE.parent))
