# Needs python3 (3.11 or newer, with venv) and nothing else. Another interpreter: make PYTHON=python3.12 demo

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
PYTHON ?= python3
VENV ?= .venv
OUT ?= demo

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install -qq --disable-pip-version-check
# uv installs in a tenth of the time of pip, which installs where uv cannot: uv does not read the settings of pip.
# Its argument has no comma, at which make would cut it: several extras get a name in pyproject.toml.
INSTALL = { { test -x $(BIN)/uv || $(PIP) uv; } && $(BIN)/uv pip install --quiet --python $(BIN)/python --constraint constraints.txt $(1); } \
	2> $(VENV)/uv.log || $(PIP) --constraint constraints.txt $(1)
COMPILING := numba numpy scipy pyyaml
RUNTIME := $(VENV)/runtime.stamp
DEVELOPMENT := $(VENV)/development.stamp
CLAIMS := $(VENV)/claims.stamp

TARGETS := help demo demo-full docs test pythons claims soak bench release clean
.PHONY: $(TARGETS)

help:
	@echo "make demo               set up, compute two example sweeps into $(OUT)/, print its time"
	@echo "make demo-full          compute every example that ships, into $(OUT)-full/"
	@echo "make docs               build the documentation, with the pages that are made, into build/site"
	@echo "make test               set up, then every check: rules, types, imports, tests"
	@echo "make pythons            the same with each supported Python, in an environment of its own"
	@echo "make claims [NAME ...]  recompute what the project says about itself (a set, a claim, or all)"
	@echo "make soak [SEED=n]      what the queue says about itself, with other kills each time: half an hour and more"
	@echo "make bench [JSON=file]  measure speed (docs/speed.md); never part of pass or fail"
	@echo "make release VERSION=n  version, changelog and citation, wheel, image and tag of a release"
	@echo "make clean              remove the environment, caches and the demo's results"

# The demo computes everything itself.
demo: $(RUNTIME)
	@$(BIN)/whipple demo --out $(OUT)
	@echo "open $(OUT)/shield.html, $(OUT)/holes/report.html and $(OUT)/craters/report.html"

demo-full: $(RUNTIME)
	@$(BIN)/whipple demo --all --out $(OUT)-full

test: $(DEVELOPMENT)
	@$(BIN)/python -m tests

# A Python that is missing: pip install uv, then uv python install 3.13 (or pyenv install 3.13).
pythons:
	@for version in 3.11 3.12 3.13; do \
		echo "--- Python $$version"; $(MAKE) --no-print-directory test PYTHON=python$$version VENV=$(VENV)-$$version; done

# "make claims house": the words after claims are names of sets or claims, not targets of its own. NAME of the
# environment is none of ours: make hands it on to whatever it starts, and some shells set it to that of the machine.
# There is a set "docs" too.
ifeq (claims,$(firstword $(MAKECMDGOALS)))
NAME = $(filter-out $(filter-out docs,$(TARGETS)),$(wordlist 2,$(words $(MAKECMDGOALS)),$(MAKECMDGOALS)))
ifneq (,$(strip $(NAME)))
.PHONY: $(NAME)
$(NAME): claims
	@:
endif
else
# Strictly: a link that leads nowhere ends it.
docs: $(DEVELOPMENT)
	@$(BIN)/python -m mkdocs build --quiet --strict
	@echo "open build/site/index.html"
endif

claims: $(CLAIMS)
	@$(BIN)/python -m tests.claims $(NAME)

# The seed decides what is killed when; it is printed, and SEED= repeats it.
soak: $(DEVELOPMENT)
	@WHIPPLE_SEED=$${SEED:-$$RANDOM} $(BIN)/python -m tests.claims queue

bench: $(DEVELOPMENT)
	@$(BIN)/python -m tests.benchmarks $(if $(JSON),--json $(JSON))
	@$(BIN)/python -m tests.benchmarks.queue

# Nothing is uploaded. IMAGE=no: where there is neither docker nor podman.
release: $(DEVELOPMENT)
	@$(BIN)/python -m docs.release $(VERSION) $(if $(filter no,$(IMAGE)),--without-image)

clean:
	@rm -rf $(VENV) $(VENV)-3.* .cache .grimp_cache .hypothesis build *.egg-info $(OUT) $(OUT)-full

# An environment that works is kept; one that is missing or too old is made anew. The kernels of the demo, which most
# scenarios share, are compiled while the other libraries are installed.
$(RUNTIME): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "whipple needs Python 3.11 or newer, and $(PYTHON) is older: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(BIN)/python -c 'import sys, pip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || $(PYTHON) -m venv --clear $(VENV)
	@echo "setting up $(VENV) ..."
	@begin=$$(date +%s); $(call INSTALL,$(COMPILING)); \
		$(BIN)/python -m studies.sweeps.kernels holes craters > $(VENV)/kernels.log 2>&1 & \
		$(call INSTALL,--editable .); wait; echo "set up in $$(($$(date +%s) - begin)) s"
	@touch $@

$(DEVELOPMENT): $(RUNTIME)
	@echo "adding the tools of the checks ..."
	@$(call INSTALL,--editable '.[dev]')
	@$(BIN)/whipple schema | tee $(addsuffix /sweep.schema.json,$(wildcard studies/*/examples)) > /dev/null
	@touch $@

$(CLAIMS): $(DEVELOPMENT)
	@echo "adding the libraries of the claims ..."
	@$(call INSTALL,--editable '.[claims]')
	@touch $@
