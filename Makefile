# `make` lists the targets. All but `make dist` set up .venv by themselves, with the first Python that has wheels of all
# extras.
# `make PYTHON=...` takes another, and builds the environment anew.
PYTHON ?= $(shell for p in python3.11 python3.10 "$$(uv python find 3.11 2>/dev/null)"; do \
  "$$p" -c "" 2>/dev/null && echo "$$p" && break; done)
NO_PYTHON = Python 3.11 or 3.10 is needed: install uv and run 'uv python install 3.11', or give make PYTHON=/path/to/python
VENV ?= .venv
SHELL := /bin/bash
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed-$(notdir $(PYTHON))

# compas_cra joins the other solvers when COMPAS names the Python of an environment that has it.
COMPAS ?=
export BLOCKSTAT_COMPAS_PYTHON := $(COMPAS)

# Names of jobs of evidence/jobs.py, for one or a few of them: make evidence ONLY="glue hard".
ONLY ?=
MISSING ?=

.PHONY: help demo test test-all notebooks lint benchmark evidence evidence-quick fuzz mutants coverage validation pages docs lock wheel dist release blender clean

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*  ## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 20

demo: $(STAMP)  ## search the thinnest walls and vault of examples/chapel.toml
	$(BIN)/dynsim optimise examples/chapel.toml -o out/chapel

test: $(STAMP)  ## run the tests except the slow and the long ones
	$(BIN)/python -m pytest -n 2 -m "not slow and not long"

test-all: notebooks  ## run all tests and the notebooks
	$(BIN)/python -m pytest -n 2

notebooks: $(STAMP)  ## run the notebooks
	$(BIN)/python -m pytest -n 2 --nbmake notebooks

lint: $(STAMP)  ## check the style and the types
	$(BIN)/python extras/lock.py --check
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

benchmark: $(STAMP)  ## time contacts, verdicts and a building
	$(BIN)/python -m evidence.benchmarks.contacts
	$(BIN)/python -m evidence.benchmarks.building

# Every table and picture of the README and the docs, within three hours on two cores.
evidence: $(STAMP)  ## make all tables and pictures again, or some: ONLY="glue hard", MISSING=1
	$(BIN)/python -m evidence $(if $(ONLY),--only $(ONLY)) $(if $(MISSING),--missing)

evidence-quick: $(STAMP)  ## run all scripts of the evidence with fewer scenes, into build/quick
	$(BIN)/python -m evidence --quick

fuzz: ONLY := fuzz
fuzz: evidence  ## 20,000 random scenes against an independent judge

# A second call goes on where the first one ended. SAMPLE and SEED choose another sample.
SAMPLE ?= 300
SEED ?= 1
mutants: $(STAMP)  ## put small bugs into the source and count those that no test notices
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[mutation]"
	$(BIN)/python -m evidence.mutation.run --sample $(SAMPLE) --seed $(SEED) --write docs/mutants.md

coverage: $(STAMP)  ## count the branches that no test takes, by room
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[mutation]"
	$(BIN)/python -m evidence.mutation.branches --measure --write docs/coverage.md

validation: ONLY := validation dynamics-validation
validation: evidence  ## recompute the reference values

pages: $(STAMP)  ## fill the pages from docs/results
	$(BIN)/python -m evidence.pages.fill

# A warning is an error. Notebooks run again when they or src have changed; after a change of evidence or docs/results
# remove build/notebooks.
docs: $(STAMP)  ## build the pages into build/docs
	$(BIN)/python -m sphinx -W --keep-going -q docs build/docs
	@echo build/docs/index.html

# make wheel PYTHONS="python3.10 python3.13": in fresh environments, without MKL, Bullet and the live page.
PYTHONS ?= $(PYTHON)
wheel: $(STAMP)  ## build the wheel and test the statics from it with each of PYTHONS
	$(BIN)/python extras/try_wheel.py $(PYTHONS)

# Tools and environments stand in build/dist, and .venv is not needed; pip fetches what is.
dist:  ## build wheel and sdist into dist/, check them, and run the quick start from each
	@$(if $(PYTHON),$(PYTHON) extras/dist.py,echo "$(NO_PYTHON)"; false)

release: $(STAMP)  ## refuse figures that come from another source than this one, then make dist
	$(BIN)/python -m pytest -m release tests/test_evidence.py
	$(MAKE) dist

blender: $(STAMP)  ## build the zips of the Blender extension in build/blender
	$(BIN)/python extras/blender/build.py

clean:  ## remove .venv, build, dist and out with all results in it
	rm -rf $(VENV) out build dist src/*.egg-info

# requirements.lock holds the versions that the tests ran with, and the hashes of their files.
$(STAMP): pyproject.toml requirements.lock
ifeq ($(PYTHON),)
	@echo "$(NO_PYTHON)"
	@false
endif
	@echo "1 of 3: a virtual environment in $(VENV) with $(PYTHON)"
	@$(PYTHON) -m venv --clear $(VENV)
	@echo "2 of 3: $$(grep -c '^[A-Za-z].*==' requirements.lock) packages, some minutes at the first time"
	@set -o pipefail; $(BIN)/python -m pip install --disable-pip-version-check --require-hashes --no-deps -r requirements.lock \
	  | sed -u -n 's/^Collecting \([^ ]*\).*/  \1/p'
	@echo "3 of 3: blockstat itself"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps -e .
	@touch $@

lock: $(STAMP)  ## renew the hashes of requirements.lock and docs/licences.md from PyPI
	$(BIN)/python extras/lock.py --same
