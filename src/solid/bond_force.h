/* bond_force: bond forces of the bond-based model, for batches of points, and breaking by critical stretch.
 *
 * On a lattice a bond of a batch is one vector for all points. The sum over a family is taken for each quadrant
 * (octant) and half axis, from the middle outward, and the sums of opposite ones are added, axis by axis. A body and
 * its mirror image then have mirrored forces to the bit, and so has a body whose points come in another order (theory:
 * 15.11).
 */
#ifndef PD_BOND_FORCE_H
#define PD_BOND_FORCE_H
#include "solid/point_batch.h"

enum { PD_BOND_FORCE_SECTORS = PD_DIM == 1 ? 3 : PD_DIM == 2 ? 9 : 27 /* sectors of a family, by the signs of xi */ };

/* Data of all bonds with one lattice vector (kind). */
typedef struct pd_bond_force_kind {
    double xi[PD_DIM]; /* [m] */
    double inv_r2;     /* [1/m2] 1/r^2 */
    double inv_r;      /* [1/m] 1/r */
    int sector;        /* sector of the family */
} pd_bond_force_kind;

typedef struct pd_bond_force {
    pd_body *body;
    const pd_bond_weights *weights; /* borrowed */
    pd_point_batch band;
    int lattice;            /* 1: all bonds are whole spacings along all axes */
    int32_t max_steps;      /* [spacing] of a bond along an axis */
    int32_t kinds;          /* (2 reach + 1)^PD_DIM on a lattice, else the parts of a family */
    pd_bond_force_kind *kind; /* [kinds] in the order in which sums take them */
    int32_t *order;         /* [kinds] the kind of each lattice vector, axis 0 fastest */
    int32_t *work;          /* [kinds + 1] work */
    int64_t capacity;
    int32_t *bond_kind; /* [room] kind of each bond of the bands */
} pd_bond_force;

#ifdef PDI_INTERNAL
/* Input and results of a force evaluation of all points. */
typedef struct pdi_bond_force_state {
    const double *u; /* [count][PD_DIM] [m] displacements */
    const double *v; /* [count][PD_DIM] [m/s] or NULL: bonds that break release their energy at u - back v */
    double midpoint_dt; /* [s] half a time step */
    double critical;    /* [-] stretch at which bonds break */
    double modulus;  /* [N/m^(2d)] */
    double *force;   /* [count][PD_DIM] [N/m3] */
    double released; /* [J] (per m in 2D, per m2 in 1D) energy of the bonds that have broken */
} pdi_bond_force_state;

/* Describes the arrays of bond kinds. */
PDI_FN void pdi_bond_force_list(pdi_array_visitor *owner, void *springs);
/* Finds the bond kinds of the body and prepares the batches; body and weights are borrowed. lattice becomes 1 where all
 * bonds are whole spacings within 1e-9, at most 200 along an axis, and kinds are lattice vectors; otherwise kinds are
 * the sectors. pdi_bond_force_update has to follow. After an error the object is empty. */
PDI_FN pd_status pdi_bond_force_build(pd_ctx *ctx, pd_body *body, const pd_bond_weights *weights,
                                      pd_bond_force *springs);
PDI_FN void pdi_bond_force_free(pd_ctx *ctx, pd_bond_force *springs);
/* Builds the batches anew and sorts their bonds, after weights have changed or bonds have broken. */
PDI_FN pd_status pdi_bond_force_update(pd_ctx *ctx, pd_bond_force *springs);
/* Reference vector xi [m] from point i to j, rounded to whole spacings on a lattice. */
PDI_FN void pdi_bond_force_compute_offset(const pd_bond_force *springs, int32_t i, int32_t j, double *xi);
/* Force densities of all points, mirror images too, into state->force. Bonds whose stretch is > state->critical break,
 * in the body and in the batches, and give no force. state->released becomes their energy, 0 where none breaks. Returns
 * how many broke, each counted once. */
PDI_FN int64_t pdi_bond_force_compute_force(const pd_ctx *ctx, pd_bond_force *springs, pdi_bond_force_state *state);
#endif

#endif
