/* fourth_order: see fourth_order.h */
#include "flow/fourth_order.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* largest Reynolds number at which fourth order is measured to pay (eq. 3.24) */
#define PDI_FOURTH_ORDER_MAX_REYNOLDS 1000.0
/* largest cell Reynolds number at which fourth order is measured to pay (eq. 3.24) */
#define PDI_FOURTH_ORDER_MAX_CELL_REYNOLDS 16.0

/* Second differences of component `component` along `axis`, [total], in the array of
 * pdi_fourth_order_compute_second_differences. */
static const double *pdi_fourth_order_get_second_difference(const pd_fourth_order *sharp, const double *second,
                                                            int axis, int component)
{
    return second + (int64_t)(axis * PD_DIM + component) * sharp->bonds->grid->total;
}

/* 1: the node is fluid, or a ghost that stands for fluid. */
static int pdi_fourth_order_is_open(const pd_fourth_order *sharp, int32_t node)
{
    return pdi_grid_is_open(sharp->bonds->grid->kind[node]);
}

/* ---- second differences ---- */

/* Second derivative at 0 of the Lagrange polynomial through `count` values f at the places x, in units of f and x. */
static double pdi_fourth_order_compute_second_derivative(const double *x, const double *f, int count)
{
    double sum = 0.0;
    for (int a = 0; a < count; a++) {
        double below = 1.0, above = 0.0;
        for (int b = 0; b < count; b++) {
            if (b == a) continue;
            below *= x[a] - x[b];
            for (int c = b + 1; c < count; c++) {
                double product = 2.0;
                if (c == a) continue;
                for (int e = 0; e < count; e++)
                    if (e != a && e != b && e != c) product *= -x[e];
                above += product;
            }
        }
        sum += f[a] * above / below;
    }
    return sum;
}

/* Second difference of a component of v along axis d at row r beside a wall: second derivative, in spacings, of the
 * polynomial through the wall value, the node and the next two (eq. 3.18). The polynomial is a quadratic where only one
 * node follows (a ghost is the last one), and between two walls. wall NULL: walls at rest. */
static double pdi_fourth_order_compute_wall_second_difference(const pd_fourth_order *sharp, pd_velocity_fn wall,
                                                              void *user, const double *v, int32_t r, int d,
                                                              int component)
{
    const pd_grid *grid = sharp->bonds->grid;
    const double *leg = sharp->bonds->neighbour_distance + ((int64_t)r * PD_DIM + d) * 2;
    int32_t node = sharp->bonds->node[r];
    const double *f = v + (int64_t)component * grid->total + node;
    double place[5], value[5];
    int count = 1;
    place[0] = 0.0;
    value[0] = f[0];
    for (int side = 0; side < 2; side++) {
        double sign = side ? 1.0 : -1.0;
        int32_t to = side ? grid->stride[d] : -grid->stride[d];
        if (pdi_fourth_order_is_open(sharp, node + to)) {
            int most = grid->kind[node + to] == PD_FLUID ? 2 : 1; /* behind a ghost may be no node */
            for (int k = 1; k <= most && pdi_fourth_order_is_open(sharp, node + k * to); k++) {
                place[count] = k * sign;
                value[count++] = f[k * to];
            }
            continue;
        }
        double x[PD_DIM], u[PD_DIM];
        place[count] = sign * fabs(leg[side]);
        value[count] = 0.0;
        if (wall) {
            pd_grid_position(grid, node, x);
            x[d] += place[count] * grid->h[d];
            wall(user, x, u);
            value[count] = u[component];
        }
        count++;
    }
    return pdi_fourth_order_compute_second_derivative(place, value, count);
}

/* Second differences along `axis` at ghosts, `second` [PD_DIM][total]: images and outlets as a vector; inlets from
 * their source, with the sign of a velocity that is odd about the value of the inlet. */
static void pdi_fourth_order_update_ghost_second_differences(const pd_fourth_order *sharp, int axis, double *second)
{
    const pd_ghosts *ghosts = &sharp->bonds->ghosts;
    int64_t total = sharp->bonds->grid->total;
    pd_ghosts_set_vector(ghosts, second);
    for (int of = 0; of < PD_DIM; of++)
        for (int32_t g = ghosts->outlets_end; g < ghosts->inlets_end; g++) {
            int odd = ghosts->normal_axis[g] >> axis & 1;
            int turned = (ghosts->sign_flips[g] ^ ghosts->normal_axis[g]) >> of & 1;
            double there = second[of * total + ghosts->source[g]];
            second[of * total + ghosts->node[g]] = odd != turned ? -there : there;
        }
}

PDI_FN void pdi_fourth_order_compute_second_differences(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                                        pd_velocity_fn wall, void *user, const double *v,
                                                        double *second)
{
    const pd_grid *grid = sharp->bonds->grid;
    int64_t total = grid->total;
    int nt = pd_par_threads(ctx, total * PD_DIM * PD_DIM * 4);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) {
            int32_t up = i + grid->stride[d], down = i - grid->stride[d];
            int between = pdi_fourth_order_is_open(sharp, up) && pdi_fourth_order_is_open(sharp, down);
            for (int of = 0; of < PD_DIM; of++) {
                const double *f = v + of * total;
                second[(d * PD_DIM + of) * total + i] =
                    between ? f[up] - 2.0 * f[i] + f[down]
                            : pdi_fourth_order_compute_wall_second_difference(sharp, wall, user, v,
                                                                              sharp->bonds->row_of_node[i], d, of);
            }
        }
    }
    for (int d = 0; d < PD_DIM; d++)
        pdi_fourth_order_update_ghost_second_differences(sharp, d, second + (int64_t)d * PD_DIM * total);
}

/* ---- advecting velocity ---- */

/* Sum of the differences of f from `node` to its two neighbours along axis b; with `only` 0 to the open ones, else to
 * those of this kind of node. Other neighbours count 0. */
static double pdi_fourth_order_compute_neighbour_difference(const pd_fourth_order *sharp, const double *f, int32_t node,
                                                            int b, int only)
{
    const pd_grid *grid = sharp->bonds->grid;
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        int32_t j = side ? node + grid->stride[b] : node - grid->stride[b];
        if (only ? grid->kind[j] == only : pdi_fourth_order_is_open(sharp, j)) sum += f[j] - f[node];
    }
    return sum;
}

/* Half the number of open neighbours along axis d: 1, 0.5 beside a wall, 0 between two. As a factor it makes up for the
 * tensor of (3.4), applied later, which doubles a component that points at a wall. */
static double pdi_fourth_order_compute_open_half_count(const pd_fourth_order *sharp, int32_t node, int d)
{
    int32_t stride = sharp->bonds->grid->stride[d];
    return 0.5 * (pdi_fourth_order_is_open(sharp, node - stride) + pdi_fourth_order_is_open(sharp, node + stride));
}

/* Component d of the advecting velocity (3.19) at a node, times half the number of its open neighbours along d. With
 * none of these it is the component of v as it is. */
static double pdi_fourth_order_compute_velocity_component(const pd_fourth_order *sharp, const double *v,
                                                          const double *second, int32_t node, int d)
{
    const double *f = v + (int64_t)d * sharp->bonds->grid->total;
    double sides = pdi_fourth_order_compute_open_half_count(sharp, node, d), value = f[node];
    if (!(sides > 0.0)) return value;
    for (int b = 0; b < PD_DIM; b++) {
        double bent = pdi_fourth_order_get_second_difference(sharp, second, b, d)[node];
        value += bent / 24.0; /* from the middle of a face to its mean */
        if (b == d) value -= sharp->third_moments[d][d] / 6.0 * bent;
        else
            value -=
                0.5 * sharp->third_moments[d][b] * pdi_fourth_order_compute_neighbour_difference(sharp, f, node, b, 0);
    }
    return sides * value;
}

/* Second difference of the inlet profile f along axis b, over inlet ghosts alone. At the end of the profile that of the
 * next ghost, since a wall is no part of it; 0 where no three inlet ghosts are in a line, or the next one is outside of
 * the box along b. */
static double pdi_fourth_order_compute_inlet_second_difference(const pd_fourth_order *sharp, const double *f,
                                                               int32_t node, int b)
{
    const pd_grid *grid = sharp->bonds->grid;
    int32_t stride = grid->stride[b];
    int below = grid->kind[node - stride] == PD_INLET, above = grid->kind[node + stride] == PD_INLET;
    if (below == above) return below ? f[node - stride] - 2.0 * f[node] + f[node + stride] : 0.0;
    int32_t to = above ? stride : -stride, at = pdi_grid_index_along(grid, node + to, b);
    if (at < 0 || at >= grid->n[b]) return 0.0; /* the last layer of ghosts may end there */
    return grid->kind[node + 2 * to] == PD_INLET ? f[node] - 2.0 * f[node + to] + f[node + 2 * to] : 0.0;
}

/* Sets the inlet ghost at place k of the list so that its mean with the node that it mirrors is (3.19) of the inlet
 * profile, which is in `work`. A component without open neighbours of that node along its axis stays. */
static void pdi_fourth_order_set_inlet_ghost(const pd_fourth_order *sharp, int32_t k, double *corrected)
{
    const pd_ghosts *ghosts = &sharp->bonds->ghosts;
    int32_t node = ghosts->node[k], source = ghosts->source[k];
    int64_t total = sharp->bonds->grid->total;
    for (int d = 0; d < PD_DIM; d++) {
        const double *f = sharp->work + d * total;
        double sides = pdi_fourth_order_compute_open_half_count(sharp, source, d), value = f[node],
               there = corrected[d * total + source];
        if (!(sides > 0.0)) continue;
        for (int b = 0; b < PD_DIM; b++) {
            if (ghosts->normal_axis[k] >> b & 1) continue;
            double bent = pdi_fourth_order_compute_inlet_second_difference(sharp, f, node, b);
            value += bent / 24.0;
            if (b == d) value -= sharp->third_moments[d][d] / 6.0 * bent;
            else
                value -= 0.5 * sharp->third_moments[d][b] *
                         pdi_fourth_order_compute_neighbour_difference(sharp, f, node, b, PD_INLET);
        }
        corrected[d * total + node] =
            2.0 * sides * value + ((ghosts->sign_flips[k] ^ ghosts->normal_axis[k]) >> d & 1 ? there : -there);
    }
}

/* Sets all inlet ghosts of `corrected` whose source is regular, after their profile in `work`: the mean of ghost and
 * source, the ghost alone where the source is not fluid. Those behind periodic and mirror sides repeat others. */
static void pdi_fourth_order_set_inlet_ghosts(const pd_fourth_order *sharp, const double *v, double *corrected)
{
    const pd_grid *grid = sharp->bonds->grid;
    const pd_ghosts *ghosts = &sharp->bonds->ghosts;
    int64_t total = grid->total;
    for (int32_t k = ghosts->outlets_end; k < ghosts->inlets_end; k++)
        for (int d = 0; d < PD_DIM; d++) {
            double there = v[d * total + ghosts->source[k]], value = v[d * total + ghosts->node[k]];
            int turned = (ghosts->sign_flips[k] ^ ghosts->normal_axis[k]) >> d & 1;
            if (grid->kind[ghosts->source[k]] == PD_FLUID) value = 0.5 * (value + (turned ? -there : there));
            sharp->work[d * total + ghosts->node[k]] = value;
        }
    for (int pass = 0; pass < 2; pass++)
        for (int32_t k = ghosts->outlets_end; k < ghosts->inlets_end; k++) {
            int i[PD_DIM];
            int32_t node = ghosts->node[k];
            pd_grid_index(grid, node, i);
            int flip = pdi_grid_fold_index(grid, i);
            int32_t first = pd_grid_node(grid, i);
            if (!sharp->is_regular[ghosts->source[k]] || pass != (first != node)) continue;
            if (!pass) pdi_fourth_order_set_inlet_ghost(sharp, k, corrected);
            for (int d = 0; d < PD_DIM && pass; d++)
                corrected[d * total + node] = (flip >> d & 1 ? -1.0 : 1.0) * corrected[d * total + first];
        }
}

PDI_FN void pdi_fourth_order_compute_advecting_velocity(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                                        const double *v, const double *second, double *corrected)
{
    const pd_grid *grid = sharp->bonds->grid;
    int nt = pd_par_threads(ctx, (int64_t)grid->total * PD_DIM * PD_DIM * 4);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID || !sharp->is_regular[i]) continue;
        for (int d = 0; d < PD_DIM; d++)
            corrected[(int64_t)d * grid->total + i] =
                pdi_fourth_order_compute_velocity_component(sharp, v, second, i, d);
    }
    pdi_fourth_order_set_inlet_ghosts(sharp, v, corrected);
}

/* ---- pressure gradient ---- */

/* 1: the node has a pressure: it is open and no inlet. */
static int pdi_fourth_order_has_pressure(const pd_fourth_order *sharp, int32_t node)
{
    return pdi_fourth_order_is_open(sharp, node) && sharp->bonds->grid->kind[node] != PD_INLET;
}

/* Second difference of p at node i with `stride`. At the end of a line (a closed node or inlet next) it is extrapolated
 * linearly from the next two nodes, or is that of the next one where there are fewer; 0 where there is none, too. */
static double pdi_fourth_order_compute_pressure_curvature(const pd_fourth_order *sharp, const double *p, int32_t i,
                                                          int32_t stride)
{
    int below = pdi_fourth_order_has_pressure(sharp, i - stride),
        above = pdi_fourth_order_has_pressure(sharp, i + stride);
    if (below && above) return p[i - stride] - 2.0 * p[i] + p[i + stride];
    if (below == above) return 0.0;
    int32_t to = above ? stride : -stride;
    if (sharp->bonds->grid->kind[i + to] != PD_FLUID || !pdi_fourth_order_has_pressure(sharp, i + 2 * to)) return 0.0;
    double next = p[i] - 2.0 * p[i + to] + p[i + 2 * to];
    if (sharp->bonds->grid->kind[i + 2 * to] != PD_FLUID || !pdi_fourth_order_has_pressure(sharp, i + 3 * to))
        return next;
    return 2.0 * next - (p[i + to] - 2.0 * p[i + 2 * to] + p[i + 3 * to]);
}

/* Derivative of p along the stride at node i, times h, with its second differences q (eq. 3.20): one-sided beside a
 * closed node or inlet, 0 between two. Exact for cubics. */
static double pdi_fourth_order_compute_derivative(const pd_fourth_order *sharp, const double *p, const double *q,
                                                  int32_t stride, int32_t i)
{
    int below = pdi_fourth_order_has_pressure(sharp, i - stride),
        above = pdi_fourth_order_has_pressure(sharp, i + stride);
    if (below && above) return 0.5 * (p[i + stride] - p[i - stride]) - (q[i + stride] - q[i - stride]) / 12.0;
    if (above) return p[i + stride] - p[i] - 0.5 * q[i] - (q[i + stride] - q[i]) / 6.0;
    if (below) return p[i] - p[i - stride] + 0.5 * q[i] + (q[i - stride] - q[i]) / 6.0;
    return 0.0;
}

PDI_FN void pdi_fourth_order_compute_pressure_gradient(const pd_ctx *ctx, const pd_fourth_order *sharp, const double *p,
                                                       double *grad)
{
    const pd_grid *grid = sharp->bonds->grid;
    const pd_ghosts *ghosts = &sharp->bonds->ghosts;
    int64_t total = grid->total;
    int nt = pd_par_threads(ctx, total * PD_DIM * 4);
    (void)nt;
    for (int d = 0; d < PD_DIM; d++) {
        int32_t stride = grid->stride[d];
        double *q = sharp->work + d * total;
        PD_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < grid->total; i++)
            if (grid->kind[i] == PD_FLUID) q[i] = pdi_fourth_order_compute_pressure_curvature(sharp, p, i, stride);
        pdi_ghosts_set_pressure(ghosts, 0.0, q);
        PD_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < grid->total; i++)
            if (grid->kind[i] == PD_FLUID && sharp->is_regular[i])
                grad[d * total + i] = pdi_fourth_order_compute_derivative(sharp, p, q, stride, i) / grid->h[d];
    }
}

/* ---- momentum through faces ---- */

/* Volume and momentum that pass a face upwards, per cell volume. */
typedef struct pdi_fourth_order_face_flux {
    double flux;              /* [1/s] of volume */
    double convective[PD_DIM]; /* [m/s2] */
    double viscous[PD_DIM];    /* [1/m/s] viscous momentum flux into the node below, over nu */
} pdi_fourth_order_face_flux;

/* 1: no smooth surface is at the face between i and j, or beside it across axis d: the face gets the correction. */
static int pdi_fourth_order_is_regular_face(const pd_fourth_order *sharp, int32_t i, int32_t j, int d)
{
    const int32_t *stride = sharp->bonds->grid->stride;
    if (!sharp->is_regular[i] || !sharp->is_regular[j]) return 0;
    for (int b = 0; b < PD_DIM; b++)
        for (int side = -1; side <= 1 && b != d; side += 2) {
            int32_t to = side * stride[b];
            if (pdi_fourth_order_is_open(sharp, i + to) && !sharp->is_regular[i + to]) return 0;
            if (pdi_fourth_order_is_open(sharp, j + to) && !sharp->is_regular[j + to]) return 0;
        }
    return 1;
}

/* Sets *face: fourth-order fluxes through the face between i and j, upper neighbour of i along d, from bonds of one and
 * of two spacings (3.21). */
static void pdi_fourth_order_compute_face(const pd_fourth_order *sharp, int32_t i, int32_t j, int d,
                                          const pdi_fourth_order_field *w, const pdi_fourth_order_field *u,
                                          pdi_fourth_order_face_flux *face)
{
    const pd_grid *grid = sharp->bonds->grid;
    double h = grid->h[d];
    const double *v = w->v + (int64_t)d * grid->total,
                 *q = pdi_fourth_order_get_second_difference(sharp, w->second, d, d);
    double below = q[i] + 2.0 * v[i] - v[j], above = q[j] + 2.0 * v[j] - v[i];
    face->flux = (0.5 * (v[i] + v[j]) - (q[i] + q[j]) / 12.0) / h;
    for (int c = 0; c < PD_DIM; c++) {
        const double *f = u->v + (int64_t)c * grid->total,
                     *k = pdi_fourth_order_get_second_difference(sharp, u->second, d, c);
        double lower = k[i] + 2.0 * f[i] - f[j], upper = k[j] + 2.0 * f[j] - f[i];
        double wide = (v[i] + above) * (f[i] + upper) + (below + v[j]) * (lower + f[j]);
        face->convective[c] = ((v[i] + v[j]) * (f[i] + f[j]) / 3.0 - wide / 24.0) / h;
        face->viscous[c] = (f[j] - f[i] - (k[j] - k[i]) / 12.0) / (h * h);
    }
}

/* Subtracts the second-order fluxes of bond k from i to j; share: the part of the bond that passes this face. */
static void pdi_fourth_order_remove_bond(const pd_fourth_order *sharp, int32_t i, int32_t j, int k, double share,
                                         const pdi_fourth_order_field *w, const pdi_fourth_order_field *u,
                                         pdi_fourth_order_face_flux *face)
{
    const pd_stencil *s = sharp->bonds->stencil;
    int64_t total = sharp->bonds->grid->total;
    double flux = 0.0;
    for (int d = 0; d < PD_DIM; d++)
        flux +=
            share * s->gradient_weight[k * PD_DIM + d] * (w->advecting[d * total + i] + w->advecting[d * total + j]);
    face->flux -= flux;
    for (int c = 0; c < PD_DIM; c++) {
        const double *f = u->v + c * total;
        face->convective[c] -= 0.5 * flux * (f[i] + f[j]);
        face->viscous[c] -= share * s->laplacian_weight[k] * (f[j] - f[i]);
    }
}

/* Fourth-order less second-order fluxes through the upper face of i along d. Half of each diagonal bond goes each way
 * round the edge, so that its ends lose what they had. Returns 0 when the face gets no correction. */
static int pdi_fourth_order_compute_face_excess(const pd_fourth_order *sharp, int32_t i, int d,
                                                const pdi_fourth_order_field *w, const pdi_fourth_order_field *u,
                                                pdi_fourth_order_face_flux *face)
{
    const int32_t *stride = sharp->bonds->grid->stride;
    const int *bond = sharp->face_bonds[d];
    int32_t j = i + stride[d];
    if (!pdi_fourth_order_is_regular_face(sharp, i, j, d)) return 0;
    pdi_fourth_order_compute_face(sharp, i, j, d, w, u, face);
    pdi_fourth_order_remove_bond(sharp, i, j, bond[0], 1.0, w, u, face);
    for (int m = 0; m < PD_DIM - 1; m++) {
        int b = m < d ? m : m + 1, sinks = bond[1 + 2 * m], rises = bond[2 + 2 * m];
        for (int side = 0; side < 2 && sinks >= 0; side++) {
            int32_t to = side ? stride[b] : -stride[b];
            if (pdi_fourth_order_is_open(sharp, j + to))
                pdi_fourth_order_remove_bond(sharp, i, j + to, side ? rises : sinks, 0.5, w, u, face);
            if (pdi_fourth_order_is_open(sharp, i + to))
                pdi_fourth_order_remove_bond(sharp, i + to, j, side ? sinks : rises, 0.5, w, u, face);
        }
    }
    return 1;
}

/* Corrections at the faces along d above each node, where it or the next one is fluid, into `work`: momentum
 * [PD_DIM][total] [m/s2] (convection less nu times friction), then volume [total] [1/s]; 0 where the face gets none.
 * Other entries stay. */
static void pdi_fourth_order_compute_faces(const pd_ctx *ctx, const pd_fourth_order *sharp, int d,
                                           const pdi_fourth_order_field *w, const pdi_fourth_order_field *u, double nu)
{
    const pd_grid *grid = sharp->bonds->grid;
    int64_t total = grid->total;
    int32_t stride = grid->stride[d];
    int nt = pd_par_threads(ctx, total * 64);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < grid->total - stride; i++) {
        pdi_fourth_order_face_flux face;
        if (grid->kind[i] != PD_FLUID && grid->kind[i + stride] != PD_FLUID) continue;
        int more = pdi_fourth_order_compute_face_excess(sharp, i, d, w, u, &face);
        for (int c = 0; c < PD_DIM; c++)
            sharp->work[c * total + i] = more ? face.convective[c] - nu * face.viscous[c] : 0.0;
        sharp->work[PD_DIM * total + i] = more ? face.flux : 0.0;
    }
}

PDI_FN void pdi_fourth_order_add_momentum(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                          const pdi_fourth_order_field *w, const pdi_fourth_order_field *u, double nu,
                                          double *ru)
{
    const pd_grid *grid = sharp->bonds->grid;
    int64_t total = grid->total;
    int nt = pd_par_threads(ctx, total * PD_DIM * 4);
    (void)nt;
    for (int d = 0; d < PD_DIM; d++) {
        int32_t stride = grid->stride[d];
        pdi_fourth_order_compute_faces(ctx, sharp, d, w, u, nu);
        PD_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < grid->total; i++) {
            if (grid->kind[i] != PD_FLUID) continue;
            const double *flux = sharp->work + PD_DIM * total + i;
            double half = 0.5 * (flux[0] - flux[-stride]);
            for (int c = 0; c < PD_DIM; c++) {
                int64_t at = c * total + i;
                ru[at] += sharp->work[at] - sharp->work[at - stride] - half * u->v[at];
            }
        }
    }
}

PDI_FN int pdi_fourth_order_compute_wall_laplacian(const pd_fourth_order *sharp, int32_t r, const double *v,
                                                   const double *second, double *lap)
{
    const pd_grid *grid = sharp->bonds->grid;
    int32_t i = sharp->bonds->node[r];
    int walls = 0;
    for (int c = 0; c < PD_DIM; c++) lap[c] = 0.0;
    for (int d = 0; d < PD_DIM && sharp->is_regular[i]; d++) {
        if (!(pdi_fourth_order_compute_open_half_count(sharp, i, d) < 1.0)) continue;
        walls = 1;
        for (int c = 0; c < PD_DIM; c++) {
            const double *f = v + (int64_t)c * grid->total,
                         *q = pdi_fourth_order_get_second_difference(sharp, second, d, c);
            double part = q[i];
            for (int side = 0; side < 2; side++) {
                int32_t j = side ? i + grid->stride[d] : i - grid->stride[d];
                if (pdi_fourth_order_is_open(sharp, j)) part -= f[j] - f[i] - (q[j] - q[i]) / 12.0;
            }
            lap[c] += part / (grid->h[d] * grid->h[d]);
        }
    }
    return walls;
}

PDI_FN void pdi_fourth_order_add_wall_friction(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                               const pdi_fourth_order_field *u,
                                               const pdi_fourth_order_wall_terms *drive, double nu, double *ru)
{
    const pd_bonds *bonds = sharp->bonds;
    int nt = pd_par_threads(ctx, (int64_t)bonds->rows * PD_DIM * 16);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++) {
        double lap[PD_DIM];
        if (!pdi_fourth_order_compute_wall_laplacian(sharp, r, u->v, u->second, lap)) continue;
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = (int64_t)d * bonds->grid->total + bonds->node[r];
            double push = drive->grad[at], motion = drive->wall_motion ? drive->wall_motion[at] : 0.0;
            if (drive->force) push -= drive->force[d];
            if (drive->body) push -= drive->body[at];
            ru[at] += bonds->wall_curvature[r] * push - nu * (lap[d] + bonds->wall_laplacian[r] * u->v[at] - motion);
        }
    }
}

/* ---- objects ---- */

PDI_COLD_BEGIN
/* Lists the arrays of a pd_fourth_order. */
PDI_FN void pdi_fourth_order_list(pdi_array_visitor *owner, void *object)
{
    pd_fourth_order *sharp = (pd_fourth_order *)object;
    int64_t total = sharp->bonds ? sharp->bonds->grid->total : 0;
    PDI_ARRAY(owner, sharp, is_regular, total, "1");
    PDI_ARRAY(owner, sharp, second, PD_DIM * PD_DIM * total, "m/s");
    PDI_ARRAY(owner, sharp, second_increment, PD_DIM * PD_DIM * total, "m/s");
    PDI_ARRAY(owner, sharp, work, (PD_DIM + 1) * total, "");
}

PDI_FN void pdi_fourth_order_mark_regular_nodes(const pd_fourth_order *sharp)
{
    const pd_bonds *bonds = sharp->bonds;
    const pd_ghosts *ghosts = &bonds->ghosts;
    for (int32_t i = 0; i < bonds->grid->total; i++) {
        int32_t r = bonds->row_of_node[i];
        sharp->is_regular[i] = bonds->grid->kind[i] == PD_FLUID && (r < 0 || !bonds->near_smooth_surface[r]);
    }
    for (int32_t g = 0; g < ghosts->inlets_end; g++)
        sharp->is_regular[ghosts->node[g]] = sharp->is_regular[ghosts->source[g]];
}

/* Bond of the stencil with offset 1 along d and `offset` along b; -1: none. */
static int pdi_fourth_order_find_bond(const pd_stencil *s, int d, int b, int offset)
{
    for (int k = 0; k < s->count; k++) {
        int same = 1;
        for (int e = 0; e < PD_DIM; e++)
            same = same && s->offset[k * PD_DIM + e] == (e == d ? 1 : e == b ? offset : 0);
        if (same) return k;
    }
    return -1;
}

/* 1: the family reaches beyond the nearest neighbours, or has bonds with offsets along three axes. */
static int pdi_fourth_order_has_far_bonds(const pd_stencil *s)
{
    int far = s->reach > 1;
    for (int k = 0; k < s->count; k++) {
        int axes = 0;
        for (int d = 0; d < PD_DIM; d++) axes += s->offset[k * PD_DIM + d] != 0;
        far = far || axes > 2;
    }
    return far;
}

PDI_FN int pdi_fourth_order_has_closed_sides(const pd_side *side)
{
    int across = 0;
    for (int d = 0; d < PD_DIM; d++) {
        if (pd_grid_is_inlet_or_outlet(side[2 * d]) || pd_grid_is_inlet_or_outlet(side[2 * d + 1])) return 0;
        across += side[2 * d] == PD_SIDE_WALL || side[2 * d + 1] == PD_SIDE_WALL;
    }
    return across > 1;
}

PDI_FN int pdi_fourth_order_is_fluid_box(const pd_grid *grid)
{
    if (!pdi_fourth_order_has_closed_sides(grid->side)) return 0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM], inside = 1;
        if (grid->kind[node] == PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        for (int d = 0; d < PD_DIM; d++) inside = inside && i[d] >= 0 && i[d] < grid->n[d];
        if (inside) return 0;
    }
    return 1;
}

PDI_FN int pdi_fourth_order_is_efficient(const pd_bonds *bonds, double rate, double length)
{
    double longest = 0.0;
    for (int d = 0; d < PD_DIM; d++) longest = pd_max(longest, bonds->grid->h[d]);
    int slow = rate * length <= PDI_FOURTH_ORDER_MAX_REYNOLDS * (1.0 + 1e-9) &&
               rate * longest <= PDI_FOURTH_ORDER_MAX_CELL_REYNOLDS;
    return slow && !pdi_fourth_order_has_far_bonds(bonds->stencil) && !bonds->grid->circumference &&
           pdi_fourth_order_is_fluid_box(bonds->grid);
}

PDI_FN pd_status pdi_fourth_order_build(pd_ctx *ctx, const pd_bonds *bonds, pd_fourth_order *sharp)
{
    const pd_stencil *s = bonds->stencil;
    memset(sharp, 0, sizeof *sharp);
    if (pdi_fourth_order_has_far_bonds(s))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "order 4 needs the nearest neighbours, m = 1, and m is %g", s->m);
    if (bonds->grid->circumference)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "order 4 has no weights of rings: axisymmetric flow has order 2");
    sharp->bonds = bonds;
    for (int d = 0; d < PD_DIM; d++) {
        for (int b = 0; b < PD_DIM; b++)
            for (int k = 0; k < s->count; k++) {
                double n = s->offset[k * PD_DIM + b];
                sharp->third_moments[d][b] += s->gradient_weight[k * PD_DIM + d] * s->xi[k * PD_DIM + d] * n * n;
            }
        sharp->face_bonds[d][0] = pdi_fourth_order_find_bond(s, d, d, 1);
        for (int m = 0; m < PD_DIM - 1; m++)
            for (int side = 0; side < 2; side++)
                sharp->face_bonds[d][1 + 2 * m + side] =
                    pdi_fourth_order_find_bond(s, d, m < d ? m : m + 1, side ? 1 : -1);
    }
    pd_status status = pdi_array_registry_build(ctx, pdi_fourth_order_list, sharp);
    if (status < 0) pdi_fourth_order_free(ctx, sharp);
    else pdi_fourth_order_mark_regular_nodes(sharp);
    return status;
}

PDI_FN void pdi_fourth_order_free(pd_ctx *ctx, pd_fourth_order *sharp)
{
    pdi_array_registry_free(ctx, pdi_fourth_order_list, sharp);
    memset(sharp, 0, sizeof *sharp);
}
PDI_COLD_END
