# For the OpenFOAM files of all cases; . it.
export WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam} FOAM_SIGFPE=false
mkdir -p 0 constant system

# dictionary FILE [CLASS]: the standard input under OpenFOAM's header.
dictionary() {
    mkdir -p "$(dirname "$1")"
    { echo "FoamFile { version 2.0; format ascii; class ${2:-dictionary}; object $(basename "$1"); }"; cat; } > "$1"
}

# foam PROGRAM ARGUMENT...: runs it; its words are kept, the last of them shown where it fails.
foam() { "$@" > "log.$1" 2>&1 || { tail -n 20 "log.$1"; exit 1; }; }

# extreme FILE COLUMN SIGN: largest value of SIGN times a column over the first one, by the parabola through three rows.
extreme() {
    awk -v c="$2" -v s="$3" '{ x[NR] = $1; f[NR] = s * $c; if (NR == 1 || f[NR] > f[k]) k = NR }
        END { a = x[k] - x[k-1]; b = x[k+1] - x[k]; p = (f[k] - f[k-1]) / a; q = (f[k+1] - f[k]) / b
              d = (p * b + q * a) / (a + b); e = (q - p) / (a + b); printf "%.10g", s * (f[k] - d * d / (4 * e)) }' "$1"
}
