# simpleFoam, laminar, SIMPLEC; central differences. Uniform: n odd, so that cells have their centres on the centre
# lines; values of cells. n:graded, n even: linear between corners and centres.
. "$CASE/../openfoam.sh"
case $1 in
*:*) n=${1%:*} grading="((.5 .5 6) (.5 .5 .16666666667))" points="uniform; nPoints 1001" scheme=cellPoint ;;
*) n=$1 grading=1 points=midPoint scheme=cell ;;
esac
time_steps simpleFoam 20000 1 12 < /dev/null
steady_flow 1e-3 "pRefCell 0; pRefValue 0; residualControl { p 1e-6; U 1e-7; }"
unit_square $n "$grading" << 'END'
lid { type wall; faces ((3 7 6 2)); }
walls { type wall; faces ((0 4 7 3) (2 6 5 1) (1 5 4 0)); }
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
