"""Second half of the set-up: system libraries, then .venv with all packages. Usage: setup_env.py run|test

Plain standard-library Python, started by setup.sh. Does nothing, quickly, when everything is in place.
"""

import fcntl
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import time
from collections import deque
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
STAMP = VENV / "riglens-setup"
PYPROJECT = ROOT / "pyproject.toml"

sys.path.insert(0, str(ROOT))

from riglens.rendering.system_libraries import Purpose, install_command, missing_requirements  # noqa: E402

PURPOSES: dict[str, Purpose] = {"run": "run", "test": "tests"}


class SetupError(Exception):
    """The set-up cannot go on; the message is one line with the remedy."""


def say(text: str) -> None:
    """Progress, on standard error."""
    print(text, file=sys.stderr, flush=True)


# ---------------------------------------------------------------- system packages


def missing_packages(purpose: Purpose) -> list[str]:
    """Debian packages for `purpose` that are absent, the one that makes virtual environments included."""
    packages = [requirement.package for requirement in missing_requirements(purpose)]
    if importlib.util.find_spec("ensurepip") is None or importlib.util.find_spec("venv") is None:
        packages.insert(0, f"python{sys.version_info.major}.{sys.version_info.minor}-venv")
    return packages


def ensure_system_packages(purpose: Purpose) -> None:
    """Install missing packages when that is allowed, otherwise name the command."""
    packages = missing_packages(purpose)
    if not packages:
        return
    advice = f"system packages are missing; install them with: {install_command(packages)}"
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        raise SetupError(advice)
    say(f"Installing {len(packages)} system packages with apt-get: {' '.join(packages)}")
    apt_get("update")
    if not apt_get("install", "-y", "--no-install-recommends", *packages):
        raise SetupError(f"apt-get failed, see above; {advice}")
    importlib.invalidate_caches()
    if still_missing := missing_packages(purpose):
        raise SetupError(f"apt-get installed them, but these are still not found: {' '.join(still_missing)}")


def apt_get(*arguments: str) -> bool:
    """Run apt-get without questions; on failure show its output."""
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    done = subprocess.run(
        ["apt-get", "-qq", *arguments],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    if done.returncode != 0:
        say(done.stdout.rstrip())
    return done.returncode == 0


# ---------------------------------------------------------------- packages in .venv


def interpreter() -> Path:
    """The Python that .venv is made with: never the one inside .venv, which may be about to be replaced."""
    return Path(sys.executable).resolve()


def environment_key() -> str:
    """Return the first lines of the stamp; when they change, .venv is rebuilt (its scripts hold absolute paths)."""
    return f"{VENV}\n{interpreter()} {sys.version.split()[0]}\n"


def wanted_stamp() -> str:
    """Return the stamp of a .venv that is complete and up to date."""
    return environment_key() + hashlib.sha256(PYPROJECT.read_bytes()).hexdigest() + "\n"


def ensure_environment() -> None:
    """Make .venv and install the packages, unless the stamp shows that this is complete."""
    found = STAMP.read_text(encoding="utf-8") if STAMP.exists() else ""
    if found == wanted_stamp():
        return
    started = time.monotonic()
    if not found.startswith(environment_key()):
        say(f"Creating .venv with Python {sys.version.split()[0]}")
        subprocess.run([interpreter(), "-m", "venv", "--clear", VENV], check=True)
    STAMP.unlink(missing_ok=True)
    say("Installing packages into .venv (1.5 GB on disk, a few minutes the first time)")
    pip_install("--editable", ".[dev]")
    STAMP.write_text(wanted_stamp(), encoding="utf-8")
    say(f"Packages installed in {time.monotonic() - started:.0f} s")


def pip_install(*arguments: str) -> None:
    """Run pip, showing on one line where it is; on failure show the end of its output."""
    command = [str(VENV / "bin" / "python"), "-m", "pip", "install", "--progress-bar", "off", *arguments]
    environment = os.environ | {"PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INPUT": "1"}
    tail: deque[str] = deque(maxlen=20)
    with subprocess.Popen(
        command,
        cwd=ROOT,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    ) as pip:
        assert pip.stdout is not None
        for line in pip.stdout:
            tail.append(line)
            show_progress(line)
    show_progress("")
    if pip.returncode != 0:
        say("".join(tail).rstrip())
        raise SetupError("pip could not install the packages, see above")


def show_progress(line: str) -> None:
    """Overwrite the terminal's current line with pip's; nothing when the output is not a terminal."""
    if sys.stderr.isatty() and (not line or line.startswith(("Collecting", "Downloading", "Installing"))):
        print(f"\r\x1b[K{line.rstrip()[:79]}", end="", file=sys.stderr, flush=True)


def main(arguments: list[str]) -> int:
    """Do the set-up for `run` or `test`; 0 done, 2 something is missing that only the user can add."""
    if len(arguments) != 1 or arguments[0] not in PURPOSES:
        say("usage: tools/setup.sh run|test")
        return 2
    try:
        with PYPROJECT.open(encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # two set-ups at once would break each other's .venv
            ensure_system_packages(PURPOSES[arguments[0]])
            ensure_environment()
    except SetupError as error:
        say(f"RigLens set-up: {error}")
        return 2
    except KeyboardInterrupt:
        say("\nRigLens set-up: interrupted; the next run starts it again")
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
