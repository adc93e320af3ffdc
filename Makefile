# The front door. Every target first does whatever set-up it needs; `make` alone lists them.
BIN := .venv/bin
SCENE ?= kb/scenes/hans.json
WORKERS ?= 2
# In the order of tests/conftest.py; of itself it would begin with the files that have most tests.
PYTEST := $(BIN)/pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder
# What `make setup` brings: every command works with it, and nothing takes long to install.
EXTRAS := --extra mesh --extra rdf --extra server
LOCK := UV_CUSTOM_COMPILE_COMMAND="make lock" uv pip compile --quiet --universal --python-version 3.11 \
	--generate-hashes --fork-strategy fewest pyproject.toml

.PHONY: help setup demo shell doctor test test-long bench coverage check lint rules page pictures wheel lock clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' Makefile

setup: .venv/.runtime ## .venv with Deixis in it, and SWI-Prolog

demo: .venv/.runtime ## the paper's Figure 3: its relations, and why they hold
	@$(BIN)/deixis demo

shell: .venv/.runtime ## Prolog with SCENE=kb/scenes/hans.json loaded
	@$(BIN)/deixis shell $(SCENE)

doctor: .venv/.runtime ## is everything here that Deixis needs?
	@$(BIN)/deixis doctor

test: check ## everything: the checks, then all tests, doctests and notebooks
	$(PYTEST)

test-long: .venv/.dev ## the tests that take minutes
	$(PYTEST) -m long --hypothesis-profile=long

# clingo and Nemo are measured too where the dependency group `bench` is installed.
bench: .venv/.dev ## measure it beside others and write kb/benchmarks.md (minutes)
	PYTHONPATH=tests $(BIN)/python -m bench.run kb/benchmarks.md

coverage: .venv/.dev ## Table 1 of the paper in PostGIS, written to kb/coverage.md (minutes)
	PYTHONPATH=tests $(BIN)/python -m bench.coverage kb/coverage.md

check: lint rules ## what takes seconds: lint, and the rules with their own tests

lint: .venv/.dev ## style, types, layers
	$(BIN)/ruff check --quiet .
	$(BIN)/ruff format --quiet --check .
	$(BIN)/mypy --no-error-summary
	$(BIN)/lint-imports --no-cache --no-logo

rules: .venv/.dev ## load every rule file without a warning and run its PlUnit tests
	swipl --on-error=status --on-warning=status -p deixis=rules -g main tests/rules/run.pl

page: .venv/.runtime ## the pages of `deixis view` and `deixis serve` (npm)
	@sh .ci/page.sh

pictures: .venv/.dev page ## the README's pictures of the page, taken anew (Chromium)
	$(BIN)/python tests/screenshots.py

wheel: .venv/.dev page ## dist/: the source archive and the wheel
	$(BIN)/python -m build --no-isolation

lock: ## pin the requirements anew (needs uv)
	$(LOCK) $(EXTRAS) --group build --output-file requirements.txt
	$(LOCK) --all-extras --group dev --constraint requirements.txt --output-file requirements-dev.txt

clean: ## remove all that make made, .venv included
	rm -rf .venv build dist src/deixis/*/page/vendor .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find src tests -name __pycache__ -prune -exec rm -rf {} +

.venv/.runtime: pyproject.toml requirements.txt .ci/setup.sh
	@sh .ci/setup.sh requirements.txt
	@touch $@

.venv/.dev: requirements-dev.txt .venv/.runtime
	@sh .ci/setup.sh requirements-dev.txt
	@touch $@
