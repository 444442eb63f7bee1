# One way in, for people and for CI. Everything is installed into .venv from the lock files, by uv
# when it is there and by pip otherwise; what is installed already is not installed again.
#
#   make run ARGS="--port 8123 --no-open"    start the visualiser
#   make test                                every check and every test, the browser's too
#   make check                               the same without the browser
#   make bench ARGS="quality --scenes 10"    measure speed and quality, beside peers where installed
#   make format                              format the code and mend what the linter can mend
#   make lock                                lock the dependencies (ARGS=--upgrade: the newest)
#   make clean                               remove what make made

BIN := .venv/bin
RUN := .venv/.installed-run
DEV := .venv/.installed-dev
PYTEST := $(BIN)/pytest --numprocesses auto --dist loadgroup
COMPILE := $(BIN)/uv pip compile pyproject.toml --no-config --no-header --quiet \
	--universal --python-version 3.11 --fork-strategy fewest --generate-hashes

.PHONY: run test check lint bench format lock clean
.DEFAULT_GOAL := run

$(RUN): requirements.lock pyproject.toml tools/install
	@tools/install requirements.lock
	@touch $@

$(DEV): requirements-dev.lock pyproject.toml tools/install
	@tools/install requirements-dev.lock
	@touch $(RUN) $@

run: $(RUN)
	@$(BIN)/abi serve $(ARGS)

test: lint
	tools/chromium
	$(PYTEST) $(ARGS)

check: lint
	$(PYTEST) -m "not browser" $(ARGS)

lint: $(DEV)
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy

bench: $(DEV)
	@$(BIN)/python -m app bench $(ARGS)

format: $(DEV)
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

lock: $(DEV)
	$(COMPILE) --group build $(ARGS) --output-file requirements.lock
	$(COMPILE) --group dev --constraint requirements.lock $(ARGS) --output-file requirements-dev.lock
	@! grep -nE '://|^ *-[^-]|^--' requirements.lock requirements-dev.lock || \
		{ echo "A lock file names a place; it may only hold names, versions and hashes." >&2; exit 1; }

clean:
	rm -rf .venv .mypy_cache .pytest_cache .ruff_cache .hypothesis dist
	find abi app tests -name __pycache__ -type d -prune -exec rm -rf {} +
