"""Finds the command and the values that the words of a command line name, and runs it."""

from __future__ import annotations

from collections.abc import Sequence

from cyclopts import CycloptsError, UnusedCliTokensError

from app.cli.commands import app
from core.errors import InputError


def run(tokens: Sequence[str]) -> object:
    """Run the command; what it returns. InputError for words that fit none."""
    try:
        return app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        raise InputError(f"found {words}, where no more is expected") from error
    except CycloptsError as error:
        raise InputError(str(error)) from error
