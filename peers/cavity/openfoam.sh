# simpleFoam, laminar, SIMPLEC; central differences. Uniform: n odd, so that cells have their centres on the centre
# lines; values of cells. n:graded, n even: linear between corners and centres.
. "$CASE/../openfoam.sh"
case $1 in
*:*) n=${1%:*} grading="((.5 .5 6) (.5 .5 .16666666667))" points="uniform; nPoints 1001" scheme=cellPoint ;;
*) n=$1 grading=1 points=midPoint scheme=cell ;;
esac
dictionary system/controlDict << END
application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 20000; deltaT 1;
writeControl timeStep; writeInterval 20000; writePrecision 12; writeFormat ascii; runTimeModifiable false;
END
dictionary system/fvSchemes << 'END'
ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; }
divSchemes { default none; div(phi,U) Gauss linear; div((nuEff*dev2(T(grad(U))))) Gauss linear; }
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
END
dictionary system/fvSolution << 'END'
solvers
{
    p { solver GAMG; smoother GaussSeidel; tolerance 1e-10; relTol 0.05; }
    U { solver PBiCGStab; preconditioner DILU; tolerance 1e-10; relTol 0.1; }
}
SIMPLE { consistent yes; pRefCell 0; pRefValue 0; residualControl { p 1e-6; U 1e-7; } }
relaxationFactors { equations { U 0.9; } }
END
dictionary system/blockMeshDict << END
vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 .1) (1 0 .1) (1 1 .1) (0 1 .1));
blocks (hex (0 1 2 3 4 5 6 7) ($n $n 1) simpleGrading ($grading $grading 1));
boundary
(
    lid { type wall; faces ((3 7 6 2)); }
    walls { type wall; faces ((0 4 7 3) (2 6 5 1) (1 5 4 0)); }
    frontAndBack { type empty; faces ((0 3 2 1) (4 5 6 7)); }
);
END
dictionary constant/transportProperties << 'END'
transportModel Newtonian; nu 1e-3;
END
dictionary constant/turbulenceProperties << 'END'
simulationType laminar;
END
dictionary 0/U volVectorField << 'END'
dimensions [0 1 -1 0 0 0 0];
internalField uniform (0 0 0);
boundaryField
{
    lid { type fixedValue; value uniform (1 0 0); }
    walls { type noSlip; }
    frontAndBack { type empty; }
}
END
dictionary 0/p volScalarField << 'END'
dimensions [0 2 -2 0 0 0 0];
internalField uniform 0;
boundaryField { lid { type zeroGradient; } walls { type zeroGradient; } frontAndBack { type empty; } }
END
dictionary system/lines << END
type sets;
libs (sampling);
interpolationScheme $scheme;
setFormat raw;
fields (U);
sets
(
    up { type $points; axis y; start (0.5 0 0.05); end (0.5 1 0.05); }
    across { type $points; axis x; start (0 0.5 0.05); end (1 0.5 0.05); }
);
END
foam blockMesh
foam simpleFoam
foam simpleFoam -postProcess -func lines -latestTime
echo "peer umin=$(extreme postProcessing/lines/*/up_U.xy 2 -1)" \
    "vmax=$(extreme postProcessing/lines/*/across_U.xy 3 1) vmin=$(extreme postProcessing/lines/*/across_U.xy 3 -1)"
