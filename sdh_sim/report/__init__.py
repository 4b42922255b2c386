"""The page of a comparison, with its figures and tables."""

from sdh_sim.report.report import write_report

__all__ = ["write_report"]
