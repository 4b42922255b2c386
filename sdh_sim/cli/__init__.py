"""The command ``sdh-sim``; ``main`` runs it, ``app`` has its commands and options."""

from sdh_sim.cli.app import app, main

__all__ = ["app", "main"]
