# One command each: make run | quick | test | check | clean. Needs python3 (3.11 or newer) and make.
# The environment is built from requirements.lock, and rebuilt whenever that file changes.

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.ONESHELL:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV ?= .venv
CORES ?= 2
bin := $(VENV)/bin
stamp := $(VENV)/.lock-$(shell sha256sum requirements.lock | cut -c1-16)

# one thread a job in BLAS; Snakemake gives the jobs theirs
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
export PYTHONPATH := src
# a cached kernel does not notice an edit of what it calls elsewhere: a cache for each state of them
export NUMBA_CACHE_DIR ?= $(CURDIR)/.numba/$(shell cat src/softsample/fem/*.py src/softsample/constitutive/*.py src/softsample/constitutive/laws/*.py | sha256sum | cut -c1-16)
unexport VIRTUAL_ENV

.PHONY: help env run quick new-study add-sample check-study study extended docs site test test-study test-long check bench bench-solver bench-imaging bench-laws bench-scale verify undeclared second-cohort second-cohort-records blind blind-foreign blind-measured blind-full \
	measured known-effects measured-docs format clean clean-env

help:
	@echo "make run        the study: every sample at 0.5 mm, tables, figures, results/report.html"
	echo "make quick      the same at 1 mm, for a look in minutes, into results-quick/"
	echo "make new-study DIR=lab    a study folder of your own, with a worked sample"
	echo "make add-sample DIR=lab IMAGE=scan.nii.gz RECORD=test.csv MODE=compression   a sample of yours"
	echo "     without an image: SHAPE=cylinder DIAMETER=20 HEIGHT=10 (mm), or SURFACE=scan.stl, in its place"
	echo "make check-study DIR=lab  everything that is wrong or doubtful with it"
	echo "make study DIR=lab        its report (CONFIG=config/quick.yaml: at 1 mm, in minutes)"
	echo "make docs       docs/reproduction.md and docs/recovery.md, tables and figures as they came out"
	echo "make site       the documentation as a site: results/site/index.html"
	echo "make extended   what takes longer: free exponents, a simulation per evaluation, effects of shape"
	echo "make test       unit, verification, regression and workflow tests"
	echo "make test-study  tests that run small studies, to their reports"
	echo "make test-long  all tests, those that take minutes each too"
	echo "make check      ruff, snakefmt, mypy, snakemake --lint"
	echo "make bench      bench-solver (speed of the solver, into results/bench/) and bench-imaging"
	echo "make bench-scale  what 1,000 samples take on 2, 64 and 1,024 cores, by the study in results/: docs/cluster.md"
	echo "make verify     the solver against exact solutions and other solvers: docs/verification.md"
	echo "make bench-imaging  accuracy of segmentation and mesh on synthetic images: docs/accuracy.md"
	echo "make bench-laws  elastic laws recovered from records that CalculiX made: docs/law_recovery.md"
	echo "make undeclared records with undeclared effects, from image to scored verdict: results/undeclared/"
	echo "make second-cohort  the second virtual cohort, from image to score, and docs/second_cohort.md: results/second-cohort/"
	echo "make second-cohort-records  its images, records and truth recomputed (CalculiX): resources/second-cohort/"
	echo "make blind      the loop on records with undeclared effects, scored: results/blind/"
	echo "make blind-foreign the same with errors of other families, sizes not told: results/blind-*/"
	echo "make blind-measured  the same with misfits of make measured: results/blind-measured/"
	echo "make blind-full the same at four sizes and three designs, fewer of each: results/blind-full/"
	echo "make measured   studies of public measured sets, if their files are there: results/measured/ (SETS=\"...\": only these)"
	echo "make known-effects  known effects on top of their records, scored: results/known/score.csv"
	echo "make measured-docs  the same, and docs/measured.md as it came out"
	echo "make format     let ruff and snakefmt rewrite the sources"
	echo "make clean      remove results (clean-env: the environment)"

env: $(stamp)

$(stamp):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "softsample needs Python 3.11 or newer; give one with: make PYTHON=python3.12 ..." >&2; exit 1; }
	echo "Building $(VENV) from requirements.lock (a minute or two, once) ..."
	# of an activated environment that is to be replaced, the interpreter behind it
	python=$$($(PYTHON) -c 'import sys; print(getattr(sys, "_base_executable", sys.executable))')
	rm -rf $(VENV)
	"$$python" -m venv $(VENV)
	$(bin)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(bin)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

run: $(stamp)
	@$(bin)/python -m softsample run --cores $(CORES)

quick: $(stamp)
	@$(bin)/python -m softsample run --quick --cores $(CORES)

# refuses a missing value, such as the folder of a study
given = $(foreach name,$(1),$(if $($(name)),,$(error name it: make $@ $(name)=...)))

new-study: $(stamp)
	@$(call given,DIR)
	$(bin)/python -m softsample new "$(DIR)"

# what the row of the sample may hold besides, as options of the command; of the shell's environment,
# where GROUP is another thing, none is taken
cells := IMAGE SURFACE SHAPE LENGTH WIDTH HEIGHT DIAMETER SAMPLE GROUP SPECIMEN ENDS FORMAT CYCLE \
  INDENTER INDENTER_RADIUS MATERIAL_Z MATERIAL_X LOADING_AXIS SHEAR_AXIS SEGMENTATION BOND_MASK LABELS
option = $(shell echo $(1) | tr A-Z_ a-z-)

add-sample: $(stamp)
	@$(call given,DIR RECORD MODE)
	$(bin)/python -m softsample add "$(DIR)" --mode "$(MODE)" --record "$(RECORD)" \
	  $(foreach cell,$(cells),$(if $(and $(filter command,$(origin $(cell))),$($(cell))),--$(call option,$(cell))="$($(cell))"))

check-study: $(stamp)
	@$(call given,DIR)
	$(bin)/python -m softsample check "$(DIR)"

study: $(stamp)
	@$(call given,DIR)
	$(bin)/python -m softsample run "$(DIR)" $(if $(CONFIG),--settings "$(CONFIG)") --cores $(CORES)

docs: $(stamp)
	$(bin)/snakemake --cores $(CORES) reproduction
	rm -rf docs/data/reproduction docs/figures/reproduction
	cp -R results/docs/. docs/
	find docs '(' -name .snakemake_timestamp -o -name '.*.sha256' ')' -delete

site: $(stamp)
	rm -rf docs/generated
	$(bin)/python -m sphinx --quiet --fail-on-warning -b html docs results/site
	echo "Site: results/site/index.html"

extended: $(stamp)
	$(bin)/snakemake --cores $(CORES) extended

in_parallel = -n $(CORES) --dist loadfile --no-loadscope-reorder

test: $(stamp)
	$(bin)/python -m pytest -m "not long and not study" $(in_parallel)
	NUMBA_DISABLE_JIT=1 $(bin)/python -m pytest -q -m nojit tests/verification

test-study: $(stamp)
	$(bin)/python -m pytest -m "study and not long" $(in_parallel)

test-long: $(stamp)
	$(bin)/python -m pytest

check: $(stamp)
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/snakefmt --check Snakefile workflow/Snakefile workflow/rules
	$(bin)/mypy
	$(bin)/snakemake --lint

bench: bench-solver bench-imaging

bench-solver: $(stamp)
	$(bin)/python benchmarks/solver.py results/bench/solver.json

verify: $(stamp)
	$(bin)/python benchmarks/verification.py

undeclared: $(stamp)
	$(bin)/snakemake --cores $(CORES) verdicts results/undeclared/scoring/verdicts.csv \
	  --configfile config/undeclared.yaml
	$(bin)/python -c "import pandas as pd; print(pd.read_csv('results/undeclared/scoring/verdicts.csv').to_string())"

# the page compares it with the first
second-cohort: $(stamp)
	$(bin)/snakemake --cores $(CORES) score results/tables/loop.csv
	$(bin)/snakemake --cores $(CORES) score laws results/second-cohort/tables/loop.csv \
	  --configfile config/second_cohort.yaml
	$(bin)/python benchmarks/second_cohort_page.py

second-cohort-records: $(stamp)
	CORES=$(CORES) $(bin)/python benchmarks/second_cohort.py

blind: $(stamp)
	$(bin)/snakemake --cores $(CORES) blind --configfile config/blind.yaml

blind-foreign: $(stamp)
	$(bin)/snakemake --cores $(CORES) blind_foreign --configfile config/blind.yaml

# misfits of the measured sets, whose results are there
blind-measured: $(stamp)
	$(bin)/snakemake --cores $(CORES) blind_measured --configfile config/blind.yaml

blind-full: $(stamp)
	$(bin)/snakemake --cores $(CORES) blind_full --configfile config/blind.yaml

# every study is run by the ordinary workflow; one that fails does not stop the others
measured: $(stamp)
	@studies=$$($(bin)/python -m softsample.measured "$${SOFTSAMPLE_MEASURED_ROOT:-resources/measured}" results/measured/studies $(SETS))
	failed=
	while IFS= read -r study; do
	  name=$${study##*/}
	  echo "Study $$name"
	  $(bin)/python -m softsample run "$$study" --results "results/measured/$$name" --cores $(CORES) \
	    --target verdicts --target reported < /dev/null || failed="$$failed $$name"
	done <<< "$$studies"
	$(bin)/python -m softsample.measured.summary results/measured
	if [ -n "$$failed" ]; then echo "Did not come through:$$failed" >&2; exit 1; fi

# effects that are known, on top of records of the measured sets, whose results are there
KNOWN := ecoflex-phantoms-sliding cmc-cryogel-sliding blood-clot-direction-sliding
known-effects: $(stamp)
	@$(bin)/python -m softsample.measured.known results/measured results/known $(or $(SETS),$(KNOWN)) |
	while IFS= read -r study; do
	  $(bin)/python -m softsample run "$$study" --results "results/known/results/$${study##*/}" \
	    --cores $(CORES) --target verdicts < /dev/null || true
	done
	$(bin)/python -m softsample.measured.known results/measured results/known

measured-docs: measured
	rm -rf docs/data/measured docs/figures/measured
	cp -R results/measured/docs/. docs/
	find docs '(' -name .snakemake_timestamp -o -name '.*.sha256' ')' -delete

bench-imaging: $(stamp)
	$(bin)/python benchmarks/imaging.py results/bench/imaging.json
	$(bin)/python benchmarks/imaging_page.py results/bench/imaging.json

bench-laws: $(stamp)
	CORES=$(CORES) $(bin)/python benchmarks/laws.py

bench-scale: $(stamp)
	$(bin)/python benchmarks/scale.py results results/bench/scale.json
	$(bin)/python benchmarks/scale_page.py results/bench/scale.json

format: $(stamp)
	$(bin)/ruff check --fix .
	$(bin)/ruff format .
	$(bin)/snakefmt Snakefile workflow/Snakefile workflow/rules

clean:
	rm -rf results results-quick logs .snakemake .numba

clean-env:
	rm -rf $(VENV)
