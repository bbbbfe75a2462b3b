#!/bin/sh
# Figures in README.md and docs/ are those of the reports (tools/texts.sh), and the tool finds what disagrees.
. tests/lib/script.sh

sh tools/texts.sh > "$dir/log" 2>&1
verdict "a figure in a text is not that of the report; make texts mends it"
! grep -q 'README.md: 0 figures' "$dir/log"
verdict "the figures of README.md have no sources"

sed -n '/^```c$/,/^```$/p' README.md | sed '/^```/d' > "$dir/program.c"
${CC:-cc} -std=c99 -Wall -Wextra -Wno-misleading-indentation -Werror -fsyntax-only -I. "$dir/program.c" \
    > "$dir/log" 2>&1
verdict "the program of README.md does not compile"

mkdir -p "$dir/docs/details"
cat > "$dir/docs/details/validation.md" << 'END'
# Validation

## Summary

| verdict | case | part | measure | goal | found |
|---|---|---|---|---|---|
| **missed** | [front, 2D](#front-2d) |  | along (1,1) | at most 0.01 | 1.33e-02 |
| met | [front, 2D](#front-2d) | fine | along x | at most 0.01 | 1.2e-15 |

<a id="front-2d"></a>

| cells | error | order | evaluations |
|---|---|---|---|
| 10 | 2.34e-02 | - | 1234 |
| 20 | 1.17e-02 | 1.00 | 160000 |

**round**

| cells | error |
|---|---|
| 10 | 5.0e-03 |
END
: > "$dir/docs/details/performance.md"
: > "$dir/docs/details/stability.md"

texts() { DOCS=$dir/docs sh tools/texts.sh "$@" "$dir/README.md" > "$dir/log" 2>&1; }
# right TEXT: the text passes. wrong TEXT MESSAGE MENDED: it is complained of, and mended to that.
right() {
    printf '%s\n' "$1" > "$dir/README.md"
    texts
    verdict "right: $1"
}
wrong() {
    printf '%s\n' "$1" > "$dir/README.md"
    ! texts && grep -qF -- "$2" "$dir/log"
    verdict "wrong: $1"
    [ -n "$3" ] || return
    texts --write
    [ "$(sed 's/<!--.*//' "$dir/README.md")" = "$3" ] && texts
    verdict "mended: $(cat "$dir/README.md"), expected $3"
}
cell='validation front-2d; 10; error'
right "0.023<!-- is $cell --> off"
right "2.3<!-- is $cell; x100 --> %"
right "2.34e-2<!-- is $cell -->"
right "0.5<!-- is validation front-2d/round; 10; error; x100 -->"
right "3e-2<!-- below validation front-2d; max; error --> and 1<!-- above validation front-2d; last; error; x100 -->"
right "1.33<!-- is validation summary; front, 2D: along (1,1); found; x100 -->"
right "one<!-- is validation summary; missed; count --> and 1<!-- is validation summary; met; count -->"
right "160,000<!-- is validation front-2d; 20; evaluations -->"
right "7<!-- from tests/scripts/texts.sh -->"
right "9<!-- is run pd2d none.scene; steps -->"
wrong "0.024<!-- is $cell --> off" "found 0.024, expected 0.023" 0.023
wrong "2.4e-2<!-- is $cell -->" "found 2.4e-2" 2.3e-2
wrong "2e-2<!-- below validation front-2d; max; error -->" "found 2e-2" 3e-2
wrong "150,000<!-- is validation front-2d; 20; evaluations -->" "expected 160,000" 160,000
wrong "five<!-- is validation summary; met; count -->" "expected one" one
wrong "1<!-- is validation front-2d; 30; error -->" 'no report has "validation front-2d; 30; error"'
wrong "1<!-- is validation back-2d; 10; error -->" 'no report has'
wrong "none <!-- is $cell -->" "there is no number before"
wrong "7<!-- from tests/none.c -->" "there is no tests/none.c"
wrong "## What was measured
| what | result | with |
|---|---|---|
| speed | 3 s | here |" "README.md:4: a row without a source"
score
