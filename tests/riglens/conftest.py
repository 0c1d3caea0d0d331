"""The command line, for tests of what a command writes."""

from tests.app.conftest import boxes, riglens, riglens_process

__all__ = ["boxes", "riglens", "riglens_process"]
