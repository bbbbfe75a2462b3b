#!/bin/sh
# Scenes of tests/scenes/ and what their runs give. Comments in the scene say what is run and what is expected of it:
#
#   # run: pd2d run.until="3 h"            the program and values that are changed
#   # run: pd2d --progress off               with notes, which --quiet leaves out
#   # expect: volume_loss = 0.144375 +- 1e-3     a figure (tests/lib/script.sh) and an absolute tolerance
#   # expect: plane=a:flow = 1.6e-8 +- 0.1 %     or a relative one
#   # expect: E absent                     no result line has the figure
#   # expect: probes.csv:2 = nan           it has no value
#   # expect: says TEXT                    a line of what the program said holds TEXT
#   # expect: silent TEXT                  none does
#   # expect: status 2                     of the program; without: 0
#
# A scene may be run more than once. Expectations belong to the run above them. The values are closed forms or
# references that other codes gave; the comment of the scene says which.
. tests/lib/script.sh

# run COMMAND SCENE: what the program says is in $dir/log, its output in $dir/out, its status in $status.
run() {
    eval "set -- $1 \"\$2\"" # the command holds quoted values
    program=$1
    shift
    rm -rf "$dir/out"
    case " $* " in *\ --progress\ *) ;; *) set -- "$@" --quiet ;; esac
    timeout 120 "$programs/$program" "$@" --out "$dir/out" > "$dir/log" 2>&1 < /dev/null
    status=$?
}

# near FOUND VALUE TOLERANCE [%]
near() {
    awk -v f="$1" -v v="$2" -v t="$3" -v p="$4" 'BEGIN { if (p == "%") t *= (v < 0 ? -v : v) / 100
        e = f - v; exit !(f ~ /^[-+.0-9]/ && e <= t + 0 && -e <= t + 0) }'
}

# expect TEXT: one expectation of the last run.
expect() {
    found=
    case $1 in
    says\ *) grep -qF -- "${1#says }" "$dir/log" ;;
    silent\ *) ! grep -qF -- "${1#silent }" "$dir/log" ;;
    *\ absent)
        found=$(figure "${1% absent}")
        [ -z "$found" ]
        ;;
    *\ =\ nan)
        found=$(figure "${1% = *}")
        [ "$found" = nan ]
        ;;
    *\ =\ *)
        found=$(figure "${1% = *}")
        # shellcheck disable=SC2046
        near "$found" $(echo "${1##* = }" | sed 's/+-//') ;;
    *) false ;;
    esac
    verdict "$name: expected $1; found '$found'" $?
}

# end_of_run: the status of the last run is what its expectations say.
end_of_run() {
    [ -z "$command" ] || { [ "$status" = "$wanted" ]; verdict "$name: status $status, expected $wanted: $command"; }
}

for scene in ${SCENES:-tests/scenes/*.scene}; do
    sed -n 's/^# *\(run: .*\)/\1/p; s/^# *\(expect: .*\)/\1/p' "$scene" > "$dir/lines"
    command='' runs=0
    while IFS= read -r line <&3; do
        case $line in
        run:*)
            end_of_run
            command=${line#run: } runs=$((runs + 1)) wanted=0
            name="$scene, run $runs"
            run "$command" "$scene" ;;
        expect:\ status\ *) wanted=${line##* } ;;
        expect:*) expect "${line#expect: }" ;;
        esac
    done 3< "$dir/lines"
    end_of_run
    check "$scene says what is run" test "$runs" -gt 0
done
score
