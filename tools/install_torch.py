"""Install the extra `riglens[detect]` into the Python that runs this: on Linux PyTorch's CPU build, without CUDA.

PyPI's build for Linux brings some gigabytes of CUDA libraries. The CPU build carries "+cpu" in its version, which only
a pinned version can ask for; other systems have no such build and need none.
"""

import subprocess
import sys

CPU_INDEX = "https://download.pytorch.org/whl/cpu"
VERSION = "2.13.0"


def packages() -> list[str]:
    """Return the arguments for pip."""
    return (
        [f"torch=={VERSION}+cpu", "--extra-index-url", CPU_INDEX]
        if sys.platform == "linux"
        else ["torch>=2.6,<3"]
    )


if __name__ == "__main__":
    print("Installing PyTorch (190 MB, 700 MB on disk)", file=sys.stderr, flush=True)
    sys.exit(subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", *packages()]).returncode)
