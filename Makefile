# trueloop's commands. `make help` lists them; each sets up what it needs.
SHELL := /bin/bash
MAKEFLAGS += --no-print-directory
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/
PLACE := $(VENV)/.place
SETUP := $(VENV)/.ready
RUST_SOURCES := $(shell find crates -name '*.rs' -o -name '*.tsv' -o -name Cargo.toml) Cargo.toml Cargo.lock
PYTHON_SOURCES := $(shell find src/trueloop -path src/trueloop/manual -prune -o -name '*.py*' -not -name '*.pyc' -print)
SHAPES := web/src/api/shapes.ts
WEB_SOURCES := $(filter-out $(SHAPES),$(shell find web -path web/node_modules -prune -o -type f -print))
NODE_PACKAGES := web/node_modules/.package-lock.json
SHAPES_CHECKED := web/node_modules/.shapes
PAGES := src/trueloop/pages/index.html
MANUAL := src/trueloop/manual/index.html
MANUAL_SOURCES := $(wildcard docs/* docs/*/* scripts/*.py scripts/manual/* scripts/manual/*/*) ARCHITECTURE.md CHANGELOG.md CONTRIBUTING.md
PART ?= modbas2

JOURNEYS := self finished certificate
SEED := 1
PARTS :=

# One more than there are cores: tests that wait for LinuxCNC or a browser leave theirs to another.
WORKERS := $(shell echo $$(( $$(nproc) + 1 )))

# Tests start hundreds of Python processes: each would compile all that it imports anew.
unexport PYTHONDONTWRITEBYTECODE

# Tests run side by side: threads of the linear algebra under them would only get in each other's way.
test test-corpus: export OMP_NUM_THREADS := 1

.PHONY: help demo demo-surface demo-memory demo-realtime demo-factory docs web wheel wheels test test-corpus test-journeys studies check format bench fuzz miri setup clean

help: ## list the targets
	@awk -F':.*## ' '/^[a-z-]+:.*## / { printf "  %-14s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

# The scripts of a virtual environment name its folder: in a clone that was moved it is made anew.
ifneq ($(file < $(PLACE)),$(CURDIR))
.PHONY: $(PLACE)
endif
$(PLACE):
	@scripts/require-tools.sh $(PYTHON)
	@rm -rf $(VENV)
	@$(PYTHON) -m venv $(VENV)
	@$(RUN)python -m pip install --quiet --disable-pip-version-check 'uv>=0.5'
	@printf '%s' '$(CURDIR)' > $@

$(SETUP): $(PLACE) pyproject.toml uv.lock $(RUST_SOURCES)
	@echo "setting up: Python packages and the Rust core"
	@UV_PROJECT_ENVIRONMENT=$(VENV) UV_PYTHON_DOWNLOADS=never $(RUN)uv sync --quiet --frozen --inexact --reinstall-package trueloop
	@touch $@

setup: $(SETUP) ## the environment and the Rust core

$(NODE_PACKAGES): web/package.json web/package-lock.json
	@scripts/require-node.sh
	@cd web && npm ci --silent
	@touch $@

# The shapes follow from the service's code. They keep their time where they come out equal: nothing is built anew.
$(SHAPES_CHECKED): $(SETUP) $(NODE_PACKAGES) $(PYTHON_SOURCES) scripts/web_shapes.py
	@$(RUN)python -m scripts.web_shapes
	@touch $@
$(SHAPES): $(SHAPES_CHECKED) ;

$(PAGES): $(SHAPES) $(WEB_SOURCES)
	@echo "building the pages of the service"
	@cd web && npm run --silent build -- --logLevel warn

web: $(PAGES) ## the pages of the service, built with Node into src/trueloop/pages

$(MANUAL): $(SETUP) $(MANUAL_SOURCES) $(PYTHON_SOURCES)
	@$(RUN)python -m scripts.manual

docs: $(MANUAL) ## the manual as a site that `trueloop docs` shows, in src/trueloop/manual, with the pages that follow from the code

wheel: $(SETUP) $(PAGES) $(MANUAL) ## what other computers install, in dist/: needs neither Rust nor Node there
	@$(RUN)maturin build --release --locked --quiet --out dist
	@ls dist/*.whl

wheels: $(SETUP) $(PAGES) $(MANUAL) ## the same for Linux (glibc 2.28, musl; x86_64, aarch64), macOS and Windows, in dist/
	@scripts/debian-packages.sh gcc-mingw-w64-x86-64-posix
	@UV_PROJECT_ENVIRONMENT=$(VENV) UV_PYTHON_DOWNLOADS=never $(RUN)uv sync --quiet --frozen --inexact --group wheels
	@scripts/wheels.sh

demo: $(SETUP) ## the main job: touches of a semi-finished part to a corrected finish program, in out/
	@$(RUN)trueloop demo $(PART)

demo-surface: $(SETUP) ## a surface: ten measured parts to a corrected STEP surface and program, in out/surface
	@$(RUN)trueloop surface compensate examples/surface/surface.toml

demo-memory: $(SETUP) ## memory of an edge: ten parts of NIST's metal, each predicted from those before it, in out/memory
	@OMP_NUM_THREADS=1 $(RUN)python -m studies.nist_memory

demo-realtime: $(SETUP) ## LinuxCNC turns a part on a virtual lathe that warms up, without and with the corrector, in out/realtime
	@scripts/debian-packages.sh linuxcnc-uspace linuxcnc-uspace-dev
	@OMP_NUM_THREADS=2 $(RUN)trueloop realtime demo

demo-factory: $(SETUP) $(PAGES) ## LinuxCNC, service and pages: ten parts made unattended, a chip and a stop decided in the browser, in out/factory
	@scripts/debian-packages.sh linuxcnc-uspace linuxcnc-uspace-dev chromium
	@OMP_NUM_THREADS=1 $(RUN)python -m scripts.factory_demo

test: $(SETUP) $(PAGES) $(MANUAL) ## all tests; installs the Debian packages they need where it may, else prints the line to run
	@scripts/debian-packages.sh linuxcnc-uspace linuxcnc-uspace-dev chromium libgl1 libx11-6 postgresql mosquitto nginx-light openssl
	cargo test --quiet --locked --workspace --exclude trueloop-python --tests
	$(RUN)python -m pytest -n $(WORKERS) --dist worksteal -m 'not corpus'

test-corpus: $(SETUP) ## the tests on real programs and measurements: make test-corpus CORPUS=DIR, where DIR/data is
	@[ -d '$(CORPUS)/data' ] || { echo "CORPUS='$(CORPUS)' holds no folder data/: make test-corpus CORPUS=DIR" >&2; exit 1; }
	@scripts/debian-packages.sh linuxcnc-uspace linuxcnc-uspace-dev chromium libgl1 libx11-6 postgresql nginx-light openssl
	$(RUN)python -m pytest -n $(WORKERS) --dist worksteal -m corpus --corpus='$(CORPUS)'

test-journeys: $(SETUP) ## a simulated shop that shares nothing with the product drives the command line: JOURNEYS='self finished', PARTS=4, SEED=1
	for one in $(JOURNEYS); do \
	    $(RUN)python tests/journeys/shop.py $$one --trueloop '$(abspath $(RUN)trueloop)' --seed $(SEED) $(if $(PARTS),--parts $(PARTS)) || exit 1; \
	done

studies: $(SETUP) ## what each study measures: make studies; one of them: make studies STUDY=memory_study
	@$(if $(STUDY),$(RUN)python -m studies.$(STUDY),for file in studies/*_study.py studies/simulator_families.py; do \
	    printf '%s: %s\n' "$$(basename $$file .py)" "$$(head -n 1 $$file | tr -d '"')"; done)

check: $(SETUP) ## lint, format, types, import direction, stubs of the Rust core, lock files
	$(RUN)ruff check --quiet
	$(RUN)ruff format --check --quiet
	$(RUN)mypy --no-error-summary
	$(RUN)lint-imports --no-logo > $(VENV)/lint-imports.txt || { cat $(VENV)/lint-imports.txt; exit 1; }
	$(RUN)stubtest --concise --allowlist <(echo 'trueloop\._core\.__all__') trueloop._core # PyO3 makes __all__ by itself
	cargo fmt --all --check
	cargo clippy --quiet --locked --workspace --all-targets -- -D warnings
	scripts/check-files.sh

format: $(SETUP) ## put Python and Rust into the one format
	$(RUN)ruff check --fix --quiet
	$(RUN)ruff format --quiet
	cargo fmt --all

bench: $(SETUP) ## ours beside what a user would pick instead, as ratios; KEEP=1 keeps them for docs/performance.md
	@UV_PROJECT_ENVIRONMENT=$(VENV) UV_PYTHON_DOWNLOADS=never $(RUN)uv sync --quiet --frozen --inexact --group bench
	@for bench in $(filter-out ratio nc_rivals,$(basename $(notdir $(wildcard benches/*.py)))); do \
	    KEEP=$(KEEP) $(RUN)python -m benches.$$bench || exit 1; done

SECONDS ?= 60
fuzz: ## readers of NC programs and images under cargo-fuzz (installed if need be), and 1,000 corrections: make fuzz SECONDS=60
	@scripts/fuzz.sh $(SECONDS)

miri: ## the real-time core, its C interface among it, under miri, which is installed if need be
	@cargo +nightly miri --version > /dev/null 2>&1 || rustup toolchain install nightly --profile minimal --component miri
	cargo +nightly miri test --quiet --locked --target-dir target/miri --package rtec --features c-library

clean: ## remove everything that can be made again
	rm -rf $(VENV) target out build dist .*_cache .hypothesis web/node_modules src/trueloop/pages src/trueloop/manual
