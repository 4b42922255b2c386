"""``python -m sdh_sim`` is the command ``sdh-sim``."""

import sys

from sdh_sim.cli import main

if __name__ == "__main__":
    sys.exit(main())
