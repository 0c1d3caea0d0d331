# The commands of RigLens. Each one does all the set-up it needs by itself.
#
#   make run      open the window (without a display: scores in the terminal, files under out/)
#   make test     the whole test suite, headless
#   make slow     the tests that take minutes
#   make test-detect  what needs PyTorch, with its CPU build (190 MB to fetch, 700 MB in .venv)
#   make test-devkit  simulated data sets in nuScenes' own development kit (100 MB to fetch, into build/devkit)
#   make fuzz     broken input for everything that reads (FUZZ="--count 1000000 --seed 2"), crashes kept in out/fuzz
#   make restless 5,000 random actions in the window: does memory stay bounded? (RESTLESS="--count 1000 --seed 2")
#   make mutation small mistakes in core: which ones does no test notice? (MUTATION="--count 100 --seed 1 --rooms core/engine")
#   make stress   the test suite on a computer with four times more work than processors
#   make bench    speed and memory against yardsticks, into out/bench.json (BENCH="--quick --only edit")
#   make docs     the pages of docs/ as a site with search, in build/site
#   make check    format, lint, types, import contracts, wording
#   make setup    the set-up alone: system libraries and packages in .venv
#   make format   rewrite the sources in the project's format
#   make clean    remove .venv, out/ and caches

PYTHON := .venv/bin/python
WHOLE_SUITE := -m "not slow" -n logical --maxprocesses 4 --dist worksteal
TEST_HELPERS = $(shell find tests -name "*.py" ! -name "test_*.py")
.DEFAULT_GOAL := help
.PHONY: help setup setup-dev run test test-detect test-devkit slow fuzz restless mutation stress bench docs check format clean

help:
	@sed -n 's/^#   make/  make/p' Makefile

setup:
	@tools/setup.sh run

setup-dev:
	@tools/setup.sh test

run: setup
	@$(PYTHON) -m app

test: setup-dev
	@$(PYTHON) -m pytest $(WHOLE_SUITE)

test-detect: setup-dev
	@$(PYTHON) -c "import torch" 2>/dev/null || $(PYTHON) tools/install_torch.py
	@$(PYTHON) -m pytest tests/core/detect tests/core/study/detection tests/riglens/studies/test_detection.py

# The kit asks for numpy 1: it is laid beside the packages, without what it asks for.
DEVKIT := nuscenes-devkit==1.2.0 pyquaternion==0.9.9 cachetools shapely descartes opencv-python-headless scikit-learn \
	narwhals joblib threadpoolctl tqdm fire termcolor pycocotools parameterized

test-devkit: setup-dev
	@test -d build/devkit/nuscenes || $(PYTHON) -m pip install --quiet --no-deps --target build/devkit $(DEVKIT)
	@PYTHONPATH=build/devkit $(PYTHON) -m pytest tests/core/simulate/test_devkit.py tests/core/detect/test_precision.py

stress: setup-dev
	@$(PYTHON) tools/beside_spinners.py $(PYTHON) -m pytest $(WHOLE_SUITE)

slow: setup-dev
	@$(PYTHON) -m pytest -m slow

fuzz: setup-dev
	@QT_QPA_PLATFORM=offscreen $(PYTHON) -m tests.fuzz $(FUZZ)

restless: setup-dev
	@xvfb-run -a -s "-screen 0 1600x1000x24" $(PYTHON) -m tests.restless $(RESTLESS)

mutation: setup-dev
	@$(PYTHON) -m tests.mutation $(MUTATION)

bench: setup-dev
	@$(PYTHON) -m pytest tests/bench/bench_*.py -q --benchmark-quiet $(BENCH)

docs: setup
	@$(PYTHON) -c "import mkdocstrings, material" 2>/dev/null || $(PYTHON) -m pip install --quiet --editable ".[docs]"
	@$(PYTHON) -m tools.build_docs

check: setup
	@$(PYTHON) -m ruff format --check .
	@$(PYTHON) -m ruff check .
	@$(PYTHON) -m mypy -p riglens
	@$(PYTHON) -m mypy $(TEST_HELPERS)
	@.venv/bin/lint-imports
	@$(PYTHON) tools/check_words.py

format: setup
	@$(PYTHON) -m ruff check --fix --exit-zero --quiet .
	@$(PYTHON) -m ruff format .

clean:
	rm -rf .venv out dist build .pytest_cache .hypothesis .benchmarks .mypy_cache .ruff_cache .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
