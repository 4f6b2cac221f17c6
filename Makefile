# SPDX-License-Identifier: BSD-3-Clause
# make demo     build into .venv, export a four-bar, simulate its FMU, plot the results
# make extras   fetch the optional packages: sweeps, tables, import of URDF files, films
# make test     check formatting, run the linters and the tests that take a quarter of an hour on two processors in all
# make tidy     run clang-tidy on everything, as CI does; FILES=src/event_driven: on these files only, each on its own
# make lint     the checks of make test and make tidy, without running any tests
# make format   format all code
# make pytest   run the tests only; one file: make pytest TESTS=tests/test_layout.py
# make thorough run the longer tests that CI also runs, seven minutes on two processors: many seeds, killed writers, random scenes in all ways
# make studies  run the tests that take half an hour; weekly
# make reductions  measure the gain of each reduction: tables of docs/reductions.md
# make charts   measure the methods: charts and tables of docs/work-precision.md and docs/stability.md
# make accuracy  measure the errors of adaptive integrators against their tolerance: docs/accuracy.md; QUICK=1: a subset
# make nonsmooth  measure dry friction, hard limits, contacts, cone solvers: docs/nonsmooth-measurements.md, docs/cone-solvers.md; QUICK=1: a subset
# make gallery  draw the pictures of docs/gallery and write its list
# make tutorial  draw the figures of docs/tutorial-*.md
# make coupling  measure laws that a master closes around an FMU: docs/coupling.md
# make batches    measure steps of instances that step together: table of docs/batches.md
# make real-time  measure control loops that step FMUs: table of docs/real-time.md
# make growth   measure how cost scales with the size of a scene: table of docs/performance.md
# make bench    benchmark kernels and runs against other engines: docs/performance.md; QUICK=1: a subset
# make costs    update the reference evaluation and instruction counts: tests/costs/figures.json; WHY="..."
# make clocks   run the timing tests, on an otherwise idle machine
# make special  compare computation paths at special configurations: all families, 2000 random mechanisms
# make thrown   simulate 3000 random scenes of thrown bodies with contacts at located events; COUNT=... other numbers
# make agreement  run 20000 random scenes in which everything non-smooth meets, each in several ways; TRIALS=... other numbers
# make masters  run the shipped scenes in third-party masters and VDMCheck: table of docs/fmu.md; needs Maven, Java and cargo
# make sanitize run the FMU under AddressSanitizer, UBSan, ThreadSanitizer and Valgrind
# make units    compile and run the native unit tests, tests/native, under AddressSanitizer and UBSan if the compiler has them; CI does so, too
# make mutants  change thresholds, guards and fall-backs at random, and see whether tests notice; COUNT=40, SEED=1
# make fuzz     fuzz the readers of scenes and saved states with libFuzzer, SECONDS_EACH=600; needs clang
# make states   regenerate the fuzzers' seeds of FMU states, after the contents of a state have changed
# make runtimes  build the FMU runtimes for other platforms with Zig, and install them as gelenk-runtimes; needs cargo; QUICK=1: not optimized; COMPARE=1: only linux64, to compare compilers
# make page-core  build the core as WebAssembly with Zig, for pages of `gelenk view` that compute, and install it; needs cargo
# make wheels   build the wheels of gelenk: build/wheels; those for other platforms after make runtimes
# make platforms  run FMUs on Windows (Wine) and ARM (QEMU), as far as these are installed, and inspect the libraries; after make runtimes
# make lock     resolve the newest versions of all requirements: requirements.lock
# make lowest   run the tests of the package with the lowest versions of its requirements
# make clean    remove everything that was built
# PYTHON=... selects the interpreter; otherwise a Python >= 3.12 is searched for. Everything else comes from PyPI.
# LOCKED=1 installs the versions in requirements.lock, verified by their hashes, instead of the newest ones.
# JOBS=... is how many compilers and tests run at once; otherwise one for each processor, as far as memory allows.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
.NOTPARALLEL:
.DEFAULT_GOAL := help

ifndef JOBS
JOBS  := $(shell sh cmake/jobs.sh)
endif
TESTS ?= tests
LOCKED ?=
QUICK ?=
VENV  := .venv
BIN   := $(VENV)/bin
PIP   := $(BIN)/python -m pip --quiet --disable-pip-version-check
# A virtualenv that happens to be active must not leak into the build.
unexport VIRTUAL_ENV PYTHONHOME
export CMAKE_BUILD_PARALLEL_LEVEL := $(JOBS)

NATIVE  := $(shell find src modelDescription fmu python/bindings \( -name '*.cpp' -o -name '*.h' \) 2>/dev/null)
PACKAGE := $(shell find python/gelenk scenes -type f -not -path '*/__pycache__/*' 2>/dev/null)
BUILD   := pyproject.toml CMakeLists.txt $(wildcard cmake/*) LICENSE $(wildcard licenses/*.txt licenses/*/*.txt)

# What a target needs beyond a compiler and Python is checked before anything is built.
NEEDS := needs-costs needs-masters needs-sanitize needs-fuzz needs-runtimes needs-page-core
needs-costs: ; @sh cmake/needs.sh costs valgrind
needs-masters: ; @sh cmake/needs.sh masters mvn java cargo libclang
needs-sanitize: ; @sh cmake/needs.sh sanitize libasan libubsan libtsan valgrind
needs-fuzz: ; @CLANGXX="$(CLANGXX)" sh cmake/needs.sh fuzz clang++
needs-runtimes: ; @sh cmake/needs.sh runtimes cargo
needs-page-core: ; @sh cmake/needs.sh page-core cargo

.PHONY: $(NEEDS) help demo extras test lint style tidy format pytest thorough reductions charts accuracy nonsmooth gallery tutorial coupling batches real-time growth bench costs clocks studies special thrown agreement masters sanitize units fuzz mutants states runtimes page-core wheels platforms lock lowest clean
help:
	@sed -n '2,40s/^# //p' Makefile

demo: $(VENV)/gelenk.stamp
	@echo "Running the demo (some seconds)"
	@$(BIN)/python -m gelenk.demo

extras: $(VENV)/created.stamp
	@$(BIN)/python cmake/lock.py --extras | $(PIP) install --progress-bar off -r /dev/stdin

test: style pytest

lint: style tidy

pytest: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	@echo "Running $(TESTS) with $(JOBS) jobs (all: four minutes with two; then tests/native is left to make units)"
	$(BIN)/python -m pytest -n $(JOBS) $(if $(filter tests,$(TESTS)),--ignore=tests/native) $(TESTS)

thorough: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python -m pytest -n $(JOBS) -m "thorough and not study" $(call marked,thorough)

# The test files in which a mark occurs: to collect all others would take longer than some marked tests.
marked = $(if $(filter tests,$(TESTS)),$(shell grep -rlE --include='test_*.py' '$(1)' tests),$(TESTS))

# Checks that do not change files.
style: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	@echo "Checking format, lint and types (a minute)"
	$(BIN)/clang-format --dry-run -Werror $(NATIVE)
	$(BIN)/ruff format --check
	$(BIN)/codespell
	$(BIN)/ruff check
	$(BIN)/mypy

# clang-tidy on all files, those of a folder together; or on each of those whose path matches FILES, which also finds missing
# includes. Nothing is compiled. It does not know -fno-gnu-unique.
FILES ?=
tidy: $(VENV)/tools.stamp
	@echo "Running clang-tidy (some minutes)"
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset ci -DPython_EXECUTABLE=$(abspath $(BIN))/python -DGELENK_TOGETHER=$(if $(FILES),OFF,ON)
	$(BIN)/python $(BIN)/run-clang-tidy.py -clang-tidy-binary $(abspath $(BIN))/clang-tidy -p build/ci -j $(JOBS) -quiet \
	  -removed-arg=-fno-gnu-unique -extra-arg=-Wno-unknown-warning-option -extra-arg=-Wno-ignored-optimization-argument '$(if $(FILES),^$(CURDIR)/$(FILES),/Unity/unity_|^$(CURDIR)/(src|fmu)/)'

reductions: $(VENV)/gelenk.stamp
	$(BIN)/python benchmarks/reductions.py

# Half an hour: one run at a time, so that times are comparable.
charts: $(VENV)/gelenk.stamp
	$(BIN)/python -m benchmarks.charts

# Two hours with two processes; an interrupted measurement is resumed.
accuracy: $(VENV)/gelenk.stamp
	$(BIN)/python -m benchmarks.accuracy --jobs $(JOBS) $(if $(QUICK),--quick)

# Some minutes; MuJoCo, Drake and EXUDYN take part if they are installed.
nonsmooth: $(VENV)/gelenk.stamp
	$(BIN)/python -m benchmarks.nonsmooth $(if $(QUICK),--quick)
	$(BIN)/python -m benchmarks.contacts $(if $(QUICK),--quick)
	$(BIN)/python -m benchmarks.contacts.failure_map $(if $(QUICK),--quick)
	$(BIN)/python -m benchmarks.cones $(if $(QUICK),--quick)

# NAMES="bennett bricard": only these.
NAMES ?=
gallery: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python -m benchmarks.gallery $(NAMES)

tutorial: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python benchmarks/tutorial.py

coupling: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python -m benchmarks.coupling

batches: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python benchmarks/batches.py

real-time: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python benchmarks/real_time.py

# Some minutes, on an otherwise idle machine.
growth: $(VENV)/gelenk.stamp
	$(BIN)/python -m benchmarks.growth

# About twenty minutes, plus some for compiling and installing the first time (the other engines come from PyPI).
bench: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset release -B build/bench -DPython_EXECUTABLE=$(abspath $(BIN))/python \
	  -DGELENK_BENCHMARKS=ON -DGELENK_SCENES=OFF
	PATH="$(abspath $(BIN)):$$PATH" cmake --build build/bench -j $(JOBS) --target gelenk-kernels gelenk-runs
	$(BIN)/python -m benchmarks.speed $(if $(QUICK),--quick)

# Needs Valgrind.
costs: needs-costs $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PYTHONPATH=tests $(BIN)/python -m costs.counting "$(WHY)"

# Ten minutes.
clocks: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python -m pytest -m clock $(call marked,mark\.clock)

# Half an hour.
studies: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	$(BIN)/python -m pytest -n $(JOBS) -o faulthandler_timeout=3600 -m study $(call marked,mark\.study|sampled)

# Half an hour; findings are written to build/special.txt. ARGS="--only 'random 87'" repeats one comparison.
ARGS ?=
special: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PYTHONPATH=tests:. $(BIN)/python -m special.study --jobs $(JOBS) $(ARGS)

# Some two minutes; prints the scenes that are refused and those with faults, of which it returns whether there are any.
COUNT ?= 3000
thrown: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PYTHONPATH=tests $(BIN)/python -m models.thrown $(COUNT)

# Two hours with two processes; prints what does not agree, by number of the scene.
TRIALS ?= 20000
agreement: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	cd tests && ../$(BIN)/python -m agreement $(TRIALS) --jobs $(JOBS)

# Ten minutes, most of them for Maestro.
MASTERS := $(abspath build/masters)
VDMCHECK := $(abspath build/vdmcheck)
FMI_SIM := 0.7.0
masters: needs-masters $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	mvn -q -B -f tests/masters/pom.xml dependency:copy-dependencies -Dmdep.prependGroupId=true -DoutputDirectory=$(MASTERS)
	cargo install --quiet --locked --root $(MASTERS) --version $(FMI_SIM) fmi-sim
	GELENK_MASTERS=$(MASTERS) PYTHONPATH=tests $(BIN)/python -m masters.study
	mvn -q -B -f tests/masters/vdmcheck.xml dependency:copy-dependencies -Dmdep.stripVersion=true -DoutputDirectory=$(VDMCHECK)
	for jar in vdmcheck2 static-model rule-model; do $(BIN)/python -m zipfile -e $(VDMCHECK)/$$jar.jar $(VDMCHECK); done
	GELENK_VDMCHECK=$(VDMCHECK) $(BIN)/python -m pytest -n $(JOBS) tests/fmu/test_vdmcheck.py

# Two native builds and about ten minutes.
sanitize: needs-sanitize $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset debug -DPython_EXECUTABLE=$(abspath $(BIN))/python -DGELENK_SCENES=OFF
	PATH="$(abspath $(BIN)):$$PATH" cmake --build --preset debug -j $(JOBS) --target gelenk_fmu
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset thread -DPython_EXECUTABLE=$(abspath $(BIN))/python -DGELENK_SCENES=OFF
	PATH="$(abspath $(BIN)):$$PATH" cmake --build --preset thread -j $(JOBS) --target gelenk_fmu
	PYTHONPATH=tests $(BIN)/python -m fmu.sanitizers address build/debug/runtime/linux64/gelenk_fmu.so
	PYTHONPATH=tests $(BIN)/python -m fmu.sanitizers thread build/thread/runtime/linux64/gelenk_fmu.so
	PYTHONPATH=tests $(BIN)/python -m fmu.sanitizers memcheck
	PYTHONPATH=tests $(BIN)/python -m fmu.sanitizers helgrind

# The runtimes of the sanitizers are preloaded, since the interpreter has none.
RUNTIMES = $(shell $(CXX) -print-file-name=libasan.so) $(shell $(CXX) -print-file-name=libubsan.so)
units: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	@case "$(RUNTIMES)" in \
	  /*\ /*) echo "Running the native unit tests under sanitizers (some minutes)"; \
	    export GELENK_SANITIZE=address LD_PRELOAD="$(RUNTIMES)" ASAN_OPTIONS=detect_leaks=0 PYTHONMALLOC=malloc ;; \
	  *) echo "Running the native unit tests without sanitizers: $(CXX) has no libasan.so or no libubsan.so" ;; \
	esac; \
	$(BIN)/python -m pytest -q -n $(JOBS) tests/native

# New inputs are kept in build/fuzz/corpus, inputs that cause a failure in build/fuzz. The build takes twenty minutes, so
# continuous integration only reads the seeds, with the package as it is: tests/fuzz/test_corpus.py.
SECONDS_EACH ?= 600
CLANGXX ?= clang++
fuzz: needs-fuzz $(VENV)/tools.stamp
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset fuzz -DPython_EXECUTABLE=$(abspath $(BIN))/python \
	  -DCMAKE_CXX_COMPILER=$(CLANGXX)
	PATH="$(abspath $(BIN)):$$PATH" cmake --build --preset fuzz -j $(JOBS)
	@for fuzzer in build/fuzz/tests/fuzz/fuzz_*; do \
	  name=$${fuzzer##*/fuzz_}; mkdir -p build/fuzz/corpus/$$name; \
	  $$fuzzer -max_total_time=$(SECONDS_EACH) -timeout=10 -max_len=8192 -dict=tests/fuzz/scene.dict \
	    -artifact_prefix=build/fuzz/$$name- build/fuzz/corpus/$$name tests/fuzz/corpus/$$name; \
	done

# Hours: each mutant costs a build, and one that survives the whole suite.
SEED ?= 1
mutants: COUNT = 40
mutants: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PATH="$(abspath $(BIN)):$$PATH" PYTHONPATH=tests $(BIN)/python -m mutants $(COUNT) $(SEED) --jobs $(JOBS)

states: $(VENV)/tools.stamp $(VENV)/gelenk.stamp
	PYTHONPATH=tests $(BIN)/python -m fuzz.states

# Twenty minutes with two processes.
$(VENV)/runtimes.stamp: $(VENV)/tools.stamp
	@$(PIP) install --progress-bar off --group runtimes
	@touch $@

RUNTIMES_BUILD := build/runtimes
COMPARE ?=
ifneq ($(COMPARE),)
runtimes: needs-runtimes $(VENV)/runtimes.stamp $(VENV)/tools.stamp
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python cmake/runtimes.py $(RUNTIMES_BUILD) $(RUNTIMES_BUILD)/package --compare
else
runtimes: needs-runtimes $(VENV)/runtimes.stamp $(VENV)/gelenk.stamp
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python cmake/runtimes.py $(RUNTIMES_BUILD) $(RUNTIMES_BUILD)/package \
	  --linux64 "$$($(BIN)/python -P -c 'from gelenk.io import export; print(export.runtime_library("linux64").parent)')" \
	  $(if $(QUICK),--quick)
	rm -rf $(RUNTIMES_BUILD)/dist
	SOURCE_DATE_EPOCH=315532800 $(PIP) wheel --no-build-isolation --no-deps -w $(RUNTIMES_BUILD)/dist $(RUNTIMES_BUILD)/package
	$(PIP) install --force-reinstall --no-deps $(RUNTIMES_BUILD)/dist/gelenk_runtimes-*.whl
endif

# Nine minutes of one processor. Builds of the package that follow contain it: cmake/GelenkPython.cmake.
PAGE_CORE := build/page-core
page-core: needs-page-core $(VENV)/runtimes.stamp $(VENV)/gelenk.stamp
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python cmake/page_core.py $(PAGE_CORE) $(PAGE_CORE)/package
	cp -r $(PAGE_CORE)/package/. "$$($(BIN)/python -P -c 'import gelenk; print(gelenk.__path__[0])')"

# Built with what .venv has, and named after the oldest glibc that it needs.
wheels: $(VENV)/runtimes.stamp $(VENV)/gelenk.stamp
	rm -rf build/wheels build/wheels-raw
	PATH="$(abspath $(BIN)):$$PATH" $(PIP) wheel --no-build-isolation --no-deps -C build-dir=build/wheel -w build/wheels-raw .
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/auditwheel repair --plat auto -w build/wheels build/wheels-raw/gelenk-*.whl
	@if [ -d $(RUNTIMES_BUILD)/package ]; then \
	  SOURCE_DATE_EPOCH=315532800 PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python cmake/cross_wheels.py \
	    build/wheels/gelenk-*x86_64.whl $(RUNTIMES_BUILD) $(RUNTIMES_BUILD)/package build/wheels; \
	else echo "make wheels: for other platforms, run make runtimes first"; fi

# Some minutes.
platforms: $(VENV)/runtimes.stamp $(VENV)/gelenk.stamp
	$(BIN)/python -m pytest -m "platforms and not clock" -n $(JOBS) tests/platforms

lock: $(VENV)/created.stamp
	$(BIN)/python cmake/lock.py

# In an environment of its own, to which the compiled package is copied from .venv. Old versions may warn of themselves.
LOWEST := build/lowest
LOWEST_TESTS := tests/test_simulate.py tests/test_linearize.py tests/test_result_files.py tests/test_cli.py tests/test_help.py tests/test_yaml.py \
  tests/test_complete_results.py tests/test_urdf_import.py tests/sweeps tests/learning
lowest: $(VENV)/gelenk.stamp
	$(BIN)/python -m venv --clear $(LOWEST)
	$(LOWEST)/bin/python -m pip --quiet --disable-pip-version-check install --only-binary=:all: \
	  $$($(BIN)/python cmake/lock.py --lowest) pytest hypothesis jsonschema
	cp -r $(VENV)/lib/python3*/site-packages/gelenk $(VENV)/lib/python3*/site-packages/gelenk-*.dist-info $(LOWEST)/lib/python3*/site-packages/
	$(LOWEST)/bin/python -m pytest -p no:cacheprovider -W default -m "not (clock or platforms or study)" $(LOWEST_TESTS)

format: $(VENV)/tools.stamp
	$(BIN)/clang-format -i $(NATIVE)
	$(BIN)/ruff check --fix --exit-zero
	$(BIN)/ruff format

clean:
	rm -rf build dist out $(VENV) .mypy_cache .pytest_cache .ruff_cache

$(VENV)/created.stamp:
	@sh cmake/needs.sh "$(or $(MAKECMDGOALS),demo)" c++
	@python=$$(sh cmake/find_python.sh); \
	echo "Creating $(VENV) with $$python (half a minute)"; \
	"$$python" -m venv --clear $(VENV)
	@$(PIP) install --upgrade pip
	@touch $@

# The first build is that of a user: pip fetches the build requirements and builds in isolation. Later builds use the
# tools installed in .venv for the linters and are incremental. One line is printed for each step.
$(VENV)/gelenk.stamp: $(VENV)/created.stamp $(BUILD) $(NATIVE) $(PACKAGE)
	@mkdir -p build; \
	if [ -e $@ ] && [ -e $(VENV)/tools.stamp ] && [ -z "$(filter pyproject.toml,$?)" ]; then \
	  echo "Building Gelenk (incremental)"; \
	  export PATH="$(abspath $(BIN)):$$PATH"; \
	  what=(--no-build-isolation --no-deps --force-reinstall -C build-dir=build/wheel .); \
	elif [ -n "$(LOCKED)" ]; then \
	  echo "Building Gelenk with the requirements in requirements.lock, with $(JOBS) jobs"; \
	  export PATH="$(abspath $(BIN)):$$PATH"; \
	  $(PIP) install --require-hashes --no-deps -r requirements.lock; \
	  what=(--no-build-isolation --no-deps .); \
	else \
	  echo "Building Gelenk: fetching 200 MB, compiling with $(JOBS) jobs (some $$((8 / $(JOBS) + 1)) minutes)"; \
	  what=('.[charts]'); \
	fi; \
	$(BIN)/python -m pip --disable-pip-version-check install -v "$${what[@]}" 2>&1 | tee build/install.log \
	  | $(BIN)/python cmake/progress.py || \
	  { tail -n 60 build/install.log >&2; echo "Installing Gelenk failed; all output is in build/install.log" >&2; exit 1; }
	@touch $@

$(VENV)/tools.stamp: $(VENV)/created.stamp pyproject.toml
	@echo "Fetching the linters, the optional packages and the requirements of the tests (a minute)"
	@if [ -n "$(LOCKED)" ]; then $(PIP) install --progress-bar off --require-hashes --no-deps -r requirements.lock; \
	else $(BIN)/python cmake/lock.py --extras | $(PIP) install --progress-bar off --group test --group lint -r /dev/stdin; fi
	@touch $@
