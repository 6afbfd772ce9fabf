# Everything is done by one virtual environment in .venv; python3 and make are all that must be there.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.DEFAULT_GOAL := help
.PHONY: help setup demo test check lint types contracts bench format wheel clean

help:
	@echo "make demo    set up and sail the overtaking mission"
	@echo "make test    set up and run the tests"
	@echo "make check   lint, types, import contracts, tests: what CI runs"
	@echo "make bench   speed and memory, as ratios in one run"
	@echo "make format  put the code in form"
	@echo "make wheel   build the wheel and try it in an environment of its own"

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	# a ground station for the tests, without its maps and windows (VTK, OpenCV), which are larger than all the rest
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --no-deps MAVProxy
	@touch $@

setup: $(READY)

demo: $(READY)
	$(BIN)/fleet sim overtaking --warp 6

test: $(READY)
	$(BIN)/python -m pytest -n 2 --dist loadfile -m 'not sails'
	$(BIN)/python -m pytest -m sails  # real processes: one mission after the other, with the machine to itself

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

contracts: $(READY)
	$(BIN)/lint-imports

check: lint types contracts test

bench: $(READY)
	$(BIN)/python -m bench

format: $(READY)
	$(BIN)/ruff check --fix-only .
	$(BIN)/ruff format .

wheel: $(READY)
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	$(PYTHON) -m venv --clear build/wheel-env
	build/wheel-env/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt dist/*.whl
	cd build && wheel-env/bin/fleet --version && wheel-env/bin/fleet mission check overtaking

clean:
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
