"""Where a graphics card draws, Qt shows OpenGL; where the processor draws, a picture, which is shown sooner."""

import pytest
from PySide6.QtWidgets import QApplication

from riglens.widgets.viewport.backend import create_viewport, draws_without_card, driver_name
from riglens.widgets.viewport.offscreen import OffscreenViewport
from riglens.widgets.viewport.viewport import Viewport


@pytest.mark.parametrize(
    ("driver", "without_card"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True),
        ("Software Rasterizer", True),
        ("Google SwiftShader", True),
        ("GDI Generic", True),
        ("Microsoft Basic Render Driver", True),
        ("Apple Software Renderer", True),
        ("", True),
        ("NVIDIA RTX A2000/PCIe/SSE2", False),
        ("Mesa Intel(R) UHD Graphics 620 (KBL GT2)", False),
        ("AMD Radeon RX 6600 (radeonsi, navi23, LLVM 15.0.7, DRM 3.54)", False),
        ("Apple M2", False),
    ],
)
def test_drivers_are_known_by_their_names(driver: str, without_card: bool) -> None:
    assert draws_without_card(driver) == without_card


@pytest.mark.parametrize(
    ("driver", "kind"), [("NVIDIA RTX A2000/PCIe/SSE2", Viewport), ("llvmpipe", OffscreenViewport)]
)
def test_the_viewport_fits_the_driver(qapp: QApplication, monkeypatch, driver: str, kind: type) -> None:
    monkeypatch.setattr("riglens.widgets.viewport.backend.driver_name", lambda: driver)
    view = create_viewport()
    assert type(view) is kind
    view.close()


def test_the_driver_says_its_name(qapp: QApplication) -> None:
    assert driver_name()
