/* corrode: bond-based corrosion. Metal and fluid are one concentration field on two phases; bonds across the front
 * carry metal into the fluid, bonds between fluid nodes carry diffusion, bonds between solid nodes nothing.
 *
 *     dC_i/dt = sum_fluid D a(n) (C_j - C_i) + sum_solid T_ji      of fluid nodes i,
 *     dC_j/dt = - sum_fluid T_ji                                   of solid nodes j,      (theory: eq. 6.7)
 *     T_ji = v(C_i) b(n) (Cs - Csat)     or     v(C_i) b(n) ln(Cs/Csat) (C_j - C_i),
 *
 * with the recession speed v of the law and the weights b(n) of front.h. A solid node turns fluid when it is down to
 * Csat or, when mechanical bonds break at random (damage.h), when it has none left. A fluid node at or above Csat takes
 * no more (salt layer) until it has fallen below, as its concentration says at every step. Every exchange is
 * antisymmetric. Solid beyond one horizon of the fluid is not visited.
 * Sources: Chen and Bobaru 2015; Jafarzadeh, Zhao, Shakouri and Bobaru 2021.
 *
 * The surface of the metal is the set of solid nodes: bonds count by the phases of their ends alone, and what is
 * thinner than a horizon does not separate fluids. Sides of the box: mirror and wall repeat what lies in front of
 * them, periodic sides too, and inlets and outlets hold `bulk` on their plane.
 */
#ifndef PD_CORRODE_H
#define PD_CORRODE_H
#include "core/archive.h"
#include "lattice/grid.h"
#include "metal/material.h"
#include "metal/front.h"
#include "metal/metal.h"
#include "metal/phase.h"

/* Zero-initialise. */
typedef struct pd_corrode_desc {
    double solid;       /* [mol/m3] concentration Cs of intact metal */
    double saturation;  /* [mol/m3] Csat, 0 < Csat < Cs */
    double diffusivity; /* [m2/s] of dissolved metal */
    double initial;     /* [mol/m3] of the fluid at the start */
    double bulk;        /* [mol/m3] held on inlets and outlets, and in all fluid with `activation` */
    int activation;     /* 1: activation control, fluid nodes hold `bulk` during a step and what they gain is gone */
    double share;       /* [-] a run chooses steps in which no node loses more of Cs - Csat; 0: 0.01 */
    double overshoot;   /* [-] and no fluid node gains more of Csat, by which the salt layer may pass it; 0: 0.05 */
    pd_rate_fn rate;    /* speed v of a flat front; never below zero */
    void *rate_user;
    int uniform;        /* 1: the law does not depend on the place, nodes of equal c need one look at it */
    int steady;         /* 1: the law does not depend on time */
    pd_drive drive;
    pd_kernel kernel;
    pd_weights weights; /* of the kernel */
    int keep_deficit;   /* 1: a node that turns fluid keeps what it has lost below Csat, as published codes have it; the
                         * front is too slow by half of `share`. 0: the metal behind the node makes up for it */
    int stochastic;     /* 1: mechanical bonds of a solid node break at random as it dissolves, and it turns fluid when
                         * none is left, with what it holds (theory: 6.7). 0: it turns at Csat */
    uint64_t seed;      /* of that */
    double repassivation; /* [mol/m3] fluid beside metal that is below it at the start of a step does not attack any
                           * more, whatever it holds later: a film has formed; up to Csat, 0: none forms */
    const uint8_t *passive; /* [total] 1: fluid there does not attack, as in front of a passive film; NULL: none.
                             * Borrowed */
    const double *factor;   /* [total] [-] of solid nodes, at least 0: multiplies the speed at which they dissolve.
                             * Ghosts are not read. NULL: 1. Borrowed */
} pd_corrode_desc;

typedef struct pd_corrode {
    pd_corrode_desc desc; /* defaults filled in */
    pd_grid *grid;
    const pd_stencil *stencil;
    pd_front front;
    pd_phases map;     /* metal and fluid, and what takes part in a step */
    int32_t *line_shift; /* [lines of the stencil] the same for the lines */
    double *c;         /* [total] [mol/m3] content of solid, concentration of fluid nodes */
    double *next;      /* [total] [mol/m3] */
    const double *base; /* [total] [mol/m3] what a step adds to: c, or the field at its start */
    double *speed;     /* [total] [m/s] v of fluid nodes at the front, 0 where they do not attack */
    double *scratch;   /* [count] [1/m] weights of the bonds of one node */
    double *factor;    /* [total] [-] that of desc, and of ghosts; NULL: 1 */
    double highest;    /* [-] largest factor */
    uint16_t *bonds;   /* [total] mechanical bonds of solid nodes at the start; NULL: not stochastic */
    double *last;      /* [total] [mol/m3] content at which the last of them breaks; NULL: not stochastic */
    uint8_t *film;     /* [total] 1: fluid in front of a film that has formed; NULL: none forms */
    double *sum;       /* [total] what changes only when nodes turn; below 0: not known. Of fluid beside metal
                        * sum b(n) f [1/m] over metal, and with `activation` of metal sum v b(n) [1/s]. NULL: drive by
                        * difference */
    int alarmed;       /* 1: a speed is another one than in the step before, or sums are not kept */
    double span;       /* [mol/m3] Cs - Csat */
    double log_ratio;  /* [-] ln(Cs/Csat) */
    int32_t *changed;  /* [changed_capacity] nodes that turned fluid in the last step, ascending; they still hold
                        * what was left in them */
    int32_t changed_count, changed_capacity;
    double fastest;    /* [m/s] largest speed */
    int64_t active;    /* nodes that change in a step */
    double diffusion;  /* [1/s] D sum a(n) */
    double held;       /* [1/s] and what images of a node behind held planes add to it, at most */
    double time;       /* [s] */
    double ahead;      /* [s] the law holds so much later: a law of time at the middle of a step */
    double start;      /* [mol] (per m in 2D, per m2 in 1D) solid and dissolved at first */
    double out;        /* [mol] gone through held sides and held fluid */
    double out_carry;  /* [mol] rounding of out */
    int64_t steps;
} pd_corrode;

#define pd_corrode_build PD_NAME(pd_corrode_build)
#define pd_corrode_open PD_NAME(pd_corrode_open)
#define pd_corrode_solid PD_NAME(pd_corrode_solid)
#define pd_corrode_dissolved PD_NAME(pd_corrode_dissolved)
#define pd_corrode_damage PD_NAME(pd_corrode_damage)
#define pd_corrode_imbalance PD_NAME(pd_corrode_imbalance)
#define pd_corrode_free PD_NAME(pd_corrode_free)

/* Grid and stencil are borrowed; kinds of the grid change when nodes turn fluid. PD_ERR_ARGUMENT: a concentration, the
 * diffusivity or the share is out of range, no law, axisymmetric grid. PD_ERR_GEOMETRY: a box with held sides is
 * thinner than a horizon. */
PD_API pd_status pd_corrode_build(pd_ctx *ctx, pd_grid *grid, const pd_stencil *stencil, const pd_corrode_desc *desc,
                                  pd_corrode *corrode);
/* The caller has set c of fluid nodes (allowed between any two steps): open the balance with it. */
PD_API void pd_corrode_open(pd_corrode *corrode);
/* Amounts [mol, per m in 2D, per m2 in 1D] in solid and in fluid nodes. */
PD_API double pd_corrode_solid(const pd_corrode *corrode);
PD_API double pd_corrode_dissolved(const pd_corrode *corrode);
/* Damage [-] of a node: of metal the share of its mechanical bonds that are broken, or the share of Cs - Csat that it
 * has lost when bonds do not break at random; 1 in fluid, 0 elsewhere. */
PD_API double pd_corrode_damage(const pd_corrode *corrode, int32_t node);
/* |solid + dissolved + out - start| over start [-]: rounding. */
PD_API double pd_corrode_imbalance(const pd_corrode *corrode);
PD_API void pd_corrode_free(pd_ctx *ctx, pd_corrode *corrode);

#ifdef PDI_INTERNAL
/* What a bond moves, over speed and weight [mol/m3]: that times 1 or times the difference of its ends (eq. 6.7). */
PDI_FN double pdi_corrode_scale(const pd_corrode *corrode);
/* `count` nodes from `first` along axis 0, of one role. */
typedef void (*pdi_corrode_run_fn)(void *user, int32_t first, int count);
/* All nodes of the box that take part, in such runs. */
PDI_FN void pdi_corrode_sweep(const pd_ctx *ctx, const pd_corrode *corrode, pdi_corrode_run_fn run, void *user);
/* sum [count] [mol/m5] of a(n) (C_j - C_i) over all bonds of nodes that lie along axis 0; c with its ghosts. */
PDI_FN void pdi_corrode_laplacian(const pd_corrode *corrode, const double *c, int32_t first, int count, double *sum);
/* The same over the wet bonds of fluid nodes of one role. */
PDI_FN void pdi_corrode_spread(const pd_corrode *corrode, const double *c, int32_t first, int count, double *sum);
/* Values of the ghosts, of c and speed. */
PDI_FN void pdi_corrode_ghosts(pd_corrode *corrode);
/* Begin a step: ghosts, films and speeds at the present concentrations. Errors as pd_corrode_limit. */
PDI_FN pd_status pdi_corrode_prepare(pd_ctx *ctx, pd_corrode *corrode);
/* What images of fluid node i behind held planes add to its exchange [1/s]. */
PDI_FN double pdi_corrode_mirrored(const pd_corrode *corrode, int32_t i);
/* Films form where fluid beside metal is below `repassivation`. At the start of a step. */
PDI_FN void pdi_corrode_repassivate(pd_corrode *corrode);
/* Speed of the law at time t [s] and fluid node i with concentration c, 0 in front of a passive film. */
PDI_FN pd_status pdi_corrode_law(pd_ctx *ctx, const pd_corrode *corrode, double t, int32_t i, double c, double *speed);
/* Share of what a step may take that the course of a law of time within it may cost. */
#define PDI_CORRODE_COURSE 0.04
/* The course of the law at the front over a step of dt [s], seen at its quarters: how far [m/s] pairs about the middle
 * are off its value there, jumps included, and its largest value on the way; 0: it does not change. */
PDI_FN void pdi_corrode_course(const pd_corrode *corrode, double dt, double *error, double *fastest);
/* next = base + dt times all exchanges at the present c and speed. */
PDI_FN void pdi_corrode_exchange(pd_ctx *ctx, pd_corrode *corrode, double dt);
/* Largest loss of a metal node in that, over Cs - Csat. */
PDI_FN double pdi_corrode_lost(const pd_corrode *corrode);
/* Lists in `changed` which nodes turn with `next`, and lets metal behind them make up for what they are below their
 * end. Share of that step [-] in which debris, metal with too little in reach for that, loses no more than it has; 1:
 * all of it, `next` is ready to be committed. */
PDI_FN double pdi_corrode_spare(pd_corrode *corrode);
/* What steps carry on beside the kinds of the grid, which come first. */
PDI_FN pd_status pdi_corrode_store(pd_ctx *ctx, pd_corrode *corrode, pd_archive *archive);
/* `next` becomes the state, as far as nodes take part. */
PDI_FN void pdi_corrode_commit(pd_corrode *corrode, double dt);
#endif

#endif
