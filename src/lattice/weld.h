/* weld: corners of triangles at one place are one vertex: as they are, or as far as files round coordinates.
 *
 * A vertex is named by the first of its corners. What is joined is a tree whose root is the first of its members.
 */
#ifndef PD_WELD_H
#define PD_WELD_H
#include "core/owner.h"
#ifdef PDI_INTERNAL

/* Vertices of a surface that is open without it are the same within this share of its largest extent. */
#define PDI_WELD_NEAR 3e-6

/* Corners corner [n][3] [m] at the same places are one vertex: vertex [n]. */
PDI_FN pd_status pdi_weld_exact(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex);
/* Vertices that lie side by side are one: files round coordinates. root [n]: work. *joined grows by the corners that
 * lie beside their vertex. */
PDI_FN pd_status pdi_weld_near(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex, int32_t *root,
                               int32_t *joined);
#endif

#endif
