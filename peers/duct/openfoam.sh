# Developed flow is a Poisson equation over the section: laplacianFoam with a source, GAMG; n odd cells a side.
. "$CASE/../openfoam.sh"
n=$1
dictionary system/controlDict << END
application laplacianFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;
writeControl timeStep; writeInterval 1; writePrecision 12; writeFormat ascii; runTimeModifiable false;
END
dictionary system/fvSchemes << 'END'
ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; }
divSchemes { default none; }
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
END
dictionary system/fvSolution << 'END'
solvers { T { solver GAMG; smoother GaussSeidel; tolerance 1e-10; relTol 0; } }
SIMPLE { nNonOrthogonalCorrectors 0; }
END
dictionary system/blockMeshDict << END
vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 .1) (1 0 .1) (1 1 .1) (0 1 .1));
blocks (hex (0 1 2 3 4 5 6 7) ($n $n 1) simpleGrading (1 1 1));
boundary
(
    walls { type patch; faces ((3 7 6 2) (0 4 7 3) (2 6 5 1) (1 5 4 0)); }
    frontAndBack { type empty; faces ((0 3 2 1) (4 5 6 7)); }
);
END
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
