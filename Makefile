PYTHON ?= python3
BIN := .venv/bin

.PHONY: setup format lint type test docs build

setup:  # .venv with everything for development
	$(PYTHON) -m venv .venv && $(BIN)/pip install -e ".[dev]"
format:
	$(BIN)/ruff check --fix . && $(BIN)/ruff format .
lint:
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
type:
	$(BIN)/pyright --pythonpath $(BIN)/python
test:
	$(BIN)/python -m pytest
docs:
	bash .ci/docs $(BIN)/python
build:
	bash .ci/wheel $(BIN)/python
