/* transform: a scene rotated, mirrored, shifted, rescaled, in other units, in another order, unfolded at its mirror. */
#ifndef METAMORPHIC_TRANSFORM_H
#define METAMORPHIC_TRANSFORM_H
#include "scene.h"

typedef enum transform_kind {
    TRANSFORM_MIRROR = 0,
    TRANSFORM_ROTATE,
    TRANSFORM_SHIFT,
    TRANSFORM_LENGTHS_7,
    TRANSFORM_LENGTHS_MILLI,
    TRANSFORM_TIMES_3,
    TRANSFORM_UNITS,
    TRANSFORM_ORDER,
    TRANSFORM_HALF,
    TRANSFORM_THREADS,
    TRANSFORM_RESUME,
    TRANSFORM_TIGHTER, /* of the class by tolerance: a tenth of rtol */
    TRANSFORM_LAYER,   /* of the class by lattice: one layer in 3D against 2D */
    TRANSFORM_RING,    /* of the class by lattice: a ring far from its axis against the plane */
    TRANSFORM_COUNT
} transform_kind;

extern const char *const transform_names[TRANSFORM_COUNT];

/* Axis a becomes axis to[a] with the sign; lengths and times are multiplied. */
typedef struct transform {
    transform_kind kind;
    int to[3], sign[3];
    double offset[3];    /* [m] */
    double length, time; /* factors */
    int unfold;          /* axis that was unfolded at its low side, -1: none */
    uint32_t seed;
} transform;

/* 0: the scene cannot be transformed so. */
int transform_draw(transform_kind kind, const scene *x, uint32_t *state, transform *t);
/* Whether it still means something for a scene that has lost sections. */
int transform_holds(const transform *t, const scene *x);
void transform_scene(const scene *x, const transform *t, scene *y);
/* Factor of a value with this dimension. */
double transform_factor(const transform *t, const dimension *d);
/* The same scene on a lattice that is finer by a whole number. */
void transform_refine(const scene *x, int by, scene *y);
/* By what values are no more the same. */
int transform_bits(transform_kind kind);

#endif
