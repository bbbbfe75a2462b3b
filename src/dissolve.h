/* dissolve: surface-rate dissolution. Solid nodes lose metal through the bonds that join them to fluid.
 *
 * A bond of offset n from solid node j moves  v(c_i) f_j c(n) Cs  [mol/m3/s] from j to i, the first fluid node on its
 * way into the fluid, with v the recession speed of the law, f_j the grain factor and c(n) the interface area that the
 * bond stands for: a flat front recedes at v for every h, m and direction (theory: eq. 6.1 to 6.4). The set of solid
 * nodes would lead the metal by about one cell, and a curved front would be too fast: so a node joins the fluid when as
 * much is left as the node set leads on average, and its solid neighbours take over the rest (their content may exceed
 * Cs: the surface stands out of the cell). The share `threshold` of the content stays in the node as dissolved metal.
 * Amounts are moved, never dropped;
 * metal that a step would use up gives what it has (eq. 6.6b).
 */
#ifndef PD_DISSOLVE_H
#define PD_DISSOLVE_H
#include "material.h"
#include "transport.h"

typedef struct pd_dissolve_desc {
    double solid;        /* [mol/m3] concentration Cs of intact metal */
    double threshold;    /* [-] fraction of Cs at which a node turns fluid, 0 <= threshold < 1 */
    pd_rate_fn rate;
    void *rate_user;
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
    int stalled;              /* 1: fluid at the front takes nothing now, but would below saturation */
    double *weight;           /* [total] [mol/m4] fluid nodes: sum f c(n) Cs over their solid bonds */
    double *speed;            /* [total] [m/s] fluid nodes: v0 and, after a step, v */
    double *rate;             /* [total] [1/s] solid nodes: share of the span lost per time in the last step */
    double *slope;            /* [total] [m4/mol/s] dv/dc, not positive */
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
/* Linearise the law at the present concentrations and set transport->source and ->absorb. PD_ERR_STATE: the law
 * returned NaN or infinity (the message names node, place and concentration). */
PD_API pd_status pd_dissolve_prepare(pd_ctx *ctx, pd_dissolve *dissolve);
/* Largest loss rate [1/s] of any node as a fraction of what a node loses before it turns fluid. */
PD_API double pd_dissolve_fastest(pd_ctx *ctx, const pd_dissolve *dissolve);
/* pd_transport_implicit of dt [s] with these sources. Where a piece of metal would give more than it has, the step is
 * taken again with what it has (theory: eq. 6.6b). */
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
#endif

#endif
