"""Define the help of an option, which stands beside its type in the class of options."""

from __future__ import annotations

from typing import NamedTuple


class OptionHelp(NamedTuple):
    """Help of a field: the form of its value on the command line ("on|off" for a switch said by words), one sentence,
    and its option where that is not called like the field."""

    metavar: str
    help: str
    option: str = ""
