# make            set everything up, run the default profile, write figures and report
# make help       the other targets
SHELL := /bin/bash
PYTHON ?= $(firstword $(shell command -v python3.11 python3))
CORES ?= all
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
SNAKEMAKE := $(BIN)/snakemake --cores $(CORES) --quiet host reason --rerun-incomplete
# A Snakemake that was killed leaves its lock behind; it is taken away when none is running.
UNLOCK := pgrep -f '[b]in/snakemake' > /dev/null || $(BIN)/python -m snakemake --unlock --quiet all  # the pattern must not match this line itself
export PATH := $(CURDIR)/$(BIN):$(PATH)

.PHONY: all default paper reset-free atlas gallery calibration flips bench scaling replay test coverage lint format lock schema docs docs-serve pages clean help
.DEFAULT_GOAL := default

all: default

default: $(READY)  ## run the default profile: figures and report in minutes
	$(BIN)/sensory-commutativity config check config/config.yaml
	@$(UNLOCK)
	$(SNAKEMAKE)
	$(SNAKEMAKE) --report results/default/report.html
	@echo "figures: results/default/figures; report: results/default/report.html"

paper: $(READY)  ## run the paper's sizes (committed under results/paper)
	$(BIN)/sensory-commutativity config check config/config.yaml config/paper.yaml
	@test -d results/paper/data || rm -rf results/paper  # the committed run, without its raw data, would look finished; git brings it back
	@$(UNLOCK)
	$(SNAKEMAKE) --configfile config/paper.yaml
	@$(UNLOCK)
	$(SNAKEMAKE) --configfile config/paper.yaml --report results/paper/report.html
	@echo "figures: results/paper/figures; report: results/paper/report.html"

reset-free: $(READY)  ## SC-experiments without a reset at the paper's sizes (committed under results/reset-free)
	@test -d results/reset-free/data || rm -rf results/reset-free  # as for the paper
	@$(UNLOCK)
	$(SNAKEMAKE) --configfile config/reset-free.yaml -- reset_free

atlas: $(READY)  ## SCP of 31 standard environments (two hours of a core)
	@$(UNLOCK)
	$(SNAKEMAKE) --configfile config/atlas.yaml -- atlas

gallery: $(READY)  ## SCP of ten public robots (an hour of a core; needs the extra gallery)
	@$(UNLOCK)
	$(SNAKEMAKE) --configfile config/gallery.yaml -- gallery

calibration: $(READY)  ## simulate the coverage of every interval and the level of every test (minutes)
	@$(UNLOCK)
	$(SNAKEMAKE) -- results/default/tables/calibration.parquet
	$(BIN)/python -c "import pandas; print(pandas.read_parquet('results/default/tables/calibration.parquet').to_string(index=False))"

flips: $(READY)  ## flip 1,000 bits in files of every kind: none may change a result unnoticed
	SENCOM_FLIPS=1000 $(BIN)/python -m pytest -q tests/adversarial/test_damage.py

bench: $(READY)  ## measure speed and print a table
	$(BIN)/python benchmarks/bench.py
	$(BIN)/python benchmarks/environments.py

scaling: $(READY)  ## measure what a second core gives, and what the workflow itself costs
	$(BIN)/python benchmarks/scaling.py

replay: $(READY)  ## play 1,000 SC-experiments of the apartment again and compare bit for bit
	$(BIN)/python benchmarks/replay.py

test: $(READY)  ## run all tests
	$(BIN)/python -m pytest --numprocesses 3 --dist loadscope  # a third, as the tests of Slurm mostly wait

coverage: $(READY)  ## branch coverage of all tests that do not run the workflow
	$(BIN)/python -m pytest --numprocesses 2 --dist loadscope --ignore=tests/workflow --cov --cov-report=term

lint: $(READY)  ## check style, types and the layers of the package
	$(BIN)/ruff check src tests benchmarks docs/_generate
	$(BIN)/ruff format --check src tests benchmarks docs/_generate
	$(BIN)/snakefmt --check workflow
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(READY)  ## rewrite code and workflow in that style
	$(BIN)/ruff check --fix src tests benchmarks docs/_generate
	$(BIN)/ruff format src tests benchmarks docs/_generate
	$(BIN)/snakefmt workflow

schema: $(READY)  ## rewrite config/schema.json after a change to the models of the configuration
	$(BIN)/sensory-commutativity config schema --out config/schema.json

docs: $(READY)  ## build the documentation site in build/site; warnings are errors
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo "site: build/site/index.html"

docs-serve: $(READY)  ## show the documentation site while you write it
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs serve

pages: $(READY)  ## rewrite what pages show of results/paper: the claims, and the outputs of the notebooks
	$(BIN)/python docs/_generate/results.py
	$(BIN)/python docs/_generate/run_notebooks.py

lock: $(READY)  ## pin the environment again (needs uv)
	uv pip compile -q --universal --no-header --python-version 3.11 pyproject.toml --extra workflow --extra slurm --extra environments --extra xacro --extra docs --extra test \
		--custom-compile-command "make lock" -o requirements.lock

clean:  ## remove the results of the default and test profiles
	rm -rf results/default results/test

help:  ## this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | column -t -s $$'\t'

# The environment. The stamp is made last, so that an interrupted installation starts again.
$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || \
		{ echo "Python 3.11 is needed, $(PYTHON) is another; set PYTHON=/path/to/python3.11" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	@touch $@
