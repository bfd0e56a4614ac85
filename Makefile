# Two commands matter: `make run` and `make test`. Each works alone on a fresh clone.
CASE ?= gu2021-beehive
# An interpreter asked for by name, and the lowest versions allowed, have an environment of their own.
VENV := .venv$(if $(PYTHON),-$(notdir $(PYTHON)))$(if $(LOWEST),-lowest)
BIN  := $(VENV)/bin
# One thread per worker: runs are parallel over cases and tests, never inside one.
ONE_THREAD := PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1
OF_THE_PACKAGE := --ignore=tests/development --ignore=tests/examples --ignore=tests/browser
PYTEST := $(ONE_THREAD) $(BIN)/python -m pytest -n auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder

export PYTHON VENV LOWEST

.PHONY: help run test test-fast test-processor test-development test-docs test-browser test-slow test-long validate validate-all bench identify uncertainty lint docs pins clean environment-run environment-test parts mutants faults guides workbench

help:
	@echo "make run       set up, then run the published study CASE=$(CASE): table and report"
	@echo "make test      set up, then run the tests (PYTHON=python3.12: by that interpreter; LOWEST=1: with the lowest versions allowed)"
	@echo "make test-fast ROOM=springs  the tests that a change of one room (folder of src/valvetrain) can break, about a minute (ARGS=\"--list\")"
	@echo "make test-processor  tests of limits and orders as another processor would round (OPENBLAS_CORETYPE=Prescott)"
	@echo "make test-development  benchmarks, scripts, faults and seeded faults run with their smallest inputs"
	@echo "make test-browser  pages and workbench, looked at in a browser"
	@echo "make test-docs the programs and commands of README, documentation and examples"
	@echo "make test-slow the tests of more than five seconds, which make test leaves out"
	@echo "make test-long the tests that check many inputs where a shorter one checks one (some minutes)"
	@echo "make validate  the rows of the validation book but those of whole studies (some minutes)"
	@echo "make validate-all  the whole validation book (docs/validation.md) and the long checks over every case (hours)"
	@echo "make docs      the documentation site in build/docs, gallery run, any warning a failure"
	@echo "make bench     measure the speed of the main parts"
	@echo "make identify  re-run the identification of the published case's unpublished numbers"
	@echo "make uncertainty  error bars of the published case anew; after make identify or a change of the rod"
	@echo "make lint      size of each folder (budget.toml), style and format (ruff), types (mypy) of the package, benchmarks, scripts, faults and mutants"
	@echo "make mutants   seed faults into copies of the source and tell the share that the tests notice (ARGS=\"--changed\": lines changed since main, a minute; ARGS=\"--sample 40\")"
	@echo "make faults    kill commands, fill disks, damage files and cases, attack a workbench for ten minutes (ARGS=\"--seed 2 --minutes 5\")"
	@echo "make workbench  measure the workbench in a browser, and its longer tests: finite elements, both widths"
	@echo "make guides    draw the pictures of docs/how-to anew and compute every number of the guides"
	@echo "make pins      resolve the pinned versions anew (needs a network)"
	@echo "make clean     remove the environment, caches and results"

environment-run:
	@bash scripts/environment.sh run

environment-test:
	@bash scripts/environment.sh test

parts:
	@bash scripts/system_parts.sh

run: environment-run
	$(BIN)/valvetrain run $(CASE)

test: environment-test parts
	$(PYTEST) -m "not slow" $(OF_THE_PACKAGE) -o junit_family=xunit1 --junitxml=build/tests/all.xml $(ARGS)

test-slow: environment-test parts
	$(PYTEST) -m slow $(OF_THE_PACKAGE) -o junit_family=xunit1 --junitxml=build/tests/slow.xml $(ARGS)

test-fast: environment-test
	$(ONE_THREAD) $(BIN)/python scripts/test_fast.py $(ROOM) $(ARGS)

validate: environment-test parts
	VALVETRAIN_LONG=1 $(PYTEST) tests/published/test_book.py tests/unit/test_book_command.py $(ARGS)

validate-all: environment-test parts
	$(ONE_THREAD) $(BIN)/python -m validation --page docs/validation.md
	VALVETRAIN_LONG=1 VALVETRAIN_ALL=1 nice env $(PYTEST) --dist load -m long tests/contracts/test_one_way_to_a_case.py \
		tests/limits/test_lift_files_with_known_answers.py tests/limits/test_tester_files.py tests/limits/test_meshes.py $(ARGS)

docs: environment-test parts
	$(ONE_THREAD) $(BIN)/python -m sphinx -b html -n -W --keep-going -q -d build/doctrees docs build/docs
	@echo "build/docs/index.html"

bench: environment-run
	$(ONE_THREAD) $(BIN)/python -m benchmarks $(ARGS)

identify: environment-run
	$(BIN)/python -m pip install -qq --no-input --no-deps --no-build-isolation -e examples/beehive
	$(BIN)/valvetrain identify examples/beehive/identify.toml --limit "12 h" $(ARGS)

uncertainty: environment-run
	$(BIN)/python scripts/write_uncertainty.py $(CASE) $(ARGS)

lint: environment-test
	$(BIN)/python scripts/count_source.py --check
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

mutants: environment-test
	nice $(BIN)/python -m mutants $(ARGS)

faults: environment-test
	$(ONE_THREAD) nice $(BIN)/python -m faults $(ARGS)
	VALVETRAIN_LONG=1 nice env $(PYTEST) tests/unit/test_study_dask.py

# Another processor rounds elsewhere: the tests of limits and orders with the kernels of OpenBLAS for one from 2004.
test-processor: environment-test
	OPENBLAS_CORETYPE=Prescott $(PYTEST) -m "not chromium and not calculix" tests/order tests/limits $(ARGS)

# Benchmarks, scripts, faults and seeded faults, each with its smallest input; test by test, as one file takes most of the time.
test-development: environment-test
	$(PYTEST) --dist worksteal tests/development $(ARGS)

# Programs and commands of README, docs and examples.
test-docs: environment-test parts
	$(PYTEST) tests/examples $(ARGS)

# Pages and workbench as a person sees them, in Chromium.
test-browser: environment-test parts
	$(PYTEST) tests/browser $(ARGS)

test-long: environment-test parts
	VALVETRAIN_LONG=1 $(PYTEST) -m long $(ARGS)

workbench: environment-test parts
	$(BIN)/python scripts/measure_workbench.py $(ARGS)
	VALVETRAIN_LONG=1 $(PYTEST) tests/browser/test_workbench_browser.py

guides: environment-test parts
	$(ONE_THREAD) nice $(BIN)/python scripts/write_pages.py how-to
	VALVETRAIN_LONG=1 nice env $(PYTEST) tests/examples/test_how_to.py

pins:
	@bash scripts/pins.sh

clean:
	rm -rf .venv .venv-* build docs/api docs/gallery docs/commands.rst docs/quantities.md docs/plausible.md docs/defaults.md docs/error-bars.md dist runs src/valvetrain.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .numba_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
