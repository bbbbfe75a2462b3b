/* weld: merges the corners of a triangle soup that coincide into shared vertices, exactly or within the rounding of
 * coordinates in files.
 *
 * A vertex has the number of its first corner. Corners are merged as disjoint sets (union-find, core/sets) whose root
 * is their lowest member.
 */
#ifndef PD_WELD_H
#define PD_WELD_H
#include "core/owner.h"
#ifdef PDI_INTERNAL

/* Vertices closer than this fraction of the largest extent of the surface are merged when the surface is not closed
 * without it. More than the rounding of coordinates in files (six decimal digits). */
#define PDI_WELD_NEAR 3e-6

/* Merges corners with identical coordinates. corner [n][3] [m]; vertex [n] receives the number of the first corner at
 * the same point. */
PDI_FN pd_status pdi_weld_exact(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex);
/* Merges vertices that lie closer than PDI_WELD_NEAR times the extent of the surface. vertex [n] goes in as
 * pdi_weld_exact leaves it and is updated; parent [n] is scratch of the disjoint sets. *merged grows by the number of
 * corners whose vertex changed. */
PDI_FN pd_status pdi_weld_near(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex, int32_t *parent,
                               int32_t *merged);
#endif

#endif
