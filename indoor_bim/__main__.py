"""`python -m indoor_bim` is `indoor-bim`."""

import sys

from indoor_bim.cli import main

if __name__ == "__main__":
    sys.exit(main())
