"""Report the missing system libraries of Qt, VTK and WeasyPrint, before any is imported.

VTK does not raise when its OpenGL libraries are absent, it crashes; so this check runs first, in the set-up
and at the start of the program. It is plain standard-library Python, because the set-up runs it before any
package is installed. The list was found by starting VTK and Qt on a bare Debian 12 and adding packages one
by one until a scene was drawn; Ubuntu uses the same names.
"""

import ctypes
import glob
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Purpose = Literal["offscreen", "window", "pdf", "run", "tests"]


class MissingLibraries(RuntimeError):
    """System libraries are absent; the message is one line that names them and the installing command."""


@dataclass(frozen=True)
class Requirement:
    """One Debian package and what shows that it is installed: a library, a program or a file.

    `files` are shell patterns; any one match is enough.
    """

    package: str
    soname: str = ""
    program: str = ""
    files: tuple[str, ...] = ()

    @property
    def wanted(self) -> str:
        """Return the library, program or package that a message names as missing."""
        return self.soname or self.program or self.package

    def is_met(self) -> bool:
        """Return whether the library loads, the program is on PATH, or a file exists."""
        if self.soname:
            return _loads(self.soname)
        if self.program:
            return shutil.which(self.program) is not None
        return any(glob.glob(pattern) for pattern in self.files)


def _loads(soname: str) -> bool:
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


# The software renderer has no soname: its file name carries the version, its folder the distribution.
_DRIVER_FILES = (
    "/usr/lib/*/dri/*_dri.so",
    "/usr/lib/dri/*_dri.so",
    "/usr/lib64/dri/*_dri.so",
    "/usr/lib/*/libgallium-*.so",
    "/usr/lib64/libgallium-*.so",
)

# VTK draws without a screen, Numba runs its threads.
_OFFSCREEN = (
    Requirement("libegl1", soname="libEGL.so.1"),
    Requirement("libgl1", soname="libGL.so.1"),
    Requirement("libgl1-mesa-dri", files=_DRIVER_FILES),
    Requirement("libgomp1", soname="libgomp.so.1"),
    Requirement("libx11-6", soname="libX11.so.6"),
    Requirement("libxcursor1", soname="libXcursor.so.1"),
)

# Qt opens a window on an X display.
_WINDOW = (
    Requirement("libdbus-1-3", soname="libdbus-1.so.3"),
    Requirement("libfontconfig1", soname="libfontconfig.so.1"),
    Requirement("libfreetype6", soname="libfreetype.so.6"),
    Requirement("libglib2.0-0", soname="libgthread-2.0.so.0"),
    Requirement("libx11-xcb1", soname="libX11-xcb.so.1"),
    Requirement("libxcb-cursor0", soname="libxcb-cursor.so.0"),
    Requirement("libxcb-icccm4", soname="libxcb-icccm.so.4"),
    Requirement("libxcb-image0", soname="libxcb-image.so.0"),
    Requirement("libxcb-keysyms1", soname="libxcb-keysyms.so.1"),
    Requirement("libxcb-randr0", soname="libxcb-randr.so.0"),
    Requirement("libxcb-render-util0", soname="libxcb-render-util.so.0"),
    Requirement("libxcb-render0", soname="libxcb-render.so.0"),
    Requirement("libxcb-shape0", soname="libxcb-shape.so.0"),
    Requirement("libxcb-shm0", soname="libxcb-shm.so.0"),
    Requirement("libxcb-sync1", soname="libxcb-sync.so.1"),
    Requirement("libxcb-util1", soname="libxcb-util.so.1"),
    Requirement("libxcb-xfixes0", soname="libxcb-xfixes.so.0"),
    Requirement("libxcb-xkb1", soname="libxcb-xkb.so.1"),
    Requirement("libxkbcommon-x11-0", soname="libxkbcommon-x11.so.0"),
    Requirement("libxkbcommon0", soname="libxkbcommon.so.0"),
)

# WeasyPrint lays out the text of a PDF.
_PDF = (
    Requirement("libpango-1.0-0", soname="libpango-1.0.so.0"),
    Requirement("libpangoft2-1.0-0", soname="libpangoft2-1.0.so.0"),
    Requirement("libharfbuzz-subset0", soname="libharfbuzz-subset.so.0"),
)

# The test suite has a display without a screen and a mouse without a hand.
_TESTS = (
    Requirement("xdotool", program="xdotool"),
    Requirement("xvfb", program="Xvfb"),
)

_REQUIREMENTS: dict[Purpose, tuple[Requirement, ...]] = {
    "offscreen": _OFFSCREEN,
    "window": _OFFSCREEN + _WINDOW,
    "pdf": _PDF,
    "run": _OFFSCREEN + _WINDOW + _PDF,
    "tests": _OFFSCREEN + _WINDOW + _PDF + _TESTS,
}


def missing_requirements(purpose: Purpose) -> list[Requirement]:
    """Return the requirements that this system lacks for `purpose`; none on systems other than Linux."""
    if not sys.platform.startswith("linux"):
        return []
    return [requirement for requirement in _REQUIREMENTS[purpose] if not requirement.is_met()]


def install_command(packages: Sequence[str]) -> str:
    """Return the command that installs Debian packages, ready to be copied into a terminal."""
    sudo = "" if os.geteuid() == 0 else "sudo "
    return f"{sudo}apt-get update && {sudo}apt-get install -y {' '.join(packages)}"


def require_system_libraries(purpose: Purpose) -> None:
    """Raise MissingLibraries unless everything for `purpose` is installed.

    Call it before the first import of PySide6, vtk, pyvista, pyvistaqt or weasyprint.
    """
    missing = missing_requirements(purpose)
    if not missing:
        return
    names = ", ".join(requirement.wanted for requirement in missing)
    command = install_command([requirement.package for requirement in missing])
    raise MissingLibraries(f"system libraries are missing ({names}); install them with: {command}")
