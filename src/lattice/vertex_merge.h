/* vertex_merge: merges the corners of a triangle soup that coincide into shared vertices, exactly or within the
 * rounding of coordinates in files.
 *
 * A vertex has the number of its first corner. Corners are merged as disjoint sets (union-find, core/disjoint_sets)
 * whose root is their lowest member.
 */
#ifndef PD_VERTEX_MERGE_H
#define PD_VERTEX_MERGE_H
#include "core/array_registry.h"
#ifdef PDI_INTERNAL

/* Vertices closer than this fraction of the largest extent of the surface are merged when the surface is not closed
 * without it. More than the rounding of coordinates in files (six decimal digits). */
#define PDI_VERTEX_MERGE_TOLERANCE 3e-6

/* Merges corners with identical coordinates (0 and -0 are). corner [n][3] [m]; vertex [n] receives the lowest number of
 * the corners at the same point. Fails only for memory, and writes nothing then. */
PDI_FN pd_status pdi_vertex_merge_identical(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex);
/* Merges vertices at most PDI_VERTEX_MERGE_TOLERANCE times the largest extent of the surface apart, and chains of such.
 * vertex [n] goes in as pdi_vertex_merge_identical leaves it and becomes the lowest number of its chain; parent [n] is
 * scratch of the disjoint sets. *merged grows by the number of corners whose vertex changed. Coordinates stay. Nothing
 * is done for an extent of 0. */
PDI_FN pd_status pdi_vertex_merge_nearby(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex, int32_t *parent,
                                         int32_t *merged);
#endif

#endif
