/* quadrature: pieces of a step in time over which two instants give the integral of a function that may jump or pulse.
 *
 * A piece is right where Gauss' rule of two instants, Simpson's rule and Gauss' rule over both halves agree, and where
 * bounds of the function leave no room for what its instants do not show, and become narrower with the piece (theory:
 * 6.1). Bounds come from interval arithmetic (Moore, Kearfott and Cloud, Introduction to Interval Analysis, SIAM 2009).
 */
#ifndef PD_QUADRATURE_H
#define PD_QUADRATURE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
typedef double (*pdi_quadrature_value)(void *user, double t);
/* Least and largest value from `from` to `to`. */
typedef void (*pdi_quadrature_bounds)(void *user, double from, double to, double *least, double *most);

/* A function of time in a step. */
typedef struct pdi_quadrature {
    pdi_quadrature_value value;
    pdi_quadrature_bounds bounds; /* NULL: by its values alone */
    void *user;
    double share; /* what the step takes for a value of 1 */
    double size;  /* what it is taken from, in the unit of share */
    double rtol;  /* [-] tolerance of the step */
} pdi_quadrature;

typedef enum pdi_quadrature_piece {
    PDI_QUADRATURE_DIVIDE, /* two instants do not give the integral */
    PDI_QUADRATURE_FITS,
    PDI_QUADRATURE_JUMP /* they do not, but next to nothing is taken there */
} pdi_quadrature_piece;

/* The first (0) or second (1) instant of Gauss' rule. */
PDI_FN double pdi_quadrature_instant(double from, double to, int second);
/* Judge a piece that is the share `part` [-] of the step. middle: 1: by the value in the middle, 0: by two instants.
 * *mean: of the function over the piece by that rule. */
PDI_FN pdi_quadrature_piece pdi_quadrature_judge(const pdi_quadrature *q, double from, double to, double part,
                                                 int middle, double *mean);
#endif

#endif
