/* reactive: several species that diffuse, are carried by a flow and react in the volume (theory: 8).
 *
 * Implicit steps of any length solve for the totals of components (components.h), so reactions in equilibrium stay so
 * at every node, and nothing is split. Each species has its own D; fluxes are those of transport.h, upwinded. Amounts
 * are kept to rounding, converged or not: what a step leaves undone is carried on. Concentrations are at least 0.
 */
#ifndef PD_REACTIVE_H
#define PD_REACTIVE_H
#include "chemistry/mineral.h"
#include "react/migration.h"
#include "solve/krylov.h"

#define PD_REACTIVE_ROWS 20 /* of a balance */
#define PD_REACTIVE_NAME 16 /* [byte] of the name of one with its end */

/* Zero-initialise. Entries of the solvent are not read. */
typedef struct pd_reactive_desc {
    const pd_species *species;   /* solutes, the solvent where reactions name it, and minerals */
    int count;
    const pd_reaction *reactions;
    int reaction_count;
    const pd_mineral *minerals;  /* solids that form and dissolve; reactions with other solids are not read */
    int mineral_count;
    double tortuosity;           /* [-] tau of D eps/tau, where minerals take room; 0: 1 */
    pd_activity activity;
    double temperature;          /* [K] of the activities and of migration */
    const double *initial;       /* [count] [mol/m3], brought to equilibrium; of minerals their amounts */
    const double *inlet;         /* [count] [mol/m3] of the inflow, brought to equilibrium; NULL: `initial` */
    const double *wall;          /* [count] [mol/m3] of each species on walls that hold; NaN: they are closed for it */
    pd_point_fn held;            /* where walls and solids hold: any number; NaN: they are closed. NULL: all are */
    void *user;
    double tolerance;            /* [-] of the equations of a step, for each component; 0: 1e-10 */
    int order;                   /* of steps in time: 1, which keeps bounds, or 2; 0: 1 */
    int migration;               /* 1: ions move in the potential that keeps the fluid neutral; 0: each diffuses by
                                  * itself. All concentrations that are given are neutral then, and so are sources,
                                  * in all, unless an inlet or a held wall lets a current pass */
    double inlet_potential;      /* [V] with migration: of inlets, against that of held walls, which is 0 */
    int most;                    /* steps of Newton before a step is refused or taken in parts; 0: 60 */
    pd_arena *arena;             /* as of pd_transport_desc */
} pd_reactive_desc;

/* Amounts [mol, per m in planar 2D, per m2 in 1D] that only sides and sources change: an element, the charge, or what
 * the solvent does not change of its elements, as H - 2 O. dissolved + solid + carry = start + in - out + imbalance. */
typedef struct pd_reactive_balance {
    char name[PD_REACTIVE_NAME]; /* "Ca", "charge", "H-2O" */
    double start, dissolved, solid, carry; /* [mol] */
    double in, out;   /* [mol] through inlets, outlets and held walls, and by sources (in) */
    double imbalance; /* [mol] */
    double relative; /* [-] over the sum of the sizes of all terms */
} pd_reactive_balance;

/* What a kinetic reaction, or a mineral with a speed, does to the preconditioner. */
typedef struct pd_reactive_filter {
    int mineral;        /* -1: a reaction */
    double *absorb;     /* [total] [1/s] rate at which it brings itself to rest */
    pd_flux flux;
    pd_inverse inverse;
} pd_reactive_filter;

typedef struct pd_reactive {
    pd_reactive_desc desc;    /* defaults filled in; the arrays of the caller are not kept */
    pd_components components;
    pd_minerals minerals;
    const pd_grid *grid;
    const pd_bonds *bonds;
    const pd_flow *flow;      /* NULL: fluid at rest */
    int rows;                 /* of the balance */
    char name[PD_REACTIVE_ROWS][PD_REACTIVE_NAME];
    double part[PD_REACTIVE_ROWS][PD_SPECIES_MAX];  /* [-] of a solute in each row */
    double start[PD_REACTIVE_ROWS];                 /* [mol] */
    double in[PD_SPECIES_MAX], out[PD_SPECIES_MAX]; /* [mol] of solutes since the start */
    double ratio[PD_SPECIES_MAX];                   /* [-] of the diffusivities to that of `diffusion` */
    double wall[PD_SPECIES_MAX], closed[PD_SPECIES_MAX]; /* [mol/m3] held, NaN: not; 0 or NaN alike */
    double inlet[PD_SPECIES_MAX];                        /* [mol/m3] */
    int proton;                      /* solute H+; -1: none */
    int linear;                      /* 1: the equations are, in the totals */
    pd_diffusion diffusion;
    pd_open_boundary boundary;
    pd_flux flux;
    pd_inverse inverse;
    pd_migration migration;          /* empty without */
    int filters;                     /* kinetic reactions, and then minerals with a speed */
    pd_reactive_filter *filter;      /* [filters] */
    pd_krylov krylov;
    pd_arena own;
    double *c;      /* [solutes][total] [mol/m3] with inlets */
    double *carry;  /* [components][total] [mol/m3] what the last step left undone; the next one delivers it */
    double *source; /* [solutes][total] [mol/m3/s] given by the caller before a step */
    double *solid;  /* [minerals][total] [mol/m3] of the cell; NULL: none form */
    double *pass;   /* [total] [-] eps/tau at the middle of the step; NULL: minerals take no room */
    double *narrow; /* [total] [1/s] rate at which the share of minerals grew in the last step that stands */
    double *filled; /* [total] [-] that share at the start of the step */
    /* lent for a step: */
    double *begin;  /* [solutes][total] [mol/m3] at the start of the step */
    double *base;   /* [solutes][total] [mol/m3] before a step of Newton */
    double *total;  /* [components][total] [mol/m3] dissolved totals at the start, with the carry */
    double *move;   /* [solutes][total] [mol/m3] change of concentrations, work */
    double *work;   /* [2][components][total] residual over its weight, correction */
    double *slope;  /* [components][total] [mol/m3] change of totals in the first stage of two; NULL: one stage */
    double *part_of; /* [total] [mol/m3/s] work */
    uint8_t *spent; /* [components][total] 1: nothing of it is there, and the balance asks for less: that is owed */
    double *rates;  /* [total] [1/s] of exchange */
    float *by;      /* [total][slots] [-] how concentrations, [1/s] kinetic reactions and [-] minerals follow totals */
    double *solid_begin, *solid_base; /* [minerals][total] [mol/m3] as `begin` and `base` */
    double *solid_start; /* [minerals][total] [mol/m3] at the start of a stage */
    double *solid_slope; /* [minerals][total] [mol/m3] as `slope`, or NULL */
    double *still;  /* [total] [1/s] zeros */
    int slots;
    double weight[PD_SPECIES_MAX];   /* [mol/m3/s] of the balances of components */
    double came[PD_SPECIES_MAX];     /* [mol/m3] largest totals of components that none was there of at the start of a
                                      * step, of all lengths that were tried of it */
    double erred;                    /* [-] error of the last step that was tried from the same start; 0: none was */
    int stays;                       /* so many tries have made it no smaller */
    double dt;                       /* [s] of the stage at hand */
    int exact;                       /* 1: the equations of a step are met to rounding, not to the tolerance */
    int short_of;                    /* 1 + component of which the last step would take more than there is; 0: none */
    int32_t short_at;                /* where that is worst */
    const double *swept;          /* [components][total] [mol/m3] that is beside the cells, where metal has gone; NULL:
                                   * none is. Borrowed from `surface` */
    struct pd_etch *surface;      /* metal that dissolves by a law in the species; NULL: none. Borrowed */
} pd_reactive;

#define pd_reactive_build PD_NAME(pd_reactive_build)
#define pd_reactive_update PD_NAME(pd_reactive_update)
#define pd_reactive_begin PD_NAME(pd_reactive_begin)
#define pd_reactive_field PD_NAME(pd_reactive_field)
#define pd_reactive_source PD_NAME(pd_reactive_source)
#define pd_reactive_ph PD_NAME(pd_reactive_ph)
#define pd_reactive_saturation PD_NAME(pd_reactive_saturation)
#define pd_reactive_film PD_NAME(pd_reactive_film)
#define pd_reactive_potential PD_NAME(pd_reactive_potential)
#define pd_reactive_neutrality PD_NAME(pd_reactive_neutrality)
#define pd_reactive_balance_of PD_NAME(pd_reactive_balance_of)
#define pd_reactive_free PD_NAME(pd_reactive_free)
#define pd_reactive_part PD_NAME(pd_reactive_part)
#define pd_reactive_system PD_NAME(pd_reactive_system)

/* Grid, bonds and flow are borrowed; flow may be NULL. PD_ERR_ARGUMENT: a value is negative or not finite, a species
 * is no solute, reactions contradict each other, or no equilibrium was found. */
PD_API pd_status pd_reactive_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                                   const pd_reactive_desc *desc, pd_reactive *reactive);
/* After pd_bonds_update. Nodes that have turned fluid have what the caller puts there. */
PD_API pd_status pd_reactive_update(pd_ctx *ctx, pd_reactive *reactive);
/* After concentrations were set by hand: bring all nodes to equilibrium, and begin the balance anew.
 * PD_ERR_ARGUMENT: a concentration is negative or not finite, or no equilibrium was found. */
PD_API pd_status pd_reactive_begin(pd_ctx *ctx, pd_reactive *reactive);
/* [total] [mol/m3] and [mol/m3/s] of a species by its number in the desc; NULL: the solvent, a solid that is no
 * mineral, or the source of one. */
PD_API double *pd_reactive_field(pd_reactive *reactive, int species);
PD_API double *pd_reactive_source(pd_reactive *reactive, int species);
/* -log10 of the activity of H+ at a node, with mol/L; NaN: there is no such species. */
PD_API double pd_reactive_ph(const pd_reactive *reactive, int32_t node);
/* log10 of IAP/K of a mineral at a node; index < 0: the largest of all of them. NaN: there is none. */
PD_API double pd_reactive_saturation(const pd_reactive *reactive, int index, int32_t node);
/* Share of the cell of a node that minerals take, 0 to 1. */
PD_API double pd_reactive_film(const pd_reactive *reactive, int32_t node);
/* [V] diffusion potential at a fluid node after a step, against inlets and held walls; where there are none, against
 * its mean. NaN: without migration, and in fluid that no current enters beside electrodes that carry one way only. */
PD_API double pd_reactive_potential(const pd_reactive *reactive, int32_t node);
/* [-] Largest charge of a node over the largest sum of |z| c. */
PD_API double pd_reactive_neutrality(const pd_reactive *reactive);
/* Row `row` < reactive->rows of the balance. */
PD_API void pd_reactive_balance_of(pd_ctx *ctx, const pd_reactive *reactive, int row, pd_reactive_balance *balance);
PD_API void pd_reactive_free(pd_ctx *ctx, pd_reactive *reactive);
/* Components and minerals of the desc. */
PD_API pd_status pd_reactive_system(pd_ctx *ctx, const pd_reactive_desc *desc, pd_reactive *reactive);
/* What one of a species, by its number in the desc, has of a row: a solute or a mineral; 0: another one. */
PD_API double pd_reactive_part(const pd_reactive *reactive, int row, int species);
/* The concentrations of a node. */
static inline void pd_reactive_get(const pd_reactive *reactive, const double *field, int32_t i, double *c)
{
    for (int n = 0; n < reactive->components.solutes; n++) c[n] = field[(int64_t)n * reactive->grid->total + i];
}

#ifdef PDI_INTERNAL
/* Share of the largest total down to which one that dies out is followed. */
#define PDI_REACTIVE_TRACE 1e-12
/* Tolerance of the equations of a step where none is given. */
#define PDI_REACTIVE_TOLERANCE 1e-10
/* Sizes of totals [components] are no smaller than that; 0 stays. */
PDI_FN void pdi_reactive_trace(const pd_reactive *reactive, double *size);
/* Arrays of a pd_reactive that steps carry on, and those that are lent for a step. */
PDI_FN void pdi_reactive_list(pdi_array_visitor *owner, void *object);
PDI_FN void pdi_reactive_work_list(pdi_array_visitor *owner, void *object);
PDI_FN pd_arena *pdi_reactive_arena(pd_reactive *reactive);
/* Plan the solvers, of whose arrays the next one is the sum [byte] with the work; nothing is made. */
PDI_FN pd_status pdi_reactive_plan(pd_ctx *ctx, pd_reactive *reactive, pd_krylov_desc *linear);
/* `slots` and `filters` of its components. */
PDI_FN void pdi_reactive_slots(pd_reactive *reactive);
PDI_FN size_t pdi_reactive_room(pd_reactive *reactive);
/* Take down what passes the sides and held walls, and what sources give, in dt [s] at the present concentrations. */
PDI_FN void pdi_reactive_pass(pd_reactive *reactive, double dt);
/* Fluid without any solute, as a node that has just turned: the search begins with the mean of the fluid around it at
 * the start, since powers of concentrations have no slope at 0. */
PDI_FN void pdi_reactive_guess(pd_reactive *reactive);
/* The amounts of minerals of a node. */
static inline void pdi_reactive_solids(const pd_reactive *reactive, const double *field, int32_t i, double *n)
{
    for (int s = 0; s < reactive->minerals.count; s++) n[s] = field[(int64_t)s * reactive->grid->total + i];
}

static inline void pdi_reactive_put(const pd_reactive *reactive, const double *c, int32_t i, double *field)
{
    for (int n = 0; n < reactive->components.solutes; n++) field[(int64_t)n * reactive->grid->total + i] = c[n];
}
#endif

#endif
