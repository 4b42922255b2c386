"""Generators of the model files under `models/`: run only to change a shape, never by a trial."""
