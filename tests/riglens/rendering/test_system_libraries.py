"""The check that keeps Qt and VTK from crashing on a system without their libraries."""

import subprocess
import sys
from pathlib import Path

import pytest

from riglens.rendering import system_libraries
from riglens.rendering.system_libraries import (
    MissingLibraries,
    Requirement,
    install_command,
    missing_requirements,
    require_system_libraries,
)
from tests.app.conftest import REPOSITORY

ABSENT = Requirement("libabsent7", soname="libabsent.so.7")


def test_this_machine_has_all_that_the_tests_need() -> None:
    assert missing_requirements("tests") == []


@pytest.mark.parametrize(
    "requirement",
    [
        ABSENT,
        Requirement("absent", program="no-such-program-here"),
        Requirement("absent", files=("/no/such/folder/*.so",)),
    ],
)
def test_what_is_not_there_is_not_met(requirement: Requirement) -> None:
    assert not requirement.is_met()


def test_one_matching_file_is_enough(tmp_path: Path) -> None:
    (tmp_path / "swrast_dri.so").touch()
    patterns = (str(tmp_path / "missing" / "*.so"), str(tmp_path / "*_dri.so"))
    assert Requirement("driver", files=patterns).is_met()


def test_the_error_is_one_line_with_the_library_and_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(system_libraries._REQUIREMENTS, "window", (ABSENT,))
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    with pytest.raises(MissingLibraries) as caught:
        require_system_libraries("window")
    assert str(caught.value) == (
        "system libraries are missing (libabsent.so.7); "
        "install them with: sudo apt-get update && sudo apt-get install -y libabsent7"
    )


def test_root_is_not_told_to_use_sudo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.geteuid", lambda: 0)
    assert install_command(["a", "b"]) == "apt-get update && apt-get install -y a b"


def test_systems_without_debian_packages_are_not_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(system_libraries._REQUIREMENTS, "window", (ABSENT,))
    monkeypatch.setattr("sys.platform", "darwin")
    require_system_libraries("window")


def test_the_check_runs_before_any_package_is_installed() -> None:
    code = (
        "import sys, riglens.rendering.system_libraries as check; check.missing_requirements('window');"
        "foreign = {'PySide6', 'vtkmodules', 'pyvista', 'numpy'} & set(sys.modules); sys.exit(bool(foreign))"
    )
    # -S leaves the installed packages out, as on a machine where the set-up has not run yet
    subprocess.run([sys.executable, "-S", "-c", code], cwd=REPOSITORY, check=True)
