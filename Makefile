# pivotgait: `make gait` runs the main job, `make test` the tests; both set up .venv when needed.
VENV := .venv
BIN := $(VENV)/bin
OUT := reports/out/knife
SOURCES := pivotgait tests analysis

# The first interpreter that really is Python 3.11 (every wheel this project needs exists for it).
PYTHON ?= $(shell for p in python3.11 python3 python; do \
	command -v $$p >/dev/null 2>&1 && $$p -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null \
	&& { command -v $$p; break; }; done)

.PHONY: gait test test-all lint format bench clean

gait: $(VENV)/.installed
	$(BIN)/pivotgait run knife --out $(OUT)

test: $(VENV)/.installed
	$(BIN)/pytest -n 2

test-all: $(VENV)/.installed
	$(BIN)/pytest -n 2 -m ""

lint: $(VENV)/.installed
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/mypy

format: $(VENV)/.installed
	$(BIN)/ruff check --fix $(SOURCES)
	$(BIN)/ruff format $(SOURCES)

bench: $(VENV)/.installed
	$(BIN)/pivotgait bench --quick

$(VENV)/.installed: pyproject.toml constraints.txt
	@test -n "$(PYTHON)" || { echo "pivotgait needs Python 3.11 and found none: install it, or name one with 'make PYTHON=path'." >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,mujoco]'
	@touch $@

clean:
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis
