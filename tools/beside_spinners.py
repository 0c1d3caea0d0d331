"""Run a command while other processes keep every processor busy: what passes then does not depend on the clock.

Usage: beside_spinners.py COMMAND [ARGUMENTS...]; three spinning processes per processor, so that the computer has four
times more work than processors. Ends with the exit code of the command.
"""

import os
import subprocess
import sys

PER_PROCESSOR = 3
SPIN = """
import os
parent = os.getppid()
while os.getppid() == parent:  # not for ever, should the one who started it be killed
    for _ in range(10_000_000):
        pass
"""


def main(command: list[str]) -> int:
    """Run the command next to the spinners."""
    count = PER_PROCESSOR * (os.cpu_count() or 1)
    spinners = [subprocess.Popen([sys.executable, "-c", SPIN]) for _ in range(count)]
    try:
        return subprocess.run(command, check=False).returncode
    finally:
        for spinner in spinners:
            spinner.kill()
        for spinner in spinners:
            spinner.wait()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
