"""The command line `riglens`: one file of arguments per group of commands, and beside it the job that does the work.

Only light modules are imported here, so that `riglens --help` answers at once and a command that draws
nothing never loads Qt or VTK; each command imports its own job when it runs.
"""

from riglens.app.commands.running import main

__all__ = ["main"]
