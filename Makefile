# `make run` and `make test` work from a bare clone: they need Python 3.11 or newer and make, nothing else.
# PYTHON names another Python than the newest one found, by a name or a path: make test PYTHON=python3.12
PYTHON ?=
export PYTHON
BIN := .venv/bin

.DEFAULT_GOAL := help
.PHONY: help core dev run reproduce robustness bench test test-slow check format docs clean

help:
	@echo "make run        fly the paper's mission under its three laws and print the comparison"
	@echo "make reproduce  vary every reading of the paper and write the report"
	@echo "make robustness fly it under gusts, wrong mass, weak rotors, noise and delay"
	@echo "make bench      time the MPC beside other solvers, and check its accuracy"
	@echo "make test       check, then run the test suite"
	@echo "make test-slow  the long flights that make test leaves out"
	@echo "make check      ruff (lint and format) and mypy"
	@echo "make format     rewrite the code in the project's format"
	@echo "make docs       build the reference as pages into site/, to be opened from disk"
	@echo "make clean      remove the environment, caches and results"

core dev:
	@sh scripts/environment.sh $@

run: core
	$(BIN)/python scripts/compare.py paper_calibrated

reproduce: core
	$(BIN)/python scripts/reproduce.py

robustness: core
	$(BIN)/python scripts/robustness.py

bench: dev
	$(BIN)/python scripts/benchmark.py

check: dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# A file's tests go to one worker: those that share flights stand in one file, so that no flight is flown twice.
PYTEST := $(BIN)/python -m pytest -n 2 --dist loadfile

test: check
	$(PYTEST)

test-slow: dev
	$(PYTEST) -m slow

format: dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# mkdocs-material otherwise tells, on every build, of projects of its own.
docs: dev
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo "the reference is in site/index.html"

clean:
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis results site
