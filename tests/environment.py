"""Empty Python environments for tests of what users install: no network, the packages of the test run below."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

from tests.waiting import TIMEOUT_S


class Environment:
    """A virtual environment that sees the dependencies of this one, but not RigLens."""

    def __init__(self, folder: Path) -> None:
        """Create it in a folder that does not exist yet."""
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
        paths = sysconfig.get_paths("venv", {"base": str(folder), "platbase": str(folder)})
        self.site, self.scripts = Path(paths["purelib"]), Path(paths["scripts"])
        # a .pth file in a folder that a .pth file names is not read, so this checkout stays out
        (self.site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")

    def install(self, *words: str | Path) -> None:
        """Install a wheel or a source folder."""
        options = ("--no-deps", "--no-index", "--no-build-isolation", "--no-warn-script-location", "--quiet")
        python = ("--python", self.scripts / "python")
        command = [sys.executable, "-m", "pip", *python, "install", *options, *words]
        subprocess.run(command, cwd=self.site, check=True, timeout=TIMEOUT_S)

    def run(self, script: str, *words: str | Path, cwd: Path | None = None) -> str:
        """Return the standard output of a script of the environment, such as "python"; it must end well."""
        return self.output(script, *words, cwd=cwd)[0]

    def output(self, script: str, *words: str | Path, cwd: Path | None = None) -> tuple[str, str]:
        """Return standard output and standard error of a script of the environment; it must end well."""
        done = subprocess.run(
            [self.scripts / script, *words],
            cwd=cwd or self.site,
            env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
            capture_output=True,
            encoding="utf-8",
            timeout=TIMEOUT_S,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout, done.stderr
