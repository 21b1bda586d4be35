# trueloop's commands. `make help` lists them; each sets up what it needs.
SHELL := /bin/bash
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

VENV := .venv
UV := $(VENV)/bin/uv
RUN := $(VENV)/bin/
SETUP := $(VENV)/.ready
RUST_SOURCES := $(shell find crates -name '*.rs' -o -name Cargo.toml) Cargo.toml Cargo.lock
PART ?= modbas2

.PHONY: help demo test test-corpus check format bench setup clean

help: ## list the targets
	@awk -F':.*## ' '/^[a-z-]+:.*## / { printf "  %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(UV):
	python3 -m venv $(VENV) || { echo "a virtual environment cannot be made: on Debian run  apt-get install python3-venv"; exit 1; }
	$(VENV)/bin/pip install --quiet 'uv>=0.5'

$(SETUP): pyproject.toml uv.lock $(RUST_SOURCES) | $(UV)
	@command -v cargo >/dev/null || { echo "cargo is missing: install a Rust toolchain, https://rustup.rs"; exit 1; }
	VIRTUAL_ENV=$(abspath $(VENV)) $(UV) sync --frozen --inexact --reinstall-package trueloop --quiet
	@touch $@

setup: $(SETUP) ## the environment and the Rust core

demo: $(SETUP) ## the main job: touches of a semi-finished part to a corrected finish program, in out/
	$(RUN)trueloop demo $(PART)

clean: ## remove everything that can be made again
	rm -rf $(VENV) target out build
