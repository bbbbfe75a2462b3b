# GNU make. `make help` lists the targets.
#
#   CC=clang     another compiler            OPENMP=0     without OpenMP (default: when a test program links)
#   CFLAGS=...   flags of the drivers        BUILD=dir    another build folder
#   V=1          show the commands           EXTRA=...    more flags for the tests, such as -g
#   PD_TEST_LIMIT=s   of a test, after which it is stopped (3600; 0: none)

ifeq ($(origin CC),default)
CC = cc
endif
BUILD ?= build
OPENMP ?= 1
LIBS = -lm
building = @$(if $(V),set -x,echo '  $(notdir $(CC)) $@');
WARN = -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes -Werror

# What the compiler offers, found by compiling and linking a small program.
ifneq ($(filter-out help clean uninstall,$(or $(MAKECMDGOALS),all)),)
probe = $(shell d=$$(mktemp -d) && printf '$(1)' > $$d/p.c && \
          $(CC) $(2) $$d/p.c -o $$d/p 2> $$d/log && echo '$(2)'; rm -rf $$d)
NATIVE := $(call probe,int main(void) { return 0; }\n,-march=native)
# Whole vectors where the processor has them: compilers are shy of the longest.
NATIVE += $(call probe,int main(void) { return 0; }\n,-mprefer-vector-width=512)
ifneq ($(OPENMP),0)
OMP := $(call probe,\043include <omp.h>\nint main(void) { return omp_get_max_threads() < 1; }\n,-fopenmp)
endif
# gcc reads the header on one core and optimises it on all of them, to an object like any other, in half of the time.
# Without optimisation there is nothing to share out.
TO_OBJECT = -flto=auto -r -flinker-output=nolto-rel
PARTS := $(shell d=$$(mktemp -d) && echo 'int main(void) { return 0; }' > $$d/p.c && $(CC) -flto -c $$d/p.c -o $$d/p.o 2> $$d/log && \
           $(CC) $(TO_OBJECT) $$d/p.o -o $$d/q.o 2> $$d/log && $(CC) $$d/q.o -o $$d/p 2> $$d/log && echo 1; rm -rf $$d)
endif

CFLAGS ?= -std=c99 -O3 $(NATIVE) -ffp-contract=off
PARTS := $(if $(filter -O2 -O3,$(CFLAGS)),$(PARTS))
# Tests run the split sources with the library's own assertions on. A test program itself needs no speed. Position
# independent, since they are loaded as a shared library, of the Python package too.
DEV = -std=c99 -O2 -fPIC -ffp-contract=off $(WARN) -DPD_DEBUG -DPDI_SPLIT $(OMP) $(EXTRA)
PLAIN = -std=c99 -O0 -fPIC -ffp-contract=off
DEV_TEST = -std=c99 -O0 -ffp-contract=off $(WARN) -DPD_DEBUG $(OMP) $(EXTRA)

AMALGAM := pdcorr_app.h pdcorr.h # the first includes the second
APP_ROOMS := $(shell sed -n 's/^app: //p' src/MODULES)

# On Linux test programs load the objects of a dimension as one library from check/ beside them: each links in a moment,
# and another source needs no other program. Elsewhere, and under sanitizers, they hold the objects.
, = ,
LOADED := $(if $(findstring -fsanitize,$(EXTRA)),,$(filter Linux,$(shell uname)))
LIBRARY_FLAGS = $(if $(LOADED),-Wl$(,)-Bsymbolic-functions$(,)-soname$(,)$(@F))
needed-objects = $(if $(LOADED),| $(BUILD)/check/libpdcorr$(1)d.so,$(OBJECTS_$(1)))
with-objects = $(if $(LOADED),-Wl$(,)--enable-new-dtags$(,)-rpath$(,)'$$ORIGIN/check' $(BUILD)/check/libpdcorr$(1)d.so,\
                 $(OBJECTS_$(1))) $(LIBS)

SOURCES := $(wildcard src/*/*.c)
HEADERS := $(wildcard src/*/*.h)
CASES := $(wildcard cases/*.h cases/*/*.h)
DIMS = 1 2 3
DRIVERS := $(foreach d,$(patsubst drivers/%.c,%,$(wildcard drivers/*.c)),\
             $(foreach k,$(DIMS),$(BUILD)/$(if $(filter scene,$d),pd,$d)$kd))
# tests/ROOM/test_x.c with `dims: 1 3` in its first five lines becomes build/test_x_1d and build/test_x_3d, and
# tests/hard/test_x.c becomes build/hard_x_1d. Behind `slow:` stand the dimensions that `make test` leaves to
# `make test-all`; in a shell test that word is `slow: yes`, or `slow: weekly` where CI leaves it to its weekly run, too.
marked = $(shell awk -v usual='$(3)' 'function say() { \
        n = split(dims, d, " "); for (k = 1; k <= n; k++) print "$(BUILD)/$(4)" name "_" d[k] "d" } \
    FNR == 1 { say(); name = FILENAME; sub(/.*\/(test_)?/, "", name); sub(/\.c$$/, "", name); dims = usual; found = 0 } \
    FNR <= 5 && !found && match($$0, /$(1): *[1-3][1-3 ]*/) { \
        found = 1; dims = substr($$0, RSTART, RLENGTH); sub(/.*: */, "", dims) } \
    END { say() }' $(2) /dev/null)
TESTED := $(patsubst src/%,tests/%,$(wildcard src/*))
TEST_SOURCES := $(wildcard $(TESTED:%=%/test_*.c))
TESTS := $(call marked,dims,$(TEST_SOURCES),2,test_)
HARD_TESTS := $(call marked,dims,tests/hard/test_*.c,2,hard_)
SLOW_TESTS := $(call marked,slow,$(TEST_SOURCES),,test_) $(call marked,slow,tests/hard/test_*.c,,hard_)
SCRIPTS := $(wildcard tests/scripts/*.sh)
SLOW_SCRIPTS := $(shell awk 'FNR <= 5 && /slow: (yes|weekly)/ { print FILENAME }' $(SCRIPTS))
SLOW_SCRIPT_LOGS = $(SLOW_SCRIPTS:tests/scripts/%.sh=$(LOGS)/%.log)
WEEKLY_SCRIPTS := $(shell awk 'FNR <= 5 && /slow: weekly/ { print FILENAME }' $(SCRIPTS))
LOGS = $(BUILD)/logs
TEST_LOGS := $(TESTS:$(BUILD)/%=$(LOGS)/%.log) $(HARD_TESTS:$(BUILD)/%=$(LOGS)/%.log)
SCRIPT_LOGS := $(SCRIPTS:tests/scripts/%.sh=$(LOGS)/%.log)
# The longest first, so that all cores end together.
LONGEST = test_embed web ways examples validate install openmp windows scenes bench wasi site python_examples peers png_reader walk \
          python checkpoint
LONGEST_LOGS := $(filter $(SCRIPT_LOGS),$(LONGEST:%=$(LOGS)/%.log))
METAMORPHIC_LOGS := $(DIMS:%=$(LOGS)/metamorphic_%d.log)
ALL_LOGS := $(LONGEST_LOGS) $(LOGS)/amalgam.log $(LOGS)/lint.log $(filter-out $(LONGEST_LOGS),$(SCRIPT_LOGS)) $(TEST_LOGS) \
            $(METAMORPHIC_LOGS)
FAST_LOGS := $(filter-out $(SLOW_TESTS:$(BUILD)/%=$(LOGS)/%.log) $(SLOW_SCRIPT_LOGS),$(ALL_LOGS))
# The programs of `make test`, and every script that is not weekly.
CI_LOGS := $(filter-out $(WEEKLY_SCRIPTS:tests/scripts/%.sh=$(LOGS)/%.log),\
                        $(filter $(FAST_LOGS) $(SCRIPT_LOGS) $(LOGS)/hard_random_2d.log,$(ALL_LOGS)))
# As many at a time as there are cores, unless make has a -j.
JOBS = $(if $(filter -j% --jobserver%,$(MAKEFLAGS)),,-j$(shell env -u OMP_NUM_THREADS nproc 2> /dev/null || echo 2))

.PHONY: all drivers run report validation bench stability test test-ci test-all test-hard test-quick tests amalgam lint
.PHONY: check-compilers sanitize clean help FORCE
.SECONDARY:
.DELETE_ON_ERROR:

all: $(foreach k,$(DIMS),$(BUILD)/pd$kd) ## build pd1d, pd2d and pd3d (default)

drivers: $(DRIVERS) ## build these and the programs of the reports

# One page without a server. Inlining and unrolling of clang make the programs larger by a third, and faster by 6 %. Rooms
# where no run spends its time are small (PDI_OPTIMISE_SIZE). wasm-opt (binaryen), where it is installed, takes a tenth off; the
# first kilobyte of the memory holds nothing. A clang that links with -O2 calls it by itself, and not with these options.
WASM = -msimd128 -mbulk-memory -mnontrapping-fptoint -msign-ext
WASM_OPT = --enable-simd --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext \
           --enable-mutable-globals -Os --const-hoisting -Oz --low-memory-unused
WEB_LINK = --target=wasm32-wasi -mexec-model=reactor
WEB_FLAGS = --target=wasm32-wasi $(WASM) -ftls-model=local-exec -std=c99 -O2 -fno-unroll-loops \
            -mllvm -inline-threshold=5 -ffp-contract=off -Wall -Wextra -Werror '-DPD_API=extern __attribute__((visibility("hidden")))'
WEB_WASM := $(foreach k,$(DIMS),$(BUILD)/web/pdcorr$kd.wasm)
.PHONY: web
web: $(BUILD)/web/index.html ## build the page for browsers, build/web/index.html; needs clang, lld, wasi-libc

WEB_SCENES := $(wildcard examples/scenes/*.scene examples/scenes/*.csv examples/scenes/templates/*.scene)
$(BUILD)/web/index.html: $(WEB_WASM) $(wildcard drivers/web/*) tools/web.sh $(WEB_SCENES)
	@echo '  web $@'
	@sh tools/web.sh $@ $(WEB_WASM)

# The package is complete in $(BUILD)/python: put that on PYTHONPATH, or pip install drivers/python.
.PHONY: python
python: $(foreach k,$(DIMS),$(BUILD)/python/pdcorr/libpdcorr$kd.so) ## build the Python package in build/python
	cp drivers/python/pdcorr/*.py drivers/python/pdcorr/py.typed $(BUILD)/python/pdcorr

.PHONY: site gallery
site: $(BUILD)/pd2d ## build the site of docs/ in build/site and check it
	BUILD=$(BUILD) sh tools/site.sh
	@echo "$(BUILD)/site/index.html"

gallery: all ## run the scenes of the gallery and of the tutorials and renew their pictures
	BUILD=$(BUILD) sh tools/gallery.sh

.PHONY: declare
declare: $(AMALGAM) ## write the declarations of the Python package; needs pycparser
	python3 drivers/python/declare.py

run: $(BUILD)/pd2d ## run the scene of the measured magnesium wire into out/
	$(BUILD)/pd2d examples/scenes/mg_wire.scene --out out/mg_wire
	@echo "measured and computed: out/mg_wire/volume_loss.png"; ls out/mg_wire/*_t12743.28s.png

.PHONY: peers
peers: $(foreach k,$(DIMS),$(BUILD)/pd$(k)d) ## run peers/ beside other codes, as far as they are installed, and draw the report; needs python3-matplotlib
	/usr/bin/python3 peers/peers.py --build $(BUILD)

report: validation bench stability ## write docs/validation.md, docs/performance.md and docs/stability.md
	sh tools/texts.sh --write

# Figures in README.md and the other texts have their sources beside them (tools/texts.sh).
.PHONY: texts texts-runs
texts: ## bring the figures of the texts to those of the reports
	sh tools/texts.sh --write

texts-runs: $(BUILD)/pd2d $(BUILD)/pd3d ## the same, with those of whole runs too: a quarter of an hour
	BUILD=$(BUILD) sh tools/texts.sh --write --runs

.PHONY: constants
constants: ## what scenes cost and give with each numeric constant over a decade: docs/constants.md
	CC='$(CC)' BUILD=$(BUILD) sh tools/constants.sh --write

# Threads sleep at barriers, because several programs may share the processor.
validation: $(foreach k,$(DIMS),$(BUILD)/validate$(k)d) ## run all validation cases and write docs/validation.md
	@rm -rf $(BUILD)/report
	for k in $(DIMS); do OMP_WAIT_POLICY=passive $(BUILD)/validate$${k}d --out $(BUILD)/report || exit 1; done
	sh tools/report.sh $(BUILD)/report docs

bench: $(foreach k,$(DIMS),$(BUILD)/bench$(k)d) ## run all benchmarks on two threads and write docs/performance.md
	@rm -rf $(BUILD)/performance
	for k in $(DIMS); do $(BUILD)/bench$${k}d --out $(BUILD)/performance || exit 1; done
	sh tools/report.sh --performance $(BUILD)/performance docs

# The hard cases with their long sweeps, one after the other, and the steps of the integrators.
stability: $(HARD_TESTS) $(foreach k,$(DIMS),$(BUILD)/stability$(k)d) ## run all hard cases and write docs/stability.md
	@rm -rf $(BUILD)/stability && mkdir -p $(BUILD)/stability
	for t in $(HARD_TESTS); do PD_HARD=1 OMP_WAIT_POLICY=passive $$t > $(BUILD)/stability/$$(basename $$t).log || \
	    echo "$$t: failed"; done
	for k in $(DIMS); do OMP_WAIT_POLICY=passive $(BUILD)/stability$${k}d --out $(BUILD)/stability || exit 1; done
	sh tools/report.sh --stability $(BUILD)/stability docs

# run-logs LOGS,FLAGS,MORE: builds MORE and what the tests need, makes the logs in their order, and ends with the sum. A
# test that does not build counts as failed, and the others still run.
needed = $(patsubst $(LOGS)/%.log,$(BUILD)/%,$(filter $(TEST_LOGS) $(METAMORPHIC_LOGS),$(1))) $(if $(filter $(SCRIPT_LOGS),$(1)),script-programs)
define run-logs
@rm -f $(LOGS)/*.log; mkdir -p $(LOGS); date +%s > $(LOGS)/begin
+@$(2) $(MAKE) -k $(JOBS) --no-print-directory $(3) $(call needed,$(1)) || true
+@$(2) $(MAKE) -k $(JOBS) --no-print-directory OF=$(words $(1)) $(1) || true
@sh tools/sum.sh --since $(LOGS)/begin $(1)
endef

# T=NAME...: of a module, of a script, or of a room of src/, with all dimensions.
named = $(filter $(foreach t,$(T),$(foreach n,$t test_$t hard_$t $(patsubst tests/$t/%.c,%,$(wildcard tests/$t/test_*.c)),\
        $(LOGS)/$n.log $(LOGS)/$n_1d.log $(LOGS)/$n_2d.log $(LOGS)/$n_3d.log)),$(ALL_LOGS))
test: ## fast checks and tests of every module: minutes; ends with the sum; T=NAME: those of a module, room or script
	$(if $(T),$(if $(named),,$(error T=$(T): tests/ has no test, room or script of that name)))
	$(call run-logs,$(if $(T),$(named),$(FAST_LOGS)),PROGRAMS=$(BUILD)/check FAST_SCRIPTS=$(if $(filter $(SLOW_SCRIPT_LOGS),$(named)),,1))

test-ci: ## what CI runs: `make test` and the slow scripts, without the weekly ones
	$(call run-logs,$(CI_LOGS),PROGRAMS=$(BUILD)/check,$(BUILD)/pd2d)

test-all: ## all checks and tests, slow ones too
	$(call run-logs,$(ALL_LOGS),PD_TEST_ALL=1)

test-quick: ## the fast tests in 2D only
	$(call run-logs,$(filter %_2d.log,$(FAST_LOGS)))

test-hard: ## the hard cases with their long sweeps: tens of minutes
	$(call run-logs,$(filter $(LOGS)/hard_%,$(TEST_LOGS)),PD_TEST_ALL=1 PD_HARD=1)

tests: $(TESTS) $(HARD_TESTS) ## build the test programs without running them

amalgam: $(BUILD)/amalgamate ## write pdcorr.h and pdcorr_app.h from src/, and the templates in it from examples/scenes/templates/
	sh tools/templates.sh
	$(BUILD)/amalgamate src LICENSE pdcorr.h pdcorr_app.h

lint: $(BUILD)/lint $(BUILD)/amalgamate ## house rules and the order of the modules
	$(BUILD)/amalgamate --rules src LICENSE pdcorr.h pdcorr_app.h
	$(BUILD)/lint

# Whole scenes in two dimensions, rings and readers of files go through most of the code.
QUICK_LOGS = $(patsubst %,$(LOGS)/%_2d.log,hard_limits test_axisym test_text test_png test_field_plot test_scene test_bond \
             test_renderer)
# SANITIZED_WHOLE=1: the header is compiled at once, in half the time that all its sources take. SANITIZED_FEWER=1: without
# the checks of pointers that the address sanitizer mostly makes, too, which take half of that.
SANITIZED = +@$(MAKE) -k --no-print-directory BUILD=$(BUILD)/sanitize OPENMP=0 \
            $(if $(SANITIZED_WHOLE),WHOLE=1) \
            EXTRA='-O1 -g1 -fsanitize=address,undefined $(if $(SANITIZED_FEWER),-fno-sanitize=$(FEWER)) -fno-sanitize-recover=all'
FEWER = null,alignment,object-size,pointer-overflow

sanitize: ## the test programs under the address and undefined-behaviour sanitizers: half an hour
	@rm -f $(BUILD)/sanitize/logs/*.log
	$(SANITIZED) sanitized-logs || true
	@sh tools/sum.sh $(TEST_LOGS:$(LOGS)/%=$(BUILD)/sanitize/logs/%)

sanitize-quick: ## a few of them, in two dimensions
	@rm -f $(BUILD)/sanitize/logs/*.log
	$(SANITIZED) quick-logs || true
	@sh tools/sum.sh $(QUICK_LOGS:$(LOGS)/%=$(BUILD)/sanitize/logs/%)

.PHONY: sanitize-quick sanitized-logs quick-logs
sanitized-logs: $(TEST_LOGS)
quick-logs: $(QUICK_LOGS)

# Random scenes, turned, mirrored, shifted, rescaled, in other units and orders: what must be the same of them. Half of the
# pairs are in 2D. `make metamorphic PAIRS=10000 SEED=7` is a long run on all cores. CLOSED=1 leaves out the seeds whose
# findings are open. Each dimension has its processes side by side, unless make has a -j.
PAIRS ?= 200
SCENES ?= 200
SEED ?= 1
SANITIZED_DIMS ?= 2 3 1
METAMORPHIC_RUNS := $(addprefix metamorphic-run-,2 3 1)
SANITIZED_RUNS := $(addprefix metamorphic-sanitized-run-,$(SANITIZED_DIMS))
PAIR_JOBS = $(if $(filter -j% --jobserver%,$(MAKEFLAGS)),1,$(shell env -u OMP_NUM_THREADS nproc 2> /dev/null || echo 2))
quarters_1 = 1
quarters_2 = 2
quarters_3 = 1

.PHONY: metamorphic metamorphic-sanitized metamorphic-programs $(METAMORPHIC_RUNS) $(SANITIZED_RUNS)
metamorphic: ## random scenes against their images: PAIRS (200) pairs from SEED (1) on
	+@$(MAKE) -k --no-print-directory $(METAMORPHIC_RUNS)

metamorphic-run-2: $(BUILD)/metamorphic_3d
$(METAMORPHIC_RUNS): metamorphic-run-%: $(BUILD)/metamorphic_%d
	$< --seed $(SEED) --pairs $$(( $(PAIRS) * $(quarters_$*) / 4 )) --jobs $(PAIR_JOBS) $(if $(CLOSED),--closed --limit 60)

metamorphic-sanitized: metamorphic-programs ## SCENES (200) random scenes under the address and undefined-behaviour sanitizers
	+@$(MAKE) -k --no-print-directory $(SANITIZED_RUNS)

$(SANITIZED_RUNS): metamorphic-sanitized-run-%:
	$(BUILD)/sanitize/metamorphic_$*d --sanitize --limit 60 --jobs $(PAIR_JOBS) --seed $$(( $(SEED) + 500000 )) \
	    --pairs $$(( $(SCENES) * $(quarters_$*) / 4 )) $(if $(CLOSED),--closed)

metamorphic-programs:
	$(SANITIZED) $(SANITIZED_DIMS:%=$(BUILD)/sanitize/metamorphic_%d)

# One fuzzer after the other, FUZZ_TIME seconds each, in 2D; seeds come from the examples. What ends one lies in
# build/fuzz/; give it back to the program to see it again.
FUZZ_TIME ?= 60
FUZZERS := $(patsubst tests/fuzz/%.c,%,$(wildcard tests/fuzz/*.c))
FUZZ_FLAGS = -std=c99 -O1 -g -DPDI_SPLIT -DPD_DEBUG -DPD_DIM=2 -fno-sanitize-recover=all
FUZZ_CHECKS = address,undefined,float-cast-overflow

fuzz: ## run the fuzzers of all readers of files for FUZZ_TIME (60) seconds each; needs clang
	@if command -v clang > /dev/null; then $(MAKE) --no-print-directory fuzz-all; \
	else echo "clang is not installed: no fuzzer was run"; fi

.PHONY: fuzz fuzz-all fuzz-programs
fuzz-programs: $(FUZZERS:%=$(BUILD)/fuzz/%)

fuzz-all: fuzz-programs
	sh tools/fuzz.sh $(BUILD)/fuzz $(FUZZ_TIME) $(FUZZERS)

$(BUILD)/fuzz/obj/%.o: src/%.c $(HEADERS)
	@mkdir -p $(@D)
	$(building) clang $(FUZZ_FLAGS) -Isrc -fsanitize=fuzzer-no-link,$(FUZZ_CHECKS) -c $< -o $@

$(FUZZERS:%=$(BUILD)/fuzz/%): $(BUILD)/fuzz/%: tests/fuzz/%.c tests/fuzz/fuzz.h $(SOURCES:src/%.c=$(BUILD)/fuzz/obj/%.o)
	$(building) clang $(FUZZ_FLAGS) -fsanitize=fuzzer,$(FUZZ_CHECKS) -Isrc $< $(SOURCES:src/%.c=$(BUILD)/fuzz/obj/%.o) -o $@ -lm

# Clean on src/ in every dimension: .clang-tidy lists the checks of clang-tidy, tools/static.sh those of cppcheck.
.PHONY: static static-quick valgrind test32
static: ## clang-tidy and cppcheck on src/, in three dimensions, as far as they are installed
	sh tools/static.sh "1 2 3" cppcheck clang-tidy

static-quick: ## cppcheck in 2D alone
	sh tools/static.sh 2 cppcheck

VALGRIND_TESTS = test_base_2d test_text_1d test_png_2d test_field_plot_2d test_scene_1d test_file_2d test_bond_1d
valgrind: $(VALGRIND_TESTS:%=$(BUILD)/%) ## a handful of quick test programs under valgrind
	sh tools/valgrind.sh $^

# Test programs of floors 0 to 3 with 32-bit pointers; needs the C library for them (gcc-multilib).
TESTS32 = base_2d rng_2d expr_2d shape_2d stencil_2d grid_2d bond_2d krylov_2d multigrid_2d coarsen_2d file_2d text_2d png_2d
test32: ## the tests of floors 0 to 3 built with -m32 and run
	@if printf '#include <stdio.h>\nint main(void) { return 0; }\n' | $(CC) -m32 -x c - -o $(BUILD)/probe32 2> /dev/null; then \
	  mkdir -p $(BUILD)/32/logs; rm -f $(BUILD)/32/logs/*.log; \
	  $(MAKE) -k --no-print-directory BUILD=$(BUILD)/32 OPENMP=0 EXTRA='-m32 -msse2 -mfpmath=sse' logs32 || true; \
	  sh tools/sum.sh $(patsubst %,$(BUILD)/32/logs/test_%.log,$(TESTS32)); \
	else echo "32-bit programs cannot be built here: install gcc-multilib"; fi

.PHONY: logs32
logs32: $(patsubst %,$(LOGS)/test_%.log,$(TESTS32))

# ---- installing: DESTDIR for packages, PREFIX and folders below it. CFLAGS without NATIVE for other machines.
PREFIX ?= /usr/local
BINDIR ?= $(PREFIX)/bin
INCLUDEDIR ?= $(PREFIX)/include
LIBDIR ?= $(PREFIX)/lib
DATADIR ?= $(PREFIX)/share
MANDIR ?= $(DATADIR)/man
LIBRARIES = $(BUILD)/lib/libpdcorr.so $(BUILD)/lib/libpdcorr.a
installer = @DESTDIR='$(DESTDIR)' PREFIX='$(PREFIX)' BINDIR='$(BINDIR)' INCLUDEDIR='$(INCLUDEDIR)' LIBDIR='$(LIBDIR)' \
            DATADIR='$(DATADIR)' MANDIR='$(MANDIR)' BUILD='$(BUILD)' OMP='$(OMP)' sh tools/install.sh

.PHONY: install uninstall libraries
libraries: $(LIBRARIES) ## build libpdcorr.so and libpdcorr.a, with all dimensions

install: all $(LIBRARIES) ## install below DESTDIR/PREFIX: header, programs, libraries, man pages, completions, scenes
	$(installer) install

uninstall: ## remove what `make install` with the same DESTDIR and PREFIX has installed
	$(installer) uninstall

$(BUILD)/lib/libpdcorr.so: $(foreach k,$(DIMS),$(BUILD)/lib/pdcorr$kd.o)
	$(building) $(CC) $(CFLAGS) $(OMP) -shared -Wl,-soname,$$(sh tools/install.sh soname) $^ -o $@ $(LIBS)

$(BUILD)/lib/libpdcorr.a: $(foreach k,$(DIMS),$(BUILD)/lib/pdcorr$kd.o)
	@rm -f $@
	$(building) ar rcs $@ $^

clean: ## remove what was built
	rm -rf $(BUILD)

help: ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## \(.*\)/  \1  \2/p' Makefile | awk '{ n = $$1; $$1 = ""; printf "  %-16s%s\n", n, $$0 }'

# Everything is rebuilt when the compiler or a flag changes.
$(BUILD)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(CC) | $(CFLAGS) | $(DEV) | $(DEV_TEST) | $(LOADED)' > $@.new
	@if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi

define RULES_OF_DIM
OBJECTS_$(1) := $$(if $$(WHOLE),$$(BUILD)/whole/pdcorr$(1)d.o,$$(SOURCES:src/%.c=$$(BUILD)/obj$(1)d/%.o))

# Sources of pdcorr_app.h see of pdcorr.h what all programs see.
$$(BUILD)/obj$(1)d/%.o: src/%.c $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(DEV) $$(if $$(filter $$(APP_ROOMS:%=%/%),$$*),-DPDI_PUBLIC_ONLY) -DPD_DIM=$(1) -Isrc -MMD -MP -c $$< -o $$@

# All of the header at once, with the flags of the objects.
$$(BUILD)/whole/pdcorr$(1)d.o: $$(AMALGAM) $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(DEV) -Wno-misleading-indentation -DPD_DIM=$(1) -DPDCORR_IMPLEMENTATION -x c -c $$< -o $$@

$$(BUILD)/hard_%_$(1)d: tests/hard/test_%.c $$(wildcard tests/hard/*.h tests/lib/*.h) $$(HEADERS) $$(BUILD)/flags \
                         $$(call needed-objects,$(1))
	$$(building) $$(CC) $$(DEV_TEST) -DPDI_SPLIT -DPD_DIM=$(1) -Isrc -Itests/lib -Itests/hard $$< \
	    -o $$@ $$(call with-objects,$(1))

$$(BUILD)/metamorphic_$(1)d: $$(wildcard tests/metamorphic/*.[ch]) tests/lib/random.h $$(HEADERS) $$(BUILD)/flags $$(call needed-objects,$(1))
	$$(building) $$(CC) $$(DEV_TEST) -DPDI_SPLIT -DPD_DIM=$(1) -Isrc -Itests/lib $$(filter %.c,$$^) -o $$@ \
	    $$(call with-objects,$(1))

$$(BUILD)/check/pd$(1)d: drivers/scene.c $$(wildcard drivers/*.h) $$(AMALGAM) $$(OBJECTS_$(1)) $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(DEV_TEST) -DPD_DIM=$(1) -DPDCORR_LINKED -I. $$< $$(OBJECTS_$(1)) -o $$@ $$(LIBS)

$$(BUILD)/check/%$(1)d: drivers/%.c $$(wildcard drivers/*.h) $$(CASES) $$(OBJECTS_$(1)) $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(filter-out $$(WARN),$$(DEV_TEST)) -DPD_DIM=$(1) -DPDCORR_LINKED -DPDI_SPLIT -I. $$< $$(OBJECTS_$(1)) -o $$@ $$(LIBS)

$$(BUILD)/check/libpdcorr$(1)d.so: $$(OBJECTS_$(1)) $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(DEV_TEST) -shared $$(LIBRARY_FLAGS) $$(OBJECTS_$(1)) -o $$@ $$(LIBS)

# Of the Python package.
$$(BUILD)/python/pdcorr/libpdcorr$(1)d.so: $$(BUILD)/lib/pdcorr$(1)d.o
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(CFLAGS) $$(OMP) -shared $$< -o $$@ $$(LIBS)

# Of the page for browsers; 8 MB of stack, as elsewhere.
$$(BUILD)/web/pdcorr$(1)d.wasm: drivers/web/web.c $$(AMALGAM)
	@mkdir -p $$(@D)
	$$(building) clang $$(WEB_FLAGS) -DPD_DIM=$(1) -I. -c $$< -o $$@.o
	@clang $$(WEB_LINK) $$@.o -o $$@ -lm -Wl,-z,stack-size=8388608,--strip-all && rm $$@.o
	@if command -v wasm-opt > /dev/null; then wasm-opt $$(WASM_OPT) $$@ -o $$@.small && mv $$@.small $$@; fi

# The library of all programs. PDI_SPLIT: the reports measure internal functions, too.
$$(BUILD)/pdcorr$(1)d.o: $$(AMALGAM) $$(BUILD)/flags
	$$(building) $$(CC) $$(CFLAGS) $$(OMP) -DPD_DIM=$(1) -DPDCORR_IMPLEMENTATION -DPDI_SPLIT $$(if $$(PARTS),-flto) -x c -c $$< -o $$@
	$$(if $$(PARTS),@$$(CC) $$(CFLAGS) $$(OMP) $$(TO_OBJECT) $$@ -o $$@.whole && mv $$@.whole $$@)

# The library that is installed: its public functions alone have names outside of it.
$$(BUILD)/lib/pdcorr$(1)d.o: $$(AMALGAM) $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(CFLAGS) $$(OMP) -fPIC -DPD_DIM=$(1) -DPDCORR_IMPLEMENTATION -x c -c $$< -o $$@

# The same without optimisation, in a moment: for scripts of tests that install it, link to it or compare with it.
$$(BUILD)/plain/pdcorr$(1)d.o: $$(AMALGAM) $$(BUILD)/flags
	@mkdir -p $$(@D)
	$$(building) $$(CC) $$(PLAIN) -DPD_DIM=$(1) -DPDCORR_IMPLEMENTATION -x c -c $$< -o $$@

$$(BUILD)/pd$(1)d: drivers/scene.c $$(wildcard drivers/*.h) $$(BUILD)/pdcorr$(1)d.o
	$$(building) $$(CC) $$(CFLAGS) $$(OMP) -DPD_DIM=$(1) -DPDCORR_LINKED -I. $$< $$(BUILD)/pdcorr$(1)d.o -o $$@ $$(LIBS)

$$(BUILD)/%$(1)d: drivers/%.c $$(wildcard drivers/*.h) $$(CASES) $$(BUILD)/pdcorr$(1)d.o
	$$(building) $$(CC) $$(CFLAGS) $$(OMP) -DPD_DIM=$(1) -DPDCORR_LINKED -DPDI_SPLIT -I. $$< $$(BUILD)/pdcorr$(1)d.o \
	    -o $$@ $$(LIBS)

-include $$(OBJECTS_$(1):.o=.d)
endef
$(foreach k,$(DIMS),$(eval $(call RULES_OF_DIM,$k)))

define RULES_OF_TESTS
$$(BUILD)/test_%_$(1)d: $(2)/test_%.c $$(wildcard tests/lib/*.h $(2)/*.h cases/*.h) $$(HEADERS) $$(BUILD)/flags \
                         $$(call needed-objects,$(1))
	$$(building) $$(CC) $$(DEV_TEST) -DPDI_SPLIT -DPD_DIM=$(1) -Isrc -I. -Itests/lib $$< -o $$@ $$(call with-objects,$(1))
endef
$(foreach k,$(DIMS),$(foreach r,$(TESTED),$(eval $(call RULES_OF_TESTS,$k,$r))))

# Small faults at random, MUTANTS of them that have an effect. SEED: without one the clock gives it. The first run finds
# out which lines each test executes, which takes half an hour; then a fault takes seconds. MUTANTS_FLAGS=--unseen lists
# the lines that no test executes, MUTANTS_FLAGS='--at ROOM/FILE.c:LINE' takes the faults of a line.
MUTANTS ?= 100
MUTANTS_FLAGS ?=
.PHONY: mutants
mutants: $(OBJECTS_1) $(OBJECTS_2) $(OBJECTS_3) ## draw small faults in src/ and print those that no test sees; needs python3
	@CC='$(CC)' DEV='$(DEV)' DEV_TEST='$(DEV_TEST)' python3 tools/mutants.py --build $(BUILD) --count $(MUTANTS) \
	    $(if $(SEED),--seed $(SEED)) $(MUTANTS_FLAGS)

$(BUILD)/amalgamate $(BUILD)/lint: $(BUILD)/%: tools/%.c $(BUILD)/flags
	$(building) $(CC) -std=c99 -O1 $(WARN) $< -o $@

# ---- logs: output, then a line "exit N"; tools/sum.sh adds them up.
log = sh tools/log.sh $@ '$(OF)' $(1)

$(LOGS)/amalgam.log: $(BUILD)/amalgamate FORCE
	@$(call log,$(BUILD)/amalgamate --check src LICENSE pdcorr.h pdcorr_app.h)

$(LOGS)/lint.log: $(BUILD)/lint FORCE
	@$(call log,$(BUILD)/lint)

$(TEST_LOGS): $(LOGS)/%.log: $(BUILD)/% FORCE
	@$(call log,$<)

# A few of the random scenes, from seeds that have no finding.
$(METAMORPHIC_LOGS): $(LOGS)/%.log: $(BUILD)/% FORCE
	@$(call log,$< --quick)

# PROGRAMS: where shell tests find pd1d and its like. `make test` gives them programs linked to the objects of the
# tests, which are built in a moment and have assertions. FAST_SCRIPTS=1: no slow script needs the programs of the
# reports, nor the library without optimisation.
PROGRAMS ?= $(BUILD)
SCRIPT_PROGRAMS = $(DIMS:%=$(PROGRAMS)/pd%d) $(BUILD)/amalgamate $(BUILD)/lint \
                  $(if $(FAST_SCRIPTS),,$(DRIVERS:$(BUILD)/%=$(PROGRAMS)/%) $(DIMS:%=$(BUILD)/plain/pdcorr%d.o))
.PHONY: script-programs
script-programs: $(SCRIPT_PROGRAMS) $(DIMS:%=$(BUILD)/check/libpdcorr%d.so)

$(SCRIPT_LOGS): $(LOGS)/%.log: tests/scripts/%.sh $(AMALGAM) $(SCRIPT_PROGRAMS) FORCE
	@$(call log,env CC='$(CC)' BUILD='$(BUILD)' OMP='$(OMP)' PROGRAMS='$(PROGRAMS)' sh $<)

$(LOGS)/walk.log: $(BUILD)/check/libpdcorr2d.so
$(LOGS)/python.log $(LOGS)/python_examples.log: $(DIMS:%=$(BUILD)/check/libpdcorr%d.so) $(wildcard drivers/python/*.py drivers/python/pdcorr/*.py)

# ---- the amalgam under every compiler at hand
# Optimised by gcc in 2D alone, unless PD_TEST_ALL: the objects of the tests are, in every dimension and with the same
# warnings.
COMPILERS := $(foreach k,$(DIMS),gcc-$k clang-$k clang-$k-fopenmp g++-$k clang++-$k msvc-$k msvc++-$k) \
             $(foreach k,$(if $(PD_TEST_ALL),$(DIMS),2),gcc-$k-fopenmp)
COMPILER_LOGS := $(COMPILERS:%=$(LOGS)/compilers/%.log)

check-compilers: ## compile the amalgam without a warning: gcc, clang, C99, C++11, MSVC's dialect
	@rm -rf $(LOGS)/compilers
	+@$(MAKE) --no-print-directory $(COMPILER_LOGS)
	@sh tools/sum.sh $(COMPILER_LOGS)

$(COMPILER_LOGS): $(LOGS)/compilers/%.log: $(AMALGAM) tools/compile.sh FORCE
	@mkdir -p $(@D)
	@$(call log,sh tools/compile.sh $(subst -, ,$*) $(WARN))
