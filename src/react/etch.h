/* etch: metal that dissolves by a law in the species at its surface, solved with the step of the species
 * (theory: eq. 8.2).
 *
 * The speed v of a node holds for the concentrations at the metal itself, behind a film that what dissolves diffuses
 * through. So v = max(law(c_s(v)), 0). Where a law falls there is one solution; where it jumps down, the speed between.
 *
 * With migration, metals may be electrodes: beside the law a polarisation curve brings its current into the species, by
 * a reaction of its own, and each circuit of metals has one potential, which is given, or follows from its total
 * current (levels.h, theory: 9.5).
 *
 * What metal leaves behind fills with the solution at its surface (theory: eq. 9.2). A cell of metal turns fluid as a
 * whole, so until then that solution is kept beside the cells of the fluid.
 */
#ifndef PD_ETCH_H
#define PD_ETCH_H
#include "react/reactive.h"
#include "transport/bounds.h"

/* Speed [m/s] at a fluid node, from what is at the surface: c [solutes] [mol/m3], pH (NaN without H+), the potential
 * phi [V] of pd_reactive_potential (NaN without migration), time t [s]. */
typedef double (*pd_etch_fn)(void *user, int32_t node, const double *c, double ph, double phi, double t);
/* Current density [A/m2] from metal to fluid, `share` [-] of that of a bare surface, from what is at the surface, at
 * `drop` [V], the potential of the metal less that of the fluid. It does not fall as that rises. */
typedef double (*pd_etch_curve_fn)(void *user, int electrode, double share, const double *c, double ph, double drop,
                                   double t);

/* Metals that are connected have one potential. */
typedef struct pd_etch_circuit {
    int holds;    /* 1: `value` is it; 0: it is the current into the fluid */
    double value; /* [V] or [A] (per m in planar 2D, per m2 in 1D) */
} pd_etch_circuit;

/* Zero-initialise. Arrays are borrowed for the life of the object, but for `part`. */
typedef struct pd_etch_electrodes {
    int count;                /* 0: none */
    pd_etch_curve_fn curve;
    double (*given)(void *user, int circuit, double t); /* value of a circuit at a time [s]; NULL: as it is */
    void *user;
    const double *part;       /* [count][species] [-] of each with one electron that leaves the fluid for the metal */
    const uint32_t *reads;    /* [count] bit n: the curve depends on solute n, and with bit 31 on pH; NULL: none does */
    const int *member;        /* [count] circuit of each */
    pd_etch_circuit *circuit; /* [circuits] */
    int circuits;
    int shares;               /* 1: places have `share`; 0: curves hold as they are */
} pd_etch_electrodes;

/* A metal that has a law of its own. */
typedef struct pd_etch_metal {
    pd_etch_fn law;     /* see pd_etch_desc */
    void *user;
    const double *shed; /* [species] [-] */
    uint32_t reads;
    int reads_ph;
} pd_etch_metal;

typedef struct pd_etch_desc {
    pd_etch_fn law;     /* NULL: none dissolves; of one metal of several: it stays */
    void *user;
    const double *shed; /* [species] [-] of each with one of the metal, negative: it goes; NULL: none comes */
    uint32_t reads;     /* bit n: the law depends on solute n */
    int reads_ph;       /* 1: on pH */
    const pd_etch_metal *more; /* [more_count] other metals, among electrodes alone; copied */
    int more_count;
    int reads_phi;      /* 1: on phi, which an inlet or a held wall has to tie, or with electrodes a given potential; of
                         * these phi is that of the fluid less that of the metal */
    pd_etch_electrodes electrodes;
    double solid;       /* [mol/m3] of the one metal: with migration what it leaves fills with what is at its surface;
                         * 0: it stays empty */
} pd_etch_desc;

typedef struct pd_etch {
    pd_etch_desc desc;         /* `shed` and `more` are not kept */
    pd_reactive *reactive;
    struct pdi_etch_kind *kind;   /* [kinds] the metals */
    int kinds;
    double scale[PD_SPECIES_MAX]; /* [-] diffusivities over the mean one, not 0 */
    pd_components film;           /* of concentrations times `scale` */
    int32_t count;                /* fluid nodes beside metal */
    int32_t *node;                /* [total] of places; those of a node follow each other */
    int32_t *slot;                /* [total] first place of a node; -1: none */
    double *weight;               /* [total] [mol/m4] of places: metal per speed */
    double *thick;                /* [total] [mol s/m4] of places: change of concentration across the film per speed */
    double *rise;                 /* [total] [mol s/m5] of places: how much that grows where metal recedes. The caller
                                   * may write it; else it is that of `solid` */
    uint8_t *metal;               /* [total] of places: which one; NULL: there is one */
    double *speed;                /* [kinds][total] [m/s] of nodes */
    double *ahead;                /* [total] [m] of places: metal that the step at hand takes, of an area */
    double *passed;               /* [total] [m] of places: the same of steps that stand */
    double *split;                /* [total] [m/s] work */
    int32_t *piece;               /* [total] of places: the piece of metal that alone gives there; -1: none is told */
    double *has;                  /* [3][total] [mol/m3 of a cell, times the circumference] of pieces; what they have
                                   * given in steps that stand, and in the step at hand */
    int32_t pieces;
    float *by;                    /* [total][components] of places: how the speed follows totals */
    float *drive;                 /* [total] [m/s] of places: how it follows F phi/(R T) of the node; with migration */
    double time;                  /* [s] of the law */
    double half;                  /* [s] of the step at hand */
    double from, span;            /* [s] start and length of that for the law and curves; span 0: `time` holds */
    /* with migration: */
    uint8_t *open;                /* [total] of places: 1: it lies on no closed loop of current, and carries none */
    uint8_t *ways, *way_of;       /* [total], [total + circuits + 1] work of loops */
    int32_t *joined;              /* [total + circuits + 1] what loops of current join: nodes, circuits, and ground */
    /* with `solid`: */
    double *surface;              /* [components][total] [mol/m3] of places: totals at the surface */
    double *sweep;                /* [components][total] [mol/m3] of places: what fills what the step at hand leaves */
    double *swept;                /* [1 + components][total] [-], [mol/m3] of nodes: volume that metal has left beside
                                   * their cells, over a cell, and what it holds */
    /* with electrodes: */
    double *part;                 /* [electrodes][solutes] [-] see pd_etch_electrodes */
    double *part_gain;            /* [electrodes][components] [-] of totals */
    int32_t *electrode;           /* [total] of places; -1: none */
    double *area;                 /* [total] [1/m] of places: of the electrode, over the volume of the node */
    double *way;                  /* [total] [s/m] of places: through the film, over the mean diffusivity */
    double *share;                /* [total] [-] of places: of their curve; NULL: 1. The caller writes it */
    double *flow;                 /* [total] [mol/m2/s] of places: electrons that leave the fluid by the curve */
    float *flow_by, *flow_drive;  /* as `by` and `drive`, of `flow` */
    double *gave;                 /* [total] [mol/m3/s] of places: of the law, at the end of the last step */
    double *side;                 /* [2][total] of places: speeds and flows on one side of a jump, and work */
    double *level;                /* [circuits] [V] potential of the metal */
    double *conduct;              /* [circuits] [mol/s/V] slope of the charge that leaves metal */
    double *charge_of;            /* [circuits] [mol/s] charge that leaves metal */
    double *charge;               /* [electrodes][2] [mol] electrons that have passed in steps that stand: from fluid to
                                   * metal; and without those that went the other way */
    double *charge_ahead;         /* [electrodes][2] [mol] the same of the step at hand */
    double *cathode;              /* [electrodes] [mol/s] electrons that curves took in the last step with metal */
    double owed, sourced;         /* [mol] charge that is owed at the start of a stage, [mol/s] that sources give */
    double late;                  /* [mol/m3/s] charge of sources that is metal's, after its step; of all nodes */
    double extra;                 /* [mol/s] what a circuit gives beside its current, where none leaves: of late metal
                                   * and of rounding */
    int alone;                    /* 1: a circuit without a given current whose metal carries current one way only
                                   * carries none; 0: it is lost. The caller writes it */
    uint32_t idle;                /* bit n: circuit n carries none for that */
    int lost;                     /* 1 + a circuit that no potential gives its current to; 0: none */
    pd_status (*stage)(pd_ctx *ctx, void *stager, double share); /* brings what law and curves read to that share of a
                                                                  * step; NULL: it holds for the step */
    void *stager;
    int32_t odd;                  /* 1 + a place whose law has been no number in the step at hand; 0: none */
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
typedef struct pdi_etch_kind {
    pd_etch_metal law;            /* shed is not kept */
    double shed[PD_SPECIES_MAX];  /* [-] of solutes */
    double gain[PD_SPECIES_MAX];  /* [-] of totals */
    double charge;                /* [-] that comes with one of the metal, as ions */
} pdi_etch_kind;

PDI_FN void pdi_etch_list(pdi_array_visitor *owner, void *object);
/* Bounds of solute n are none on the side to which sources and metal that dissolves bring it. */
PDI_FN void pdi_etch_bounds(const pd_reactive *reactive, int n, pdi_bounds *bounds);
/* What a film between nodes and surfaces solves with: the system of concentrations times `scale` [solutes], and the
 * same with the activities of a node: ln gamma of a charge of 1. */
PDI_FN void pdi_etch_film(const pd_reactive *reactive, pd_components *film, double *scale);
PDI_FN void pdi_etch_activities(const pd_components *of, const pd_components *film, double davies, pd_components *now);
/* The place put last is of that metal and has that electrode: `area` [1/m] of it over the volume of the node, `way`
 * [m] from the node to it. Of the places of a node one of each metal has a weight. */
PDI_FN void pdi_etch_polarise(pd_etch *etch, int metal, int electrode, double area, double way);
/* Nothing has passed in the step at hand; dt [s] of it at the present speeds; the step stands. */
PDI_FN void pdi_etch_begin(pd_etch *etch);
PDI_FN void pdi_etch_pass(pd_etch *etch, double dt);
PDI_FN void pdi_etch_accept(pd_etch *etch);
/* Share of the step at hand after which the first piece of metal has given what it has, in [0, 1); 1: all last.
 * *used: 1: one has just given it. */
PDI_FN double pdi_etch_lasts(pd_etch *etch, int *used);
/* Nodes that were metal are fluid: with `solid` they get what has filled them; `split` of them is the share of a cell
 * that they lack. */
PDI_FN void pdi_etch_turn(pd_etch *etch, const int32_t *turned, int32_t count);
/* Law and curves are those of a share of the step, and what they read. */
PDI_FN pd_status pdi_etch_stage(pd_ctx *ctx, pd_etch *etch, double share);
/* shed [solutes] comes with one of a metal. Its electrons go where curves took them last: shed gets the reactions
 * there, and is neutral. */
PDI_FN void pdi_etch_whole(const pd_etch *etch, double *shed);
/* With electrodes: `gave` is that of now. */
PDI_FN void pdi_etch_note(pd_etch *etch);
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
/* The same of what its electrode gives [mol/m2/s]. */
static inline double pdi_etch_follow_flow(const pd_etch *s, int32_t place, const double *change)
{
    int count = s->reactive->components.count;
    const float *by = s->flow_by + (int64_t)place * count;
    double sum = 0.0;
    for (int k = 0; k < count; k++) sum += (double)by[k] * change[k];
    return sum;
}
/* The metal of a place, by its number and what it is like, and its speed at the node. */
static inline int pdi_etch_which(const pd_etch *s, int32_t place) { return s->metal ? s->metal[place] : 0; }
static inline const pdi_etch_kind *pdi_etch_of(const pd_etch *s, int32_t place)
{
    return &s->kind[pdi_etch_which(s, place)];
}
static inline double *pdi_etch_speed(const pd_etch *s, int32_t place)
{
    return &s->speed[pdi_etch_which(s, place) * s->reactive->grid->total + s->node[place]];
}
/* The place of a node where that metal dissolves; -1: there is none. */
PDI_FN int32_t pdi_etch_law(const pd_etch *etch, int metal, int32_t i);
/* Circuit of a place; -1: it is no electrode. */
static inline int pdi_etch_circuit(const pd_etch *s, int32_t place)
{
    return s->electrode && s->electrode[place] >= 0 ? s->desc.electrodes.member[s->electrode[place]] : -1;
}
/* [mol/m3/s] of component k for a speed and a flow of a place. */
static inline double pdi_etch_gives(const pd_etch *s, int32_t place, int k, double speed, double flow)
{
    double with = pdi_etch_of(s, place)->gain[k];
    if (s->surface) with -= s->surface[k * s->reactive->grid->total + place] / s->desc.solid;
    double sum = with * s->weight[place] * speed;
    if (s->electrode && s->electrode[place] >= 0)
        sum += s->part_gain[s->electrode[place] * s->reactive->components.count + k] * s->area[place] * flow;
    return sum;
}
/* Adds to gain [components] [mol/m3/s] what metal and electrodes give node i at the present speeds and flows. */
static inline void pdi_etch_gain(const pd_etch *s, int32_t i, double *gain)
{
    for (int32_t p = s->slot[i]; p >= 0 && p < s->count && s->node[p] == i; p++)
        for (int k = 0; k < s->reactive->components.count; k++)
            gain[k] += pdi_etch_gives(s, p, k, s->weight[p] > 0.0 ? *pdi_etch_speed(s, p) : 0.0,
                                      s->electrode ? s->flow[p] : 0.0);
}
#endif

#endif
