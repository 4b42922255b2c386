"""The version, also of a checkout that is not installed; ``pyproject.toml`` says the same."""

__version__ = "0.1.0"
