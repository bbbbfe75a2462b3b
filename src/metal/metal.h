/* metal: dissolving metal, as data: its law, its content, and the fluid beside it.
 *
 * Two models of the surface share all of this. They differ in the weights of the bonds that cross the surface and in
 * when a node turns fluid.
 * - Surface rate: what a bond gives enters at the first fluid node on its way, behind a film (theory: 10.2, 10.7).
 * - Bonds: what a bond gives enters at its far end, and a node turns at saturation (theory: 11).
 */
#ifndef PD_METAL_H
#define PD_METAL_H
#include "transport/transport.h"
#include "lattice/bond_path.h"
#include "solve/physics.h"
#include "metal/front.h"
#include "metal/law.h"
#include <math.h>

typedef enum pd_metal_model {
    PD_METAL_SURFACE = 0, /* surface rate */
    PD_METAL_BONDS        /* bond-based corrosion */
} pd_metal_model;

typedef enum pd_drive {
    PD_DRIVE_CONSTANT = 0,  /* the law holds at every concentration of the fluid */
    PD_DRIVE_DIFFERENCE = 1 /* loss in proportion to C_j - C_i: the law holds at C_i = 0 */
} pd_drive;

/* A metal that has a Cs and a law of its own. */
typedef struct pd_metal {
    double solid;    /* [mol/m3] see pd_dissolve_desc */
    pd_rate_fn rate;
    void *rate_user;
    int uniform;
    int timeless;
    pd_rate_bounds_fn bounds;
    const double *breaks; /* [s] */
    int break_count;
} pd_metal;

/* Zero-initialise. */
typedef struct pd_dissolve_desc {
    double solid;         /* [mol/m3] concentration Cs of intact metal */
    double threshold;     /* [-] fraction of Cs at which a node turns fluid, 0 <= threshold < 1; bonds: Csat/Cs */
    pd_rate_fn rate;      /* any law: rising, flat, with jumps; negative speeds count as 0 */
    void *rate_user;
    int uniform;          /* 1: the law depends on the concentration alone, its ends are looked for once */
    int timeless;         /* 1: it does not depend on time */
    pd_rate_bounds_fn bounds; /* of the law in time; NULL: it stays between its values at both ends and in the middle of
                               * any time without a break: */
    const double *breaks; /* [break_count] [s] ascending: when it jumps, or a pulse begins or ends. Borrowed */
    int break_count;
    const pd_metal *more; /* [more_count] other metals, whose amounts add up in the fluid; copied */
    int more_count;       /* at most 7 */
    const uint8_t *metal; /* [total] of solid nodes: 0: the metal above, k: more[k - 1]; NULL: 0. Borrowed */
    const int32_t *grain; /* [total] of solid nodes: what a law sees as pd_rate_at.grain; NULL: -1. Borrowed */
    const double *factor; /* [total] [-] of solid nodes, multiplies the speed; NULL: 1. Borrowed */
    int sheds;            /* 1: `shed` of pd_dissolve is kept; 2: of each metal for itself */
    int lags;             /* 1: and lasts from step to step: its user empties it before the metal moves */
    pd_solve_at_fn found; /* the fluid beside metal is known, for laws at that time; they are asked afterwards. NULL:
                           * nobody wants to know */
    void *found_user;
    int follows;          /* 1: laws hold for a step, and follow what moves behind the metal: steps are as long as that
                           * is right */
    int driven;           /* 1: what they follow is found anew at the middle of a step, by `found` */
    int anew;             /* 1: what is behind the metal moves after each of its steps; 0: it may do so after several */
    pd_metal_model model;
    /* ---- bonds: */
    double saturation;    /* [mol/m3] Csat, 0 < Csat < Cs: fluid at or above it takes no metal, metal turns there */
    double rtol;          /* [-] error in time of the fluid over Csat, root mean square, from which the next step
                           * follows; 0: 1e-3 */
    int activation;       /* 1: fluid holds `bulk`, what it gains is gone at once */
    double bulk;          /* [mol/m3] with activation */
    pd_drive drive;
    pd_kernel kernel;
    pd_weights weights;   /* of the kernel */
    int stochastic;       /* 1: mechanical bonds of a node break at random as it dissolves, and it turns fluid when none
                           * is left, with what it holds (theory: 11.5) */
    uint64_t seed;        /* of that */
    double repassivation; /* [mol/m3] fluid beside metal that is below it at the start of a step does not attack any
                           * more: a film has formed; up to Csat, 0: none forms */
    const uint8_t *passive; /* [total] 1: fluid there does not attack; NULL: none. Borrowed */
} pd_dissolve_desc;

typedef struct pd_dissolve {
    pd_dissolve_desc desc;
    pd_grid *grid;
    pd_bond_paths paths;      /* of the metal's bonds */
    pd_transport *transport;  /* its array c holds the solid content too */
    pd_front kernel;          /* bonds: weights across the front */
    const double *weight;     /* [count] [1/m] weights of the bonds across the surface */
    struct pdi_metal_kind *kind; /* [kinds] the metals */
    int kinds;
    int uniform;              /* 1: all laws are */
    uint8_t *exposed;         /* [total] solid node with a fluid node in its family */
    int32_t capacity;         /* of the lists: all solid nodes of the build */
    int32_t *front;           /* exposed nodes, ascending */
    int32_t *changed;         /* nodes that turned fluid in the last step */
    int32_t *piece;           /* nodes of the pieces of metal that the step uses up, and work */
    int32_t front_count, changed_count, gone_count;
    uint8_t *mark;            /* [total] what the step knows of a solid node */
    int rated;                /* 1: rate is that of the transport step just made */
    double lead;              /* [-] content at which a node joins the fluid and its solid neighbours take the rest, so
                               * that the surface of the node set lies where the metal ends on average (eq. 10.9) */
    double spread;            /* [1/m2] sum a(n) of a whole family */
    double time;              /* [s] of the law, set by the caller before pd_dissolve_prepare */
    double *moment, *part;    /* [moments] [s] instants in whose place it stands, and their weights [-]; there is room
                               * where a law depends on time */
    int moments;              /* 0: the law is that of `time` */
    int timed;                /* 1: a law depends on time */
    double most;              /* [-] set like time: the largest share of its supply that a node may lose in a step; 0:
                               * any */
    double rtol;              /* [-] set like time: error in time of the metal lost, over all that is lost; 0: any */
    double lost;              /* [mol] set like time: lost before the step */
    double retry_dt;          /* [s] after PD_RETRY: the step to try next */
    double last_dt;           /* [s] of the last step; 0: none */
    double next_dt;           /* [s] longest step that the error in time of the last one proposes; HUGE_VAL: any */
    double lean, step_lean;   /* [mol] what steps have taken too little by their estimates; the step at hand */
    double stray, step_stray; /* [mol] what steps have missed of the fluid, whatever its sign; the step at hand */
    double last_speed;        /* [mol/s] with `follows`: at the end of the last step, by the law that it went by */
    double first_speed;       /* [mol/s] at its start */
    double foreseen;          /* [s] how long the next step may be by the last one */
    int faint;                /* 1: whose error was none beside a cell, or there was no step */
    double drift;             /* [mol/s] what laws of its middle give more there */
    int rounds;               /* linear systems in the last step */
    int32_t *slot;            /* [total] place of a fluid node beside metal in `beside`, and with bonds of an exposed
                               * node in `reach`; -1: it has none */
    struct pdi_beside *beside; /* [beside_capacity + 1] these nodes; the last one takes what finds no room */
    struct pdi_metal_beside *portion; /* [beside_capacity + 1, kinds] the metals beside them */
    int32_t beside_count, beside_capacity;
    int beside_lacks;         /* 1: a node has found no room */
    double *rate;             /* [total] [1/s] solid nodes: share of the supply lost per time in the last step */
    uint32_t *reach;          /* bonds: [reach_rows][words] bit k % 32 of word k / 32: bond k of an exposed node leads
                               * to fluid that takes metal */
    int32_t reach_rows, reach_used;
    int16_t *facing;          /* [total][PD_DIM] of exposed nodes: from metal to fluid, in spacings, of any length */
    float *tilt;              /* [total] [-] 1/f(N) of exposed nodes, by which their bonds count (eq. 10.6); NULL: 1 */
    int tilted;               /* 1: they are those of now, but for touched nodes */
    int reached;              /* 1: they are those of now, but for touched nodes */
    int lags;                 /* 1: nodes have been touched since the rates were found */
    int lasts;                /* 1: `rate` of all exposed nodes follows from the speeds `rated` of now */
    int32_t *pinned;          /* [beside_capacity + 1] see pd_transport */
    /* ---- bonds: */
    uint8_t *film;            /* [total] 1: fluid in front of a film that has formed; NULL: none forms */
    uint16_t *links;          /* [total] mechanical bonds of solid nodes at the start; NULL: not stochastic */
    double *last;             /* [total] [mol/m3] content at which the last of them breaks; NULL: not stochastic */
    double *moved;            /* [total] [mol/m3] change of fluid nodes in the last step; NULL: surface, activation */
    int32_t turned;           /* nodes that turned in it: fields bend there, which is no error in time */
    double *shed;             /* [total] [mol/m3] what fluid nodes have got from metal since it was emptied by its user;
                               * [kinds][total] where each metal is kept for itself; NULL: nobody asks */
    double rinsed;            /* [mol] activation: what is gone in the last step */
    /* ---- a run: */
    pd_transport_result result; /* of the last step */
    double longest;           /* [s] attempt at the step at hand */
    double out, in;           /* [mol] (per m in planar 2D) through outlets, inlets and held walls since the build */
    int64_t krylov;
} pd_dissolve;

#ifdef PDI_INTERNAL
/* A metal: Cs, content that it loses before it turns fluid, content at which it turns [mol/m3], law. */
typedef struct pdi_metal_kind {
    double solid, supply, end;
    pd_metal law;
    double ratio;    /* [-] ln(Cs/Csat), of a drive by difference */
    double from, to; /* [mol/m3] a uniform law is positive between these; HUGE_VAL: it ends nowhere */
    double touch;    /* [mol/m3] a law touches 0 here, where it was looked at; 0: nowhere; below 0: not looked at yet */
    int32_t like;    /* place in `beside` of a node that this metal is alone at and whose line is known; -1: none */
} pdi_metal_kind;

/* One of the metals beside a fluid node. */
typedef struct pdi_metal_beside {
    double enters;         /* [mol/m4] see pdi_beside */
    double mean;           /* [m/s] speed of the metal where it enters */
    double weight;         /* [mol/m4] see pdi_beside */
    double speed;          /* [m/s] what its law gives where it arrives */
    double stock;          /* bonds: [mol2/m7] sum of weight times the content of the metal; else [mol/m3/s] what
                            * pieces of it give that do not last the step */
    double used, used_stock; /* of pieces of metal that do not last the step: weight [mol/m4], that times content */
    double paid;           /* [mol/m4] and what they give, per speed */
    double rated;          /* [m/s] `mean` when the rates were found */
} pdi_metal_beside;

/* A fluid node beside metal: what all metals there are together. */
typedef struct pdi_beside {
    int32_t node;
    /* where metal enters */
    double enters;         /* [mol/m4] sum f c(n) Cs over the solid bonds that enter here and follow the law */
    double hollow, factor; /* [mol/m4] sums of that times the film in cells, and times f Cs/Cs of the first metal */
    double normal[PD_DIM]; /* from the metal */
    double links;          /* sum of what the bonds through here count */
    /* where it arrives */
    double weight;         /* [mol/m4] share of `enters` */
    double touch;          /* [mol/m3] the laws of all its metals touch 0 here, now; 0: nowhere */
    double given;          /* [mol/m3/s] what pieces of metal give that do not last the step (eq. 10.11) */
    double film;           /* [mol/m3] sum of weight times the film */
    double flux;           /* [mol/m4] sum of weight times f Cs/Cs of the first metal */
    double before;         /* [m/s] speed at the start of the step */
    double late;           /* [mol/m3/s] half of what transport brings more at the start of a step than at its end */
    int fresh;             /* 1: bonds: not there when the rates were found */
    pdi_law_point point;
} pdi_beside;

static inline int pdi_metal_bonds(const pd_dissolve *d) { return d->desc.model == PD_METAL_BONDS; }
static inline double pdi_metal_factor(const pd_dissolve *d, int32_t solid)
{
    return d->desc.factor ? d->desc.factor[solid] : 1.0;
}
/* What the bonds of exposed node j count: its factor, and what its area is over that of its weights. */
static inline double pdi_metal_gives(const pd_dissolve *d, int32_t solid)
{
    return pdi_metal_factor(d, solid) * (d->tilt ? d->tilt[solid] : 1.0);
}
/* Index of the metal of solid node j. */
static inline int pdi_metal_of(const pd_dissolve *d, int32_t j) { return d->desc.metal ? d->desc.metal[j] : 0; }
/* Row of `shed` of that metal. */
static inline double *pdi_metal_shed(const pd_dissolve *d, int metal)
{
    return d->shed + (d->desc.sheds > 1 ? metal : 0) * d->grid->total;
}
/* Cs there. */
static inline double pdi_metal_solid(const pd_dissolve *d, int32_t j) { return d->kind[pdi_metal_of(d, j)].solid; }
/* What an intact node j loses before it turns fluid [mol/m3]. */
static inline double pdi_metal_supply(const pd_dissolve *d, int32_t j) { return d->kind[pdi_metal_of(d, j)].supply; }
/* Content at which node j turns [mol/m3]. */
static inline double pdi_metal_end(const pd_dissolve *d, int32_t j)
{
    return d->last ? d->last[j] : d->kind[pdi_metal_of(d, j)].end;
}
/* The metals beside a fluid node. */
static inline pdi_metal_beside *pdi_metal_portion(const pd_dissolve *d, const pdi_beside *beside)
{
    return d->portion + (beside - d->beside) * d->kinds;
}
/* Content of node j above what stays in it, as a share of the supply. */
static inline double pdi_metal_left(const pd_dissolve *d, int32_t j)
{
    return (d->transport->c[j] - pdi_metal_end(d, j)) / pdi_metal_supply(d, j);
}
/* Weight c(n) [1/m] of bond k of node j across the surface; a ring moves what a bond crosses at its mean radius. */
static inline double pdi_metal_area(const pd_dissolve *d, int32_t j, int k)
{
    const pd_stencil *s = d->paths.stencil;
    if (PD_DIM != 2 || !d->grid->circumference) return d->weight[k];
    double middle = pdi_grid_circumference_at(d->grid, j, 0.5 * s->xi[k * PD_DIM + PD_DIM - 1]);
    return d->weight[k] * (middle / pd_grid_circumference(d->grid, j));
}
/* The same of bond k of fluid node i, which leads to metal j. Behind a side it leads to the image of j, at another mean
 * radius than the bond of j, which leads to the image of i: that one counts for both. */
static inline double pdi_metal_area_beside(const pd_dissolve *d, int32_t i, int k, int32_t j)
{
    const pd_stencil *s = d->paths.stencil;
    if (PD_DIM != 2 || !d->grid->circumference) return d->weight[k];
    int64_t stride = d->grid->stride[PD_DIM - 1];
    if (j / stride - i / stride == s->offset[k * PD_DIM + PD_DIM - 1]) return pdi_metal_area(d, i, k);
    double middle = pdi_grid_circumference_at(d->grid, j, 0.5 * s->xi[k * PD_DIM + PD_DIM - 1]);
    return d->weight[k] * (middle / pd_grid_circumference(d->grid, i));
}
/* Volume of node j over that of node i. */
static inline double pdi_metal_over(const pd_dissolve *d, int32_t j, int32_t i)
{
    return pd_grid_circumference(d->grid, j) / pd_grid_circumference(d->grid, i);
}
/* 1: there is a passive film in front of fluid node i. */
static inline int pdi_metal_passive(const pd_dissolve *d, int32_t i)
{
    return (d->desc.passive && d->desc.passive[i]) || (d->film && d->film[i]);
}
/* What a bond between metal j and fluid i moves, over what it would by a constant drive [-]. */
static inline double pdi_metal_drive(const pd_dissolve *d, int32_t j, int32_t i)
{
    if (d->desc.drive == PD_DRIVE_CONSTANT) return 1.0;
    const pdi_metal_kind *kind = &d->kind[pdi_metal_of(d, j)];
    return kind->ratio * (d->transport->c[j] - d->transport->c[i]) / kind->supply;
}
#endif

#endif
