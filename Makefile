# make benchmark   set up .venv, then the main job on the embedded data
# make demo        two simulated recordings, thigh and shank, to knee angles and a picture of the strides
# make test        lint, types, docstrings, tests with coverage
# make test-slow   tests that take long: sweeps that are killed, every export format, all real recordings
# make speed       add the peers, then the speed benchmark
# make embedded    what the methods cost on an 8-bit microcontroller (gcc-avr avr-libc simavr)
# make mutants    mutation testing of one package: ROOM=kinematics
# make release    sdist and wheel from the committed files, checked, installed, used
# make docs        the documentation as a site, into site/
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# exact versions; torch is pinned there because an open range fetches gigabytes of CUDA
PIP := $(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt
OVERRIDES ?=
ROOM ?= kinematics

.PHONY: benchmark demo test test-slow mutants release docs speed embedded clean

benchmark: $(VENV)/.run
	$(BIN)/python -m experiments.benchmark $(OVERRIDES)

demo: $(VENV)/.run
	$(BIN)/python -m experiments.demo_recordings output=demo
	$(BIN)/python -m experiments.predict output=demo/knee.csv \
		"input={thigh_right: demo/thigh_right.csv, shank_right: demo/shank_right.csv}"

test: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -m "not slow" -n 2 --dist worksteal --cov --cov-report=term:skip-covered --durations=10

test-slow: $(VENV)/.dev
	$(BIN)/pytest -m slow -n 2 --dist worksteal --durations=10

mutants: $(VENV)/.mutation
	rm -rf mutants
	$(BIN)/mutmut run "narx.$(ROOM)*"

release: $(VENV)/.dev
	$(BIN)/python -m nox -s release

docs: $(VENV)/.dev
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

speed: $(VENV)/.peers
	$(BIN)/python -m experiments.speed $(OVERRIDES)

embedded: $(VENV)/.run
	$(BIN)/python -m experiments.embedded

# torch goes first: with it installed, no other package can ask for another build
$(VENV)/.run: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(PIP) torch
	$(PIP) --editable ".[filters]"
	touch $@

$(VENV)/.dev: $(VENV)/.run
	$(PIP) --editable ".[dev,docs,cluster,filters,onnx,sweep]"
	touch $@

$(VENV)/.mutation: $(VENV)/.dev
	$(PIP) --editable ".[mutation]"
	touch $@

$(VENV)/.peers: $(VENV)/.run
	$(PIP) --editable ".[peers]"
	touch $@

clean:
	rm -rf $(VENV) demo site mutants dist outputs multirun .coverage .pytest_cache .mypy_cache .ruff_cache
