# Every target sets up what it needs: Python 3.11 or newer, make and pip are enough.

PYTHON ?= $(shell python3.11 -c '' 2>/dev/null && echo python3.11 || echo python3)
VENV := .venv
PY := $(VENV)/bin/python
READY := $(VENV)/.ready
DOCS := $(VENV)/.ready-docs
INSTALL = -m pip install --disable-pip-version-check --no-compile --quiet
FREEZE = -m pip freeze --disable-pip-version-check --exclude-editable

# What in models/ is not the declaration of a machine.
NOT_MODELS := models/__init__.py models/__main__.py
MODELS = $(filter-out $(NOT_MODELS) $(wildcard models/_*.py),$(sort $(wildcard models/*.py))) $(SPACE) $(HARD)
SPACE = $(sort $(shell grep -l '^model = ' models/space/*.py))
# The hard cases' folder holds their declarations and what runs them.
HARD = $(sort $(shell grep -l '^model = ' models/hard/*.py))
SCRIPTS = runtime/show/animation/page
NOTEBOOKS = $(sort $(wildcard notebooks/*.ipynb))

WORKERS ?= 2
PYTEST = -m pytest -n $(WORKERS)

DEMO = $(PY) -m models.studies compressor
FIGURES = $(PY) -m models.studies --only-figures
BENCH = $(PY) -m benchmarks

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help install demo compiled test test-oldest lint format types imports check build gallery \
	figures hard notebooks docs docs-links bench lock clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

install: $(READY) ## set up .venv from the locked versions

# A change of the requirements brings the environment up to date; a second call does nothing.
$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Linkwright needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Name one: make PYTHON=/path/to/python3.11")'
	@echo "Setting up $(VENV) with $(PYTHON); this takes about a minute." >&2
	@$(PYTHON) -m venv $(VENV)
	@$(PY) $(INSTALL) --constraint constraints.txt --editable '.[all]'
	@touch $@

demo: $(READY) ## build the compressor, simulate it, print the table, draw into figures/
	$(DEMO)

# Collecting imports what the tests import.
compiled: $(READY) ## compile the runtime into numba's cache, where it is not there yet
	$(PY) -m runtime.precompile
	$(PY) -m pytest --collect-only -qq

test: $(READY) ## run the tests; every warning is an error
	$(PY) $(PYTEST)

.venv-oldest/.ready: pyproject.toml constraints-oldest.txt
	@$(PYTHON) -m venv .venv-oldest
	@.venv-oldest/bin/python $(INSTALL) --constraint constraints-oldest.txt --editable '.[all]'
	@touch $@

test-oldest: .venv-oldest/.ready ## run the tests with the lowest versions that pyproject.toml allows
	.venv-oldest/bin/python $(PYTEST)

lint: $(READY) ## formatting and lint rules, of Python and of the player's script
	@status=0; \
	$(PY) -m ruff format --check . || status=1; \
	$(PY) -m ruff check . || status=1; \
	$(VENV)/bin/oxlint --deny-warnings $(SCRIPTS) || status=1; \
	exit $$status

format: $(READY) ## bring the files into the form that `make lint` asks for
	$(PY) -m ruff format .
	$(PY) -m ruff check --fix .

types: $(READY) ## mypy --strict over codegen and runtime, and over benchmarks
	$(PY) -m mypy

imports: $(READY) ## who may import whom
	$(VENV)/bin/lint-imports

# One process builds all the models, whose texts must be those of the list of checksums.
check: $(READY) ## is what is written from the source what the source says today?
	@test -n "$(MODELS)" || { echo "models/ declares no machine" >&2; exit 1; }
	@failed=; \
	$(PY) -W error docs/make_checksums.py --check $(MODELS) || failed="$$failed generated"; \
	$(PY) -m codegen elements --out docs/elements --check || failed="$$failed docs/elements"; \
	$(PY) -m codegen methods --check || failed="$$failed methods"; \
	$(PY) docs/make_constants.py --check || failed="$$failed docs/reference/constants.md"; \
	$(PY) docs/make_schemas.py --check || failed="$$failed docs/schema"; \
	$(PY) docs/make_modules.py --check || failed="$$failed docs/development/modules.md"; \
	$(PY) docs/make_command_line.py --check || failed="$$failed docs/reference/command-line.md"; \
	if [ -n "$$failed" ]; then echo "stale or failing:$$failed; run make build and look at the difference" >&2; exit 1; fi

build: $(READY) ## bring all that is written from the source up to date
	$(PY) docs/make_checksums.py $(MODELS)
	$(PY) -m codegen elements --out docs/elements
	$(PY) -m codegen methods
	$(PY) docs/make_constants.py
	$(PY) docs/make_modules.py
	$(PY) docs/make_schemas.py
	$(PY) docs/make_command_line.py

gallery: $(READY) ## run every machine of the chapter: one table, all figures into figures/
	$(PY) -m models.studies --gallery docs/gallery/book.md

figures: $(READY) ## draw the book's figures into figures/
	$(FIGURES)

hard: $(READY) ## run every hard case by every method and write benchmarks/results/hard-cases.md
	$(PY) -m models.hard $(CASES)

notebooks: $(READY) ## run every notebook from top to bottom
	@set -e; for notebook in $(NOTEBOOKS); do \
		echo $$notebook; $(VENV)/bin/jupyter-execute --inplace $$notebook; \
	done

$(DOCS): $(READY)
	@$(PY) $(INSTALL) --constraint constraints.txt --editable '.[docs]'
	@touch $@

# Some fifty processes import the same packages, whose byte code is kept whatever the shell says.
docs: export PYTHONDONTWRITEBYTECODE =
docs: $(DOCS) ## build the site into docs/_build/html; every warning is an error
	$(PY) -m runtime.precompile
	$(PY) -m sphinx --jobs $(WORKERS) --fail-on-warning --keep-going -b html docs docs/_build/html

docs-links: $(DOCS) ## try the links of the site to other places, which needs a network
	$(PY) -m sphinx -b linkcheck docs docs/_build/links

bench: $(READY) ## measure
	$(BENCH)

lock: ## resolve every requirement anew and write constraints.txt
	$(PYTHON) -m venv --clear .venv-lock
	.venv-lock/bin/python $(INSTALL) --editable '.[all,docs]'
	{ echo '# Written by `make lock`: the versions that `make` installs.'; \
	  .venv-lock/bin/python $(FREEZE); } > constraints.txt.new
	mv constraints.txt.new constraints.txt
	rm -rf .venv-lock

clean: ## remove the environments, the caches and what the targets wrote
	rm -rf .venv .venv-* .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis \
		build dist docs/_build docs/elements/pictures docs/gallery/pages docs/notebooks figures results
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
