# simpleFoam, laminar, SIMPLEC; central differences. A ring of 4 n by n cells around the cylinder, n cells across half
# the depth, whose other half is its mirror image.
. "$CASE/../openfoam.sh"
n=$1
half=$((n / 2))
time_steps simpleFoam 3000 1 10 << 'END'
functions
{
    forces
    {
        type forces; libs (forces); patches (cylinder); rho rhoInf; rhoInf 1; CofR (0.5 0.2 0);
        writeControl timeStep; writeInterval 1;
    }
}
END
steady_flow 1e-3 "nNonOrthogonalCorrectors 0; residualControl { p 1e-5; U 1e-6; }"
# A square of 0.2 m around the cylinder holds the ring; a to d: where its diagonals meet the cylinder.
dictionary system/blockMeshDict << END
a 0.46464466094; b 0.53535533906; c 0.16464466094; d 0.23535533906;
vertices
(
    (0 0 0) (.4 0 0) (.6 0 0) (2.5 0 0)
    (0 .1 0) (.4 .1 0) (.6 .1 0) (2.5 .1 0)
    (0 .3 0) (.4 .3 0) (.6 .3 0) (2.5 .3 0)
    (0 .41 0) (.4 .41 0) (.6 .41 0) (2.5 .41 0)
    (\$a \$c 0) (\$b \$c 0) (\$a \$d 0) (\$b \$d 0)
    (0 0 .205) (.4 0 .205) (.6 0 .205) (2.5 0 .205)
    (0 .1 .205) (.4 .1 .205) (.6 .1 .205) (2.5 .1 .205)
    (0 .3 .205) (.4 .3 .205) (.6 .3 .205) (2.5 .3 .205)
    (0 .41 .205) (.4 .41 .205) (.6 .41 .205) (2.5 .41 .205)
    (\$a \$c .205) (\$b \$c .205) (\$a \$d .205) (\$b \$d .205)
);
blocks
(
    hex (0 1 5 4 20 21 25 24) ($n $half $n) simpleGrading (.5 3 4)
    hex (1 2 6 5 21 22 26 25) ($n $half $n) simpleGrading (1 3 4)
    hex (2 3 7 6 22 23 27 26) ($((3 * n)) $half $n) simpleGrading (8 3 4)
    hex (4 5 9 8 24 25 29 28) ($n $n $n) simpleGrading (.5 1 4)
    hex (6 7 11 10 26 27 31 30) ($((3 * n)) $n $n) simpleGrading (8 1 4)
    hex (8 9 13 12 28 29 33 32) ($n $half $n) simpleGrading (.5 .3333333 4)
    hex (9 10 14 13 29 30 34 33) ($n $half $n) simpleGrading (1 .3333333 4)
    hex (10 11 15 14 30 31 35 34) ($((3 * n)) $half $n) simpleGrading (8 .3333333 4)
    hex (5 6 17 16 25 26 37 36) ($n $n $n) simpleGrading (1 .25 4)
    hex (9 5 16 18 29 25 36 38) ($n $n $n) simpleGrading (1 .25 4)
    hex (10 9 18 19 30 29 38 39) ($n $n $n) simpleGrading (1 .25 4)
    hex (6 10 19 17 26 30 39 37) ($n $n $n) simpleGrading (1 .25 4)
);
edges
(
    arc 16 17 (.5 .15 0) arc 18 19 (.5 .25 0) arc 16 18 (.45 .2 0) arc 17 19 (.55 .2 0)
    arc 36 37 (.5 .15 .205) arc 38 39 (.5 .25 .205) arc 36 38 (.45 .2 .205) arc 37 39 (.55 .2 .205)
);
boundary
(
    inlet { type patch; faces ((0 20 24 4) (4 24 28 8) (8 28 32 12)); }
    outlet { type patch; faces ((3 7 27 23) (7 11 31 27) (11 15 35 31)); }
    walls
    {
        type wall;
        faces
        (
            (0 1 21 20) (1 2 22 21) (2 3 23 22) (12 32 33 13) (13 33 34 14) (14 34 35 15)
            (0 4 5 1) (1 5 6 2) (2 6 7 3) (4 8 9 5) (6 10 11 7) (8 12 13 9) (9 13 14 10) (10 14 15 11)
            (5 16 17 6) (5 9 18 16) (9 10 19 18) (17 19 10 6)
        );
    }
    middle
    {
        type symmetryPlane;
        faces
        (
            (20 21 25 24) (21 22 26 25) (22 23 27 26) (24 25 29 28) (26 27 31 30) (28 29 33 32) (29 30 34 33)
            (30 31 35 34) (25 26 37 36) (25 36 38 29) (29 38 39 30) (37 26 30 39)
        );
    }
    cylinder { type wall; faces ((16 36 37 17) (16 18 38 36) (18 19 39 38) (17 37 39 19)); }
);
END
dictionary 0/U volVectorField << 'END'
dimensions [0 1 -1 0 0 0 0];
internalField uniform (0.2 0 0);
boundaryField
{
    inlet
    {
        type exprFixedValue; value uniform (0 0 0);
        valueExpr "vector(16*0.45*pos().y()*(0.41-pos().y())*pos().z()*(0.41-pos().z())/pow(0.41,4), 0, 0)";
    }
    outlet { type zeroGradient; }
    walls { type noSlip; }
    cylinder { type noSlip; }
    middle { type symmetryPlane; }
}
END
dictionary 0/p volScalarField << 'END'
dimensions [0 2 -2 0 0 0 0];
internalField uniform 0;
boundaryField
{
    inlet { type zeroGradient; }
    outlet { type fixedValue; value uniform 0; }
    walls { type zeroGradient; }
    cylinder { type zeroGradient; }
    middle { type symmetryPlane; }
}
END
foam blockMesh
foam simpleFoam
tail -n 1 postProcessing/forces/0/force.dat | tr '()' '  ' |
    awk '{ printf "peer drag=%.10g lift=%.10g\n", 2 * $2 / (0.04 * 0.1 * 0.205), 2 * $3 / (0.04 * 0.1 * 0.205) }'
