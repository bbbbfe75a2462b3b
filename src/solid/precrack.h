/* precrack: pre-cracks of a body, and the damage field.
 *
 * A pre-crack is a point (1D), a segment (2D) or a plane convex polygon (3D). It breaks the bonds whose straight line
 * crosses it. The plane of a cut has a lower and an upper side: the upper one lies along the last axis along which the
 * normal has a part. Points on the plane count as above it, so a cut through a row of points divides the body below
 * that row: no point loses its family, and bonds within the row stay. A bond crosses the plane when its ends are on two
 * sides; the cut has its rim, so a bond that meets the end of a segment or the edge of a polygon breaks, and cuts that
 * share an end leave no gap. What is nearer than the rounding of places (1e-9 of the horizon, and some units in the
 * last place of the coordinates) lies on a plane or on a rim. Nothing depends on the order of points, of cuts, of the
 * corners, or on the end of a bond.
 */
#ifndef PD_PRECRACK_H
#define PD_PRECRACK_H
#include "solid/body.h"

typedef struct pd_precrack {
    int corners;          /* 1D: 1, 2D: 2, 3D: at least 3 */
    const double *corner; /* [corners][PD_DIM] [m] one after another around a polygon, either way. Borrowed */
} pd_precrack;

#define pd_body_apply_precracks PD_NAME(pd_body_apply_precracks)
#define pd_body_damage PD_NAME(pd_body_damage)

/* Break the bonds that cross one of the cuts. *broken (NULL: not wanted): how many were intact. Materials that are
 * built afterwards know of it; pd_correspondence_update tells those that exist. count 0 changes nothing.
 * PD_ERR_ARGUMENT, and no bond breaks: a negative count, corners of a wrong number or not finite, a segment without
 * length, a polygon that is not plane, not convex or without area. */
PD_API pd_status pd_body_apply_precracks(pd_ctx *ctx, pd_body *body, const pd_precrack *cuts, int count,
                                         int64_t *broken);
/* damage [count] [-]: the share of broken bonds in the family of each point, by volume (Silling and Askari 2005,
 * eq. 27): 1 - sum of V_j over intact bonds / sum of V_j over all. 0 for a point without bonds. */
PD_API void pd_body_damage(const pd_ctx *ctx, const pd_body *body, double *damage);

#endif
