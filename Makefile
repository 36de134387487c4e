# Needs python3 (3.11 or newer, with venv) and nothing else. Another interpreter: make PYTHON=python3.12 demo

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
PYTHON ?= python3
VENV ?= .venv
OUT ?= demo

BIN := $(VENV)/bin
# Python compiles what is imported; to compile all that is installed takes as long as installing it.
PIP := $(BIN)/python -m pip install -qq --no-compile --disable-pip-version-check --constraint constraints.txt
RUNTIME := $(VENV)/runtime.stamp
DEVELOPMENT := $(VENV)/development.stamp

TARGETS := help demo test claims soak bench map clean
.PHONY: $(TARGETS)

help:
	@echo "make demo               set up, compute the two example sweeps into $(OUT)/, print its time"
	@echo "make test               set up, then every check: rules, types, imports, tests, quick claims"
	@echo "make claims [NAME ...]  recompute what the project says about itself (a set, a claim, or all)"
	@echo "make soak [SEED=n]      what the queue says about itself, with other kills each time: half an hour and more"
	@echo "make bench [JSON=file]  measure speed (docs/speed.md); never part of pass or fail"
	@echo "make map                print rooms, arrows, floors, circles and lines of each package, and draw them"
	@echo "make clean              remove the environment, caches and the demo's results"

# The demo computes everything itself; the first time it compiles the kernels too.
demo: $(RUNTIME)
	@$(BIN)/whipple demo --out $(OUT)
	@echo "open $(OUT)/holes/report.html and $(OUT)/craters/report.html"

test: $(DEVELOPMENT)
	@$(BIN)/python -m tests

# "make claims first-light": the words after claims are names of sets or claims, not targets of its own.
ifeq (claims,$(firstword $(MAKECMDGOALS)))
NAME ?= $(filter-out $(TARGETS),$(wordlist 2,$(words $(MAKECMDGOALS)),$(MAKECMDGOALS)))
ifneq (,$(strip $(NAME)))
.PHONY: $(NAME)
$(NAME): claims
	@:
endif
endif

claims: $(DEVELOPMENT)
	@$(BIN)/python -m tests.claims $(NAME)

# The seed decides what is killed when; it is printed, and SEED= repeats it.
soak: $(DEVELOPMENT)
	@WHIPPLE_SEED=$${SEED:-$$RANDOM} $(BIN)/python -m tests.claims queue

bench: $(DEVELOPMENT)
	@$(BIN)/python -m tests.benchmarks $(if $(JSON),--json $(JSON))
	@$(BIN)/python -m tests.benchmarks.queue

map: $(DEVELOPMENT)
	@$(BIN)/python -m tests.house

clean:
	@rm -rf $(VENV) .cache build *.egg-info $(OUT)

# An environment that works is kept; one that is missing or too old is made anew.
$(RUNTIME): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "whipple needs Python 3.11 or newer, and $(PYTHON) is older: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(BIN)/python -c 'import sys, pip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || $(PYTHON) -m venv --clear $(VENV)
	@echo "setting up $(VENV) ..."
	@begin=$$SECONDS; $(PIP) --editable . && echo "set up in $$((SECONDS - begin)) s"
	@touch $@

$(DEVELOPMENT): $(RUNTIME)
	@echo "adding the tools of the checks ..."
	@$(PIP) --editable '.[dev]'
	@touch $@
