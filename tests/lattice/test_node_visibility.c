/* node_visibility: lines between metal nodes that leave the metal, against half-spaces and slits of any slope.
 * dims: 1 2 3 */
#include "lattice/node_visibility.h"
#include "random.h"
#include "test.h"

enum { CELLS = PD_DIM == 1 ? 40 : PD_DIM == 2 ? 20 : 11, ALL = 1 << PD_DIM };

/* A box of cells of the width h that begins at `lo`, and its metal: the last one of the shapes. */
typedef struct chord_case {
    pd_ctx ctx;
    pd_stencil stencil;
    pd_grid grid;
    pd_shape shape[6];
} chord_case;

static chord_case test_case;

static int metal(const void *self, const int *cell)
{
    const pd_grid *grid = (const pd_grid *)self;
    return grid->kind[pd_grid_node(grid, cell)] == PD_SOLID;
}

static int stairs(const pd_grid *grid, int32_t node, const int *step)
{
    int from[PD_DIM];
    pd_grid_index(grid, node, from);
    return pdi_node_visibility_has_staircase(from, step, metal, grid);
}

static chord_case *begin(void)
{
    memset(&test_case, 0, sizeof test_case);
    pd_ctx_init(&test_case.ctx);
    return &test_case;
}

/* 0: no node is metal. */
static int fill(chord_case *c, double m, double h, double lo, int shapes)
{
    pd_stencil_desc stencil;
    pd_grid_desc grid;
    memset(&stencil, 0, sizeof stencil);
    memset(&grid, 0, sizeof grid);
    stencil.m = m;
    for (int d = 0; d < PD_DIM; d++) {
        stencil.h[d] = h;
        grid.lo[d] = lo;
        grid.hi[d] = lo + CELLS * h;
    }
    grid.shapes = c->shape;
    grid.solid = &c->shape[shapes - 1];
    if (!CHECK_OK(&c->ctx, pd_stencil_build(&c->ctx, &stencil, &c->stencil))) return 0;
    return pd_grid_build(&c->ctx, &c->stencil, &grid, &c->grid) == PD_OK;
}

static void empty(chord_case *c)
{
    pd_grid_free(&c->ctx, &c->grid);
    pd_stencil_free(&c->ctx, &c->stencil);
}

static void end(chord_case *c) { CHECK_INT(c->ctx.in_use, 0); }

/* Node, place and end of bond k of a node; -1: it leaves the box or does not end in metal. */
static int32_t other(const chord_case *c, int32_t node, int k, int *step, double *x, double *xi)
{
    int at[PD_DIM];
    pd_grid_index(&c->grid, node, at);
    pd_grid_position(&c->grid, node, x);
    for (int d = 0; d < PD_DIM; d++) {
        step[d] = c->stencil.offset[k * PD_DIM + d];
        xi[d] = step[d] * c->grid.h[d];
        at[d] += step[d];
    }
    if (!pd_grid_is_inside(&c->grid, at)) return -1;
    int32_t to = pd_grid_node(&c->grid, at);
    return c->grid.kind[to] == PD_SOLID ? to : -1;
}

/* A shape's side of a plane: its normal, and how far it is from the middle of the box. */
static void plane(pd_shape *s, const double *normal, double middle, double off, double sign)
{
    memset(s, 0, sizeof *s);
    s->type = PD_SHAPE_HALF_SPACE;
    for (int d = 0; d < PD_DIM; d++) {
        s->a[d] = middle + off * normal[d];
        s->b[d] = sign * normal[d];
    }
}

static void join(pd_shape *s, pd_shape_type type, int first, int second)
{
    memset(s, 0, sizeof *s);
    s->type = type;
    s->child_count = 2;
    s->child[0] = first;
    s->child[1] = second;
}

/* Directions along axes, diagonals, and others. */
static void direction(int k, uint32_t *state, double *n)
{
    double length = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        n[d] = k < 3 * ALL ? (double)((k / (1 << d)) % 3 - 1) : random_real(state);
        length += n[d] * n[d];
    }
    if (!(length > 0.0)) n[0] = length = 1.0;
    for (int d = 0; d < PD_DIM; d++) n[d] /= sqrt(length);
}

/* No bond of a half-space leaves it, whatever its slope, by cells and by its surface. */
TEST(half_spaces_lose_no_bond)
{
    chord_case *c = begin();
    uint32_t state = 7;
    for (int k = 0; k < (PD_DIM == 3 ? 60 : 150); k++) {
        double n[PD_DIM], x[PD_DIM], xi[PD_DIM], h = k % 2 ? 1e-3 : 7e-9, lo = h * (k % 3) / 3.0;
        int step[PD_DIM], lost[2] = {0, 0}, bonds = 0;
        direction(k, &state, n);
        plane(&c->shape[0], n, lo + 0.5 * CELLS * h, h * (k % 7) / 3.0, 1.0);
        if (CHECK(fill(c, 1.0 + k % 4, h, lo, 1)))
            for (int32_t node = 0; node < c->grid.total; node++)
                for (int b = 0; b < c->stencil.count && c->grid.kind[node] == PD_SOLID; b++) {
                    if (other(c, node, b, step, x, xi) < 0) continue;
                    bonds++;
                    lost[0] += !stairs(&c->grid, node, step);
                    lost[1] += !pdi_node_visibility_is_visible(&c->grid, x, xi);
                }
        CHECK(bonds > 0);
        CHECK_INT(lost[0], 0);
        CHECK_INT(lost[1], 0);
        empty(c);
    }
    end(c);
}

/* Both sides of a slit keep their bonds and none reaches across it: by its surface however thin it is, by cells from
 * the width of a cell on. */
TEST(slits_part_what_is_on_their_sides)
{
    chord_case *c = begin();
    uint32_t state = 7;
    int all = 0;
    for (int k = 0; k < (PD_DIM == 3 ? 60 : 150); k++) {
        double n[PD_DIM], x[PD_DIM], xi[PD_DIM], h = k % 2 ? 1e-3 : 7e-9, lo = h * (k % 3) / 3.0;
        double m = 1.0 + k % 4, wide = k % 5 ? 1.0 + (m - 1.0) * ((k / 5) % 4) / 3.0 : 0.02;
        int step[PD_DIM], wrong[3] = {0, 0, 0}, across = 0;
        direction(k, &state, n);
        plane(&c->shape[0], n, lo + 0.5 * CELLS * h, h * (k % 7) / 3.0, 1.0);
        plane(&c->shape[1], n, lo + 0.5 * CELLS * h, h * ((k % 7) / 3.0 + wide + 1e-6), -1.0);
        join(&c->shape[2], PD_SHAPE_UNION, 0, 1);
        if (CHECK(fill(c, m, h, lo, 3)))
            for (int32_t node = 0; node < c->grid.total; node++)
                for (int b = 0; b < c->stencil.count && c->grid.kind[node] == PD_SOLID; b++) {
                    double y[PD_DIM];
                    int32_t to = other(c, node, b, step, x, xi);
                    if (to < 0) continue;
                    pd_grid_position(&c->grid, to, y);
                    int same =
                        pdi_shape_contains(c->shape, 0, c->grid.h, x) == pdi_shape_contains(c->shape, 0, c->grid.h, y);
                    across += !same;
                    wrong[0] += same != pdi_node_visibility_is_visible(&c->grid, x, xi);
                    wrong[1] += same && !stairs(&c->grid, node, step);
                    wrong[2] += !same && wide >= 1.0 && stairs(&c->grid, node, step);
                }
        all += across > 0;
        for (int e = 0; e < 3; e++) CHECK_INT(wrong[e], 0);
        empty(c);
    }
    CHECK(all > 20);
    end(c);
}

/* A slit that ends: cells part what it parts up to two cells from its end, and no line that passes two cells ahead of
 * it is lost. Both ends of a line see the same. */
TEST(a_notch_parts_up_to_its_end)
{
    chord_case *c = begin();
    for (int k = 0; k < 40 && PD_DIM > 1; k++) {
        double h = k % 2 ? 1e-3 : 7e-9, lo = h * (k % 3) / 3.0, m = 1.0 + k % 4, x[PD_DIM], xi[PD_DIM];
        double tip = lo + (CELLS / 2 + (k % 7) / 7.0) * h, floor_at = lo + (CELLS / 2) * h, wide = (1 + k % 3) * h;
        int step[PD_DIM], back[PD_DIM], wrong[4] = {0, 0, 0, 0}, last = PD_DIM - 1;
        memset(c->shape, 0, 3 * sizeof *c->shape);
        c->shape[0].type = c->shape[1].type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) {
            c->shape[0].a[d] = lo;
            c->shape[0].b[d] = lo + CELLS * h;
            c->shape[1].a[d] = d == last ? floor_at : lo - h;
            c->shape[1].b[d] = d == last ? floor_at + wide : d ? lo + (CELLS + 1) * h : tip;
        }
        join(&c->shape[2], PD_SHAPE_DIFFERENCE, 0, 1);
        if (CHECK(fill(c, m, h, lo, 3)))
            for (int32_t node = 0; node < c->grid.total; node++)
                for (int b = 0; b < c->stencil.count && c->grid.kind[node] == PD_SOLID; b++) {
                    int32_t to = other(c, node, b, step, x, xi);
                    if (to < 0) continue;
                    for (int d = 0; d < PD_DIM; d++) back[d] = -step[d];
                    int stays = stairs(&c->grid, node, step);
                    wrong[0] += stays != stairs(&c->grid, to, back);
                    double at[2], first = 1.0, then = 0.0; /* where the line is between the faces */
                    for (int e = 0; e < 2; e++) {
                        at[e] = -1.0;
                        if (fabs(xi[last]) > 0.0) at[e] = (floor_at + e * wide - x[last]) / xi[last];
                    }
                    first = pd_max(0.0, pd_min(at[0], at[1]));
                    then = pd_min(1.0, pd_max(at[0], at[1]));
                    double low = HUGE_VAL; /* along x there */
                    if (fabs(xi[last]) > 0.0 && first < then)
                        low = pd_min(x[0] + first * xi[0], x[0] + then * xi[0]);
                    wrong[1] += (low < tip - 1e-6 * h) == pdi_node_visibility_is_visible(&c->grid, x, xi) &&
                                !(fabs(low - tip) < 1e-6 * h);
                    double far = pd_max(x[0], x[0] + xi[0]), near = pd_min(x[0], x[0] + xi[0]);
                    int through = (x[last] < floor_at) != (x[last] + xi[last] < floor_at);
                    wrong[2] += through && far < tip - 2.0 * h && stays;
                    wrong[3] += near > tip + 2.0 * h && !stays;
                }
        for (int e = 0; e < 4; e++) CHECK_INT(wrong[e], 0);
        empty(c);
    }
    CHECK(PD_DIM > 0);
    end(c);
}

/* A line grazes a concave corner of cells or cuts it. */
TEST(concave_corners)
{
    chord_case *c = begin();
    double x[PD_DIM], xi[PD_DIM] = {0.0};
    int step[PD_DIM] = {0}, middle = CELLS / 2, at[PD_DIM];
    if (PD_DIM == 1) SKIP("no corner in 1D");
    memset(c->shape, 0, sizeof c->shape);
    for (int k = 0; k < 2; k++) { /* two slabs, along both first axes */
        c->shape[k].type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) {
            c->shape[k].a[d] = 0.0;
            c->shape[k].b[d] = d == k ? (double)middle : (double)CELLS;
        }
    }
    join(&c->shape[2], PD_SHAPE_UNION, 0, 1);
    if (!CHECK(fill(c, 3.0, 1.0, 0.0, 3))) return;
    for (int far = 0; far < 2; far++) {
        for (int d = 0; d < PD_DIM; d++) at[d] = middle - 1;
        at[1] += 1 + far; /* from above the corner to its right */
        step[0] = 1 + far;
        step[1] = -1 - far;
        for (int d = 0; d < PD_DIM; d++) xi[d] = step[d];
        pd_grid_position(&c->grid, pd_grid_node(&c->grid, at), x);
        CHECK_INT(pdi_node_visibility_is_visible(&c->grid, x, xi), !far);
        CHECK_INT(stairs(&c->grid, pd_grid_node(&c->grid, at), step), !far);
    }
    empty(c);
    end(c);
}

TEST_MAIN(ENTRY(half_spaces_lose_no_bond) ENTRY(slits_part_what_is_on_their_sides) ENTRY(a_notch_parts_up_to_its_end)
          ENTRY(concave_corners))
