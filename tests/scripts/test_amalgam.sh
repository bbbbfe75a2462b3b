#!/bin/sh
# slow: yes
# What amalgamate refuses, and that its output is the files themselves, less their includes of each other.
. tests/lib/script.sh
tool=$build/amalgamate
CC=${CC:-cc}
cd "$dir" || exit 1

# A library of three modules in two rooms.
fresh() {
    rm -rf src one.h one.h.new
    mkdir -p src/cellar src/attic
    printf '# room modules\ncellar config low\nattic high\n' > src/MODULES
    printf '/* config: switches. */\n#define PD_VERSION_MAJOR 9\n' > src/cellar/config.h
    printf '#define PD_VERSION_MINOR 8\n#define PD_VERSION_PATCH 7\n' >> src/cellar/config.h
    printf '/* low: the floor below. */\n#include "cellar/config.h"\n#include <math.h>\nint low;\n' > src/cellar/low.h
    printf '/* low: see low.h */\n#include "cellar/low.h"\nint low = 1;\n' > src/cellar/low.c
    printf '/* high: the floor above. */\n#include "cellar/low.h"\nint high;\n' > src/attic/high.h
    printf '/* high: see high.h */\n#include "attic/high.h"\n' > src/attic/high.c
    printf '#include <stdio.h>\n  int  high = 2;  /* kept */\n' >> src/attic/high.c
    printf 'Licence text\n' > LICENCE
    : > log
}

tool() { "$tool" "$@" src LICENCE one.h > log 2>&1; }

# refuses TEXT [OPTION]: fails, says TEXT, and leaves no output behind.
refuses() {
    text=$1
    shift
    ! tool "$@" && grep -q "$text" log && [ ! -e one.h ] && [ ! -e one.h.new ]
}

line_of() { grep -n "$1" one.h | head -n 1 | cut -d : -f 1; }

fresh
check "writes" tool
check "leaves nothing aside" [ ! -e one.h.new ]
check "names the version" grep -q 'pdcorr 9.8.7' one.h
check "lists the contents" grep -q '^ \*     low  *the floor below.$' one.h
check "drops local includes" [ "$(grep -c '^#include "' one.h)" = 0 ]
check "keeps system includes" [ "$(grep -c '^#include <' one.h)" = 2 ]
check "keeps lines as they are" grep -qx '  int  high = 2;  /\* kept \*/' one.h
check "keeps the order" [ "$(line_of '>>cellar/low.h')" -lt "$(line_of '>>attic/high.h')" ]
check "puts sources after headers" [ "$(line_of '>>attic/high.h')" -lt "$(line_of '>>cellar/low.c')" ]
check "carries the licence" grep -q '^ \* Licence text$' one.h
check "is fresh" tool --check
cp one.h before.h
check "writes again" tool
check "the same bytes" cmp -s before.h one.h
echo '/* more */' >> src/attic/high.c
check "notices a change" sh -c '! "$0" --check src LICENCE one.h > log 2>&1 && grep -q stale log' "$tool"
check "does not mend it by itself" cmp -s before.h one.h

fresh
printf '/* config: switches. */\n#define PD_VERSION_MAJOR 9\n' > src/cellar/config.h
check "no version" refuses 'no line #define PD_VERSION_MINOR'
fresh
check "nothing to compare with" refuses 'not found; run' --check
printf '#include "attic/high.h"\n' >> src/cellar/low.c
check "a source reaches up" sh -c '! "$0" --rules src LICENCE one.h > log 2>&1' "$tool"
check "and the message says so" grep -q 'include cycle: low -> high -> low' log
fresh
printf '/* low: the floor below. */\n#include "attic/high.h"\n' > src/cellar/low.h
printf '/* high: the floor above. */\n' > src/attic/high.h
printf '/* high: see high.h */\n#include "attic/high.h"\n' > src/attic/high.c
check "a header reaches up" refuses 'cellar/low reaches up: it includes attic/high'
fresh
printf '#include "attic/high.h"\n' >> src/cellar/config.h
check "a long cycle" refuses 'include cycle: config -> high -> low -> config'
fresh
printf '#include "cellar/low.h"\n' >> src/cellar/low.h
check "a header includes itself" refuses 'low.h includes itself'
fresh
: > src/attic/stray.c
check "a file without module" refuses 'stray.c: no module'
fresh
mkdir src/shed
: > src/shed/low.c
check "a module in another room" refuses 'shed/low.c: no module'
fresh
: > src/stray.c
check "a file outside of the rooms" refuses 'stray.c: no module'
fresh
printf '#include "foreign.h"\n' >> src/attic/high.c
check "an unknown include" refuses 'high.c includes "foreign.h"'
fresh
rm src/attic/high.h
check "a module without header" refuses 'high.h: not found'
fresh
printf 'attic late\n' >> src/MODULES
check "a module without a file" refuses 'attic/late.h: not found'
fresh
printf 'attic low\n' >> src/MODULES
check "listed twice" refuses 'low is listed twice'
fresh
printf 'int tail;' >> src/attic/high.c
check "no newline at the end" refuses 'does not end with a newline'
fresh
printf 'int low;\n' > src/cellar/low.h
check "no first comment" refuses 'first line has to begin'
fresh
rm src/cellar/low.c
check "a module of a header alone" tool

# Two headers: what all see, what is internal, the sources.
fresh
printf 'int below;\n#ifdef PDI_INTERNAL\nint secret;\n#endif\n' >> src/cellar/low.h
printf '#ifdef PDI_APP_INTERNAL\nint hidden;\n#endif\n' >> src/attic/high.h
printf 'app: attic\n' >> src/MODULES
check "an app without a second output" refuses 'no second output is named'
two() { "$tool" "$@" src LICENCE one.h app.h > log 2>&1; }
check "writes two" two
check "both are fresh" two --check
check "the second includes the first" grep -qx '#include "one.h"' app.h
check "each has its own rooms" sh -c '! grep -q "int high" one.h && ! grep -q "int low" app.h'
check "shows first what all see" [ "$(line_of '^int below;$')" -lt "$(line_of '>>internal')" ]
check "then what is internal" [ "$(line_of '^int secret;$')" -gt "$(line_of '>>internal')" ]
check "then the sources" [ "$(line_of '>>cellar/low.c')" -gt "$(line_of '^int secret;$')" ]
cp app.h one.h
check "so the second" [ "$(line_of '^int high;$')" -lt "$(line_of '>>internal')" ]
check "and what is internal to it" [ "$(line_of '^int hidden;$')" -gt "$(line_of '>>internal')" ]
fresh
printf '#if 1\n#if 1\n#ifdef PDI_INTERNAL\n#endif\n#endif\n#endif\n' >> src/cellar/low.h
check "what is internal under a condition" refuses 'stands under another condition'
fresh
printf '#ifdef PDI_INTERNAL\nint secret;\n#else\n#endif\n' >> src/cellar/low.h
check "another branch of it" refuses 'has another branch'

# Rooms that a macro leaves out, and modules that gain nothing from much optimisation.
fresh
printf 'cut NO_ATTIC: attic\ncold 1: attic\ncold 2: low high\n' >> src/MODULES
check "cuts" tool
check "guards headers and sources" [ "$(grep -c '^#if !defined(NO_ATTIC)$' one.h)" = 2 ]
check "closes the guards" [ "$(grep -c '^#endif /\* cut \*/$' one.h)" = 2 ]
sed -n 's/^#pragma GCC //p' one.h > pragmas
check "the later level counts" [ "$(grep -c O2 pragmas) $(grep -c O1 pragmas)" = "2 0" ]
check "restores the level" [ "$(sed -n '/_options/s/_.*//p' pragmas | tr '\n' ' ')" = 'push pop push pop ' ]
grep -v '^# *include <' one.h > cut.c
check "leaves out the attic" sh -c "$CC -DNO_ATTIC -DPDCORR_IMPLEMENTATION -DPDI_INTERNAL -E cut.c > cut.i &&
    grep -q 'int low' cut.i && ! grep -q 'int *high' cut.i"
fresh
printf 'cut NO_CELLAR: cellar\n' >> src/MODULES
check "a cut below what stays" refuses 'NO_CELLAR leaves out cellar/low, which attic/high uses'
fresh
printf 'cut NO_SHED: shed\n' >> src/MODULES
check "a cut of no room" refuses 'shed is no room or module that stands before'
fresh
printf 'cut NO_LOW: low\n' >> src/MODULES
check "a cut of a module" refuses 'low is no room or module that stands before'
fresh
printf 'cold 1: shed\n' >> src/MODULES
check "a level of nothing" refuses 'shed is no room or module'
fresh
printf 'cold g: attic\n' >> src/MODULES
check "a level for what is rarely run" tool
check "says so to gcc" grep -q '^#pragma GCC optimize ("Og")$' one.h
fresh
printf 'cold 3: attic\nsmall: attic low\n' >> src/MODULES
check "modules that are small where programs are sent" tool
check "says so to clang" [ "$(grep -c '^#pragma clang attribute push' one.h)" = 2 ]
check "ends what it says" [ "$(grep -c '^#pragma clang attribute pop' one.h)" = 2 ]
check "beside a level and without one" \
    [ "$(grep -c '^#elif defined(PDI_OPTIMISE_SIZE)$' one.h) $(grep -c '^#ifdef PDI_OPTIMISE_SIZE$' one.h)" = '2 2' ]
fresh
printf 'cold 7: attic\n' >> src/MODULES
check "no such level" refuses 'cold/7:.h: not found'

score
