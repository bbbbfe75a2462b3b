/* diffusion: see diffusion.h */
#include "transport/diffusion.h"
#include "core/vec.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Directions that the bonds between rows do not span keep the factor 1: singular values below this share of the trace
 * are damped away. */
#define PDI_DIFFUSION_DAMPING 1e-3
/* The same along metal: at its inner edges few bonds lie within both surfaces. */
#define PDI_DIFFUSION_EDGES 0.02
/* Factors stay within these bounds. */
#define PDI_DIFFUSION_LEAST 0.25
#define PDI_DIFFUSION_MOST 8.0
/* A normal that is shorter than this share of what it is summed of has cancelled, a share of a bond that is smaller is
 * none, and what is nearer to a plane, in cells, lies on it: all would be rounding. */
#define PDI_DIFFUSION_NONE 1e-9
/* Tensors and normals are kept in parts of 1. */
#define PDI_DIFFUSION_PARTS 16777216.0

/* (xi xi^T) packed as xx, xy, yy, xz, yz, zz. */
static void pdi_diffusion_pack(const double *xi, double *packed)
{
    int at = 0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++) packed[at++] = xi[a] * xi[b];
}

/* How often an entry of a packed tensor counts in e^T X e. */
static double pdi_diffusion_twice(int t)
{
    return t == 0 || t == 2 || t == 5 ? 1.0 : 2.0;
}

/* Solve a small dense system by elimination with pivoting; 0: singular. */
static int pdi_diffusion_solve(double a[][PD_DIFFUSION_TENSOR], double *b)
{
    enum { n = PD_DIFFUSION_TENSOR };
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int r = c + 1; r < n; r++)
            if (fabs(a[r][c]) > fabs(a[pivot][c])) pivot = r;
        if (!(fabs(a[pivot][c]) > 0.0)) return 0;
        for (int k = 0; k < n; k++) {
            double keep = a[c][k];
            a[c][k] = a[pivot][k];
            a[pivot][k] = keep;
        }
        double keep = b[c];
        b[c] = b[pivot];
        b[pivot] = keep;
        for (int r = c + 1; r < n; r++) {
            double factor = a[r][c] / a[c][c];
            for (int k = c; k < n; k++) a[r][k] -= factor * a[c][k];
            b[r] -= factor * b[c];
        }
    }
    for (int c = n - 1; c >= 0; c--) {
        for (int k = c + 1; k < n; k++) b[c] -= a[c][k] * b[k];
        b[c] /= a[c][c];
    }
    return 1;
}

/* 1 when what cuts bond k of row r is metal. *all: nothing but metal does, and no wall that meets it there. */
static int pdi_diffusion_metal(const pd_diffusion *d, int32_t r, int k, int *all)
{
    const pd_bond_paths *paths = &d->bonds->paths;
    int32_t i = d->bonds->node[r];
    int group = d->metals ? pdi_bond_path_find_closed_group(paths, i, k) : -1;
    *all = 0;
    return group < 0 ? 0 : pdi_bond_path_has_metal(paths, i, group, all);
}

static void pdi_diffusion_offset(const pd_diffusion *d, int k, double *xi)
{
    for (int a = 0; a < PD_DIM; a++) xi[a] = (double)d->bonds->stencil->offset[k * PD_DIM + a];
}

/* Share of a bond along e that counts as lying along a surface of metal: 1 within it, 0 where it leaves it as steeply
 * as the flattest bond of the family leaves a plane of the lattice (eq. 6.9). */
static double pdi_diffusion_along(const pd_diffusion *d, const double *normal, const double *e)
{
    double across = pdi_vec_dot(normal, e), steep = across * across * d->flattest, along = 1.0 - steep * steep;
    return along > PDI_DIFFUSION_NONE ? along : 0.0;
}

/* The moments that the cut bonds of a row leave out, sum of a xi xi^T in cells, packed. */
typedef struct pdi_diffusion_cuts {
    double walls[PD_DIFFUSION_TENSOR], metal[PD_DIFFUSION_TENSOR];
    double normal[PD_DIM];  /* of the metal, from it; 0: there is none */
} pdi_diffusion_cuts;

/* The normal takes the weights of the plane lattice: those of rings are larger outwards, and what is left of two faces
 * across a gap would count as a direction at any radius. */
static void pdi_diffusion_count(const pd_diffusion *d, int32_t r, const uint8_t *held, pdi_diffusion_cuts *cuts)
{
    const pd_bonds *bonds = d->bonds;
    const double *lap = pdi_bond_get_laplacian_weights(bonds, bonds->node[r]), *even = bonds->stencil->laplacian_weight;
    double whole = 0.0;
    memset(cuts, 0, sizeof *cuts);
    for (int k = 0; k < bonds->stencil->count; k++) {
        double xi[PD_DIM], packed[PD_DIFFUSION_TENSOR];
        if (pdi_bond_is_open(bonds, r, k) || (held && held[k])) continue;
        int all, metal = pdi_diffusion_metal(d, r, k, &all);
        pdi_diffusion_offset(d, k, xi);
        pdi_diffusion_pack(xi, packed);
        for (int t = 0; t < PD_DIFFUSION_TENSOR; t++) (metal ? cuts->metal : cuts->walls)[t] += lap[k] * packed[t];
        for (int a = 0; a < PD_DIM && metal; a++) cuts->normal[a] -= even[k] * xi[a];
        if (metal) whole += even[k] * pdi_vec_norm(xi);
    }
    double length = pdi_vec_norm(cuts->normal);
    int cancels = !(length > PDI_DIFFUSION_NONE * whole);
    for (int a = 0; a < PD_DIM; a++) cuts->normal[a] = cancels ? 0.0 : cuts->normal[a] / length;
}

/* The part of a packed tensor within the plane of a normal: P X P with P = 1 - n n^T. */
static void pdi_diffusion_within(const double *normal, double *x)
{
    double full[PD_DIM][PD_DIM], half[PD_DIM][PD_DIM];
    int at = 0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++) full[a][b] = full[b][a] = x[at++];
    for (int a = 0; a < PD_DIM; a++) {
        double across = pdi_vec_dot(normal, full[a]);
        for (int b = 0; b < PD_DIM; b++) half[b][a] = full[a][b] - across * normal[b];
    }
    at = 0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++) x[at++] = half[a][b] - pdi_vec_dot(normal, half[a]) * normal[b];
}

/* Entries p <= q of sum of a xi xi^T along e e^T, packed twice, over the open bonds of a row that end on rows with cut
 * bonds; normal: with their shares along metal, or NULL. */
static void pdi_diffusion_moments(const pd_diffusion *d, int32_t r, const double *normal,
                                  double sum[][PD_DIFFUSION_TENSOR])
{
    enum { N = PD_DIFFUSION_TENSOR };
    const pd_bonds *bonds = d->bonds;
    const int32_t *place = d->place + bonds->node[r];
    const double *lap = pdi_bond_get_laplacian_weights(bonds, bonds->node[r]);
    for (int k = 0; k < bonds->stencil->count; k++) {
        const double *e = d->unit + k * PD_DIM;
        double xi[PD_DIM], packed[N];
        if (!pdi_bond_is_open(bonds, r, k) || place[bonds->paths.shift[k]] < 0) continue;
        pdi_diffusion_offset(d, k, xi);
        double part = lap[k] * pdi_vec_dot(xi, xi) * (normal ? pdi_diffusion_along(d, normal, e) : 1.0);
        if (!(part > 0.0)) continue;
        pdi_diffusion_pack(e, packed);
        for (int p = 0; p < N; p++)
            for (int q = p; q < N; q++) sum[p][q] += part * packed[p] * packed[q];
    }
}

/* X of one row: sum over its bonds to rows of a (e^T X e) xi xi^T = `lack`, what the moments of the bonds that walls
 * cut, or metal, leave out (eq. 6.8), in the sense of least squares. normal: that of metal. Its cut bonds carry what
 * dissolves (eq. 10.3), so they lack in nothing but along the surface. NULL: of walls. */
static void pdi_diffusion_row(const pd_diffusion *d, int32_t r, const double *lack, const double *normal, double *x)
{
    enum { N = PD_DIFFUSION_TENSOR };
    double matrix[N][N], square[N][N], trace = 0.0, damping = normal ? PDI_DIFFUSION_EDGES : PDI_DIFFUSION_DAMPING;
    memset(matrix, 0, sizeof matrix);
    memset(square, 0, sizeof square);
    pdi_diffusion_moments(d, r, normal, matrix);
    for (int p = 0; p < N; p++)
        for (int q = 0; q < p; q++) matrix[p][q] = matrix[q][p];
    for (int p = 0; p < N; p++)
        for (int q = 0; q < N; q++) matrix[p][q] *= pdi_diffusion_twice(q);
    for (int p = 0; p < N; p++) trace += matrix[p][p];
    for (int p = 0; p < N; p++) {
        x[p] = 0.0;
        for (int q = 0; q < N; q++) {
            x[p] += matrix[q][p] * lack[q];
            for (int t = 0; t < N; t++) square[p][q] += matrix[t][p] * matrix[t][q];
        }
        square[p][p] += damping * damping * trace * trace;
    }
    if (!pdi_diffusion_solve(square, x)) memset(x, 0, N * sizeof *x);
}

/* Numbers that differ by the order of their sums only become equal: what is symmetric conducts symmetrically. */
static float pdi_diffusion_round(double x)
{
    return (float)(round(PDI_DIFFUSION_PARTS * x) / PDI_DIFFUSION_PARTS);
}

static void pdi_diffusion_keep(pd_diffusion *d, int32_t r, const uint8_t *held)
{
    enum { N = PD_DIFFUSION_TENSOR };
    double x[N];
    pdi_diffusion_cuts cuts;
    int64_t i = d->place[d->bonds->node[r]];
    pdi_diffusion_count(d, r, held, &cuts);
    /* a diagonal entry is positive where bonds are cut */
    if (cuts.walls[0] + cuts.walls[N > 1 ? 2 : 0] + cuts.walls[N - 1] > 0.0) {
        pdi_diffusion_row(d, r, cuts.walls, NULL, x);
        for (int t = 0; t < N; t++) d->tensor[i * N + t] = pdi_diffusion_round(x[t]);
    }
    if (!(pdi_vec_norm(cuts.normal) > 0.0)) return;
    pdi_diffusion_within(cuts.normal, cuts.metal);
    pdi_diffusion_row(d, r, cuts.metal, cuts.normal, x);
    for (int t = 0; t < N; t++) d->metal[i * N + t] = pdi_diffusion_round(x[t]);
    for (int a = 0; a < PD_DIM; a++) d->facing[i * PD_DIM + a] = pdi_diffusion_round(cuts.normal[a]);
}

/* ---- places ---- */

static void pdi_diffusion_take(pd_diffusion *d, int32_t i)
{
    if (d->place[i] >= 0) return;
    PD_ASSERT(d->spares || d->used < d->capacity);
    d->place[i] = d->spares ? d->spare[--d->spares] : d->used++;
}

static void pdi_diffusion_leave(pd_diffusion *d, int32_t i)
{
    if (d->place[i] >= 0) d->spare[d->spares++] = d->place[i];
    d->place[i] = -1;
}

/* The ghost k of the list has the numbers of the node that it stands for, or mirrors. */
static int pdi_diffusion_stands(const pd_ghosts *g, int32_t k) { return k < g->images_end || k >= g->outlets_end; }

/* Room for all rows and for the ghosts of them. *all: 1 when there is other room than before, where nothing stands. */
static pd_status pdi_diffusion_fit(pd_ctx *ctx, pd_diffusion *d, int *all)
{
    const pd_bonds *bonds = d->bonds;
    const pd_ghosts *g = &bonds->ghosts;
    int64_t need = bonds->rows;
    for (int32_t k = 0; k < g->inlets_end; k++)
        need += pdi_diffusion_stands(g, k) && (bonds->row_of_node[g->source[k]] >= 0 || d->place[g->source[k]] >= 0);
    if (need <= d->capacity && d->tensor) return PD_OK;
    need += need / 4;
    d->used = d->spares = 0;
    for (int32_t i = 0; i < bonds->grid->total; i++) d->place[i] = -1;
    *all = 1;
    return pdi_array_registry_rebuild(ctx, pdi_diffusion_place_list, d, &d->capacity,
                                      (int32_t)(need < INT32_MAX ? need : INT32_MAX));
}

/* What a ghost has of the tensors [capacity][PD_DIFFUSION_TENSOR] of the node that it mirrors along the axes of `flip`:
 * off-diagonal entries change their sign. */
static void pdi_diffusion_mirror(float *tensor, int64_t ghost, int64_t from, int flip)
{
    int at = 0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++, at++) {
            float value = tensor[from * PD_DIFFUSION_TENSOR + at];
            tensor[ghost * PD_DIFFUSION_TENSOR + at] = (flip >> a ^ flip >> b) & 1 ? -value : value;
        }
}

/* Images and inlet ghosts have the numbers of the nodes that they stand for, or mirror. */
static void pdi_diffusion_ghosts(pd_diffusion *d)
{
    const pd_ghosts *g = &d->bonds->ghosts;
    for (int32_t k = 0; k < g->inlets_end; k++)
        if (pdi_diffusion_stands(g, k) && d->place[g->source[k]] < 0) pdi_diffusion_leave(d, g->node[k]);
    for (int32_t k = 0; k < g->inlets_end; k++) {
        int32_t i = g->node[k], source = g->source[k];
        if (!pdi_diffusion_stands(g, k)) continue;
        d->renewed[i] = d->renewed[source];
        if (d->place[source] < 0) continue;
        pdi_diffusion_take(d, i);
        int64_t to = d->place[i], from = d->place[source];
        pdi_diffusion_mirror(d->tensor, to, from, g->sign_flips[k]);
        if (!d->metals) continue;
        pdi_diffusion_mirror(d->metal, to, from, g->sign_flips[k]);
        for (int a = 0; a < PD_DIM; a++) {
            float value = d->facing[from * PD_DIM + a];
            d->facing[to * PD_DIM + a] = g->sign_flips[k] >> a & 1 ? -value : value;
        }
    }
}

/* Value held where the cut bond k of row r meets a wall, NaN: none; its place x [m] and the conductance [1/s]. */
static double pdi_diffusion_meet(const pd_diffusion *d, int32_t r, int k, double *x, double *t, double *conduct)
{
    int32_t i = d->bonds->node[r];
    double home[PD_DIM];
    *t = pdi_bond_find_cut_fraction(&d->bonds->paths, i, k, x);
    memcpy(home, x, sizeof home);
    pdi_grid_fold_position_images(d->bonds->grid, home);
    double c = d->desc.held(d->desc.user, home);
    *conduct = 0.0;
    if (!(c >= 0.0)) return c;
    *conduct = pdi_bond_get_laplacian_weights(d->bonds, i)[k] / *t;
    *conduct *= d->field ? pdi_bond_diffusivity_get_part(&d->media, i, k, *t) : d->desc.diffusivity;
    return c;
}

/* 1 when what cuts bond k of row r holds nothing, whatever `held` says. */
static int pdi_diffusion_unasked(const pd_diffusion *d, int32_t r, int k)
{
    int all;
    if (!d->desc.walls_only) return 0;
    pdi_diffusion_metal(d, r, k, &all);
    return all;
}

PDI_FN double pdi_diffusion_wall(const pd_diffusion *d, int32_t r, int k, double *value)
{
    double x[PD_DIM], t, conduct;
    if (!d->wall_rate || pdi_bond_is_open(d->bonds, r, k) || pdi_diffusion_unasked(d, r, k)) return 0.0;
    *value = pdi_diffusion_meet(d, r, k, x, &t, &conduct);
    return conduct;
}

/* Share of the bond from node i to x [m], where it meets a wall, that passes a plane. On the plane itself half of what
 * it carries is of either side; all of it where nothing but the wall is behind the plane. */
static double pdi_diffusion_passes(const pd_grid *grid, int32_t i, double x, int axis, int index)
{
    int at[PD_DIM];
    double far = (x - grid->lo[axis]) / grid->h[axis] - index;
    pd_grid_index(grid, i, at);
    int before = at[axis] < index;
    if (fabs(far) > PDI_DIFFUSION_NONE) return before == (far > 0.0) ? 1.0 : 0.0;
    at[axis] = 2 * index - 1 - at[axis];
    pdi_grid_fold_index(grid, at);
    return pd_grid_is_inside(grid, at) && grid->kind[pd_grid_node(grid, at)] == PD_FLUID ? 0.5 : 1.0;
}

PDI_FN double pdi_diffusion_through(const pd_diffusion *d, const double *c, const double *rest, int axis, int index)
{
    const pd_bonds *bonds = d->bonds;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t r = 0; r < bonds->rows && d->wall_rate; r++) {
        int32_t i = bonds->node[r];
        double x[PD_DIM], t, conduct;
        if (!(d->wall_rate[i] > 0.0)) continue;
        int above = pdi_grid_index_along(bonds->grid, i, axis) >= index;
        for (int k = 0; k < bonds->stencil->count; k++) {
            if (pdi_bond_is_open(bonds, r, k) || pdi_diffusion_unasked(d, r, k)) continue;
            double value = pdi_diffusion_meet(d, r, k, x, &t, &conduct);
            double share = value >= 0.0 ? pdi_diffusion_passes(bonds->grid, i, x[axis], axis, index) : 0.0;
            if (!(share > 0.0)) continue;
            double gain = conduct * ((value - c[i]) - (rest ? rest[i] : 0.0));
            pdi_compensated_sum_add(&sum, share * (above ? gain : -gain) * pd_grid_circumference(bonds->grid, i));
        }
    }
    return pdi_compensated_sum_total(&sum) * bonds->stencil->volume;
}

/* Conductance of row r to the values held where its cut bonds meet walls, by linear extension (eq. 2.2 without
 * bending), and which of its bonds those are. */
static void pdi_diffusion_hold(pd_diffusion *d, int32_t r, uint8_t *held)
{
    const pd_bonds *bonds = d->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r], place = d->place[i];
    double x[PD_DIM], t, value;
    int first = 1;
    for (int k = 0; k < s->count; k++) {
        held[k] = 0;
        if (pdi_bond_is_open(bonds, r, k)) continue;
        if (pdi_diffusion_unasked(d, r, k)) {
            d->wall_part[place] = 1;
            continue;
        }
        double c = pdi_diffusion_meet(d, r, k, x, &t, &value);
        if (!(c >= 0.0)) d->wall_part[place] = 1;
        if (c < 0.0) d->held_least = pd_min(d->held_least, c); /* for the caller to refuse */
        if (!(c >= 0.0)) continue;
        held[k] = 1;
        for (int a = 0; a < PD_DIM && d->wall_grad; a++) {
            d->wall_grad[(int64_t)place * PD_DIM + a] += s->gradient_weight[k * PD_DIM + a] / t * c;
            d->wall_grad_rate[(int64_t)place * PD_DIM + a] += s->gradient_weight[k * PD_DIM + a] / t;
        }
        if (first) d->wall_value[place] = c;
        first = 0;
        d->wall_rate[i] += value;
        d->wall_source[place] += value * c;
        d->wall_rest[place] += value * (c - d->wall_value[place]);
        d->held_least = pd_min(d->held_least, c);
        d->held_most = pd_max(d->held_most, c);
    }
}

/* 1 when a bond of the node is cut. Rows at inlets may have none. */
static int pdi_diffusion_cut(const pd_bonds *bonds, int32_t i)
{
    int32_t r = bonds->row_of_node[i];
    for (int k = 0; k < bonds->stencil->count && r >= 0; k++)
        if (!pdi_bond_is_open(bonds, r, k)) return 1;
    return 0;
}

/* What node i gets from held walls is renewed. */
static void pdi_diffusion_release(pd_diffusion *d, int32_t i)
{
    int64_t place = d->place[i];
    d->wall_rate[i] = 0.0;
    if (place < 0) return;
    d->wall_source[place] = d->wall_value[place] = d->wall_rest[place] = 0.0;
    for (int a = 0; a < PD_DIM && d->wall_grad; a++)
        d->wall_grad[place * PD_DIM + a] = d->wall_grad_rate[place * PD_DIM + a] = 0.0;
}

/* The numbers of node i are renewed. */
static void pdi_diffusion_clear(pd_diffusion *d, int32_t i)
{
    enum { N = PD_DIFFUSION_TENSOR };
    int64_t place = d->place[i];
    d->renewed[i] = d->bonds->version;
    if (d->wall_rate) pdi_diffusion_release(d, i);
    if (place < 0) return;
    for (int t = 0; t < N; t++) d->tensor[place * N + t] = 0.0f;
    for (int t = 0; t < N && d->metals; t++) d->metal[place * N + t] = 0.0f;
    for (int a = 0; a < PD_DIM && d->metals; a++) d->facing[place * PD_DIM + a] = 0.0f;
    if (d->wall_rate) d->wall_part[place] = 0;
}

/* The same for the neighbours of node i, which has come to have cut bonds or has none any more. */
static void pdi_diffusion_turn(pd_diffusion *d, int32_t i)
{
    const pd_bonds *bonds = d->bonds;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int at[PD_DIM];
        pd_grid_index(bonds->grid, i, at);
        for (int a = 0; a < PD_DIM; a++) at[a] += bonds->stencil->offset[k * PD_DIM + a];
        pdi_grid_fold_index(bonds->grid, at);
        int32_t j = pd_grid_node(bonds->grid, at);
        if (bonds->grid->kind[j] == PD_FLUID) pdi_diffusion_clear(d, j);
    }
}

/* Which nodes have bonds that are cut, and the nodes whose numbers follow from that: they, and their neighbours. Those
 * that leave their places go first. */
static void pdi_diffusion_find(pd_diffusion *d, int all)
{
    const pd_bonds *bonds = d->bonds;
    int32_t total = bonds->grid->total;
    for (int32_t i = 0; i < total; i++) {
        if ((!all && bonds->node_version[i] <= d->version) || d->place[i] < 0 || pdi_diffusion_cut(bonds, i)) continue;
        pdi_diffusion_leave(d, i);
        if (!all) pdi_diffusion_turn(d, i);
    }
    for (int32_t i = 0; i < total; i++) {
        if (!all && bonds->node_version[i] <= d->version) continue;
        int turned = d->place[i] < 0 && pdi_diffusion_cut(bonds, i);
        if (turned) pdi_diffusion_take(d, i);
        pdi_diffusion_clear(d, i);
        if (turned && !all) pdi_diffusion_turn(d, i);
    }
}

PDI_FN pd_status pdi_diffusion_update(pd_ctx *ctx, pd_diffusion *d)
{
    const pd_bonds *bonds = d->bonds;
    int nt = pd_par_threads(ctx, (int64_t)bonds->rows * bonds->stencil->count * PD_DIFFUSION_TENSOR);
    int all = d->version == 0;
    (void)nt;
    if (d->version == bonds->version) return PD_OK;
    if (d->version == 0) {
        d->held_least = HUGE_VAL;
        d->held_most = -HUGE_VAL;
    }
    PD_TRY(pdi_diffusion_fit(ctx, d, &all));
    pdi_diffusion_find(d, all);
    pdi_diffusion_ghosts(d);
    for (int32_t r = 0; r < bonds->rows && d->wall_rate; r++) {
        int32_t i = bonds->node[r];
        if (d->place[i] < 0 || d->renewed[i] != bonds->version) continue;
        pdi_diffusion_hold(d, r, d->held);
        pdi_diffusion_keep(d, r, d->held);
    }
    PD_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < (d->wall_rate ? 0 : bonds->rows); r++) {
        int32_t i = bonds->node[r];
        if (d->place[i] >= 0 && d->renewed[i] == bonds->version) pdi_diffusion_keep(d, r, NULL);
    }
    pdi_diffusion_ghosts(d);
    d->version = bonds->version;
    return PD_OK;
}

PDI_FN void pdi_diffusion_renew(pd_diffusion *d)
{
    const pd_bonds *bonds = d->bonds;
    d->held_least = HUGE_VAL;
    d->held_most = -HUGE_VAL;
    for (int32_t r = 0; r < bonds->rows && d->wall_rate; r++) {
        int32_t i = bonds->node[r];
        if (d->place[i] < 0) continue;
        pdi_diffusion_release(d, i);
        pdi_diffusion_hold(d, r, d->held);
    }
}

PDI_FN void pdi_diffusion_list(pdi_array_visitor *owner, void *object)
{
    pd_diffusion *diffusion = (pd_diffusion *)object;
    if (!diffusion->bonds) return;
    int64_t total = diffusion->bonds->grid->total;
    PDI_ARRAY(owner, diffusion, unit, PD_DIM * diffusion->bonds->stencil->count, "1");
    PDI_ARRAY(owner, diffusion, place, total, "1");
    PDI_ARRAY(owner, diffusion, renewed, total, "1");
    if (!diffusion->desc.held) return;
    PDI_ARRAY(owner, diffusion, wall_rate, total, "1/s");
    PDI_ARRAY(owner, diffusion, held, diffusion->bonds->stencil->count, "1");
}

PDI_FN void pdi_diffusion_place_list(pdi_array_visitor *owner, void *object)
{
    pd_diffusion *diffusion = (pd_diffusion *)object;
    int64_t count = diffusion->capacity;
    PDI_ARRAY(owner, diffusion, spare, count, "1");
    PDI_ARRAY(owner, diffusion, tensor, PD_DIFFUSION_TENSOR * count, "1");
    if (diffusion->metals) PDI_ARRAY(owner, diffusion, metal, PD_DIFFUSION_TENSOR * count, "1");
    if (diffusion->metals) PDI_ARRAY(owner, diffusion, facing, PD_DIM * count, "1");
    if (!diffusion->desc.held) return;
    PDI_ARRAY(owner, diffusion, wall_source, count, "mol/m3/s");
    PDI_ARRAY(owner, diffusion, wall_value, count, "mol/m3");
    PDI_ARRAY(owner, diffusion, wall_rest, count, "mol/m3/s");
    PDI_ARRAY(owner, diffusion, wall_part, count, "1");
    if (diffusion->desc.smooth) return;
    PDI_ARRAY(owner, diffusion, wall_grad, PD_DIM * count, "mol/m4");
    PDI_ARRAY(owner, diffusion, wall_grad_rate, PD_DIM * count, "1/m");
}

static pd_status pdi_diffusion_make(pd_ctx *ctx, const pd_bonds *bonds, const pd_diffusion_desc *desc, pd_diffusion *d)
{
    memset(d, 0, sizeof *d);
    d->desc = *desc;
    d->bonds = bonds;
    if (!(desc->diffusivity >= 0.0) || !(desc->diffusivity < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "diffusion", "D = %g m2/s, expected a finite value of at least 0",
                       desc->diffusivity);
    d->metals = bonds->grid->solid_count > 0; /* all of it may dissolve */
    PD_TRY(pdi_array_registry_build(ctx, pdi_diffusion_list, d));
    for (int32_t i = 0; i < bonds->grid->total; i++) d->place[i] = -1;
    for (int k = 0; k < bonds->stencil->count; k++) {
        double xi[PD_DIM];
        pdi_diffusion_offset(d, k, xi);
        for (int a = 0; a < PD_DIM; a++) {
            d->unit[k * PD_DIM + a] = xi[a] / pdi_vec_norm(xi);
            if (fabs(xi[a]) < 1.5 && fabs(xi[a]) > 0.5) d->flattest = pd_max(d->flattest, pdi_vec_dot(xi, xi));
        }
    }
    if (desc->field)
        PD_TRY(pdi_bond_diffusivity_build(ctx, bonds->stencil, bonds->grid, desc->field, desc->level, desc->user,
                                          &d->media));
    d->field = d->media.node_value;
    return pdi_diffusion_update(ctx, d);
}

PDI_FN pd_status pdi_diffusion_build(pd_ctx *ctx, const pd_bonds *bonds, const pd_diffusion_desc *desc, pd_diffusion *d)
{
    pd_status status = pdi_diffusion_make(ctx, bonds, desc, d);
    if (status < 0) pdi_diffusion_free(ctx, d);
    return status;
}

/* e^T X e of tensor i of an array of them. `along`: e e^T, entries counting as often as in the full tensor. */
static double pdi_diffusion_quadratic(const float *tensors, int64_t i, const double *along)
{
    const float *tensor = tensors + i * PD_DIFFUSION_TENSOR;
    double sum = 0.0;
    for (int t = 0; t < PD_DIFFUSION_TENSOR; t++) sum += along[t] * (double)tensor[t];
    return sum;
}

/* The same of what metal beside the node of place i adds. */
static double pdi_diffusion_beside(const pd_diffusion *d, int64_t i, const double *e, const double *along)
{
    double normal[PD_DIM];
    for (int a = 0; a < PD_DIM; a++) normal[a] = (double)d->facing[i * PD_DIM + a];
    return pdi_diffusion_quadratic(d->metal, i, along) * pdi_diffusion_along(d, normal, e);
}

PDI_FN float pdi_diffusion_more(const pd_diffusion *d, int32_t i, int k)
{
    int32_t near = d->place[i], far = d->place[i + d->bonds->paths.shift[k]];
    const double *e = d->unit + k * PD_DIM;
    double along[PD_DIFFUSION_TENSOR];
    if (near < 0 || far < 0) return 0.0f;
    pdi_diffusion_pack(e, along);
    for (int t = 0; t < PD_DIFFUSION_TENSOR; t++) along[t] *= pdi_diffusion_twice(t);
    double twice = pdi_diffusion_quadratic(d->tensor, near, along) + pdi_diffusion_quadratic(d->tensor, far, along);
    if (d->metals) twice += pdi_diffusion_beside(d, near, e, along) + pdi_diffusion_beside(d, far, e, along);
    double more = pd_max(0.5 * twice, PDI_DIFFUSION_LEAST - 1.0);
    return (float)(more < PDI_DIFFUSION_MOST - 1.0 ? more : PDI_DIFFUSION_MOST - 1.0);
}

PDI_FN void pdi_diffusion_bond(const pd_diffusion *d, int32_t i, int k, int count, int rows, double *bond)
{
    int32_t j = i + d->bonds->paths.shift[k];
    double a = pdi_bond_get_laplacian_weights(d->bonds, i)[k];
    if (d->field)
        for (int b = 0; b < count; b++) bond[b] = a * pdi_bond_diffusivity_get(&d->media, i + b, j + b, k);
    else
        for (int b = 0; b < count; b++) bond[b] = d->desc.diffusivity * a;
    for (int b = 0; b < count && rows; b++) bond[b] *= 1.0 + (double)pdi_diffusion_more(d, i + b, k);
}

PDI_FN void pdi_diffusion_free(pd_ctx *ctx, pd_diffusion *d)
{
    pdi_array_registry_free(ctx, pdi_diffusion_list, d);
    pdi_array_registry_free(ctx, pdi_diffusion_place_list, d);
    pdi_bond_diffusivity_free(ctx, &d->media);
    memset(d, 0, sizeof *d);
}
