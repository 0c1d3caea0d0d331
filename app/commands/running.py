"""Runs the command line: what becomes of errors, Ctrl-C and closed pipes, and the exit code."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable, Sequence

from riglens.app.launch.interrupt import INTERRUPTED, insistent_interrupt
from riglens.core.compiler import require_compiler
from riglens.core.errors import InputError
from riglens.core.shown_text import visible
from riglens.evaluation.names import option_of
from riglens.evaluation.options import DEFAULT_RIG, SceneOptions, ScoreOptions
from riglens.rendering.system_libraries import MissingLibraries

DONE, BAD_INPUT, FAILED = 0, 2, 3


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code. Bad input gives one line on standard error, a bug a traceback."""
    tokens = sys.argv[1:] if arguments is None else list(arguments)
    return guarded(lambda: _run(tokens))


def guarded(work: Callable[[], object], name: Callable[[str], str] = option_of) -> int:
    """Do some work and return the exit code of the command line; `name` maps fields to their names there."""
    _open_missing_streams()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        with insistent_interrupt():
            code = work()
        sys.stdout.flush()
    except InputError as error:
        return _say(error.text(name), BAD_INPUT)
    except MissingLibraries as error:
        return _say(str(error), BAD_INPUT)
    except KeyboardInterrupt as error:  # with words where files were written
        return _say(f"interrupted; {error.args[0] if error.args else 'no file was changed'}", INTERRUPTED)
    except MemoryError:
        return _say("out of memory; use larger voxels, a smaller ROI or fewer rays", FAILED)
    except BrokenPipeError:
        _forget_stdout()
        return DONE
    except OSError as error:  # the system's fault, not the program's: a full disk, a device that is gone
        _forget_stdout()
        place = f"{error.filename}: " if error.filename else ""
        return _say(f"{place}{error.strerror or error}", FAILED)
    except SystemExit:  # this is how rich says that nobody reads its output any more
        return DONE
    except Exception:  # a bug: 1 would say that a requirement is not met
        traceback.print_exc()
        return _say("unexpected failure; please report it with the lines above", FAILED)
    return code if isinstance(code, int) else DONE


def _run(tokens: Sequence[str]) -> object:
    """Run the command. The parser, which is slow to load, is not loaded where only the window can be meant."""
    require_compiler()
    if not tokens or _is_only_a_rig(tokens):
        from riglens.app.commands.start import start

        return start(tokens[0] if tokens else DEFAULT_RIG, SceneOptions(), ScoreOptions())
    from riglens.app.commands.parsing import run

    return run(tokens)


def _is_only_a_rig(tokens: Sequence[str]) -> bool:
    """Return whether this is a single word that is neither a command (those consist of letters alone) nor an option."""
    return len(tokens) == 1 and not tokens[0].isalpha() and not tokens[0].startswith("-")


def _say(message: str, code: int) -> int:
    """Print one line on standard error and pass the exit code on."""
    print(f"riglens: {visible(' '.join(message.split()))}", file=sys.stderr)
    return code


def _open_missing_streams() -> None:
    """Discard output to a stream that was closed before the start (`riglens ... >&-`).

    Otherwise the first file that is opened would take the stream's place, and what libraries print would land in it.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
    sys.stdout = sys.stdout or os.fdopen(os.dup(1), "w", encoding="utf-8")
    sys.stderr = sys.stderr or os.fdopen(os.dup(2), "w", encoding="utf-8")


def _forget_stdout() -> None:
    """Standard output is closed or full: keep Python from trying, and complaining, once more at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
