# Developed flow is a Poisson equation over the section: laplacianFoam with a source, GAMG; n odd cells a side.
. "$CASE/../openfoam.sh"
n=$1
time_steps laplacianFoam 1 1 12 < /dev/null
schemes steadyState ""
dictionary system/fvSolution << 'END'
solvers { T { solver GAMG; smoother GaussSeidel; tolerance 1e-10; relTol 0; } }
SIMPLE { nNonOrthogonalCorrectors 0; }
END
unit_square $n 1 <<< "walls { type patch; faces ((3 7 6 2) (0 4 7 3) (2 6 5 1) (1 5 4 0)); }"
dictionary constant/transportProperties << 'END'
DT DT [0 2 -1 0 0 0 0] 1;
END
dictionary system/fvOptions << 'END'
push
{
    type scalarSemiImplicitSource; active yes; selectionMode all; volumeMode specific;
    injectionRateSuSp { T (1 0); }
}
END
dictionary 0/T volScalarField << 'END'
dimensions [0 0 0 0 0 0 0]; internalField uniform 0;
boundaryField { walls { type fixedValue; value uniform 0; } frontAndBack { type empty; } }
END
foam blockMesh
foam laplacianFoam
awk -v n="$n" '/internalField/ { on = 1; next } /^\)/ { on = 0 } on && /^[0-9]/ && seen++ { k++; sum += $1
        if (k == (n * n + 1) / 2) m = $1 } END { printf "peer flow=%.10g middle=%.10g\n", sum / k, m }' 1/T
