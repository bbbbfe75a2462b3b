/* crack: see crack.h */
#include "solid/crack.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Share of bonds that a point at the tip of a crack has lost: half of the part of its ball beyond the crack, which for
 * points half a cell beside it is 0.16 to 0.21 with m = 2 to 4. */
#define PDI_CRACK_TIP_DAMAGE 0.15
/* Points count as equally far ahead within this distance, over the horizon. */
#define PDI_CRACK_ROUNDING 1e-9
/* Singular shape tensor: smallest pivot over the largest entry of K below which no gradient exists. */
#define PDI_CRACK_MIN_PIVOT 1e-6
/* Sum of the gradient of q along the crack, over the sum of its absolute values, above which a surface cuts the domain
 * across the crack. */
#define PDI_CRACK_OPEN_SURFACE 0.05

enum { PDI_CRACK_TENSOR = PD_DIM * PD_DIM };

/* Fields for the domain integral around a tip. */
typedef struct pdi_crack_fields {
    const pd_material_interface *solid;
    pd_crack_desc desc; /* way and front of length 1 */
    int64_t count;
    double *q;        /* [count] [-] */
    double *q_gradient; /* [count][PD_DIM] [1/m] of q */
    double *gradient; /* [count][PD_DIM^2] [-] of u, by correspondence */
    double *force;    /* [count][PD_DIM] [N/m3] */
    double *stress;   /* [count][PD_DIM^2] [Pa] of materials without bonds that pull */
    double *density;  /* [count] [J/m3] of materials with bonds that pull */
} pdi_crack_fields;

/* Describes these fields. */
static void pdi_crack_list(pdi_array_visitor *owner, void *object)
{
    pdi_crack_fields *crack = (pdi_crack_fields *)object;
    PDI_ARRAY(owner, crack, q, crack->count, "1");
    PDI_ARRAY(owner, crack, q_gradient, crack->count * PD_DIM, "1/m");
    PDI_ARRAY(owner, crack, gradient, crack->count * PDI_CRACK_TENSOR, "1");
    PDI_ARRAY(owner, crack, force, crack->count * PD_DIM, "N/m3");
    PDI_ARRAY(owner, crack, stress, crack->solid->force_state ? 0 : crack->count * PDI_CRACK_TENSOR, "Pa");
    PDI_ARRAY(owner, crack, density, crack->solid->force_state ? crack->count : 0, "J/m3");
}

/* Scales x [PD_DIM] to length 1. Returns 1; 0: it has no length or no finite one, and stays. */
static int pdi_crack_normalise(double *x)
{
    double length = pdi_vec_norm(x);
    if (!(length > 0.0) || !(length < 1e100)) return 0;
    for (int d = 0; d < PD_DIM; d++) x[d] /= length;
    return 1;
}

/* Checks the description and the material, and normalises direction and front in place. PD_ERR_ARGUMENT: not 0 <= inner
 * < outer, a tip that is not finite, a direction without length; in 3D a front not at a right angle to it or a
 * thickness not positive; a material with force states without densities, or without them no stress or forces that are
 * not linear. */
static pd_status pdi_crack_check(pd_ctx *ctx, pdi_crack_fields *c)
{
    pd_crack_desc *desc = &c->desc;
    int good =
        desc->inner >= 0.0 && desc->outer > desc->inner && desc->outer < 1e100 && pdi_crack_normalise(desc->direction);
    for (int d = 0; d < PD_DIM; d++) good = good && fabs(desc->tip[d]) < 1e100;
    if (PD_DIM == 3)
        good = good && pdi_crack_normalise(desc->front) && fabs(pdi_vec_dot(desc->direction, desc->front)) < 1e-6 &&
               desc->thickness > 0.0 && desc->thickness < 1e100;
    if (!good)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "crack", "radii of %g and %g m: expected a finite tip, a direction%s and "
                       "an outer radius beyond the inner one", desc->inner, desc->outer,
                       PD_DIM == 3 ? ", a front at a right angle to it, its length" : "");
    if (c->solid->force_state ? !c->solid->density : !c->solid->stress || !c->solid->linear)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "crack", "the %s material has neither springs nor a stress that is linear"
                       " in small strains", c->solid->name);
    return PD_OK;
}

/* Sets the weight function q of point i and q_gradient, by its distance from the tip, in 3D from the line of the front:
 * q is 1 up to inner, 0 from outer on, and falls between them by a polynomial of degree 5. */
static void pdi_crack_compute_q(const pdi_crack_fields *c, int64_t i)
{
    const double *x = c->solid->body->position + i * PD_DIM;
    double from[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) from[d] = x[d] - c->desc.tip[d];
    double along = PD_DIM == 3 ? pdi_vec_dot(from, c->desc.front) : 0.0;
    for (int d = 0; d < PD_DIM; d++) from[d] -= along * c->desc.front[d];
    double r = pdi_vec_norm(from), wide = c->desc.outer - c->desc.inner, s = (r - c->desc.inner) / wide;
    c->q[i] = s <= 0.0 ? 1.0 : s >= 1.0 ? 0.0 : 1.0 - s * s * s * (10.0 - s * (15.0 - 6.0 * s));
    double fall = s <= 0.0 || s >= 1.0 ? 0.0 : -30.0 * s * s * (1.0 - s) * (1.0 - s) / wide;
    for (int d = 0; d < PD_DIM; d++) c->q_gradient[i * PD_DIM + d] = fall < 0.0 ? fall * from[d] / r : 0.0;
}

/* 1: q varies over the family of point i, so that its displacement gradient counts. */
static int pdi_crack_needs_gradient(const pdi_crack_fields *c, int32_t i)
{
    const pd_body *body = c->solid->body;
    if (c->q[i] > 0.0 && c->q[i] < 1.0) return 1;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double other = c->q[f.neighbour];
        if (other < c->q[i] || other > c->q[i]) return 1;
    }
    return 0;
}

/* Displacement gradient of u at point i by its unbroken bonds, into c->gradient (theory: eq. 14.1). Returns 1; 0: the
 * shape tensor is singular, and it stays zero. */
static int pdi_crack_compute_gradient(const pdi_crack_fields *c, const double *u, int32_t i)
{
    const pd_body *body = c->solid->body;
    double k[PDI_CRACK_TENSOR] = {0.0}, sum[PDI_CRACK_TENSOR] = {0.0}, inverse[PDI_CRACK_TENSOR];
    double over = 1.0 / (body->horizon * body->horizon);
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        int64_t j = f.neighbour;
        double xi[PD_DIM];
        if (pd_body_bond_is_broken(&f)) continue;
        pdi_body_bond_vector(body, i, &f, xi);
        double weight = over * body->volume[j] * pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi);
        for (int p = 0; p < PDI_CRACK_TENSOR; p++) {
            int row = p / PD_DIM, column = p % PD_DIM;
            k[p] += weight * xi[row] * xi[column];
            sum[p] += weight * (u[j * PD_DIM + row] - u[(int64_t)i * PD_DIM + row]) * xi[column];
        }
    }
    if (!(pdi_vec_invert(k, inverse) > PDI_CRACK_MIN_PIVOT)) return 0;
    for (int p = 0; p < PDI_CRACK_TENSOR; p++) {
        double h = 0.0;
        for (int d = 0; d < PD_DIM; d++) h += sum[p / PD_DIM * PD_DIM + d] * inverse[d * PD_DIM + p % PD_DIM];
        c->gradient[(int64_t)i * PDI_CRACK_TENSOR + p] = h;
    }
    return 1;
}

/* Displacement gradients of all points with q > 0 or q that varies over the family. PD_ERR_GEOMETRY: q has no gradient
 * along the crack at any point; the sum of this gradient exceeds 0.05 of the sum of its absolute values, as where a
 * surface cuts the domain; or q varies over a family with a singular shape tensor that has unbroken bonds. */
static pd_status pdi_crack_compute_gradients(pd_ctx *ctx, const pdi_crack_fields *c, const double *u)
{
    const pd_body *body = c->solid->body;
    double slope = 0.0, size = 0.0;
    for (int64_t i = 0; i < body->count; i++) {
        double along = pdi_vec_dot(c->q_gradient + i * PD_DIM, c->desc.direction);
        slope += body->volume[i] * along;
        size += body->volume[i] * fabs(along);
    }
    if (!(size > 0.0))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "crack", "no point of the body lies between the radii of %g and %g m "
                       "about the tip", c->desc.inner, c->desc.outer);
    if (fabs(slope) > PDI_CRACK_OPEN_SURFACE * size)
        return pd_fail(ctx, PD_ERR_GEOMETRY, "crack", "between the radii of %g and %g m about the tip lies a surface "
                       "that is not parallel to the crack, or too few points", c->desc.inner, c->desc.outer);
    for (int32_t i = 0; i < body->count; i++) {
        int near = pdi_crack_needs_gradient(c, i);
        if ((near || c->q[i] > 0.0) && !pdi_crack_compute_gradient(c, u, i) && near &&
            pdi_body_bonds_count_intact(body, i))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "crack", "the bonds of point %d do not span all directions: they "
                           "give no gradient", (int)i);
    }
    return PD_OK;
}

/* Derivative of u along the crack direction at point i, into along [PD_DIM]. */
static void pdi_crack_derivative_along(const pdi_crack_fields *c, int64_t i, double *along)
{
    for (int a = 0; a < PD_DIM; a++)
        along[a] = pdi_vec_dot(c->gradient + i * PDI_CRACK_TENSOR + a * PD_DIM, c->desc.direction);
}

/* Integrand of J at point i [J/m4] by its stress: equivalent domain integral (theory: eq. 15.14). */
static double pdi_crack_local_integrand(const pdi_crack_fields *c, int64_t i)
{
    const double *stress = c->stress + i * PDI_CRACK_TENSOR, *slope = c->q_gradient + i * PD_DIM;
    double along[PD_DIM], sum = 0.0, density = 0.0;
    pdi_crack_derivative_along(c, i, along);
    for (int p = 0; p < PDI_CRACK_TENSOR; p++) {
        sum += stress[p] * along[p / PD_DIM] * slope[p % PD_DIM];
        density += 0.5 * stress[p] * c->gradient[i * PDI_CRACK_TENSOR + p];
    }
    return sum - density * pdi_vec_dot(slope, c->desc.direction);
}

/* Integrand of J at point i [J/m4] by its bond forces (theory: eq. 15.15; Silling and Lehoucq 2010). */
static double pdi_crack_bond_integrand(const pdi_crack_fields *c, const double *u, int32_t i)
{
    const pd_body *body = c->solid->body;
    double sum = -c->density[i] * pdi_vec_dot(c->q_gradient + (int64_t)i * PD_DIM, c->desc.direction);
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double along[PD_DIM], pull[PD_DIM], step = c->q[i] - c->q[f.neighbour];
        if (pd_body_bond_is_broken(&f) || !(fabs(step) > 0.0)) continue;
        c->solid->force_state(c->solid->self, u, i, &f, pull);
        pdi_crack_derivative_along(c, f.neighbour, along);
        sum -= body->volume[f.neighbour] * step * pdi_vec_dot(pull, along);
    }
    return sum;
}

/* Domain integral *j [J/m2] of displacements u, less the work of external forces within the domain; in 3D divided by
 * the thickness. By bond forces where the material has force states, otherwise by its stress. Checks the description
 * and allocates the fields, which the caller frees. Statuses: as of pd_crack_j. */
static pd_status pdi_crack_compute_j(pd_ctx *ctx, pdi_crack_fields *c, const double *u, double *j)
{
    const pd_material_interface *solid = c->solid;
    pdi_compensated_sum all = {0.0, 0.0};
    PD_TRY(pdi_crack_check(ctx, c));
    PD_TRY(pdi_array_registry_build(ctx, pdi_crack_list, c));
    for (int64_t i = 0; i < c->count; i++) pdi_crack_compute_q(c, i);
    PD_TRY(pdi_crack_compute_gradients(ctx, c, u));
    pd_status status = solid->force(ctx, solid->self, u, c->force);
    if (status != PD_OK) return status;
    if (solid->force_state) solid->density(ctx, solid->self, u, c->density);
    else solid->stress(ctx, solid->self, u, c->stress);
    for (int32_t i = 0; i < c->count; i++) {
        double along[PD_DIM],
            share = solid->force_state ? pdi_crack_bond_integrand(c, u, i) : pdi_crack_local_integrand(c, i);
        pdi_crack_derivative_along(c, i, along);
        share += c->q[i] * pdi_vec_dot(c->force + (int64_t)i * PD_DIM, along); /* minus what loads or holds it */
        pdi_compensated_sum_add(&all, solid->body->volume[i] * share);
    }
    *j = pdi_compensated_sum_total(&all) / (PD_DIM == 3 ? c->desc.thickness : 1.0);
    return PD_OK;
}

pd_status pd_crack_j(pd_ctx *ctx, const pd_material_interface *solid, const pd_crack_desc *desc, const double *u,
                     double *j)
{
    pdi_crack_fields c;
    memset(&c, 0, sizeof c);
    c.solid = solid;
    c.desc = *desc;
    c.count = solid->body->count;
    pd_status status = pdi_crack_compute_j(ctx, &c, u, j);
    pdi_array_registry_free(ctx, pdi_crack_list, &c);
    return status;
}

/* ---- tip ---- */

/* 1: point i has lost at least this share of its bonds, by their number; 0 also for a point without bonds. */
static int pdi_crack_is_damaged(const pd_body *body, int32_t i, double share)
{
    double all = (double)(body->first_bond[i + 1] - body->first_bond[i]);
    return all > 0.0 && all - (double)pdi_body_bonds_count_intact(body, i) >= share * all;
}

/* Mean position of the damaged points that lie farthest along `unit`, into tip; among [count]: 1 for candidates, NULL:
 * all. PD_RETRY: there is none, and tip stays. */
static pd_status pdi_crack_find_farthest(const pd_body *body, const uint8_t *among, const double *unit, double share,
                                         double *tip)
{
    double sum[PD_DIM] = {0.0}, farthest = -HUGE_VAL;
    int32_t found = 0;
    for (int32_t i = 0; i < body->count; i++)
        if ((!among || among[i]) && pdi_crack_is_damaged(body, i, share))
            farthest = pd_max(farthest, pdi_vec_dot(body->position + (int64_t)i * PD_DIM, unit));
    for (int32_t i = 0; i < body->count; i++) {
        const double *x = body->position + (int64_t)i * PD_DIM;
        if (pdi_vec_dot(x, unit) < farthest - PDI_CRACK_ROUNDING * body->horizon) continue;
        if ((among && !among[i]) || !pdi_crack_is_damaged(body, i, share)) continue;
        for (int d = 0; d < PD_DIM; d++) sum[d] += x[d];
        found++;
    }
    if (!found) return PD_RETRY;
    for (int d = 0; d < PD_DIM; d++) tip[d] = sum[d] / found;
    return PD_OK;
}

pd_status pd_crack_tip(pd_ctx *ctx, const pd_body *body, const double *way, double share, double *tip)
{
    double unit[PD_DIM];
    memcpy(unit, way, sizeof unit);
    if (!(share >= 0.0) || !(share <= 1.0) || !pdi_crack_normalise(unit))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "crack", "a tip where points have lost %g of their bonds, expected 0 to "
                       "1, and a direction", share);
    return pdi_crack_find_farthest(body, NULL, unit, share > 0.0 ? share : PDI_CRACK_TIP_DAMAGE, tip);
}

/* Square of the distance [m2] of position x from a segment. */
static double pdi_crack_segment_distance(const double *from, const double *to, const double *x)
{
    double edge[PD_DIM], off[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        edge[d] = to[d] - from[d];
        off[d] = x[d] - from[d];
    }
    double length = pdi_vec_dot(edge, edge), share = length > 0.0 ? pdi_vec_dot(off, edge) / length : 0.0;
    share = pd_min(pd_max(share, 0.0), 1.0);
    for (int d = 0; d < PD_DIM; d++) off[d] -= share * edge[d];
    return pdi_vec_dot(off, off);
}

/* 1: point i lies at most a horizon from the corner (1D), an edge of the polyline (2D) or of the closed polygon (3D)
 * corner [corners][PD_DIM]. */
static int pdi_crack_is_near_edge(const pd_body *body, int corners, const double *corner, int32_t i)
{
    const double *x = body->position + (int64_t)i * PD_DIM;
    int edges = PD_DIM == 3 ? corners : corners > 1 ? corners - 1 : 1;
    for (int k = 0; k < edges; k++) {
        const double *to = corner + (k + 1 < corners ? k + 1 : 0) * PD_DIM;
        if (pdi_crack_segment_distance(corner + k * PD_DIM, to, x) <= body->horizon * body->horizon) return 1;
    }
    return 0;
}

pd_status pd_crack_find_tip(pd_ctx *ctx, const pd_body *body, int corners, const double *corner,
                                    const double *left, const double *way, double *tip)
{
    double unit[PD_DIM];
    uint8_t *seen = NULL;
    int32_t *next = NULL, known = 0;
    memcpy(unit, way, sizeof unit);
    if (!pdi_crack_normalise(unit))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "crack", "a crack that grows in no direction");
    pd_status status = PD_NEW(ctx, "crack", body->count, seen);
    if (status == PD_OK) status = PD_NEW(ctx, "crack", body->count, next);
    for (int32_t i = 0; i < body->count && status == PD_OK; i++) {
        seen[i] = left[i] > 0.0 && pdi_crack_is_near_edge(body, corners, corner, i) &&
                  pdi_crack_is_damaged(body, i, PDI_CRACK_TIP_DAMAGE);
        if (seen[i]) next[known++] = i;
    }
    for (int32_t k = 0; k < known; k++)
        for (pd_bond_iterator f = pd_body_bonds_begin(body, next[k]); pd_body_bonds_next(&f);) {
            if (seen[f.neighbour] || !(left[f.neighbour] > 0.0) ||
                !pdi_crack_is_damaged(body, f.neighbour, PDI_CRACK_TIP_DAMAGE))
                continue;
            seen[f.neighbour] = 1;
            next[known++] = f.neighbour;
        }
    if (status == PD_OK) status = pdi_crack_find_farthest(body, seen, unit, PDI_CRACK_TIP_DAMAGE, tip);
    PD_DELETE(ctx, body->count, next);
    PD_DELETE(ctx, body->count, seen);
    return status;
}

#undef PDI_CRACK_TIP_DAMAGE
#undef PDI_CRACK_ROUNDING
#undef PDI_CRACK_MIN_PIVOT
#undef PDI_CRACK_OPEN_SURFACE
