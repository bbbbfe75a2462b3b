/* compare: two records of one scene, the second one transformed: the first figure or value that differs most. */
#ifndef METAMORPHIC_COMPARE_H
#define METAMORPHIC_COMPARE_H
#include "record.h"
#include "transform.h"

typedef struct finding {
    int found;
    int other_steps; /* 1: not compared, see compare_records */
    char kind[24]; /* "outcome", "crash", "hang", "field", "figure", "file", "missing" */
    char name[96]; /* of the field or run_figure */
    char detail[1200];
    char others[400];   /* what else differs */
    double a, b, scale; /* the values, and what they are compared with */
} finding;

/* Two records of one scene with different steps, the second one's smaller: amounts and losses, and fields where no
 * metal goes. */
void compare_steps(const scene *x, const transform *t, const record *a, const record *b, double tolerance, finding *f);
enum { APART_FIELDS = 64 };

/* How far fields of two lattices are apart, over their own sizes. */
typedef struct apart {
    int count;
    char name[APART_FIELDS][48];
    double value[APART_FIELDS];
} apart;

/* A scene in 2D and one layer of it in 3D, or a ring: the largest of `of`. f: where an outcome differs. */
double compare_layer(const scene *x, const record *a, const record *b, apart *of, finding *f);
/* A field that is `least` or more apart and has not fallen by `factor`. a, fine: records of the first lattice with h
 * and with a part of it, for scenes with bodies, which each h cuts otherwise; NULL: all falls. */
void compare_falls(const apart *before, const apart *now, double factor, double least, const record *a,
                   const record *fine, finding *f);
/* tolerance: [-] of the own scale of each field and figure; 0: bits, and files byte by byte. */
void compare_records(const scene *x, const transform *t, const record *a, const record *b, double tolerance,
                     finding *f);

#endif
