# `make` lists the targets. All of them set up .venv by themselves with Python 3.11.
PYTHON ?= python3.11
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DOCS := $(VENV)/.docs

# compas_cra joins the other solvers when COMPAS names the Python of an environment that has it.
COMPAS ?=
export BLOCKSTAT_COMPAS_PYTHON := $(COMPAS)

# Names of jobs of evidence/jobs.py, for one or a few of them: make evidence ONLY="glue hard".
ONLY ?=
MISSING ?=

.PHONY: help demo test test-all notebooks lint benchmark evidence fuzz mutants validation pages docs clean

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*  ## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 20

demo: $(STAMP)  ## search the thinnest walls of examples/chapel.toml
	$(BIN)/dynsim optimise examples/chapel.toml -o out/chapel

test: $(STAMP)  ## run the tests except the slow ones
	$(BIN)/python -m pytest -n 2 -m "not slow"

test-all: notebooks  ## run all tests and the notebooks
	$(BIN)/python -m pytest -n 2

notebooks: $(STAMP)  ## run the notebooks
	$(BIN)/python -m pytest -n 2 --nbmake notebooks

lint: $(STAMP)  ## check the style and the types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

benchmark: $(STAMP)  ## time contacts, verdicts and a building
	$(BIN)/python -m evidence.benchmarks.contacts
	$(BIN)/python -m evidence.benchmarks.building

# Every table and picture of the README and the docs, within an hour on two cores.
evidence: $(STAMP)  ## make all tables and pictures again, or some: ONLY="glue hard", MISSING=1
	$(BIN)/python -m evidence $(if $(ONLY),--only $(ONLY)) $(if $(MISSING),--missing)

fuzz: ONLY := fuzz
fuzz: evidence  ## 20,000 random scenes against an independent judge

# About two hours on two cores; a second call goes on where the first one ended. SAMPLE and SEED choose another sample.
SAMPLE ?= 300
SEED ?= 1
mutants: $(STAMP)  ## put small bugs into the source and count those that no test notices
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c requirements.lock -e ".[mutation]"
	$(BIN)/python -m evidence.mutation.run --sample $(SAMPLE) --seed $(SEED) --write docs/mutants.md

validation: ONLY := validation dynamics-validation
validation: evidence  ## recompute the reference values

pages: $(STAMP)  ## fill the pages from docs/results
	$(BIN)/python -m evidence.pages.fill

# A warning is an error. Notebooks run, and are run again when they or the code have changed.
docs: $(DOCS)  ## build the pages into build/docs
	$(BIN)/python -m sphinx -W --keep-going -q docs build/docs
	@echo build/docs/index.html

clean:  ## remove what was built or installed
	rm -rf $(VENV) out build dist src/*.egg-info

# requirements.lock holds the versions that the tests ran with.
$(STAMP): pyproject.toml requirements.lock
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c requirements.lock -e ".[fast,dynamics,ui,test,dev]"
	touch $@

$(DOCS): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c requirements.lock -e ".[docs]"
	touch $@
