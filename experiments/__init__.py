"""Tables, figures and studies, each runnable as ``python -m experiments.NAME``."""
