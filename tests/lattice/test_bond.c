/* bond: openness, tightness of thin walls, updates, wall coefficients, cut points, memory faults.
 * dims: 1 2 3 */
#include "bond_scene.h"
#include "random.h"
#include <stdlib.h>

static void cell_index(const scene *s, int cell, int *i)
{
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = cell % s->n[d];
        cell /= s->n[d];
    }
}

static int32_t cell_node(const scene *s, int cell)
{
    int i[PD_DIM];
    cell_index(s, cell, i);
    return pd_grid_node(&s->grid, i);
}

/* 1 when bond k of `node` is in its row, or the node needs none. */
static int is_open(const pd_bonds *b, int32_t node, int k)
{
    int32_t r = b->row_of_node[node];
    return r < 0 || pdi_bond_is_open(b, r, k);
}

/* Fractions of the bond between which its line runs through the closed cell c (offset from the start). 0: never. */
static int passage(const int *n, const int *c, double *first, double *last)
{
    *first = 0.0;
    *last = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        if (n[d] == 0 && c[d] == 0) continue;
        if (n[d] == 0) return 0;
        double a = (c[d] - 0.5) / n[d], b = (c[d] + 0.5) / n[d];
        *first = fmax(*first, fmin(a, b));
        *last = fmin(*last, fmax(a, b));
    }
    return *last > *first - 1e-12;
}

/* The definition of openness: a way from face to face along open cells that the line touches leads to the far end. */
static int connected(const pd_bonds *b, int32_t node, int k)
{
    const int *n = b->stencil->offset + k * PD_DIM;
    static int32_t touched[512];
    static int reached[512];
    int reach = b->stencil->reach, total = 1, count = 0, grown = 1;
    for (int d = 0; d < PD_DIM; d++) total *= 2 * reach + 1;
    for (int i = 0; i < total; i++) {
        int c[PD_DIM];
        double first, last;
        int32_t at = node;
        for (int d = 0, rest = i; d < PD_DIM; d++, rest /= 2 * reach + 1) {
            c[d] = rest % (2 * reach + 1) - reach;
            at += c[d] * b->grid->stride[d];
        }
        if (!passage(n, c, &first, &last) || !pdi_grid_is_open(b->grid->kind[at])) continue;
        touched[count] = at;
        reached[count++] = at == node;
    }
    while (grown) {
        grown = 0;
        for (int i = 0; i < count; i++)
            for (int j = 0; j < count && reached[i]; j++)
                for (int d = 0; d < PD_DIM && !reached[j]; d++)
                    if (abs(touched[i] - touched[j]) == b->grid->stride[d]) grown = reached[j] = 1;
    }
    for (int i = 0; i < count; i++)
        if (touched[i] == node + b->paths.shift[k]) return reached[i];
    return 0;
}

static void check_openness(const scene *s)
{
    const pd_bonds *b = &s->bonds;
    int count = s->stencil.count;
    int64_t fluid = 0;
    for (int32_t node = 0; node < s->grid.total; node++) {
        if (s->grid.kind[node] != PD_FLUID) {
            CHECK_INT(b->row_of_node[node], -1);
            continue;
        }
        fluid++;
        for (int k = 0; k < count; k++) {
            int32_t far = node + b->paths.shift[k];
            int open = is_open(b, node, k);
            CHECK_INT(open, connected(b, node, k));
            if (s->grid.kind[far] == PD_FLUID) CHECK_INT(open, is_open(b, far, count - 1 - k));
        }
    }
    CHECK_INT(fluid, s->grid.fluid_count);
}

TEST(random_masks)
{
    scene *s = &test_scene;
    uint32_t state = 3;
    pd_ctx_init(&s->ctx);
    for (int round = 0; round < (PD_DIM == 3 ? 4 : 12); round++) {
        int share = 2 + round % 8;
        if (!scene_init(s, PD_DIM == 3 ? 2.0 + round % 2 : 1.0 + round % 5, 1.0, 9, 8, 6)) return;
        for (int c = 0; c < s->cells; c++) s->mask[c] = next_random(&state) % 10 < (uint32_t)share;
        s->mask[0] = 1;
        scene_voxels(s);
        s->desc.side[0] = PD_SIDE_INLET;
        s->desc.side[1] = PD_SIDE_OUTLET;
        if (!scene_build(s)) return;
        check_openness(s);
        scene_free(s);
    }
}

#if PD_DIM > 1
static int sheet_of(const int *i, const int *normal)
{
    int sum = 0;
    for (int d = 0; d < PD_DIM; d++) sum += normal[d] * i[d];
    return sum;
}

/* The nodes of one lattice plane are solid: no bond joins its sides, however oblique the plane. */
static void check_tight(double m, const int *normal, int level)
{
    scene *s = &test_scene;
    int crossing = 0, sides[2] = {0, 0};
    pd_ctx_init(&s->ctx);
    if (!scene_init(s, m, 1.0, 12, 11, 10)) return;
    for (int c = 0; c < s->cells; c++) {
        int i[PD_DIM];
        cell_index(s, c, i);
        s->mask[c] = sheet_of(i, normal) == level;
    }
    scene_voxels(s);
    if (!scene_build(s)) return;
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[PD_DIM], j[PD_DIM];
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_index(&s->grid, node, i);
        int side = sheet_of(i, normal) > level;
        sides[side]++;
        for (int k = 0; k < s->stencil.count; k++) {
            for (int d = 0; d < PD_DIM; d++) j[d] = i[d] + s->stencil.offset[k * PD_DIM + d];
            if (!pd_grid_is_inside(&s->grid, j) || s->grid.kind[pd_grid_node(&s->grid, j)] != PD_FLUID) continue;
            crossing += (sheet_of(j, normal) > level) != side && is_open(&s->bonds, node, k);
        }
    }
    CHECK_INT(crossing, 0);
    CHECK(sides[0] > 20 && sides[1] > 20);
    scene_free(s);
}

TEST(thin_walls_are_tight)
{
#if PD_DIM == 2
    static const int normal[][2] = {{1, 0}, {0, 1}, {1, -1}, {1, 1}};
    static const int level[] = {5, 4, 0, 10};
#else
    static const int normal[][3] = {{1, 0, 0}, {0, 0, 1}, {1, -1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, -1}, {-1, 1, 1}};
    static const int level[] = {5, 4, 0, 9, 14, 7, 5};
#endif
    for (int k = 0; k < (int)(sizeof level / sizeof level[0]); k++)
        for (int m = 1; m <= (PD_DIM == 2 ? 6 : 4); m++) check_tight(m, normal[k], level[k]);
}
#endif

/* The same rows in the same order, with the same numbers bit for bit, and the same runs. a may be those at rest. */
static void check_same(const pd_bonds *a, const pd_bonds *b)
{
    int64_t in_all = 0, dd = PD_DIM * PD_DIM;
    CHECK_INT(a->rows, b->rows);
    CHECK_INT(a->rows_without_inlet, b->rows_without_inlet);
    for (int32_t node = 0; node < a->grid->total; node++) {
        int32_t r = a->row_of_node[node], q = b->row_of_node[node];
        if (!CHECK((r < 0) == (q < 0)) || r < 0) continue;
        CHECK_INT(a->node[r], node);
        CHECK_INT(r, q);
        CHECK_INT(a->has_inlet[r], b->has_inlet[q]);
        for (int k = 0; k < a->stencil->count; k++) CHECK_INT(pdi_bond_is_open(a, r, k), pdi_bond_is_open(b, q, k));
        CHECK(a->options || a->wall_laplacian[r] == b->wall_laplacian[q]);
        CHECK(a->options || a->wall_curvature[r] == b->wall_curvature[q]);
        CHECK(memcmp(a->inverse_moment + r * dd, b->inverse_moment + q * dd, (size_t)dd * sizeof *a->inverse_moment) ==
              0);
    }
    const pd_node_ranges *mine[2] = {&a->full_ranges, &a->truncated_ranges},
                         *other[2] = {&b->full_ranges, &b->truncated_ranges};
    for (int cut = 0; cut < 2; cut++) {
        if (!CHECK_INT(mine[cut]->count, other[cut]->count)) continue;
        for (int32_t k = 0; k < mine[cut]->count; k++) {
            int32_t first = mine[cut]->first[k];
            CHECK_INT(first, other[cut]->first[k]);
            CHECK_INT(mine[cut]->length[k], other[cut]->length[k]);
            for (int32_t o = 0; o < mine[cut]->length[k]; o++) {
                CHECK(a->grid->kind[first + o] == PD_FLUID);
                CHECK_INT(a->row_of_node[first + o], cut ? a->row_of_node[first] + o : -1);
            }
            in_all += mine[cut]->length[k];
        }
    }
    CHECK_INT(in_all + a->rows - a->rows_without_inlet, a->grid->fluid_count);
}

/* Lean bonds find moments when they are asked for: those of others, to the bit. */
static void check_lean(const pd_bonds *lean, const pd_bonds *other)
{
    int worse = 0;
    CHECK(!lean->inverse_moment && !lean->wall_laplacian && lean->rows == other->rows);
    for (int32_t r = 0; r < lean->rows && lean->rows == other->rows; r++) {
        double found[PD_DIM * PD_DIM], room[PD_DIM * PD_DIM];
        memcpy(found, pdi_bond_get_inverse_moment(lean, r, room), sizeof found);
        worse += memcmp(found, pdi_bond_get_inverse_moment(other, r, room), sizeof found) != 0;
    }
    CHECK_INT(worse, 0);
}

/* Dissolve random nodes in batches until none is left; after each batch the updated bonds are those of a new build. */
static void dissolve_all(scene *s, uint32_t *state)
{
    pd_bonds rest, lean;
    CHECK_INT(pd_bonds_build(&s->ctx, &s->stencil, &s->grid, PD_BONDS_LOW_MEMORY, &lean), PD_ERR_ARGUMENT);
    if (!CHECK_OK(&s->ctx,
                  pd_bonds_build(&s->ctx, &s->stencil, &s->grid, PD_BONDS_NO_FLOW | PD_BONDS_LOW_MEMORY, &lean)))
        return;
    if (!CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, PD_BONDS_NO_FLOW, &rest))) return;
    CHECK(!rest.wall_laplacian && !rest.neighbour_distance && !rest.flux_correction);
    while (s->grid.solid_count > 0) {
        int32_t changed[64], count = 0, batch = 1 + (int32_t)(next_random(state) % 60);
        pd_bonds fresh;
        int first = (int)(next_random(state) % (uint32_t)s->cells);
        for (int tried = 0; tried < s->cells && count < batch; tried++) {
            int32_t node = cell_node(s, (first + 7 * tried) % s->cells);
            if (s->grid.kind[node] != PD_SOLID) continue;
            pdi_grid_set_fluid(&s->grid, node);
            changed[count++] = node;
        }
        if (!CHECK_OK(&s->ctx, pd_bonds_update(&s->ctx, changed, count, &s->bonds))) return;
        if (!CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds))) return;
        if (!CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &fresh))) return;
        check_same(&s->bonds, &fresh);
        if (CHECK_OK(&s->ctx, pd_bonds_update(&s->ctx, changed, count, &rest))) check_same(&rest, &fresh);
        if (CHECK_OK(&s->ctx, pd_bonds_update(&s->ctx, changed, count, &lean))) check_lean(&lean, &rest);
        pd_bonds_free(&s->ctx, &fresh);
    }
    pd_bonds_free(&s->ctx, &rest);
    pd_bonds_free(&s->ctx, &lean);
}

/* With a voxel solid (faces) and with a ball (cut points on its surface, then on faces). */
TEST(update_equals_fresh)
{
    scene *s = &test_scene;
    uint32_t state = 11;
    pd_ctx_init(&s->ctx);
    for (int round = 0; round < 4; round++) {
        if (!scene_init(s, 1.0 + round % 3, 0.5, 15, 13, 11)) return;
        for (int c = 0; c < s->cells; c++) s->mask[c] = next_random(&state) % 10 < 6;
        s->mask[0] = 1;
        scene_voxels(s);
        s->desc.side[0] = PD_SIDE_INLET;
        s->desc.side[2 * PD_DIM - 1] = PD_SIDE_OUTLET;
        if (round % 2) {
            s->shapes[0].type = PD_SHAPE_BALL;
            for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = 2.8;
            s->shapes[0].radius = 2.1;
        }
        if (!scene_build(s)) return;
        dissolve_all(s, &state);
        scene_free(s);
    }
}

TEST(validate_notices)
{
    scene *s = &test_scene;
    int i[PD_DIM];
    pd_ctx_init(&s->ctx);
    if (!scene_init(s, 2.0, 1.0, 10, 9, 8) || !scene_build(s)) return;
    for (int d = 0; d < PD_DIM; d++) i[d] = 4;
    int32_t node = pd_grid_node(&s->grid, i);
    s->grid.kind[node] = PD_SOLID; /* behind the back of the bonds */
    CHECK_INT(pd_bonds_validate(&s->ctx, &s->bonds), PD_ERR_INTERNAL);
    s->grid.kind[node] = PD_FLUID;
    CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
    memset(i, 0, sizeof i);
    CHECK_INT(s->bonds.node[0], pd_grid_node(&s->grid, i));
    s->bonds.open_mask[0] |= 1u; /* a bond of the corner node that leaves the box */
    s->grid.kind[s->bonds.node[0] + s->bonds.paths.shift[0]] = PD_FLUID;
    CHECK_INT(pd_bonds_validate(&s->ctx, &s->bonds), PD_ERR_INTERNAL);
    scene_free(s);
}

/* What validate says of the bonds with an entry of `array` set to `value` for the while. */
static pd_status validate_with(scene *s, int32_t *array, int32_t value)
{
    int32_t kept = *array;
    *array = value;
    pd_status status = pd_bonds_validate(&s->ctx, &s->bonds);
    *array = kept;
    CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
    return status;
}

/* One wrong entry of rows, masks and ranges is enough: a bond that is closed at one end alone, a number out of range, a
 * node with the row of another, a row too many, a range that holds other nodes or begins too early. */
TEST(validate_notices_one_entry)
{
    scene *s = &test_scene;
    pd_bonds *b = &s->bonds;
    int closed = 0;
    pd_ctx_init(&s->ctx);
    if (!scene_init(s, 2.0, 1.0, 10, 9, 8)) return;
    s->desc.side[0] = PD_SIDE_INLET;
    if (!scene_build(s)) return;
    int32_t row = b->rows_without_inlet / 2, node = b->node[row], full = b->full_ranges.first[0];
    for (int k = 0; k < s->stencil.count; k++) { /* those that end on another row */
        int32_t other = node + b->paths.shift[k];
        if (!pdi_bond_is_open(b, row, k) || s->grid.kind[other] != PD_FLUID || b->row_of_node[other] < 0) continue;
        uint32_t *word = b->open_mask + (int64_t)(k >> 5) * b->capacity + row;
        *word ^= 1u << (k & 31);
        CHECK_INT(pd_bonds_validate(&s->ctx, b), PD_ERR_INTERNAL);
        *word ^= 1u << (k & 31);
        closed++;
    }
    CHECK(closed > 0);
    CHECK(b->rows_without_inlet > 1 && b->rows > b->rows_without_inlet);
    CHECK_INT(validate_with(s, &b->node[row], -1), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->node[row], s->grid.total), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->node[row], b->node[row - 1]), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->row_of_node[node], -2), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->row_of_node[node], -1), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->row_of_node[node], b->rows), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->row_of_node[full], row), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->row_of_node[0], row), PD_ERR_INTERNAL); /* a ghost */
    CHECK_INT(validate_with(s, &b->rows_without_inlet, b->rows_without_inlet - 1), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->full_ranges.first[0], full - 1), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->truncated_ranges.first[0], b->truncated_ranges.first[0] + 1), PD_ERR_INTERNAL);
    CHECK_INT(validate_with(s, &b->truncated_ranges.length[0], b->truncated_ranges.length[0] - 1), PD_ERR_INTERNAL);
    scene_free(s);
}

/* ---- wall coefficients ---- */

/* Sums over the bonds of a node `layer` cells above a wall that lies on a face: a bond n steps down meets it at
 * t = (layer + 1/2)/n. */
static void flat_wall(const pd_stencil *s, int axis, int layer, double *lap, double *curv)
{
    *lap = *curv = 0.0;
    for (int k = 0; k < s->count; k++) {
        int n = -s->offset[k * PD_DIM + axis];
        if (n <= layer) continue;
        double t = (layer + 0.5) / n, height = n * s->h[axis];
        *lap += s->laplacian_weight[k] / t;
        *curv += s->laplacian_weight[k] * height * height * (1.0 - t) / 2.0;
    }
}

TEST(flat_wall_coefficients)
{
    scene *s = &test_scene;
    pd_ctx_init(&s->ctx);
    for (int m = 1; m <= 4; m++)
        for (int axis = 0; axis < PD_DIM; axis++) {
            int i[PD_DIM];
            double lap, curv;
            if (!scene_init(s, m, 0.5, 14, 13, 12) || !scene_build(s)) return;
            for (int d = 0; d < PD_DIM; d++) i[d] = 6;
            for (int layer = 0; layer < m; layer++) {
                i[axis] = layer;
                int32_t r = s->bonds.row_of_node[pd_grid_node(&s->grid, i)];
                if (!CHECK(r >= 0)) continue;
                flat_wall(&s->stencil, axis, layer, &lap, &curv);
                CHECK_REL(s->bonds.wall_laplacian[r], lap, 1e-13);
                CHECK_REL(s->bonds.wall_curvature[r], curv, 1e-13);
            }
            i[axis] = m;
            CHECK_INT(s->bonds.row_of_node[pd_grid_node(&s->grid, i)], -1);
            scene_free(s);
        }
}

#if PD_DIM == 1
/* m = 1: a = 1/h^2, t = 1/2: a/t = 2/h^2 and 1/2 (1 - 1/2) = 1/4.
 * m = 2: a_1 = 2/3, a_2 = 1/12 (over h^2); node 0: t = 1/2, 1/4; node 1: only a_2 at t = 3/4. */
TEST(flat_wall_by_hand)
{
    scene *s = &test_scene;
    double h = 0.5;
    pd_ctx_init(&s->ctx);
    if (!scene_init(s, 1.0, h, 9, 1, 1) || !scene_build(s)) return;
    CHECK_INT(s->bonds.rows, 2);
    CHECK_REL(s->bonds.wall_laplacian[0], 2.0 / (h * h), 1e-14);
    CHECK_REL(s->bonds.wall_curvature[0], 0.25, 1e-14);
    scene_free(s);
    if (!scene_init(s, 2.0, h, 9, 1, 1) || !scene_build(s)) return;
    CHECK_INT(s->bonds.rows, 4);
    CHECK_REL(s->bonds.wall_laplacian[0], 5.0 / 3.0 / (h * h), 1e-14);
    CHECK_REL(s->bonds.wall_curvature[0], 7.0 / 24.0, 1e-14);
    CHECK_REL(s->bonds.wall_laplacian[1], 1.0 / 9.0 / (h * h), 1e-14);
    CHECK_REL(s->bonds.wall_curvature[1], 1.0 / 24.0, 1e-14);
    scene_free(s);
}
#endif

/* First fraction t > 0 at which |x + t xi - c| = r over the axes in `round`; 2: none before the end. */
static double hit_round(const double *x, const double *xi, const double *c, double r, int round)
{
    double aa = 0.0, ab = 0.0, bb = -r * r;
    for (int d = 0; d < PD_DIM; d++) {
        if (!((round >> d) & 1)) continue;
        aa += xi[d] * xi[d];
        ab += xi[d] * (x[d] - c[d]);
        bb += (x[d] - c[d]) * (x[d] - c[d]);
    }
    double root = ab * ab - aa * bb;
    if (root < 0.0 || aa == 0.0) return 2.0;
    double t = (-ab - sqrt(root)) / aa;
    if (t <= 0.0) t = (-ab + sqrt(root)) / aa;
    return t > 0.0 && t <= 1.0 ? t : 2.0;
}

/* Nodes all of whose cut bonds end in the closed body: their coefficients from the exact intersections t and normals N,
 * and for the field u = g d + q d^2/2 of the distance d to the surface, which bends by `sign`/r in the round axes:
 *     along the bond        u'' = g (sign/r) (|xi|^2 - (xi.N)^2) + q (xi.N)^2    (|xi| in the round axes)
 *     of the whole          lap u = g mean + q,  mean = sign (axes - 1)/r
 * Cut bonds bring a (u_far - u_i) with u_far = u_i - u_i/t + (1 - t)/2 u''. Returns how many nodes there were. */
static int check_round(const scene *s, const double *centre, double r, int round, double sign)
{
    int checked = 0, axes = 0;
    for (int d = 0; d < PD_DIM; d++) axes += (round >> d) & 1;
    for (int32_t row = 0; row < s->bonds.rows; row++) {
        double x[PD_DIM], lap = 0.0, curv = 0.0, radius = 0.0, mean = sign * (axes - 1) / r;
        int32_t node = s->bonds.node[row];
        int whole = 1, cuts = 0;
        pd_grid_position(&s->grid, node, x);
        for (int d = 0; d < PD_DIM; d++)
            if ((round >> d) & 1) radius += (x[d] - centre[d]) * (x[d] - centre[d]);
        double distance = sign * (sqrt(radius) - r);
        for (int k = 0; k < s->stencil.count && whole; k++) {
            const double *xi = s->stencil.xi + k * PD_DIM;
            int32_t far = node + s->bonds.paths.shift[k];
            int i[PD_DIM];
            if (is_open(&s->bonds, node, k)) continue;
            double t = hit_round(x, xi, centre, r, round), reach = 0.0, xi2 = 0.0;
            pd_grid_index(&s->grid, far, i);
            whole = t <= 1.0 && !pdi_grid_is_open(s->grid.kind[far]) && pd_grid_is_inside(&s->grid, i);
            for (int d = 0; d < PD_DIM; d++) {
                if (!((round >> d) & 1)) continue;
                reach += xi[d] * (x[d] + t * xi[d] - centre[d]) / r;
                xi2 += xi[d] * xi[d];
            }
            /* with lap u = w: g = (u_i - w d^2/2) / (d - mean d^2/2) and q = w - g mean */
            double bend = sign / r * (xi2 - reach * reach) - mean * reach * reach;
            double per_slope = 1.0 / (distance - 0.5 * mean * distance * distance);
            double half = 0.5 * s->stencil.laplacian_weight[k] * (1.0 - t);
            lap += s->stencil.laplacian_weight[k] / t - half * bend * per_slope;
            curv += half * (reach * reach - bend * per_slope * 0.5 * distance * distance);
            cuts++;
        }
        CHECK(s->bonds.wall_laplacian[row] > 0.0);
        if (!whole || !cuts) continue;
        CHECK_REL(s->bonds.wall_laplacian[row], lap, 1e-6); /* curvatures come from differences of the distance */
        CHECK_NEAR(s->bonds.wall_curvature[row], curv, 1e-7);
        checked++;
    }
    return checked;
}

/* A ball in the fluid and, in 2D and 3D, a fluid tube in a wall. */
TEST(cut_points_on_round_surfaces)
{
    scene *s = &test_scene;
    double centre[PD_DIM];
    pd_ctx_init(&s->ctx);
    for (int m = 1; m <= 3; m++) {
        if (!scene_init(s, m, 0.1, 24, 24, 14)) return;
        for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = centre[d] = d == 2 ? 0.71 : 1.23;
        s->shapes[0].type = PD_SHAPE_BALL;
        s->shapes[0].radius = 0.533;
        s->desc.solid = &s->shapes[0];
        if (!scene_build(s)) return;
        CHECK_LE(PD_DIM == 1 ? 2 : 12, check_round(s, centre, 0.533, 7, 1.0));
        scene_free(s);
#if PD_DIM > 1
        if (!scene_init(s, m, 0.1, 24, 24, 14)) return;
        s->shapes[0].type = PD_SHAPE_CYLINDER;
        s->shapes[0].axis = 2;
        s->shapes[0].a[0] = s->shapes[0].a[1] = centre[0] = centre[1] = 1.21;
        s->shapes[0].radius = 0.8007;
        s->shapes[1].type = PD_SHAPE_COMPLEMENT;
        s->shapes[1].child_count = 1;
        s->desc.wall = &s->shapes[1];
        if (!scene_build(s)) return;
        CHECK_LE(12, check_round(s, centre, 0.8007, 3, -1.0));
        scene_free(s);
#endif
    }
}

/* ---- memory faults ---- */

/* Stencil, grid, bonds and an update, until the first failure. */
static pd_status build_all(scene *s)
{
    pd_stencil_desc sd;
    int32_t changed[CELLS_MAX], count = 0;
    pd_status status;
    memset(&sd, 0, sizeof sd);
    sd.m = 2.0;
    for (int d = 0; d < PD_DIM; d++) sd.h[d] = 1.0;
    if ((status = pd_stencil_build(&s->ctx, &sd, &s->stencil)) < 0) return status;
    if ((status = pd_grid_build(&s->ctx, &s->stencil, &s->desc, &s->grid)) < 0) return status;
    if ((status = pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) < 0) return status;
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[PD_DIM];
        if (s->grid.kind[node] != PD_SOLID) continue;
        pd_grid_index(&s->grid, node, i);
        if (i[0] % 4 > 1) continue;
        pdi_grid_set_fluid(&s->grid, node);
        changed[count++] = node;
    }
    return pd_bonds_update(&s->ctx, changed, count, &s->bonds);
}

/* A plate that is thinner than a cell, and no multiple of one away from the nodes: bonds end on its surface, whichever
 * way they go through it. */
TEST(thin_plate_off_the_lattice)
{
    scene *s = &test_scene;
    pd_ctx_init(&s->ctx);
    for (int m = 1; m <= 3; m++) {
        int cuts = 0;
        if (!scene_init(s, m, 1.0, 11, 11, 11)) return;
        for (int d = 0; d < PD_DIM; d++) {
            s->desc.side[2 * d] = s->desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
            s->shapes[0].a[d] = d ? 0.0 : 5.15;
            s->shapes[0].b[d] = d ? 11.0 : 5.85;
        }
        s->shapes[0].type = PD_SHAPE_BOX;
        s->desc.solid = &s->shapes[0];
        if (!scene_build(s)) return;
        for (int32_t r = 0; r < s->bonds.rows; r++) {
            double x[PD_DIM], place[PD_DIM];
            pd_grid_position(&s->grid, s->bonds.node[r], x);
            for (int k = 0; k < s->stencil.count; k++) {
                if (pdi_bond_is_open(&s->bonds, r, k)) continue;
                double surface = x[0] < 5.5 ? 5.15 : 5.85;
                CHECK_NEAR(pdi_bond_find_cut_fraction(&s->bonds.paths, s->bonds.node[r], k, place),
                           (surface - x[0]) / s->stencil.xi[k * PD_DIM], 1e-12);
                CHECK_NEAR(place[0], surface, 1e-12);
                cuts++;
            }
            CHECK_INT(s->bonds.near_smooth_surface[r], 0);
        }
        CHECK(cuts > 0);
        scene_free(s);
    }
}

#if PD_DIM > 1
/* A ball about a plane of symmetry of the lattice: bonds and their mirror images end at the same fraction, also those
 * that pass through so little of it that they leave it where the search for the surface begins. */
TEST(mirrored_bonds)
{
    scene *s = &test_scene;
    int cuts = 0;
    double off = 0.0;
    pd_ctx_init(&s->ctx);
    if (!scene_init(s, 3.0, 1e-5, 16, 12, 6)) return;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = d == 0 ? 8e-5 : d == 1 ? 6e-5 : 3e-5;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 2.5e-5;
    s->desc.solid = &s->shapes[0];
    if (!scene_build(s)) return;
    for (int32_t r = 0; r < s->bonds.rows; r++) {
        int i[PD_DIM];
        double place[PD_DIM], t, other;
        pd_grid_index(&s->grid, s->bonds.node[r], i);
        i[1] = 11 - i[1];
        int32_t q = s->bonds.row_of_node[pd_grid_node(&s->grid, i)];
        for (int k = 0; k < s->stencil.count; k++) {
            int far = 0;
            const int *n = s->stencil.offset + k * PD_DIM;
            for (int b = 0; b < s->stencil.count; b++) {
                const int *o = s->stencil.offset + b * PD_DIM;
                int same = o[1] == -n[1];
                for (int d = 0; d < PD_DIM; d += 2) same = same && o[d] == n[d];
                if (same) far = b;
            }
            CHECK_INT(pdi_bond_is_open(&s->bonds, r, k), pdi_bond_is_open(&s->bonds, q, far));
            if (pdi_bond_is_open(&s->bonds, r, k)) continue;
            t = pdi_bond_find_cut_fraction(&s->bonds.paths, s->bonds.node[r], k, place);
            other = pdi_bond_find_cut_fraction(&s->bonds.paths, s->bonds.node[q], far, place);
            off = fmax(off, fabs(t - other));
            cuts++;
        }
    }
    CHECK(cuts > 100);
    CHECK_LE(off, 1e-9);
    scene_free(s);
}
#define OF_MIRRORS ENTRY(mirrored_bonds)
#else
#define OF_MIRRORS
#endif

TEST(memory_faults)
{
    scene *s = &test_scene;
    pd_status status = PD_ERR_MEMORY;
    int tried = 0;
    while (status < 0 && tried < 200) {
        fault f;
        pd_ctx_init(&s->ctx);
        if (!scene_init(s, 2.0, 1.0, PD_DIM == 1 ? 900 : 24, 16, 8)) return;
        pd_stencil_free(&s->ctx, &s->stencil);
        s->shapes[0].type = PD_SHAPE_BOX; /* all solid but a strip at the start of axis 0 */
        for (int d = 0; d < PD_DIM; d++) s->shapes[0].b[d] = s->desc.hi[d];
        s->shapes[0].a[0] = 2.0;
        s->desc.solid = &s->shapes[0];
        fault_context(&f, ++tried, 0, &s->ctx);
        status = build_all(s);
        if (status < 0) CHECK_INT(status, PD_ERR_MEMORY);
        else CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
        scene_free(s);
        CHECK_INT(f.live, 0);
        CHECK_INT(f.wrong, 0);
    }
    CHECK_INT(status, PD_OK);
    CHECK(tried > 25);
}

#if PD_DIM == 1
#define OF_DIM ENTRY(flat_wall_by_hand)
#else
#define OF_DIM ENTRY(thin_walls_are_tight)
#endif

TEST_MAIN(ENTRY(random_masks) OF_DIM SLOW_ENTRY_IF(PD_DIM == 3, update_equals_fresh) ENTRY(validate_notices)
              ENTRY(validate_notices_one_entry) ENTRY(flat_wall_coefficients) ENTRY(cut_points_on_round_surfaces)
                  ENTRY(thin_plate_off_the_lattice) OF_MIRRORS
                      SLOW_ENTRY_IF(PD_DIM == 3, memory_faults))
