"""Define the command line `riglens`: one file per command.

Only light modules are imported here, so that `riglens --help` answers at once and a command that draws
nothing never loads Qt or VTK; each command is imported when it is called.
"""

import signal
import sys
import threading
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code. Ctrl-C ends also the loading of the program in one line."""
    is_in_charge = threading.current_thread() is threading.main_thread()
    try:
        if is_in_charge:
            signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C, from the first import on
        from riglens.app.commands import running
    except KeyboardInterrupt:
        if sys.stderr is not None:
            sys.stderr.write("riglens: interrupted; no file was changed\n")
        return 130
    if is_in_charge and arguments is None:  # the process ends after the work, which listens by itself
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
    return running.main(arguments)
