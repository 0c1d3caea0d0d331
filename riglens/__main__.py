"""`python -m riglens` is the same as the console script `riglens`."""

import sys

from riglens.app.commands import main

if __name__ == "__main__":
    sys.exit(main())
