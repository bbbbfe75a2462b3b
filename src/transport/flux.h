/* flux: advection and diffusion at a bond: upwinded fluxes from node to node, and the antidiffusive fluxes that take
 * back what upwinding adds (theory: eq. 6.1, 6.15).
 */
#ifndef PD_FLUX_H
#define PD_FLUX_H
#include "flow/flow.h"
#include "transport/bend.h"
#include "transport/conductance.h"
#include "transport/limiter.h"

/* The terms of the balance of a node; the first ones are borrowed. */
typedef struct pd_flux {
    const pd_bonds *bonds;
    const pd_flow *flow;           /* NULL: fluid at rest */
    const pd_diffusion *diffusion; /* conductances, held walls included */
    const pd_limiter *limiter;     /* with a flow */
    const pd_open_boundary *boundary;
    const double *absorb;          /* [total] [1/s] */
    double rate;                   /* [1/s] of the term in time: 1 over the step, or 0 */
    double ratio[PD_DIM];          /* [-] a(n) xi over g(n), where that is one number for all bonds ... */
    int even;                      /* ... 1: it is */
    double *stream;                /* [PD_DIM+1][total] w [m/s] and q [m2/s] that the volume fluxes follow from; lent
                                    * for a step */
    double *flux;                  /* [count/2][total] [1/s] volume fluxes F of the first half of the bonds: those of
                                    * the others are what their far ends have, negated. NULL in 3D, where making them
                                    * anew takes no longer than reading them, and for fluid at rest; lent, too */
    pd_bend bend;                  /* of its antidiffusive fluxes */
    pd_conductance conductance;    /* of the bonds of rows */
    const double *plain;           /* [total] [mol/m3] the field, where `pdi_flux_apply` at rest is given it less a
                                    * constant; else NULL */
    int exact;                     /* 1: `pdi_flux_apply` keeps amounts but for rounding of what bonds carry */
    double *boundary_flux;         /* [boundary_capacity][count] [1/s] volume fluxes of the bonds of nodes beside inlets
                                    * and outlets */
    double *boundary_bond;         /* [boundary_capacity][count] [1/s] their conductances */
    int32_t boundary_capacity;
} pd_flux;

#ifdef PDI_INTERNAL
/* Several fields that one flow carries, and sums of what leaves by each of them. */
#define PDI_FLUX_FIELDS 32
typedef struct pdi_flux_fields {
    int count, sums;
    const double *ratio;  /* [count] [-] of their diffusivities to that of the flux */
    const double *wall;   /* [count] [mol/m3] what each holds on walls that hold; NaN: they are closed for it */
    const double *c;      /* [count][total] with images and inlets */
    const double *weight; /* [sums][count] [-] */
    const double *pass;   /* [total] [-] of nodes: bonds conduct its harmonic mean as a share; NULL: all of it */
    double *y;            /* [sums][total] [mol/m3/s] */
} pdi_flux_fields;
/* y: the sums of what leaves each fluid node through its bonds and into held walls, upwinded (eq. 6.1). None of
 * them `rests`. */
PDI_FN void pdi_flux_apply_fields(const pd_ctx *ctx, const pd_flux *t, const pdi_flux_fields *fields);
/* Bond k of the nodes i .. i+count-1, of a block of pdi_node_loop_by_blocks: volume fluxes F to the far ends and
 * conductances [1/s]. Returns where the far ends stand from the nodes. */
PDI_FN int32_t pdi_flux_bonds(const pd_flux *t, int32_t i, int32_t row, int32_t place, int k, int count, double *flux,
                              double *bond);
/* Arrays of a pd_flux that are lent for a step. */
PDI_FN void pdi_flux_list(pdi_array_visitor *owner, void *object);
/* The borrowed terms are given. */
PDI_FN pd_status pdi_flux_build(pd_ctx *ctx, pd_flux *t);
/* After pd_bonds_update and pdi_open_boundary_update: room for their rows. */
PDI_FN pd_status pdi_flux_fit(pd_ctx *ctx, pd_flux *t);
/* Store what the flow and the diffusivity give the bonds; the sweeps below read it. PD_ERR_STATE: no room for rows. */
PDI_FN pd_status pdi_flux_refresh(pd_ctx *ctx, pd_flux *t);
PDI_FN void pdi_flux_free(pd_ctx *ctx, pd_flux *t);
/* y [total] [mol/m3/s] = rate c + absorb c + what leaves each fluid node through its bonds and into held walls,
 * upwinded (eq. 6.1); c [total] with its images and inlets, and unless `exact` 0 in metal and walls at rest. */
PDI_FN void pdi_flux_apply(const pd_ctx *ctx, const pd_flux *t, const double *c, double *y);
/* y [total] [1/s]: the rate at which each fluid node exchanges its content, with `room` times the part of upwinding. */
PDI_FN void pdi_flux_rates(const pd_ctx *ctx, const pd_flux *t, double room, double *y);
/* A sweep of Gauss and Seidel over c [total] for A c = b with the operator above, forwards or (back = 1) backwards: one
 * thread. Inlets count as zero: b and c are a residual and a correction. */
PDI_FN void pdi_flux_relax(const pd_flux *t, const double *b, int back, double *c);
/* y [total] [mol/m3/s]: what each fluid node gains by the antidiffusive fluxes of its bonds (eq. 6.15), with the
 * present limiter. Inlets have some, outlets none. */
PDI_FN void pdi_flux_anti(const pd_ctx *ctx, const pd_flux *t, const double *c, double *y);
/* Keep the derivatives of antidiffusive fluxes where `bend` has room: of c with its images and the present limiter. */
PDI_FN void pdi_flux_differentiate(const pd_ctx *ctx, const pd_flux *t, const double *c);
/* The derivative of pdi_flux_anti along x [total], with its images and zero at inlets, from those of the limiter along
 * x, and from what was kept for that c where something was. */
PDI_FN void pdi_flux_anti_by(const pd_ctx *ctx, const pd_flux *t, const double *c, const double *x,
                             const double *factor_by, const double *slope_by, double *y);
/* Flux [mol/s] towards + of all bonds through the plane before index `index` of `axis`; anti: those of
 * pdi_flux_anti, or NULL. */
PDI_FN double pdi_flux_through(const pd_flux *t, const double *c, const double *anti, int axis, int index);
/* Of bond k of node i: volume flux F [1/s] to the far end, conductance [1/s], and what upwinding adds to it [1/s]. */
PDI_FN void pdi_flux_bond(const pd_flux *t, int32_t i, int k, double *flux, double *bond, double *upwind);
/* Amount per volume and time [mol/m3/s] that leaves i through bond k, upwinded (eq. 6.1). */
PDI_FN double pdi_flux_bond_flux(const pd_flux *t, const double *c, int32_t i, int k);
/* F and the conductance of bond k of node i [1/s], as sweeps see them. */
PDI_FN void pdi_flux_one(const pd_flux *t, int32_t i, int k, double *flux, double *bond);
/* Bond k of node i is open: by its row, or since its family is whole. */
PDI_FN int pdi_flux_open(const pd_flux *t, int32_t i, int k);
#endif

#endif
