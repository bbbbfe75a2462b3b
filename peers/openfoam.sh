# For the OpenFOAM files of all cases; . it.
export WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam} FOAM_SIGFPE=false
mkdir -p 0 constant system

# dictionary FILE [CLASS]: the standard input under OpenFOAM's header.
dictionary() {
    mkdir -p "$(dirname "$1")"
    { echo "FoamFile { version 2.0; format ascii; class ${2:-dictionary}; object $(basename "$1"); }"; cat; } > "$1"
}

# time_steps PROGRAM END DELTA DIGITS < MORE: as many significant digits of what is written at END.
time_steps() {
    { echo "application $1; startFrom startTime; startTime 0; stopAt endTime; endTime $2; deltaT $3;"
      echo "writeControl runTime; writeInterval $2; writePrecision $4; writeFormat ascii; runTimeModifiable false;"
      cat; } | dictionary system/controlDict
}

# schemes DDT DIVERGENCES: derivatives of second order but for what these two say.
schemes() {
    dictionary system/fvSchemes << END
ddtSchemes { default $1; }
gradSchemes { default Gauss linear; }
divSchemes { default none; $2 }
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
END
}

# steady_flow NU SIMPLE: laminar, central differences, SIMPLEC; SIMPLE: residuals at which it ends, and more keys.
steady_flow() {
    schemes steadyState "div(phi,U) Gauss linear; div((nuEff*dev2(T(grad(U))))) Gauss linear;"
    dictionary system/fvSolution << END
solvers
{
    p { solver GAMG; smoother GaussSeidel; tolerance 1e-10; relTol 0.05; }
    U { solver PBiCGStab; preconditioner DILU; tolerance 1e-10; relTol 0.1; }
}
SIMPLE { consistent yes; $2 }
relaxationFactors { equations { U 0.9; } }
END
    dictionary constant/transportProperties <<< "transportModel Newtonian; nu $1;"
    dictionary constant/turbulenceProperties <<< "simulationType laminar;"
}

# unit_square N GRADING < PATCHES: one cell deep; its sides are (3 7 6 2) above, (0 4 7 3) left, (2 6 5 1) right,
# (1 5 4 0) below.
unit_square() {
    { echo "vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 .1) (1 0 .1) (1 1 .1) (0 1 .1));"
      echo "blocks (hex (0 1 2 3 4 5 6 7) ($1 $1 1) simpleGrading ($2 $2 1));"
      echo "boundary ( $(cat) frontAndBack { type empty; faces ((0 3 2 1) (4 5 6 7)); } );"; } |
        dictionary system/blockMeshDict
}

# foam PROGRAM ARGUMENT...: runs it; its words are kept, the last of them shown where it fails.
foam() { "$@" > "log.$1" 2>&1 || { tail -n 20 "log.$1"; exit 1; }; }

# extreme FILE COLUMN SIGN: largest value of SIGN times a column over the first one, by the parabola through three rows.
extreme() {
    awk -v c="$2" -v s="$3" '{ x[NR] = $1; f[NR] = s * $c; if (NR == 1 || f[NR] > f[k]) k = NR }
        END { a = x[k] - x[k-1]; b = x[k+1] - x[k]; p = (f[k] - f[k-1]) / a; q = (f[k+1] - f[k]) / b
              d = (p * b + q * a) / (a + b); e = (q - p) / (a + b); printf "%.10g", s * (f[k] - d * d / (4 * e)) }' "$1"
}
