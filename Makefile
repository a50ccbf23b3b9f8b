# `make setup` needs Python 3.11 or newer with venv and pip, and nothing else.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# The tests start many interpreters: without bytecode each compiles every module again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup demo room test test-long test-all lint types layers docs docs-links bench wheel c-kernels lock clean
.DELETE_ON_ERROR:

# Bytecode of what is used is made at its first import, in a third of the time of all that there is.
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile

setup: $(STAMP)

$(STAMP): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "vividc needs Python 3.11 or newer; '$(PYTHON)' is $$($(PYTHON) --version 2>&1)." >&2; \
	  echo "hint: make setup PYTHON=python3.12" >&2; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) --require-hashes -r requirements.lock
	$(PIP) --no-deps --no-build-isolation -e .
	$(BIN)/python -m vividc.cli.ship
	@touch $@

demo: setup
	$(BIN)/python -m benchmarks.demo

# One room's tests: `make test ROOM=mapper`, `make test-all ROOM=ssa/rewrite`.
TESTS := tests$(if $(ROOM),/$(ROOM))
PYTEST := $(BIN)/python -m pytest -q -n 2 --dist worksteal

room:
	@test -d '$(TESTS)' || { echo "There is no room $(TESTS)/. ROOM is one of:" >&2; \
	  (cd tests && find . -mindepth 2 -name 'test_*.py') | sed 's|^\./||; s|/[^/]*$$||' | sort -u | xargs >&2; exit 1; }

test: room setup
	$(PYTEST) -m "not slow and not long" $(TESTS)

# Tests that take more than half a second: five in a hundred, and half of the time of all.
test-long: setup
	$(PYTEST) -m long $(shell cut -d: -f1 tests/long.txt | uniq)

test-all: room setup
	$(PYTEST) $(TESTS)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: setup
	$(BIN)/mypy

layers: setup
	$(BIN)/lint-imports

bench: setup
	$(BIN)/python -m benchmarks -o benchmarks

# A release: the wheel in dist/, with the renderers' kernels compiled. Built in a copy: the backend
# leaves build/ and *.egg-info beside pyproject.toml, and reuses stale ones.
DIST := dist
COPY := build/wheel

wheel: setup
	rm -rf $(COPY) && mkdir -p $(COPY) $(DIST)
	tar --exclude=./.git --exclude=./.venv --exclude=./build --exclude=./dist --exclude='*.egg-info' \
	  --exclude=./scenes -cf - . | tar -xf - -C $(COPY)
	$(BIN)/python -m vividc.render.array.device.ship $(COPY)/vividc/programs
	$(BIN)/python -m vividc.cli.ship $(COPY)/vividc/objects
	$(BIN)/python -m build --wheel --no-isolation --outdir $(DIST) $(COPY) >$(COPY).log 2>&1 || \
	  { cat $(COPY).log; exit 1; }
	@ls $(DIST)/*.whl

# The committed `.ll` files; Debian's clang, version 15 or newer. Users never need it.
CLANG ?= clang-16
C_FLAGS := -O1 -g -fno-jump-tables -fdebug-compilation-dir=. -emit-llvm -S

c-kernels:
	cd kernels/c && for file in *.c; do $(CLANG) $(C_FLAGS) $$file -o $${file%.c}.ll || exit 1; done
	cd tests/frontend/c && for file in *.c; do \
	  $(CLANG) -w -O1 -ffp-contract=off -fno-jump-tables -emit-llvm -S $$file -o $${file%.c}.ll || exit 1; done

# The site, in build/site: warnings are errors, and its notebooks run.
DOCS_STAMP := $(VENV)/.docs-installed

$(DOCS_STAMP): $(STAMP) requirements-docs.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	@touch $@

docs: $(DOCS_STAMP)
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going -b html -c docs/site docs build/site
	@echo "written: build/site/index.html"

docs-links: $(DOCS_STAMP)
	$(BIN)/python -m sphinx --quiet -b linkcheck -c docs/site docs build/links

# For maintainers; users never need uv.
lock:
	uv pip compile pyproject.toml --extra dev --generate-hashes --no-emit-index-url --universal \
	  --python-version 3.11 --quiet --output-file requirements.lock
	uv pip compile pyproject.toml --extra dev --extra docs --constraint requirements.lock --generate-hashes \
	  --no-emit-index-url --universal --python-version 3.11 --quiet --output-file requirements-docs.lock

clean:
	rm -rf $(VENV) build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -not -path './.git/*' -prune -exec rm -rf {} +
