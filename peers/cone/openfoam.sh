# scalarTransportFoam, limitedLinear; 8 n steps, Courant number 0.2 at the middle of the cone.
. "$CASE/../openfoam.sh"
n=$1
time_steps scalarTransportFoam 1 "$(awk "BEGIN { printf \"%.12g\", 1 / (8 * $n) }")" 10 < /dev/null
schemes "CrankNicolson 0.9" "div(phi,T) Gauss limitedLinear 1;"
dictionary system/fvSolution << 'END'
solvers { T { solver PBiCGStab; preconditioner DILU; tolerance 1e-9; relTol 0; } }
SIMPLE { nNonOrthogonalCorrectors 0; }
END
unit_square $n 1 <<< "rim { type patch; faces ((3 7 6 2) (0 4 7 3) (2 6 5 1) (1 5 4 0)); }"
dictionary constant/transportProperties << 'END'
DT DT [0 2 -1 0 0 0 0] 1e-12;
END
# field U or T: its values in the cells, x fastest.
field() {
    awk -v n="$n" -v U="$1" 'BEGIN { pi = atan2(0, -1); print n * n; print "("
        for (k = 0; k < n * n; k++) { x = (k % n + 0.5) / n; y = (int(k / n) + 0.5) / n
            if (U == "U") printf "(%.10g %.10g 0)\n", 2 * pi * (0.5 - y), 2 * pi * (x - 0.5)
            else { c = 1 - sqrt((x - 0.5)^2 + (y - 0.25)^2) / 0.15; if (c < 0) c = 0; printf "%.10g\n", c } }
        print ");" }'
}
{ echo "dimensions [0 1 -1 0 0 0 0]; internalField nonuniform List<vector>"; field U
  echo "boundaryField { rim { type zeroGradient; } frontAndBack { type empty; } }"; } | dictionary 0/U volVectorField
{ echo "dimensions [0 0 0 0 0 0 0]; internalField nonuniform List<scalar>"; field T
  echo "boundaryField { rim { type inletOutlet; inletValue uniform 0; value uniform 0; } frontAndBack { type empty; } }"
} | dictionary 0/T volScalarField
foam blockMesh
foam scalarTransportFoam
awk -v n="$n" '/internalField/ { on = 1; next } /^\)/ { on = 0 } on && /^[-0-9]/ && seen++ { k = seen - 2
        x = (k % n + 0.5) / n; y = (int(k / n) + 0.5) / n; c = 1 - sqrt((x - 0.5)^2 + (y - 0.25)^2) / 0.15
        if (c < 0) c = 0; d = $1 - c; off += d < 0 ? -d : d; size += c; if ($1 > peak) peak = $1 }
    END { printf "peer l1=%.8g peak=%.8g\n", off / size, peak }' 1/T
