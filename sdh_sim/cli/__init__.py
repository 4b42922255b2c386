"""The command ``sdh-sim``; ``main`` runs it."""

from sdh_sim.cli.app import main

__all__ = ["main"]
