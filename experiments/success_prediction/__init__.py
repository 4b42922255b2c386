"""Every metric, and baselines without wrenches, against the simulated outcomes."""
