# Everything a fresh machine needs: python3 (3.11 or newer, with its venv module) and make.
#   make setup      environment in .venv with the `caramelo` command (the other targets call it when needed)
#   make demo       walks the robot up stairs in the simulator, in space if that is installed; results in out/demo
#   make test       linter, type checker and all tests; what is skipped is listed with what to install for it
#   make check      linter, type checker and the tests of what has been changed, in about a minute
#   make renew      writes all that is generated, and the budgets of costs and sizes, from the sources as they are
#   make docs       builds the documentation site in out/site, and checks its links, commands, files and quotes
#   make core       compiles the control core for this computer: ten times as fast (needs a C compiler)
#   make setup-pi   what a Raspberry Pi runs, without simulator, firmware tools and tests
#   make wheel      a wheel with the core compiled for this computer, in dist; without it: pip wheel --no-deps .
#   make lock       writes constraints.txt again from pyproject.toml (needs the network)
#   make pi-wheels  checks that all a Pi runs is to be had as aarch64 wheels (needs the network)

PYTHON ?= python3
EXTRAS ?= sim,space,lab,web,record,foxglove,firmware,docs,test
# Of each of the two runs of tests, as many as there are cores: with more, emulated servos come too late for the bus.
JOBS ?= $(shell getconf _NPROCESSORS_ONLN)
COMPILE ?= --compile
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --disable-pip-version-check
comma := ,
STAMP := .venv/.setup-$(subst $(comma),-,$(EXTRAS))

.PHONY: setup setup-pi demo test check renew docs core wheel lock pi-wheels clean
.DELETE_ON_ERROR:

setup: $(STAMP)

# Whatever comes from a package index has the hash that constraints.txt says; the project itself is built with what is
# installed by then.
$(STAMP): pyproject.toml constraints.txt .ci/requirements.py
	@command -v $(PYTHON) >/dev/null || { echo "make setup: $(PYTHON) not found: install Python 3.11 or newer, or name one: make setup PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "make setup: $$($(PYTHON) -V 2>&1) is too old: 3.11 or newer is needed, name one: make setup PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "make setup: $(PYTHON) comes without its venv module: on Debian, apt-get install python3-venv" >&2; exit 1; }
	@$(BIN)/python -c '' 2>/dev/null || $(PYTHON) -m venv --clear .venv
	$(BIN)/python .ci/requirements.py '$(EXTRAS)' > .venv/requirements.txt
	@echo "make setup, 1 of 2: the packages it needs; pip says nothing while it installs what has come"
	$(PIP) $(COMPILE) --require-hashes --requirement .venv/requirements.txt
	@echo "make setup, 2 of 2: caramelo itself"
	$(PIP) --quiet --no-deps --no-build-isolation --editable .
	@touch $@

setup-pi:
	@$(MAKE) --no-print-directory setup EXTRAS=web,record,pi

demo:
	@$(MAKE) --no-print-directory setup EXTRAS=sim,space,web COMPILE=--no-compile
	$(BIN)/caramelo walk --in $$($(BIN)/python -c 'import mujoco' 2>/dev/null && echo space || echo plane) --speed 0.15 \
		--terrain stairs-up --height 0.03 --length 0.35 --out out/demo

# Hundreds of processes start, and each would compile its modules again where the environment says to keep no bytecode.
test check: export PYTHONDONTWRITEBYTECODE =

test: setup
	@$(BIN)/python .ci/test.py $(BIN) $(JOBS)

check: setup
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest -n $(JOBS) $$($(BIN)/python .ci/touched.py)

# A change of a cost is decided: look at what this changes before it is committed.
renew: setup
	$(BIN)/python -m host.boards.build.tables
	$(BIN)/python -m host.protocol.generate
	$(BIN)/python -m host.boards.build.sizes
	$(BIN)/caramelo bench --update-budget

docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	$(BIN)/pytest tests/test_docs.py

core:
	@$(MAKE) --no-print-directory setup EXTRAS=$(EXTRAS),compile
	$(BIN)/caramelo core build

wheel:
	@$(MAKE) --no-print-directory setup EXTRAS=$(EXTRAS),compile
	CARAMELO_WHEEL=compiled $(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .

lock:
	@$(MAKE) --no-print-directory setup EXTRAS=$(EXTRAS),lock
	$(BIN)/python .ci/lock.py

pi-wheels: setup
	$(BIN)/python .ci/pi_wheels.py

clean:
	rm -rf .venv out build *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
