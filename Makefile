# Two commands do everything on a fresh machine: `make demo` and `make test`.
# Each makes its own .venv by the standard library; README shows the same steps without make.
PYTHON ?= python3
BIN = .venv/bin
WORKERS ?= auto

.PHONY: demo test docs fuzz soak lowest mutation coverage lint typing check clean

demo: .venv/user
	$(BIN)/baroarma demo --out demo

test: .venv/dev
	$(BIN)/python -m pytest -n $(WORKERS)

docs: .venv/dev
	$(BIN)/sphinx-build -W --keep-going -n -q docs build/docs

# Beside the gate, which runs short versions of the first two.
fuzz: .venv/dev
	$(BIN)/python -m pip install --quiet -e '.[fuzz]'
	$(BIN)/python tests/fuzz/fuzz.py --runs 100000 --seed 1

soak: .venv/dev
	$(BIN)/python benchmarks/soak.py

# All tests with the oldest versions that pyproject.toml allows of what it names, in a .venv of their own.
LOWEST = .venv-lowest/bin
lowest: .venv-lowest/test
	NUMBA_CACHE_DIR=$(CURDIR)/.venv-lowest/numba $(LOWEST)/python -m pytest -n $(WORKERS)

mutation: .venv/dev
	$(BIN)/python benchmarks/mutation.py

# What is compiled can't be seen: the kernels' tests run once more as plain Python, slow ones not to their end.
KERNELS = tests/estimators tests/identification/test_arma_kernels.py tests/identification/test_kernels.py
coverage: .venv/dev
	$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest -n $(WORKERS)
	-NUMBA_DISABLE_JIT=1 $(BIN)/coverage run -m pytest -q -n $(WORKERS) --timeout 20 $(KERNELS)
	$(BIN)/coverage combine
	$(BIN)/coverage report

lint: .venv/dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

typing: .venv/dev
	rm -rf build/lib build/typing
	$(BIN)/python -m pip install --quiet --no-deps --upgrade --target build/typing .
	$(BIN)/mypy

check: lint typing test

.venv/bin/python:
	$(PYTHON) -m venv .venv

.venv/user: .venv/bin/python pyproject.toml setup.cfg
	$(BIN)/python -m pip install --quiet -e .
	touch $@

.venv/dev: .venv/bin/python pyproject.toml setup.cfg
	$(BIN)/python -m pip install --quiet -e '.[dev]'
	touch .venv/user $@

.venv-lowest/test: pyproject.toml setup.cfg
	$(PYTHON) -m venv --clear .venv-lowest
	$(LOWEST)/python -m pip install --quiet uv
	$(LOWEST)/uv pip install --quiet --python $(LOWEST)/python --resolution lowest-direct -e '.[test]'
	touch $@

clean:
	rm -rf .venv .venv-lowest build demo *.egg-info
