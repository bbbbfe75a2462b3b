#!/bin/sh
# Names that texts and comments speak of exist: functions, types and macros, files, modules, tests, cases, scenes.
. tests/lib/script.sh

# Two kinds of lines: "code NAME", "text FILE:LINE NAME". A comment is text, strings are neither.
cat > "$dir/split.awk" << 'END'
function names(s, kind, at,    name) {
    while (match(s, /(^|[^A-Za-z0-9_])(pd|pdi|PD|PDI|PDCORR)_[A-Za-z0-9_]+\**/)) {
        name = substr(s, RSTART, RLENGTH)
        sub(/^[^A-Za-z]/, "", name)
        s = substr(s, RSTART + RLENGTH)
        if (kind == "code") sub(/\**$/, "", name)
        print kind, at, name
    }
}
FNR == 1 { comment = 0 }
FILENAME !~ /\.[ch]$/ { names($0, FILENAME ~ /\.(md|scene)$/ ? "text" : "code", FILENAME ":" FNR); next }
{
    line = $0
    while (line != "") {
        if (comment) {
            end = index(line, "*/")
            names(end ? substr(line, 1, end - 1) : line, "text", FILENAME ":" FNR)
            line = end ? substr(line, end + 2) : ""
            comment = !end
        } else if (match(line, /"([^"\\]|\\.)*"|'([^'\\]|\\.)*'|\/\*/)) {
            before = substr(line, 1, RSTART - 1)
            comment = substr(line, RSTART, RLENGTH) == "/*"
            line = substr(line, RSTART + RLENGTH)
            names(before, "code", FILENAME ":" FNR)
        } else {
            names(line, "code", FILENAME ":" FNR)
            line = ""
        }
    }
}
END

# A name in a text may end in `*` or `_`, which stands for all that begin so, in `X` or `x`, which stands for any, or in
# the dimension that PD_NAME adds.
cat > "$dir/judge.awk" << 'END'
$1 == "code" { known[$3] = 1; while (sub(/_[^_]*$/, "", $3)) begins[$3 "_"] = 1; next }
{
    name = $3
    star = sub(/\**$/, "", name)
    if (name in known || name in begins || name ~ /^pdi?_[xXT](_|$)/) next
    if ($3 ~ /\*$/) for (k in known) if (index(k, name) == 1) next
    sub(/_[123]d$/, "", name)
    if (!(name in known)) print $2 ": no " $3
}
END

# wrong_names FILE...: the names of nothing, one a line.
wrong_names() {
    awk -f "$dir/split.awk" "$@" | sort -s -k1,1 | awk -f "$dir/judge.awk"
}

sources=$(find src drivers cases tests tools examples -name '*.[ch]' -o -name '*.sh' | sort)
pages="README.md $(echo docs/*.md docs/theory/*.md)"
texts="$pages $(echo examples/scenes/*.scene examples/scenes/validation/*.scene)"
# shellcheck disable=SC2086
wrong_names $sources Makefile $texts > "$dir/log"
check "texts and comments name what the code has" test ! -s "$dir/log"

# Files. The tests of the tools make up some, and name none in comments.
folder='(src|drivers|cases|tests|tools|examples|docs)'
grep -noE "(^|[^A-Za-z0-9_/.-])$folder/[A-Za-z0-9_./-]*[A-Za-z0-9_/][*<\$%]*" CHANGELOG.md $pages \
    Makefile $(find src drivers cases examples tests/hard tests/embed tests/fuzz -type f) |
    sed 's/:[^:A-Za-z]*\([a-z]*\/\)/:\1/' | while IFS=: read -r file line path; do
    case $path in *[*\<\$%] | tests/ROOM/test_x.c | tests/hard/test_x.c) continue ;; esac
    [ -e "$path" ] || [ -e "${file%/*}/$path" ] || echo "$file:$line: no $path"
done > "$dir/log"
check "texts and comments name files that exist" test ! -s "$dir/log"

# Modules, tests and cases, as the texts write them.
modules=$(sed -n '/^#/d; /^c[ou]/s/^\(cut\|cold\) .*//; p' src/MODULES | cut -d' ' -f2-)
grep -noE '[Mm]odules? `[a-z_]+`' $pages | sed 's/:[^:]*`\(.*\)`/:\1/' |
    while IFS=: read -r file line name; do
    case " $(echo $modules) " in *" $name "*) ;; *) echo "$file:$line: no module $name" ;; esac
done > "$dir/log"
check "texts name modules that exist" test ! -s "$dir/log"

grep -noE '`test_[a-z0-9_]+`' $pages | sed 's/`//g' | while IFS=: read -r file line name; do
    ls tests/*/"$name".c tests/scripts/"$name".sh 2> /dev/null | grep -q . || echo "$file:$line: no $name"
done > "$dir/log"
check "texts name tests that exist" test ! -s "$dir/log"

grep -noE '`(validate|bench)[123]d [a-z0-9_ ]+`' $pages | tr -d '`' |
    while IFS=: read -r file line words; do
    set -- $words
    cases=cases/${1%[123]d}
    shift
    for name; do grep -qE "^ *\"$name\"," "$cases"/*.h || echo "$file:$line: no case $name in $cases"; done
done > "$dir/log"
check "texts name cases that exist" test ! -s "$dir/log"

grep -noE '[a-z0-9_/]+\.(scene|cfg|csv)`' $pages | tr -d '`' | while IFS=: read -r file line name; do
    case $name in examples/*) [ -e "$name" ] || echo "$file:$line: no $name" ;; esac
done > "$dir/log"
check "texts name scenes that exist" test ! -s "$dir/log"

# What the test finds.
cat > "$dir/code.c" << 'END'
/* pd_gone, pd_there_*, pd_there_on_2d, pd_there_on, pd_gone_*
 * and PDI_GONE */
int pd_there_on; /* PD_GONE */ char *s = "/* pd_string */"; int PD_HERE;
END
wrong_names "$dir/code.c" | sed 's/.*: no //' | tr '\n' ' ' > "$dir/log"
check "finds what is gone" test "$(cat "$dir/log")" = "pd_gone pd_gone_* PDI_GONE PD_GONE "
score
