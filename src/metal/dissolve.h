/* dissolve: surface-rate dissolution. Solid nodes lose metal through the bonds that join them to fluid.
 *
 * A bond of offset n from solid node j moves  V f_j c(n) Cs  [mol/m3/s] into the fluid, with V the mean of V(c_i), the
 * recession speed of the law behind the film between the surface and node i (law.h), over the nodes whose bonds the
 * metal cuts there (eq. 6.2c), f_j the grain factor and c(n) the interface area that the bond stands for: a flat front
 * recedes at V for every h, m and direction (theory: eq. 6.1 to 6.4). Law and transport are solved together for the end
 * of the step. The set of solid nodes would lead the metal by about one cell, and a curved front be too fast: so a
 * node joins the fluid when as much is left as the node set leads on average, and its solid neighbours take over the
 * rest (their content may exceed Cs: the surface stands out of the cell). The share `threshold` of the content stays in
 * the node as dissolved metal. Amounts are moved, never dropped;
 * metal that a step would use up gives what it has (eq. 6.6b).
 */
#ifndef PD_DISSOLVE_H
#define PD_DISSOLVE_H
#include "transport/transport.h"
#include "metal/law.h"

typedef struct pd_dissolve_desc {
    double solid;        /* [mol/m3] concentration Cs of intact metal */
    double threshold;    /* [-] fraction of Cs at which a node turns fluid, 0 <= threshold < 1 */
    pd_rate_fn rate;      /* any law: rising, flat, with jumps; negative speeds count as 0 */
    void *rate_user;
    int uniform;          /* 1: the law depends on the concentration alone, its ends are looked for once */
    const double *factor; /* [total] [-] of solid nodes, multiplies the speed; NULL: 1. Borrowed */
} pd_dissolve_desc;

typedef struct pd_dissolve {
    pd_dissolve_desc desc;
    pd_grid *grid;
    const pd_bonds *bonds;
    pd_transport *transport;  /* its array c holds the solid content too */
    uint8_t *exposed;         /* [total] solid node with a fluid node in its family */
    int32_t capacity;         /* of the lists: all solid nodes of the build */
    int32_t *front;           /* exposed nodes, ascending */
    int32_t *changed;         /* nodes that turned fluid in the last step */
    int32_t *piece;           /* nodes of the pieces of metal that the step uses up, and work */
    int32_t front_count, changed_count, gone_count;
    uint8_t *mark;            /* [total] what the step knows of a solid node */
    int rated;                /* 1: rate is that of the transport step just made */
    double lead;              /* [-] content at which a node joins the fluid and its solid neighbours take the rest, so
                               * that the surface of the node set lies where the metal ends on average (eq. 6.5) */
    double spread;            /* [1/m2] sum a(n) of a whole family */
    double time;              /* [s] of the law, set by the caller before pd_dissolve_prepare */
    double most;              /* [-] likewise: the largest share of its span that a node may lose in a step; 0: any */
    double rtol;              /* [-] likewise: error in time of the metal lost, over all that is lost; 0: any */
    double lost;              /* [mol] likewise: lost before the step */
    double retry_dt;          /* [s] after PD_RETRY: the step to try next */
    double next_dt;           /* [s] longest step that the error in time of the last one proposes; HUGE_VAL: any */
    int rounds;               /* linear systems in the last step */
    int32_t *slot;            /* [total] place of a fluid node beside metal in `shore`; -1: it is none */
    struct pdi_shore *shore;  /* these nodes */
    int32_t shore_count, shore_capacity;
    double from, end;         /* [mol/m3] a uniform law is positive between these; HUGE_VAL: it ends nowhere */
    double *rate;             /* [total] [1/s] solid nodes: share of the span lost per time in the last step */
} pd_dissolve;

#define pd_dissolve_build PD_NAME(pd_dissolve_build)
#define pd_dissolve_prepare PD_NAME(pd_dissolve_prepare)
#define pd_dissolve_fastest PD_NAME(pd_dissolve_fastest)
#define pd_dissolve_transport PD_NAME(pd_dissolve_transport)
#define pd_dissolve_finish PD_NAME(pd_dissolve_finish)
#define pd_dissolve_stock PD_NAME(pd_dissolve_stock)
#define pd_dissolve_free PD_NAME(pd_dissolve_free)

/* Fills the solid nodes of transport->c with Cs. PD_ERR_ARGUMENT: solid not positive, threshold out of range. */
PD_API pd_status pd_dissolve_build(pd_ctx *ctx, pd_grid *grid, const pd_bonds *bonds, pd_transport *transport,
                                   const pd_dissolve_desc *desc, pd_dissolve *dissolve);
/* Begin a step: who lies beside metal, and the law there, at the present concentrations and at dissolve->time; sets
 * transport->source and ->absorb. PD_ERR_STATE: the law returned NaN, infinity or 1e100 m/s and more (the message names
 * node, place and concentration). */
PD_API pd_status pd_dissolve_prepare(pd_ctx *ctx, pd_dissolve *dissolve);
/* Largest loss rate [1/s] of any node as a fraction of what a node loses before it turns fluid. */
PD_API double pd_dissolve_fastest(pd_ctx *ctx, const pd_dissolve *dissolve);
/* pd_transport_implicit of dt [s] together with the law at its end. Where a piece of metal would give more than it has,
 * the step is taken again with what it has (theory: eq. 6.6b). PD_RETRY, nothing changed: a node would lose more than
 * `most`, the error is above `rtol`, or law and transport found no common solution; prepare again and take retry_dt. */
PD_API pd_status pd_dissolve_transport(pd_ctx *ctx, pd_dissolve *dissolve, double dt, pd_transport_result *result);
/* After the transport step of dt [s]: take the losses from the solid, turn empty nodes fluid (grid kinds and ghosts
 * change; bonds, flow and transport are the caller's to update with dissolve->changed). */
PD_API pd_status pd_dissolve_finish(pd_ctx *ctx, pd_dissolve *dissolve, double dt);
/* Amount [mol, per m in planar 2D] left in solid nodes. */
PD_API double pd_dissolve_stock(pd_ctx *ctx, const pd_dissolve *dissolve);
PD_API void pd_dissolve_free(pd_ctx *ctx, pd_dissolve *dissolve);

#ifdef PDI_INTERNAL
/* Nodes have turned fluid: who is exposed now. */
PDI_FN void pdi_dissolve_turned(pd_dissolve *dissolve, const int32_t *turned, int32_t count);
/* Recession speed [m/s] of metal beside node i in the last step; 0: there is none. */
PDI_FN double pdi_dissolve_speed(const pd_dissolve *dissolve, int32_t i);
/* The course of the law over a step from t [s] at the present concentrations: share [-] of a node's content by which
 * the law at the middle of the step and Simpson's rule disagree, and that the faster of middle and end takes, at most.
 */
PDI_FN void pdi_dissolve_course(const pd_dissolve *dissolve, double t, double dt, double *error, double *taken);
/* Bytes of one node of `shore`, which holds the metal and the fluid within a horizon of it. */
PDI_FN size_t pdi_dissolve_shore_size(void);
#endif

#endif
