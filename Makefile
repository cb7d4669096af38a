# make demo    an arch comes to equilibrium; everything needed is installed into .venv first
# make test    the test suite without the tests that are marked slow: five to ten minutes on two cores
# make test-all  all of it: what CI runs
# make test-kernels  tests that rounding could decide, once more with other machine code of OpenBLAS
# make lint    what CI checks besides the tests
# make docs    the user guide in docs/_build; a warning is an error
# make wheel   the package in dist/, tried in an environment of its own
# make format  put the sources in the house format
# make clean   remove results and caches;  make distclean: .venv too

.PHONY: help demo test test-all test-kernels lint docs wheel format clean distclean

BIN := .venv/bin
PYTEST_ARGS ?=
export PYTHON

# Two processes that keep a file's tests together, so that what they share is made once.
TWO := -n 2 --dist worksteal
# One thread a process: small blocks gain nothing from more.
ONE_THREAD := OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MKL_NUM_THREADS=1
# Some kernels that are asked for crash without this on some processors, see tests/kernels.py.
ASKED := OPENBLAS_L2_SIZE=512

help:
	@sed -n 's/^# make /make /p' Makefile

.venv/.demo: pyproject.toml tools/prepare
	@sh tools/prepare fenicsx,gmsh,pictures
	@touch $@

.venv/.test: pyproject.toml tools/prepare
	@sh tools/prepare fenicsx,gmsh,pictures,movies,browser,dxf,test
	@touch $@ .venv/.demo

.venv/.docs: pyproject.toml tools/prepare
	@sh tools/prepare fenicsx,gmsh,pictures,docs
	@touch $@ .venv/.demo

demo: .venv/.demo
	$(BIN)/masonry-fem run demos/arch.toml --out results/arch

test: .venv/.test
	$(if $(OPENBLAS_CORETYPE),$(ASKED)) $(ONE_THREAD) $(BIN)/python -m pytest $(TWO) -m "not slow" $(PYTEST_ARGS)

test-all: .venv/.test
	$(if $(OPENBLAS_CORETYPE),$(ASKED)) $(ONE_THREAD) $(BIN)/python -m pytest $(TWO) $(PYTEST_ARGS)

# The suite runs with the code that OpenBLAS picks for the processor; this selection with another one,
# where there is one that the processor can run.
ROUNDED := tests/validation tests/extremes tests/nscd/test_turns.py

test-kernels: .venv/.test
	@$(BIN)/python -m tests.kernels
	@other=$$($(BIN)/python -m tests.kernels --other) && \
	if [ -z "$$other" ]; then echo "test-kernels: skipped, no second kernel can be had here"; else \
	echo "test-kernels: $(ROUNDED) with OPENBLAS_CORETYPE=$$other" && \
	OPENBLAS_CORETYPE=$$other $(ASKED) $(ONE_THREAD) $(BIN)/python -m pytest $(TWO) $(PYTEST_ARGS) $(ROUNDED); fi

lint: .venv/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: .venv/.docs
	$(BIN)/sphinx-build -W --keep-going -q docs docs/_build

wheel: .venv/.demo
	@sh tools/try_wheel

format: .venv/.test
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf results dist docs/_build docs/demos docs/sg_execution_times.rst .pytest_cache .mypy_cache .ruff_cache .hypothesis .benchmarks .import_linter_cache
	find masonry_fem tests demos benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf .venv
