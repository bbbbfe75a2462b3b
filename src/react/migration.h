/* migration: the potential that keeps species neutral as they diffuse, and its part in the linear systems (theory:
 * 8.7).
 *
 * A step changes totals T and psi = F phi/(R T) together, with sum z T = 0. Both are kept in one change x of totals: x
 * = dT + M z c dpsi. The neutral part of x is dT, and its charge is dpsi times the sum of z^2 c.
 */
#ifndef PD_MIGRATION_H
#define PD_MIGRATION_H
#include "chemistry/components.h"
#include "transport/inverse.h"
#include "transport/migrate.h"

typedef struct pd_migration {
    int on;                 /* 0: species diffuse each by itself; nothing below is there */
    const pd_flux *flux;
    const pd_components *components;
    const double *ratio;    /* [solutes] [-] of the diffusivities to that of the flux */
    const double *wall;     /* [solutes] [mol/m3] held, NaN: not */
    const double *pass;     /* [total] [-] of a pdi_migrate */
    double charge[PD_SPECIES_MAX]; /* [-] of solutes */
    double volt;            /* [V] of psi = 1 */
    int tied;               /* 1: an inlet or a wall that holds has psi = 0; else the mean of psi is 0 */
    double excess;          /* [m2] tau of eq. 6.22 */
    double share;           /* [-] of the change of psi that a step of Newton takes */
    double pace[PD_SPECIES_MAX]; /* [-] of components: factors of the preconditioner's answers */
    double *psi;            /* [total] [-] */
    uint8_t *idle;          /* [total] 1: fluid that no loop of current passes: psi has no value there */
    /* lent for a step: */
    double *begin, *base;   /* [total] [-] psi at the start of the step, and before a step of Newton */
    double *move;           /* [total] [-] change of psi */
    double *size;           /* [total] [mol/m3] sum of z^2 c, at least a small share of the largest */
    double *current;        /* [total] [mol/m3/s] work */
    pd_compact_operator compact;
    pd_multigrid mg;
} pd_migration;

#ifdef PDI_INTERNAL
/* flux, components, ratio and wall are borrowed, and need not be filled in yet. */
PDI_FN pd_status pdi_migration_plan(pd_ctx *ctx, const pd_multigrid_desc *desc, const pd_flux *flux,
                                    const pd_components *components, pd_migration *migration);
/* [K]; ratio and wall [solutes]. PD_ERR_ARGUMENT: the temperature. */
PDI_FN pd_status pdi_migration_begin(pd_ctx *ctx, double temperature, const double *ratio, const double *wall,
                                     pd_migration *migration);
PDI_FN void pdi_migration_free(pd_ctx *ctx, pd_migration *migration);
/* Arrays that stay, and those of a step. Both have none where it is not on. */
PDI_FN void pdi_migration_list(pdi_array_visitor *owner, pd_migration *migration);
PDI_FN void pdi_migration_work_list(pdi_array_visitor *owner, pd_migration *migration);
/* Charge [mol/m3] of concentrations; *size: the sum of |z| c. */
PDI_FN double pdi_migration_charge(const pd_migration *migration, const double *c, double *size);
/* Make c [solutes] neutral by c exp(-z lambda), which keeps ideal equilibria. */
PDI_FN void pdi_migration_neutralise(const pd_migration *migration, double *c);
/* What leaves by c and psi (fields [solutes][total] with images; move = c), or its derivative along `move` and
 * migration->move, or (move NULL) along the latter alone; weight [components][solutes]. */
PDI_FN void pdi_migration_leave(const pd_ctx *ctx, pd_migration *migration, const double *c, const double *move,
                                const double *weight, double *y);
/* y [total] [mol/m3/s]: what leaves by diffusion of s [total] [mol/m3], whose images are filled. */
PDI_FN void pdi_migration_spread(const pd_ctx *ctx, const pd_migration *migration, double *s, double *y);
/* M z c over the sum of z^2 c: along [components]. Its charge is 1. */
PDI_FN void pdi_migration_along(const pd_migration *migration, const double *c, double *along);
/* What a surface does: at `count` nodes it takes up take [mol/m3/s] of charge a unit of psi. */
typedef struct pdi_migration_surface {
    int32_t count;
    const int32_t *node;
    const double *take;
} pdi_migration_surface;
/* For the present concentrations [solutes][total]: sizes, and the conductances of the preconditioner. */
PDI_FN pd_status pdi_migration_setup(pd_ctx *ctx, pd_migration *migration, const double *c,
                                     const pdi_migration_surface *surface);
/* y [total] [-]: near the psi that drives `current` [mol/m3/s] out of the nodes. */
PDI_FN void pdi_migration_apply(pd_ctx *ctx, pd_migration *migration, const double *current, double *y);
/* Largest change of psi in the step of Newton at hand [-]. */
PDI_FN double pdi_migration_largest(const pd_migration *migration);
/* Inlets have the potential phi [V]. */
PDI_FN void pdi_migration_inlets(pd_migration *migration, double phi);
/* For steps of dt [s]. Returns the rate [1/s] of time of the preconditioner. */
PDI_FN double pdi_migration_pace(pd_migration *migration, double dt);
/* Find out whether it is tied. */
PDI_FN void pdi_migration_tie(pd_migration *migration);
/* Where it is not tied the mean of psi becomes 0. */
PDI_FN void pdi_migration_level(pd_migration *migration);
#endif

#endif
