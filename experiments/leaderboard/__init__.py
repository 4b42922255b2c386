"""Every metric of the field on the same trials, at every moment that a run looked at."""
