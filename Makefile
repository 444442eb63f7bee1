# One way in, for people and for CI. Everything is installed into .venv from the lock files, by uv,
# which pip brings where it is missing; what is installed already is not installed again.
#
#   make run ARGS="--port 8123 --no-open"    start the visualiser
#   make install                             what the tests need, into .venv
#   make test                                every check and every test, the browser's too
#   make check                               the same without the browser
#   make quick ARGS=tests/abi/test_kernels.py    some tests at once; without ARGS, most of them
#   make thorough                            make test with more examples and all scenes, as once a night
#   make coverage                            the lines that make check's tests leave out
#   make test-wheel                          build the wheel, install it elsewhere, plan with it
#   make test-lowest                         the fast tests with the oldest dependencies allowed
#   make test-newest                         the same with the newest
#   make docs                                the documentation, into docs/_build/html
#   make pictures                            take the pictures of README and documentation anew
#   make bench ARGS="quality --scenes 10"    measure speed and quality, beside peers where installed
#   make attack ARGS="--messages 10000"      malformed messages to one tab while another works on
#   make fuzz ARGS="--files 200"             hostile meshes, arms and scenes to the reader of files
#   make soak ARGS="--minutes 1"             thirty tabs that drag and play, one of them frozen
#   make restarts ARGS="--kills 20"          kill and start the server under a tab, lose nothing
#   make poses ARGS="--steps 300"            choose scenes and arms at random: all is where it is planned
#   make format                              format the code and mend what the linter can mend
#   make lock                                lock the dependencies (ARGS=--upgrade: the newest)
#   make clean                               remove what make made

BIN := .venv/bin
RUN := .venv/.installed-run
DEV := .venv/.installed-dev
DOCS := .venv/.installed-docs
# else each process that a test starts compiles all modules anew
unexport PYTHONDONTWRITEBYTECODE

PARALLEL := --numprocesses auto --dist loadfile --durations 60 --durations-min 1
PYTEST := $(BIN)/pytest $(PARALLEL)
COMPILE := $(BIN)/uv pip compile pyproject.toml --no-config --no-header --quiet \
	--universal --python-version 3.11 --fork-strategy fewest --no-strip-extras --generate-hashes

.PHONY: run install test check thorough quick coverage test-wheel test-lowest test-newest tests kernels modules lint style types docs pictures thumbnails bench attack fuzz soak restarts poses format lock clean
.DEFAULT_GOAL := run

$(RUN): requirements.lock pyproject.toml tools/install
	@tools/install requirements.lock
	@touch $@

$(DEV): requirements-dev.lock pyproject.toml tools/install
	@tools/install requirements-dev.lock
	@touch $(RUN) $@

$(DOCS): requirements-docs.lock pyproject.toml tools/install
	@tools/install requirements-docs.lock
	@touch $(RUN) $@

run: $(RUN)
	@$(BIN)/abi serve $(ARGS)

install: $(DEV)

READY := $(MAKE) --jobs=2 style kernels $(if $(ARGS),,modules)
# types are checked while browsers wait
BESIDE := $(MAKE) --jobs=2 types

test: $(DEV)
	$(READY)
	tools/chromium
	tools/nginx
	$(BESIDE) tests

check: $(DEV)
	$(READY)
	$(BESIDE) tests MARKED='-m "not browser"'

tests: $(DEV)
	$(PYTEST) $(MARKED) $(ARGS)

# without CI, hypothesis tries others each time
thorough: $(DEV)
	$(READY)
	tools/chromium
	tools/nginx
	env -u CI ABI_THOROUGH=1 $(BESIDE) tests

# one file is done before the workers have started
quick: $(DEV)
	$(BIN)/ruff check --quiet $(filter %.py,$(ARGS))
	$(BIN)/pytest --quiet -m "not browser and not slow" $(if $(ARGS),$(ARGS),$(PARALLEL))

coverage: $(DEV)
	$(PYTEST) -m "not browser" --cov --cov-report term $(ARGS)

test-wheel: $(DEV)
	tools/test-wheel $(BIN)/python

test-lowest test-newest: test-%: $(DEV)
	tools/unlocked $* $(ARGS)

docs: $(DOCS)
	$(BIN)/sphinx-build --fail-on-warning --keep-going --quiet docs docs/_build/html $(ARGS)
	@echo "The documentation is at docs/_build/html/index.html"

pictures: $(DEV)
	tools/chromium
	$(BIN)/python -m tools.pictures $(ARGS)

thumbnails: $(DEV)
	$(BIN)/python -m tools.thumbnails $(ARGS)

kernels: $(DEV)
	$(BIN)/python -c "import abi; abi.compile(spare=1)"

# once, instead of in each worker at the same time: the tests' modules, and those they import
modules: $(DEV)
	@$(BIN)/pytest --quiet --quiet --collect-only >/dev/null || true  # what fails there fails the tests

lint: style types

style: $(DEV)
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/lint-imports --no-cache

types: $(DEV)
	nice $(BIN)/mypy

bench: $(DEV)
	@$(BIN)/python -m app bench $(ARGS)

attack: $(DEV)
	@$(BIN)/python -m benchmarks.attack $(ARGS)

fuzz: $(DEV)
	@$(BIN)/python -m benchmarks.fuzz $(ARGS)

soak: $(DEV)
	@$(BIN)/python -m benchmarks.soak $(ARGS)

restarts: $(DEV)
	tools/chromium
	@$(BIN)/python -m benchmarks.restarts $(ARGS)

poses: $(DEV)
	tools/chromium
	@$(BIN)/python -m benchmarks.poses $(ARGS)

format: $(DEV)
	$(BIN)/ruff format
	$(BIN)/ruff check --fix
	$(BIN)/python -m tools.documented_tables

lock: $(DEV)
	$(COMPILE) --group build $(ARGS) --output-file requirements.lock
	$(COMPILE) --group dev --extra notebook --extra sweep --constraint requirements.lock $(ARGS) --output-file requirements-dev.lock
	$(COMPILE) --group docs --constraint requirements-dev.lock $(ARGS) --output-file requirements-docs.lock
	@! grep -nE '://|^ *-[^-]|^--' requirements*.lock || \
		{ echo "A lock file names a place; it may only hold names, versions and hashes." >&2; exit 1; }

clean:
	rm -rf .venv .mypy_cache .pytest_cache .ruff_cache .hypothesis .coverage dist docs/_build docs/gallery docs/api/*.rst docs/data/*.svg
	find abi abi_sweep app tests -name __pycache__ -type d -prune -exec rm -rf {} +
