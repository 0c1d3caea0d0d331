"""Finds the command and the values that the words of a command line name, and runs it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from difflib import get_close_matches

from cyclopts import CycloptsError, UnusedCliTokensError

from riglens.app.commands.commands import app
from riglens.core.errors import InputError


def run(tokens: Sequence[str]) -> object:
    """Run the command; what it returns. InputError for words that fit none."""
    _check_words(tokens)
    try:
        return app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        raise InputError(f"found {words}, where no more is expected") from error
    except CycloptsError as error:
        raise InputError(str(error)) from error


def _check_words(tokens: Sequence[str]) -> None:
    """Refuse a name that is empty, which would be the working folder, and a misspelt command, which would be a rig."""
    if "" in tokens:
        raise InputError("found an empty word '', accepted is the name of a file, a rig or a command")
    word = tokens[0] if tokens else ""
    meant = meant_command(word)
    if meant is not None and not os.path.exists(word):
        raise InputError(f"found '{word}', which is no command; did you mean riglens {meant}?")


def meant_command(word: str) -> str | None:
    """The command that a misspelt one was probably meant to be; None for a command, and for anything else."""
    known = [name for name in app if name.isalpha()]
    if not word.isalpha() or word in known:
        return None
    if word.lower() == "help":
        return "--help"
    close = get_close_matches(word.lower(), known, 1, cutoff=0.75)
    return close[0] if close else None
