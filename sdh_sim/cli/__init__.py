"""The command line ``sdh-sim``, run by ``main``; each command imports what it needs."""

from sdh_sim.cli.app import main

__all__ = ["main"]
