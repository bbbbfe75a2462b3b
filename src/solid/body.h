/* body: material points of a solid and their families.
 *
 * Points are those of a lattice or any others. The family of a point is all points within the horizon: |xi| <= horizon,
 * or with `spacing` all whose cells reach into the horizon, where cells at the rim count with the part that lies within
 * it. Families are rows of a sparse matrix; a row is sorted by the places of its points, so what is summed over it
 * does not depend on the order of the points. Search: cell lists, O(count).
 */
#ifndef PD_BODY_H
#define PD_BODY_H
#include "core/owner.h"
#include "solid/rim.h"
#include <math.h>

/* How bonds count by their length r. */
typedef enum pd_influence {
    PD_INFLUENCE_CONSTANT = 0, /* 1 */
    PD_INFLUENCE_INVERSE,      /* horizon/r */
    PD_INFLUENCE_LINEAR        /* 1 - r/(horizon + spacing) */
} pd_influence;

/* Which part of a cell at the rim of the horizon counts. */
typedef enum pd_rim {
    PD_RIM_LINEAR = 0, /* by its distance: falls from 1 at horizon - spacing/2 to 0 at horizon + spacing/2 */
    PD_RIM_EXACT       /* the part of the interval, square or cube that lies within the ball */
} pd_rim;

typedef struct pd_body_desc {
    int32_t count;
    const double *position; /* [count][PD_DIM] [m] */
    const double *volume;   /* [count] [m^d] */
    double horizon;         /* [m] */
    double spacing;         /* [m] of a lattice: parts of cells at the rim count; 0: points count wholly or not */
    pd_rim rim;             /* of a lattice */
} pd_body_desc;

typedef struct pd_body {
    int32_t count;
    double horizon;    /* [m] */
    double spacing;    /* [m] */
    pd_rim rim;
    int32_t cells;     /* of a lattice with exact parts: cells an axis whose parts are kept; 0: none */
    double *part;      /* [cells^PD_DIM] [-] parts of cells by their places in the lattice, axis 0 fastest */
    double *position;  /* [count][PD_DIM] [m] */
    double *volume;    /* [count] [m^d] */
    int64_t bonds;     /* of all families: each bond counts twice */
    int64_t *row;      /* [count + 1] begin of each family in column */
    int32_t *column;   /* [bonds] points */
    uint8_t *broken;   /* [bonds] 1: the bond is broken; both of its ends say so */
} pd_body;

#define pd_body_build PD_NAME(pd_body_build)
#define pd_body_free PD_NAME(pd_body_free)

/* PD_ERR_ARGUMENT: no point, a horizon that is not positive, a place or a volume that is not finite or not positive.
 * PD_ERR_GEOMETRY: two points at one place (the message names both). */
PD_API pd_status pd_body_build(pd_ctx *ctx, const pd_body_desc *desc, pd_body *body);
PD_API void pd_body_free(pd_ctx *ctx, pd_body *body);

#ifdef PDI_INTERNAL
PDI_FN void pdi_body_list(pdi_owner *owner, void *body);
PDI_FN void pdi_body_row_list(pdi_owner *owner, void *body);

/* The other end of a bond less point i [m]. */
static inline void pdi_body_bond(const pd_body *body, int32_t i, int64_t bond, double *xi)
{
    const double *from = body->position + (int64_t)i * PD_DIM;
    const double *to = body->position + (int64_t)body->column[bond] * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) xi[d] = to[d] - from[d];
}
/* Stretch of a bond xi whose ends move apart by eta; Y, r and |Y| [m]. It is a difference of squares over their sum,
 * which has the digits of the displacements. */
static inline double pdi_body_strain(const double *xi, const double *eta, double *y, double *r, double *length)
{
    double square = 0.0, more = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        y[d] = xi[d] + eta[d];
        square += xi[d] * xi[d];
        more += eta[d] * (xi[d] + y[d]);
    }
    *r = sqrt(square);
    *length = sqrt(square + more);
    return more / (*r * (*length + *r));
}
/* How many bonds point i has that are not broken. */
PDI_FN int64_t pdi_body_intact(const pd_body *body, int32_t i);
/* Break all bonds of point i, at both ends. How many. */
PDI_FN int64_t pdi_body_release(pd_body *body, int32_t i);
/* The bond of point j that leads to point i. */
PDI_FN int64_t pdi_body_back(const pd_body *body, int32_t i, int32_t j);
/* The points that bonds join to point i, into piece[0 ..] [count]; seen [count] marks them. Returns how many. */
PDI_FN int32_t pdi_body_piece(const pd_body *body, int32_t i, uint8_t *seen, int32_t *piece);
/* Weight of the bond xi [m]: its influence times the part of the cell at its end that lies within the horizon; 0: it is
 * none. Both ends get the same bits. */
PDI_FN double pdi_body_weight(const pd_body *body, pd_influence influence, const double *xi);
#endif

#endif
