#!/bin/sh
# Bad scenes: the driver says what is wrong in one line with file and line, ends with 2 and leaves no output behind.
build=${BUILD:-build}
case $build in /*) ;; *) build=$PWD/$build ;; esac
root=$PWD
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1
passed=0 failed=0

# A small channel with a pin: the base that each case spoils.
base() {
    cat > bad.scene << 'END'
[grid]      h = 10 um   m = 3   box = -100 um .. 200 um, -60 um .. 60 um
[shape pin] box = 0 .. 60 um, -20 um .. 20 um   kind = solid   material = mg4ag   grains = 40 um
[side x-]   flow = inlet   profile = parabola   mean = 0.01 m/s   C = 0
[side x+]   flow = outlet   p = 0
[flow]      rho = 1000   mu = 1e-3 Pa s
[transport] D = 1e-9 m2/s
[dissolve]  rate = 1.3 um/h * (1 - C/Csat)   Csat = 56 mol/m3   gb_factor = 3
[run]       until = 1 h
[output]    fields = C, v
[probe a]   at = 100 um, 0
END
    sed -i 's/rho = 1000 /rho = 1000 kg\/m3 /' bad.scene
}

# rejects NAME MESSAGE [ARGUMENT...]: status 2, nothing on stdout, exactly the line "pd2d: MESSAGE", no folder.
rejects() {
    name=$1 message=$2
    shift 2
    rm -rf out
    "$build/pd2d" bad.scene --out out "$@" > stdout 2> stderr
    status=$?
    printf 'pd2d: %s\n' "$message" > wanted
    if [ $status = 2 ] && [ ! -s stdout ] && [ ! -e out ] && cmp -s stderr wanted; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "$name: status $status, folder $([ -e out ] && echo made || echo absent)"
        sed 's/^/  expected /' wanted
        sed 's/^/  found    /' stderr
        sed 's/^/  stdout   /' stdout
    fi
}

# spoil NAME SED MESSAGE: one edit of the base.
spoil() {
    base
    sed -i "$2" bad.scene
    rejects "$1" "$3"
}
