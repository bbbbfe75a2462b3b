#!/bin/sh
# texts.sh [--write] [--runs] [FILE...]: holds figures in texts against the reports in docs/details/. A figure
# is a number right before a comment, which readers do not see:
#
#   0.98<!-- is validation cylinder-2d; 10; drag, box; x100 --> % off
#
#   is | below | above    the same to the digits printed | a bound of it
#   REPORT SECTION        docs/details/REPORT.md and the name of its section: the id of the anchor; /CAPTION behind it:
#                         the table under that bold caption, else the first one that has the row and the column
#   ; ROW                 first cell of the row, in a summary "case, 2D: part, measure"; `max`, `min`, `last`: of all
#   ; COLUMN              heading
#   ; x100                factor, where there is one
#   REPORT summary; met; count          number of goals (missed: those missed)
#   count GLOB            number of files; in words, too
#   run PROGRAM ARGUMENTS; KEY; x100    of the result line of a run; held against it with --runs only
#   from FILE             stands in the log or the comments of that file, which has to be there
#
# --write puts the figures of the reports in place of those in the texts. Every row of the table "What was measured" of
# README.md has to have a source. Without files: README.md and the texts of docs/ that are not generated.
write=0 runs=0
while :; do
    case $1 in
    --write) write=1 ;;
    --runs) runs=1 ;;
    *) break ;;
    esac
    shift
done
[ $# -gt 0 ] || set -- README.md docs/architecture.md docs/crevice.md docs/decisions.md docs/guide.md docs/theory.md \
    docs/theory/*.md docs/paper/paper.md
docs=${DOCS:-docs} build=${BUILD:-build}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT

# What awk cannot look up: "KIND WORDS<tab>VALUE", one a line.
markers() { cat "$@" | grep -o "<!-- [a-z]* $kind [^>]*-->" | sed "s/<!-- [a-z]* $kind //; s/ *-->\$//" | sort -u; }
: > "$dir/values"
kind=count
markers "$@" | while read -r glob; do
    printf 'count %s\t%s\n' "$glob" "$(ls $glob 2> /dev/null | wc -l)" >> "$dir/values"
done
kind=run
[ $runs = 0 ] || markers "$@" | sed 's/ *;.*//' | sort -u | while read -r command; do
    program=${command%% *}
    printf '%s\n' "runs $command" >&2
    eval "\"$build/$program\" ${command#* } --out \"$dir/out\" --quiet" > "$dir/log" 2>&1 || cat "$dir/log" >&2
    rm -rf "$dir/out"
    line=$(grep '^result case=[^ ]* dim=' "$dir/log" | tail -n 1)
    for pair in $line; do printf 'run %s; %s\t%s\n' "$command" "${pair%%=*}" "${pair#*=}"; done >> "$dir/values"
done
for file in examples/*.c tests/*/*.c tests/scripts/*.sh cases/*/*.h; do
    printf 'from %s\t1\n' "$file" >> "$dir/values"
done

for text in "$@"; do
    awk -v write=$write -v runs=$runs -v name="$text" -v out="$dir/new" -v docs="$docs" -v values="$dir/values" '
    function trim(s) { gsub(/^[ \t]+|[ \t]+$/, "", s); return s }
    function complain(what) { printf "%s:%d: %s\n", name, FNR, what; wrong++ }
    # ---- the reports: cell[report, table, row, column], head[report, table, heading], of[report, table] = section
    function learn(report, line,    n, c, k, cells) {
        if (match(line, /^<a id="[^"]*">/)) { section = substr(line, RSTART + 7, RLENGTH - 9); caption = ""; return }
        if (line ~ /^## Summary/) section = "summary"
        if (line ~ /^\*\*.*\*\*$/) { caption = substr(line, 3, length(line) - 4); return }
        if (line !~ /^\|/) { inside = 0; return }
        n = split(line, cells, "|")
        if (!inside) {
            inside = 1
            table = ++tables[report]
            of[report, table] = section
            under[report, table] = caption
            for (k = 2; k < n; k++) {
                c = trim(cells[k])
                if (!((report, table, c) in head)) head[report, table, c] = k - 1
            }
            return
        }
        if (cells[2] ~ /^-+$/) return
        c = ++rows[report, table]
        for (k = 2; k < n; k++) cell[report, table, c, k - 1] = trim(cells[k])
        if (section != "summary") return
        # "poiseuille, 2D: m = 3, u, L2" in place of the verdict, which is counted
        k = cell[report, table, c, 1]
        gsub(/\*/, "", k)
        given[report " summary; " k "; count"]++
        label = cell[report, table, c, 2]
        sub(/^\[/, "", label)
        sub(/\].*/, "", label)
        label = label ":"
        for (k = 3; k < n - 3; k++)
            if (cell[report, table, c, k] != "") label = label (label ~ /:$/ ? " " : ", ") cell[report, table, c, k]
        cell[report, table, c, 1] = label
    }
    function number(s) { gsub(/\*/, "", s); return s ~ /^[-+]?[0-9.]+(e[-+]?[0-9]+)?$/ ? s + 0 : "none" }
    # The value of "REPORT SECTION[/CAPTION]; ROW; COLUMN", "none" when there is none.
    function value(source,    part, n, words, report, where, want, t, r, k, v, best, slash) {
        if (source in given) return given[source]
        n = split(source, part, /; */)
        if (n < 3) return "none"
        split(part[1], words, " ")
        report = words[1]
        where = substr(part[1], length(report) + 2)
        want = ""
        if ((slash = index(where, "/")) > 0) { want = substr(where, slash + 1); where = substr(where, 1, slash - 1) }
        for (t = 1; t <= tables[report]; t++) {
            if (of[report, t] != where || (want != "" && under[report, t] != want)) continue
            if (!((report, t, part[3]) in head)) continue
            k = head[report, t, part[3]]
            best = "none"
            for (r = 1; r <= rows[report, t]; r++) {
                v = number(cell[report, t, r, k])
                if (v == "none") continue
                if (cell[report, t, r, 1] == part[2]) return v
                if (part[2] == "last" || (part[2] == "max" && (best == "none" || v > best)) || \
                    (part[2] == "min" && (best == "none" || v < best))) best = v
            }
            if (best != "none") return best
        }
        return "none"
    }
    # ---- numbers as they stand in texts
    function decimals(s,    at) { sub(/e.*/, "", s); at = index(s, "."); return at ? length(s) - at : 0 }
    function plain(s) { gsub(/,/, "", s); return s + 0 }
    function unit(s,    e) {
        e = s ~ /e/ ? substr(s, index(s, "e") + 1) + 0 : 0
        return 10 ^ (e - decimals(s))
    }
    function commas(s,    whole, rest) {
        whole = s
        rest = ""
        while (length(whole) > 3) {
            rest = "," substr(whole, length(whole) - 2) rest
            whole = substr(whole, 1, length(whole) - 3)
        }
        return whole rest
    }
    # v in the style of s; up: away from the value, for a bound
    function styled(v, s, up,    t, step) {
        if (up) { # one digit
            step = 10 ^ int(log(v) / log(10) - (v < 1 ? 0.999999999999 : 0))
            v = (up > 0 ? int(v / step - 1e-9) + 1 : int(v / step + 1e-9)) * step
        }
        if (s ~ /e/) {
            t = sprintf("%." decimals(s) "e", v)
            sub(/e-0*/, "e-", t)
            sub(/e\+0*/, "e", t)
            return t
        }
        t = sprintf("%." decimals(s) "f", v)
        if (t + 0 == 0 && v != 0) t = sprintf("%.1g", v)
        return s ~ /,/ ? commas(t) : t
    }
    function holds(how, v, s,    t) {
        t = plain(s)
        if (how == "is") return (v - t <= 0.5000001 * unit(s)) && (t - v <= 0.5000001 * unit(s))
        return how == "below" ? v <= t * (1 + 1e-9) : v >= t * (1 - 1e-9)
    }
    # ---- one line of a text
    function figures(line,    done, at, len, mark, how, source, s, v, factor, start, is_word, k) {
        done = ""
        while (match(line, /<!-- (is|below|above|from) [^>]*-->/)) {
            at = RSTART
            len = RLENGTH
            mark = trim(substr(line, at + 5, len - 8))
            found++
            how = mark
            sub(/ .*/, "", how)
            source = how == "from" ? mark : substr(mark, length(how) + 2)
            start = substr(line, 1, at - 1)
            factor = 1
            if (match(source, /; *x[0-9.e-]+$/)) {
                factor = substr(source, RSTART)
                sub(/; *x/, "", factor)
                source = substr(source, 1, RSTART - 1)
            }
            is_word = 0
            s = ""
            if (match(start, /[0-9][0-9,]*(\.[0-9]+)?(e-?[0-9]+)?$/)) s = substr(start, RSTART)
            else if (match(start, /[a-z]+$/)) {
                for (k = 1; k <= 12; k++) if (substr(start, RSTART) == word[k]) is_word = k
                s = substr(start, RSTART)
            }
            v = value(source)
            if (how == "from") {
                if (!(source in given)) complain("there is no " substr(source, 6))
            } else if (source ~ /^run / && !runs) {
                skipped++
            } else if (v == "none") complain("no report has \"" source "\"")
            else if (s == "") complain("there is no number before \"" mark "\"")
            else {
                v *= factor
                if (is_word ? v != is_word : !holds(how, v, s)) {
                    if (write) {
                        k = is_word ? word[v] : styled(v, s, how == "is" ? 0 : how == "below" ? 1 : -1)
                        start = substr(start, 1, length(start) - length(s)) k
                        printf "%s:%d: %s -> %s\n", name, FNR, s, k
                    } else complain("found " s ", expected " (how == "is" ? "" : how " the bound ") \
                                    (is_word ? word[v] : styled(v, s, 0)) " (" source ")")
                }
            }
            done = done start substr(line, at, len)
            line = substr(line, at + len)
        }
        return done line
    }
    BEGIN {
        split("one two three four five six seven eight nine ten eleven twelve", word, " ")
        while ((getline line < values) > 0) { split(line, pair, "\t"); given[pair[1]] = pair[2] + 0 }
        split("validation performance stability", report, " ")
        for (r = 1; r <= 3; r++) {
            section = caption = ""
            inside = 0
            while ((getline line < (docs "/details/" report[r] ".md")) > 0) learn(report[r], line)
        }
    }
    {
        before = found
        fresh = figures($0)
        if ($0 ~ /^## /) measured = $0 ~ /^## What was measured/
        if (measured && /^\| / && !/^\| what \|/ && found == before) complain("a row without a source")
        print fresh > out
    }
    END {
        printf "%s: %d figures with a source, %d of runs that were not made\n", name, found, skipped
        exit wrong > 0
    }' "$text"
    status=$?
    [ $status = 0 ] || failed=1
    [ $write = 0 ] || cmp -s "$dir/new" "$text" || cp "$dir/new" "$text"
done
[ -z "$failed" ]
