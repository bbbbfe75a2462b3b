#!/bin/sh
# Every house rule of lint: a clean module passes, and each offence is named.
. tests/lib/script.sh
tool=$build/lint
cd "$dir" || exit 1
mkdir src docs

fresh() {
    cat > src/thing.h <<'END'
/* thing: an example. */
#define PD_THING_MAX 3
typedef struct pd_thing {
    double a, b; /* [kg/(m3 s)] both */
    double *v;   /* [count] [m^(d-2)] values,
                  * see the theory */
    /* [-] a group */
    double c;
    double d;
    int n;
} pd_thing;
#define pd_thing_build PD_NAME(pd_thing_build)
PD_API int pd_thing_build(pd_thing *thing);
PDI_FN double pdi_thing_size(const pd_thing *thing);
END
    cat > src/thing.c <<'END'
/* thing: see thing.h */
#include "thing.h"
#define PDI_THING_LIMIT 4
#define PDI_X(name) name
#undef PDI_X
static const int pdi_thing_table[] = {1, 2};
static int pdi_thing_helper(int n) { return n; }
END
    printf 'A text.\n' > docs/text.md
}

# offence TEXT COMMAND...: after the command, lint names exactly this one offence.
offence() {
    text=$1
    shift
    fresh
    "$@"
    ! "$tool" > log && grep -q "$text" log && grep -q ' 1 complaints$' log
    verdict "expected: $text; lint said:"
}

add() { echo "$2" >> "src/thing.$1"; }
swap() { sed "$2" "src/thing.$1" > new && mv new "src/thing.$1"; }
blanks() { printf "%$1s" ''; }

fresh
"$tool" > log
verdict "a clean module"
offence 'columns, at most 120' add c "/*$(blanks 117)*/"
offence 'lines, at most 830' sh -c 'awk "BEGIN { for (k = 0; k < 830; k++) print \"\" }" >> src/thing.c'
offence 'a tab' add c "$(printf 'int\tpdi_x;')"
offence 'a trailing blank' add c '/* a */ '
offence 'leftover marker' add c '/* FIX''ME */'
offence 'newline' sh -c 'printf "/* a */" >> src/thing.c'
offence 'a path of one machine' sh -c 'echo "see /ho""me/somebody" >> docs/text.md'
offence 'static helper' add c 'static int helper(void) { return 1; }'
offence 'static table' add c 'static const double table[] = {'
offence 'type size_table' add c 'typedef struct size_table {'
offence 'macro LIMIT' add c '#define LIMIT 3'
offence 'macro SIZE' add h '#define SIZE 3'
offence 'declares PD_API' add h 'int pdi_thing_more(void);'
offence 'internal function pdi_other' add h 'PDI_FN int pdi_other(void);'
offence 'public function pd_thing_free: the line' add h 'PD_API void pd_thing_free(pd_thing *thing);'
offence 'pd_thing_gone is mapped' add h '#define pd_thing_gone PD_NAME(pd_thing_gone)'
offence 'a double without a unit' swap h 's/\[kg.*\] both/both/'
offence 'a double without a unit' swap h 's/ \[m^(d-2)\]//'
offence 'thing.h:10: a double without a unit' swap h 's/    double d;/    int k;\n    double d;/'

score
