/* content: what solid nodes hold: pieces that a step uses up, who turns fluid, and who takes over the rest.
 *
 * Surface rate: the set of solid nodes would lead the metal by about one cell, so a node joins the fluid when as much
 * is left as the set leads on average, and its solid neighbours take over the rest (theory: 10.7). Bonds: a node turns
 * at the end of the step that is closest to its end, and the metal around evens out the rest (theory: 11.6). Amounts
 * are moved, never dropped.
 */
#ifndef PD_CONTENT_H
#define PD_CONTENT_H
#include "metal/interface.h"

#ifdef PDI_INTERNAL
/* Marks of solid nodes within a step. */
enum {
    PDI_CONTENT_SEEN = 1,  /* by the search at hand */
    PDI_CONTENT_LASTS = 2, /* its piece has more than it gives */
    PDI_CONTENT_GONE = 4,  /* its piece gives all that it has */
    PDI_CONTENT_TURNED = 8 /* fluid from this step on */
};
/* Mean lead of the node set [-] for the surface rate. */
PDI_FN double pdi_content_lead(const pd_stencil *stencil);
PDI_FN int pdi_content_is_exposed(const pd_dissolve *dissolve, int32_t j);
/* List the exposed nodes. */
PDI_FN void pdi_content_collect(pd_dissolve *dissolve);
/* Pieces that would give more than they have get sources that give what they have. Returns the number of such
 * pieces. */
PDI_FN int pdi_content_spare(pd_dissolve *dissolve, double dt);
/* A piece of metal of `metal`, the `piece`-th, has `has` [mol/m3 of a cell, times the circumference on rings] above
 * the threshold, and gives `weight` [mol/m4] a unit of speed to a fluid node. */
typedef void (*pdi_content_put_fn)(void *user, int32_t piece, double has, int metal, int32_t node, double weight);
/* Pieces of few nodes, with all fluid nodes that they give to. Returns 1 when there are others. */
PDI_FN int pdi_content_small(pd_dissolve *dissolve, pdi_content_put_fn put, void *user);
/* Nodes have turned fluid: who is exposed now. */
PDI_FN void pdi_content_turned(pd_dissolve *dissolve, const int32_t *turned, int32_t count);
/* After the transport step of dt [s]: take the losses from the solid, turn nodes fluid. */
PDI_FN pd_status pdi_content_finish(pd_ctx *ctx, pd_dissolve *dissolve, double dt);
/* Amount [mol, per m in planar 2D] left in solid nodes, and its volume [m3, m2 in planar 2D]. */
PDI_FN double pdi_content_stock(const pd_ctx *ctx, const pd_dissolve *dissolve, double *volume);
#endif

#endif
