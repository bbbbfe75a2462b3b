/* etch: metal that dissolves by a law in the species at its surface, solved with the step of the species
 * (theory: eq. 5c.4).
 *
 * The speed v of a node holds for the concentrations at the metal itself, behind a film that what dissolves diffuses
 * through. So v = max(law(c_s(v)), 0). Where a law falls there is one solution; where it jumps down, the speed between.
 */
#ifndef PD_ETCH_H
#define PD_ETCH_H
#include "react/reactive.h"

/* Speed [m/s] at a fluid node, from what is at the surface: c [solutes] [mol/m3], pH (NaN without H+), the potential
 * phi [V] of pd_reactive_potential (NaN without migration), time t [s]. */
typedef double (*pd_etch_fn)(void *user, int32_t node, const double *c, double ph, double phi, double t);

typedef struct pd_etch_desc {
    pd_etch_fn law;
    void *user;
    const double *shed; /* [species] [-] of each with one of the metal, negative: it goes */
    uint32_t reads;     /* bit n: the law depends on solute n */
    int reads_ph;       /* 1: on pH */
    int reads_phi;      /* 1: on phi, which an inlet or a held wall has to tie */
} pd_etch_desc;

typedef struct pd_etch {
    pd_etch_desc desc;         /* shed is not kept */
    pd_reactive *reactive;
    double shed[PD_SPECIES_MOST]; /* [-] of solutes */
    double gain[PD_SPECIES_MOST]; /* [-] of totals */
    double charge;                /* [-] that comes with one of the metal, as ions */
    double scale[PD_SPECIES_MOST]; /* [-] diffusivities over the mean one, not 0 */
    pd_components film;           /* of concentrations times `scale` */
    int32_t count;                /* fluid nodes beside metal */
    int32_t *node;                /* [total] of places */
    int32_t *slot;                /* [total] place of a node; -1: none */
    double *weight;               /* [total] [mol/m4] of places: metal per speed */
    double *thick;                /* [total] [mol s/m4] of places: change of concentration across the film per speed */
    double *speed;                /* [total] [m/s] of nodes */
    double *ahead;                /* [total] [m] of places: metal that the step at hand takes, of an area */
    double *passed;               /* [total] [m] of places: the same of steps that stand */
    double *split;                /* [total] [m/s] work */
    float *by;                    /* [total][components] of places: how the speed follows totals */
    float *drive;                 /* [total] [m/s] of places: how it follows F phi/(R T) of the node; with migration */
    double time;                  /* [s] of the law */
} pd_etch;

#define pd_etch_build PD_NAME(pd_etch_build)
#define pd_etch_open PD_NAME(pd_etch_open)
#define pd_etch_put PD_NAME(pd_etch_put)
#define pd_etch_free PD_NAME(pd_etch_free)

/* A law for the species; reactive is borrowed, and takes it into its steps. Nodes beside metal are listed by the next
 * two. */
PD_API pd_status pd_etch_build(pd_ctx *ctx, pd_reactive *reactive, const pd_etch_desc *desc, pd_etch *etch);
/* Begin a list of fluid nodes beside metal. */
PD_API void pd_etch_open(pd_etch *etch);
/* One more: each speed v [m/s] gives it `weight` v [mol/m3/s] of metal, and lies behind a film across which what comes
 * from metal rises by `thick` v [mol/m3], at the mean diffusivity. Beside a plane, half a cell: Cs/h, Cs h/(2 D). */
PD_API void pd_etch_put(pd_etch *etch, int32_t node, double weight, double thick);
PD_API void pd_etch_free(pd_ctx *ctx, pd_etch *etch);

#ifdef PDI_INTERNAL
PDI_FN void pdi_etch_list(pdi_owner *owner, void *object);
/* What a film between nodes and surfaces solves with: the system of concentrations times `scale` [solutes], and the
 * same with the activities of a node: ln gamma of a charge of 1. */
PDI_FN void pdi_etch_film(const pd_reactive *reactive, pd_components *film, double *scale);
PDI_FN void pdi_etch_activities(const pd_components *of, const pd_components *film, double davies, pd_components *now);
/* Speed [m/s] at a fluid node for the present concentrations, behind such a film. NaN: the law is not finite. */
PDI_FN double pdi_etch_at(const pd_etch *etch, int32_t node, double thick, double guess);
/* The speeds of all places; `derive`: and how they follow the totals. */
PDI_FN void pdi_etch_solve(const pd_ctx *ctx, pd_etch *etch, int derive);
/* Nothing has passed in the step at hand; dt [s] of it at the present speeds; the step stands. */
PDI_FN void pdi_etch_begin(pd_etch *etch);
PDI_FN void pdi_etch_pass(pd_etch *etch, double dt);
PDI_FN void pdi_etch_accept(pd_etch *etch);
/* With migration, after derivatives: `split` [mol/m3/s] of places: charge that comes less with a higher F phi/(R T). */
PDI_FN void pdi_etch_yield(pd_etch *etch);
/* Change of the speed [m/s] with that of the dissolved totals [mol/m3] of its node. */
static inline double pdi_etch_follow(const pd_etch *s, int32_t place, const double *change)
{
    int count = s->reactive->components.count;
    const float *by = s->by + (int64_t)place * count;
    double sum = 0.0;
    for (int k = 0; k < count; k++) sum += (double)by[k] * change[k];
    return sum;
}
#endif

#endif
