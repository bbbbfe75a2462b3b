/* interpenetration: interpenetration of surfaces of a body, a diagnostic: no contact is computed between points without
 * bonds.
 *
 * Adjacent points without a bond are on two surfaces. These interpenetrate by the shortening of their distance less the
 * initial gap between them. Other points interpenetrate when they come nearer than a cell. Shortening that intact bonds
 * show as well is no interpenetration. Points that have lost all bonds are skipped.
 */
#ifndef PD_INTERPENETRATION_H
#define PD_INTERPENETRATION_H
#include "lattice/grid.h"
#include "solid/body.h"

typedef struct pd_interpenetration {
    const pd_grid *grid;  /* borrowed, as all below */
    const pd_body *body;
    const int32_t *node;  /* [count] of the points */
    const int32_t *point; /* [total] of the nodes; -1: none */
    const double *stiffness_factor; /* [count] [-] stiffness factor; 0: dissolved */
    int32_t count;        /* points; further ones of the body are images */
    int32_t components;   /* pieces of the body as it was built */
    int32_t *component;   /* [count] the piece of each point; empty with one piece */
    int32_t bins;         /* size of the hash table, a power of two; 0: not prepared */
    int32_t *bin;         /* [bins] the last point that came to it, -1: none */
    int32_t *next;        /* [count with bins] the one before it */
    /* [m] largest overlap within one component (crack faces), at the last check; 0: none */
    double crack_overlap;
    double max_crack_overlap; /* [m] the same of all checks */
    double component_overlap; /* [m] largest overlap of two components that were apart at the start; 0: none */
    int32_t first, other; /* points of these */
} pd_interpenetration;

#ifdef PDI_INTERNAL
/* Counts the components that unbroken bonds connect now, into `components`, and allocates `component` where there are
 * two or more. Images connect points but have no entry. grid to count are set before, the other members are 0. After an
 * error pdi_interpenetration_free is to be called. */
PDI_FN pd_status pdi_interpenetration_build(pd_ctx *ctx, pd_interpenetration *overlap);
/* Allocates the hash table (bin, next) by which points that were not adjacent are checked: bins is the first power of
 * two from 1024 on that is at least count, at most 2^29. After an error pdi_interpenetration_free is to be called. */
PDI_FN pd_status pdi_interpenetration_prepare(pd_ctx *ctx, pd_interpenetration *overlap);
/* Computes crack_overlap and component_overlap [m] at displacements u [count][PD_DIM] [m], with the points first and
 * other of the latter, which stay where it is 0, and raises max_crack_overlap. What is shorter by no larger a fraction
 * than the worst intact bond of adjacent points, or 1e-6, is no overlap. Points that were not adjacent are checked only
 * with the hash table, and only where both lack bonds of a complete family. Dissolved points are skipped. */
PDI_FN void pdi_interpenetration_compute(pd_interpenetration *overlap, const double *u);
PDI_FN void pdi_interpenetration_free(pd_ctx *ctx, pd_interpenetration *overlap);
#endif

#endif
