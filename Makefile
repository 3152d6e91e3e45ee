# Everything a user needs: `make demo` and `make test`. Both set up .venv by themselves with Python 3.11.
PYTHON ?= python3.11
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DOCS := $(VENV)/.docs

# `make solvers` takes most of an hour and 10 GB; compas_cra joins in when COMPAS names the Python of an environment
# that has it.
COMPAS ?=

.PHONY: demo test test-all lint benchmark search solvers bullet speed-error validation hard pictures gallery scenes screenshots docs clean

demo: $(STAMP)
	$(BIN)/dynsim optimise examples/chapel.toml -o out/chapel

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 -m "not slow"

test-all: $(STAMP)
	$(BIN)/python -m pytest -n 2

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

benchmark: $(STAMP)
	$(BIN)/python benchmarks/assess.py
	$(BIN)/python benchmarks/loads.py
	$(BIN)/python benchmarks/compare_verdicts.py
	$(BIN)/python benchmarks/live_page.py
	$(BIN)/python benchmarks/building.py

# Takes long: the chapel optimised three ways, soundness of pruning, cost of a sweep, the paper's experiment.
search: $(STAMP)
	$(BIN)/python benchmarks/search.py --lighter
	$(BIN)/python benchmarks/soundness.py
	$(BIN)/python benchmarks/sweep.py
	$(BIN)/python examples/paper/experiment.py --write

solvers: $(STAMP)
	$(BIN)/python benchmarks/solvers.py --write --sizes 100 1000 3000 10000 --limit 300 $(if $(COMPAS),--compas $(COMPAS))

# Half an hour: a chapel of 2,600 blocks alone takes ten minutes.
bullet: $(STAMP)
	$(BIN)/python benchmarks/bullet.py --write

speed-error: $(STAMP)
	$(BIN)/python benchmarks/speed_error.py --write

validation: $(STAMP)
	$(BIN)/python docs/make_validation.py
	$(BIN)/python docs/make_dynamics_validation.py

hard: $(STAMP)
	$(BIN)/python docs/make_hard.py

pictures: $(STAMP)
	$(BIN)/python docs/make_pictures.py

gallery: $(STAMP)
	$(BIN)/python docs/make_gallery.py

screenshots: $(STAMP)
	$(BIN)/python docs/make_screenshots.py

scenes: $(STAMP)
	$(BIN)/python docs/make_scenes.py

# A warning is an error. Notebooks run, and are run again when they or the code have changed.
docs: $(DOCS)
	$(BIN)/python -m sphinx -W --keep-going -q docs build/docs
	@echo build/docs/index.html

clean:
	rm -rf $(VENV) out build dist src/*.egg-info

# requirements.lock holds the versions that the tests ran with.
$(STAMP): pyproject.toml requirements.lock
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c requirements.lock -e ".[fast,dynamics,ui,test,dev]"
	touch $@

$(DOCS): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c requirements.lock -e ".[docs]"
	touch $@
