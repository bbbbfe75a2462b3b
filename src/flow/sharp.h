/* sharp: the flow of fourth order on the nearest neighbours.
 *
 * Sums over a narrow family err by third and fourth derivatives. Second differences along the axes take these errors
 * off: node by node from the advecting velocity and from the pressure gradient, face by face from the momentum. At
 * walls cubics through the wall and three nodes give the second differences. Nodes beside smooth surfaces stay as they
 * are (theory: eq. 4.6b to 4.6g).
 */
#ifndef PD_SHARP_H
#define PD_SHARP_H
#include "core/owner.h"
#include "lattice/bond.h"

typedef struct pd_sharp {
    const pd_bonds *bonds;        /* NULL: second order */
    double third[PD_DIM][PD_DIM]; /* [-] third moments sum g_d xi_d n_b^2 of the gradient */
    int facing[PD_DIM][2 * PD_DIM - 1]; /* bonds through the upper face along axis d: the one along d, and for each
                                         * other axis those that sink and rise along it; -1: none */
    uint8_t *calm;                /* [total] 1: fluid beside no smooth surface, and what stands for it */
    double *bend, *bend_step;     /* [PD_DIM axes][PD_DIM][total] [m/s] second differences of the velocity, and of the
                                   * step of a solver */
    double *work;                 /* [PD_DIM+1][total] velocity behind inlets [m/s]; of the pressure [m2/s2]; momentum
                                   * [m/s2] and volume [1/s] of faces */
} pd_sharp;

#ifdef PDI_INTERNAL
/* A velocity in the sums of momentum. Ghosts are filled. */
typedef struct pdi_sharp_field {
    const double *advecting; /* [PD_DIM][total] [m/s] what makes the fluxes of the bonds */
    const double *v, *bend;  /* [m/s] */
} pdi_sharp_field;

/* side [2 PD_DIM]. 1: fluid neither enters nor leaves, and there are walls across two axes or more: they meet. */
PDI_FN int pdi_sharp_closed(const pd_side *side);
/* 1: a closed box without bodies, whose walls meet. */
PDI_FN int pdi_sharp_box(const pd_grid *grid);
/* 1: such a box on nearest neighbours, and a flow that is slow enough: it has less error there for the same time.
 * rate [1/m]: Reynolds number over the length [m] of the flow. */
PDI_FN int pdi_sharp_pays(const pd_bonds *bonds, double rate, double length);
/* PD_ERR_ARGUMENT: the family reaches beyond the nearest neighbours, or nodes are rings. */
PDI_FN pd_status pdi_sharp_build(pd_ctx *ctx, const pd_bonds *bonds, pd_sharp *sharp);
PDI_FN void pdi_sharp_list(pdi_owner *owner, void *object);
/* Which nodes are calm, as the geometry is. */
PDI_FN void pdi_sharp_update(const pd_sharp *sharp);
/* Second differences of v [PD_DIM][total] along all axes (eq. 4.6b). wall: velocity of the walls; NULL: at rest. */
PDI_FN void pdi_sharp_bend(const pd_ctx *ctx, const pd_sharp *sharp, pd_velocity_fn wall, void *user, const double *v,
                           double *bend);
/* sharpened = v less what the bonds err in the flux of it, at fluid nodes and behind inlets (eq. 4.6c). It holds v. The
 * tensor of (4.2b) comes on top. */
PDI_FN void pdi_sharp_velocity(const pd_ctx *ctx, const pd_sharp *sharp, const double *v, const double *bend,
                               double *sharpened);
/* grad of p at calm nodes (eq. 4.6d). */
PDI_FN void pdi_sharp_gradient(const pd_ctx *ctx, const pd_sharp *sharp, const double *p, double *grad);
/* ru += convection of u by w less friction nu of u, beyond what the bonds give (eq. 4.6e, 4.6f). */
PDI_FN void pdi_sharp_momentum(const pd_ctx *ctx, const pd_sharp *sharp, const pdi_sharp_field *w,
                               const pdi_sharp_field *u, double nu, double *ru);
/* What (3.3) and (3.4) take of the friction of walls. NULL: none. */
typedef struct pdi_sharp_drive {
    const double *grad;        /* [PD_DIM][total] [m/s2] of the pressure */
    const double *force, *body; /* [PD_DIM], [PD_DIM][total] [m/s2] */
    const double *motion;      /* [PD_DIM][total] [1/m/s] of moving walls */
} pdi_sharp_drive;
/* ru += friction nu of flat walls by (4.6g), in the place of that by (3.3) and (3.4). */
PDI_FN void pdi_sharp_friction(const pd_ctx *ctx, const pd_sharp *sharp, const pdi_sharp_field *u,
                               const pdi_sharp_drive *drive, double nu, double *ru);
/* lap [PD_DIM] [1/m/s] = what walls bring to the Laplacian of v at row r (eq. 4.6g). 1: the row has it. */
PDI_FN int pdi_sharp_rub(const pd_sharp *sharp, int32_t r, const double *v, const double *bend, double *lap);
PDI_FN void pdi_sharp_free(pd_ctx *ctx, pd_sharp *sharp);
#endif

#endif
