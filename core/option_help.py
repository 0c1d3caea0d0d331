"""Define the help of an option, which stands beside its type in the class of options; and help that several have."""

from __future__ import annotations

from typing import NamedTuple


class OptionHelp(NamedTuple):
    """Help of a field: the form of its value on the command line ("on|off" for a switch said by words), one sentence,
    its option where that is not called like the field, and the option that switches it off, if there is one."""

    metavar: str
    help: str
    option: str = ""
    negative: str = ""


SHAPE = OptionHelp(
    "", "class: cars have glass and a gap below, cyclists and pedestrians are slim; box: plain boxes."
)
RANGE_LAW = OptionHelp("on|off", "on: returns from far or oblique surfaces may get lost.")
PHASE = OptionHelp(
    "",
    "random: each LiDAR is rotated in each frame by a fraction of its azimuth step; 0: azimuths as listed.",
)
