/* grid: numbering, kinds, ghosts, dissolving nodes, refused input.
 * dims: 1 2 3 */
#include "lattice/grid.h"
#include "random.h"
#include "test.h"

#define H 0.25

typedef struct scene {
    pd_ctx ctx;
    pd_stencil stencil;
    pd_grid_desc desc;
    pd_shape shapes[4];
    pd_grid grid;
} scene;

static scene test_scene;

/* A box of n[] cells around the origin, walls all round, no shape yet. */
static int scene_init(scene *s, double m, const int *n)
{
    pd_stencil_desc sd;
    memset(s, 0, sizeof *s);
    memset(&sd, 0, sizeof sd);
    pd_ctx_init(&s->ctx);
    sd.m = m;
    s->desc.shapes = s->shapes;
    for (int d = 0; d < PD_DIM; d++) {
        sd.h[d] = H * (d + 1);
        s->desc.lo[d] = -0.5 * n[d] * sd.h[d];
        s->desc.hi[d] = 0.5 * n[d] * sd.h[d];
    }
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &sd, &s->stencil));
}

static pd_status scene_build(scene *s) { return pd_grid_build(&s->ctx, &s->stencil, &s->desc, &s->grid); }

static void scene_free(scene *s)
{
    pd_grid_free(&s->ctx, &s->grid);
    pd_grid_free(&s->ctx, &s->grid); /* twice is allowed */
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT(s->ctx.in_use, 0);
}

static void set_cells(int *n, int x, int y, int z)
{
    int all[3];
    all[0] = x;
    all[1] = y;
    all[2] = z;
    for (int d = 0; d < PD_DIM; d++) n[d] = all[d];
}

/* A box shape of whole cells, given by its first and last cell. */
static void cells_box(const scene *s, const int *first, const int *last, pd_shape *shape)
{
    memset(shape, 0, sizeof *shape);
    shape->type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        shape->a[d] = s->desc.lo[d] + first[d] * s->stencil.h[d];
        shape->b[d] = s->desc.lo[d] + (last[d] + 1) * s->stencil.h[d];
    }
}

TEST(numbering)
{
    scene *s = &test_scene;
    int n[PD_DIM], i[PD_DIM];
    set_cells(n, 7, 5, 4);
    if (!scene_init(s, 2.0, n) || !CHECK_OK(&s->ctx, scene_build(s))) return;
    pd_grid *g = &s->grid;
    int64_t total = 1, inside = 1;
    for (int d = 0; d < PD_DIM; d++) {
        CHECK_INT(g->n[d], n[d]);
        CHECK_INT(g->padded[d], n[d] + 4);
        total *= n[d] + 4;
        inside *= n[d];
    }
    CHECK_INT(g->total, total);
    CHECK_INT(g->fluid_count, inside);
    CHECK_INT(g->ghost, 2);
    for (int32_t node = 0; node < g->total; node++) {
        double x[PD_DIM];
        int within = 1, rest = node;
        pd_grid_index(g, node, i);
        pd_grid_position(g, node, x);
        CHECK_INT(pd_grid_node(g, i), node);
        for (int d = 0; d < PD_DIM; d++) {
            CHECK_INT(i[d], rest % (n[d] + 4) - 2); /* axis 0 fastest */
            rest /= n[d] + 4;
            CHECK_NEAR(x[d], (i[d] + 0.5 - 0.5 * n[d]) * H * (d + 1), 1e-14);
            within = within && fabs(x[d]) < 0.5 * n[d] * H * (d + 1);
        }
        CHECK_INT(pd_grid_is_inside(g, i), within);
        CHECK_INT(g->kind[node] == PD_FLUID, within);
    }
    scene_free(s);
}

/* Inside the wall: wall; else inside the solid: solid; else fluid. */
TEST(kinds_follow_shapes)
{
    scene *s = &test_scene;
    int n[PD_DIM];
    set_cells(n, 24, 16, 10);
    if (!scene_init(s, 3.0, n)) return;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].a[0] = 0.3;
    s->shapes[0].radius = 1.1;
    s->shapes[1].type = PD_SHAPE_HALF_SPACE;
    s->shapes[1].a[0] = -0.4;
    s->shapes[1].b[0] = 2.0;
    s->desc.solid = &s->shapes[0];
    s->desc.wall = &s->shapes[1];
    if (!CHECK_OK(&s->ctx, scene_build(s))) return;
    int64_t count[6] = {0, 0, 0, 0, 0, 0};
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[PD_DIM], expected;
        double x[PD_DIM], r2 = 0.0;
        pd_grid_index(&s->grid, node, i);
        count[s->grid.kind[node]]++;
        if (!pd_grid_is_inside(&s->grid, i)) continue;
        pd_grid_position(&s->grid, node, x);
        for (int d = 0; d < PD_DIM; d++) r2 += (x[d] - s->shapes[0].a[d]) * (x[d] - s->shapes[0].a[d]);
        expected = x[0] < -0.4 ? PD_WALL : r2 <= 1.21 ? PD_SOLID : PD_FLUID;
        CHECK(s->grid.kind[node] == expected || (expected == PD_WALL && s->grid.kind[node] == PD_INACTIVE));
    }
    for (int k = 0; k < 6; k++) CHECK_INT(pdi_grid_count_kind(&s->grid, (pd_kind)k), count[k]);
    CHECK_INT(s->grid.fluid_count, count[PD_FLUID]);
    CHECK_INT(s->grid.solid_count, count[PD_SOLID]);
    CHECK(count[PD_FLUID] > 0 && count[PD_SOLID] > 0 && count[PD_WALL] > 0 && count[PD_INACTIVE] > 0);
    scene_free(s);
}

/* A node owns nothing exactly when it is closed for good and no fluid or solid node reaches it. */
static void check_outside(const scene *s)
{
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[PD_DIM], reached = 0;
        if (s->grid.kind[node] != PD_INACTIVE && s->grid.kind[node] != PD_WALL) continue;
        pd_grid_index(&s->grid, node, i);
        for (int k = 0; k < s->stencil.count && !reached; k++) {
            int j[PD_DIM];
            for (int d = 0; d < PD_DIM; d++) j[d] = i[d] + s->stencil.offset[k * PD_DIM + d];
            if (!pd_grid_is_inside(&s->grid, j)) continue;
            uint8_t kind = s->grid.kind[pd_grid_node(&s->grid, j)];
            reached = kind == PD_FLUID || kind == PD_SOLID;
        }
        CHECK_INT(s->grid.kind[node], reached ? PD_WALL : PD_INACTIVE);
    }
}

/* The axis of the only side that index i lies behind; -1: inside; -2: behind an edge or corner. */
static int behind(const pd_grid *g, const int *i)
{
    int axis = -1;
    for (int d = 0; d < PD_DIM; d++)
        if (i[d] < 0 || i[d] >= g->n[d]) axis = axis == -1 ? d : -2;
    return axis;
}

/* Ghosts as the header has it: those of inlets and outlets are open where their mirror is fluid, edges and corners
 * never. */
static void check_ghosts(const scene *s)
{
    const pd_grid *g = &s->grid;
    for (int32_t node = 0; node < g->total; node++) {
        int i[PD_DIM], image[PD_DIM];
        uint8_t expected = PD_WALL;
        pd_grid_index(g, node, i);
        int axis = behind(g, i);
        if (axis == -1) continue;
        if (axis >= 0) {
            int up = i[axis] >= g->n[axis], layer = up ? i[axis] - g->n[axis] : -1 - i[axis];
            pd_side side = g->side[2 * axis + up];
            memcpy(image, i, sizeof i);
            layer %= 2 * g->n[axis]; /* a thin box is mirrored more than once */
            if (layer >= g->n[axis]) layer = 2 * g->n[axis] - 1 - layer;
            image[axis] = up ? g->n[axis] - 1 - layer : layer;
            CHECK_INT(pd_grid_find_source(g, node, NULL), pd_grid_node(g, image));
            int fluid = g->kind[pd_grid_node(g, image)] == PD_FLUID;
            if (side == PD_SIDE_OUTLET && fluid) expected = PD_OUTLET;
            if (side == PD_SIDE_INLET && fluid) expected = PD_INLET;
        }
        CHECK(g->kind[node] == expected || (expected == PD_WALL && g->kind[node] == PD_INACTIVE));
    }
}

/* Inlet at x-, outlet at x+ (and at the last axis, upper side); a solid that touches both, with a hole behind its
 * first layer at the inlet. */
static int build_ported(scene *s, double m, const int *n)
{
    int first[PD_DIM], last[PD_DIM];
    if (!scene_init(s, m, n)) return 0;
    s->desc.side[0] = PD_SIDE_INLET;
    s->desc.side[1] = PD_SIDE_OUTLET;
    s->desc.side[2 * PD_DIM - 1] = PD_SIDE_OUTLET;
    for (int d = 0; d < PD_DIM; d++) {
        first[d] = 0;
        last[d] = d == 0 ? 0 : n[d] / 2;
    }
    cells_box(s, first, last, &s->shapes[0]);
    first[0] = n[0] - 2;
    last[0] = n[0] - 1;
    cells_box(s, first, last, &s->shapes[1]);
    s->shapes[2].type = PD_SHAPE_UNION;
    s->shapes[2].child[1] = 1;
    s->shapes[2].child_count = 2;
    s->desc.solid = &s->shapes[2];
    return CHECK_OK(&s->ctx, scene_build(s));
}

TEST(ghosts)
{
    scene *s = &test_scene;
    int n[PD_DIM];
    set_cells(n, 12, 9, 8);
    if (!build_ported(s, 3.0, n)) return;
    check_ghosts(s);
    check_outside(s);
#if PD_DIM > 1
    CHECK(pdi_grid_count_kind(&s->grid, PD_INLET) > 0);
#endif
    CHECK(pdi_grid_count_kind(&s->grid, PD_OUTLET) > 0);
    scene_free(s);
}

/* Fewer cells than ghost layers, down to one node. */
TEST(smaller_than_the_horizon)
{
    scene *s = &test_scene;
    for (int cells = 1; cells <= 5; cells++)
        for (int m = 1; m <= (PD_DIM == 3 ? 4 : 6); m++) {
            int n[PD_DIM];
            set_cells(n, cells, 1, cells);
            if (!scene_init(s, m, n)) return;
            s->desc.side[0] = PD_SIDE_INLET;
            s->desc.side[1] = PD_SIDE_OUTLET;
            if (!CHECK_OK(&s->ctx, scene_build(s))) return;
            CHECK_INT(s->grid.fluid_count, PD_DIM == 3 ? cells * cells : cells);
            check_ghosts(s);
            check_outside(s);
            scene_free(s);
        }
}

/* Kinds after dissolving node by node against those of a grid that never had the nodes. */
TEST(dissolve_equals_fresh)
{
    static uint8_t mask[4096];
    scene *s = &test_scene;
    uint32_t state = 7;
    int n[PD_DIM], cells = 1;
    set_cells(n, 9, 8, 7);
    for (int d = 0; d < PD_DIM; d++) cells *= n[d];
    for (int round = 0; round < 6; round++) {
        pd_grid fresh;
        if (!scene_init(s, 3.0, n)) return;
        for (int c = 0; c < cells; c++) mask[c] = next_random(&state) % 3 > 0;
        mask[0] = 1;
        s->desc.side[0] = PD_SIDE_INLET;
        s->desc.side[2 * PD_DIM - 1] = PD_SIDE_OUTLET;
        s->shapes[0].type = PD_SHAPE_VOXELS;
        s->shapes[0].mask = mask;
        for (int d = 0; d < PD_DIM; d++) {
            s->shapes[0].a[d] = s->desc.lo[d];
            s->shapes[0].b[d] = s->stencil.h[d];
            s->shapes[0].mask_size[d] = n[d];
        }
        s->desc.solid = &s->shapes[0];
        if (!CHECK_OK(&s->ctx, scene_build(s))) return;
        for (int c = cells - 1; c > 0; c--) {
            int i[PD_DIM];
            if (!mask[c] || next_random(&state) % 2) continue;
            for (int d = 0, rest = c; d < PD_DIM; d++, rest /= n[d - 1]) i[d] = rest % n[d];
            mask[c] = 0;
            pdi_grid_set_fluid(&s->grid, pd_grid_node(&s->grid, i));
        }
        if (!CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->desc, &fresh))) return;
        CHECK_INT(s->grid.fluid_count, fresh.fluid_count);
        CHECK_INT(s->grid.solid_count, fresh.solid_count);
        CHECK_INT(pdi_grid_count_kind(&s->grid, PD_FLUID), fresh.fluid_count);
        for (int32_t node = 0; node < fresh.total; node++) {
            int closed = s->grid.kind[node] == PD_WALL || s->grid.kind[node] == PD_INACTIVE;
            int fresh_closed = fresh.kind[node] == PD_WALL || fresh.kind[node] == PD_INACTIVE;
            CHECK(s->grid.kind[node] == fresh.kind[node] || (closed && fresh_closed));
        }
        check_ghosts(s);
        pd_grid_free(&s->ctx, &fresh);
        scene_free(s);
    }
}

static void check_refused(scene *s, pd_status expected, const char *part)
{
    CHECK_INT(scene_build(s), expected);
    CHECK(strncmp(s->ctx.message, "grid: ", 6) == 0);
    if (!CHECK(strstr(s->ctx.message, part) != NULL)) NOTE("%s", s->ctx.message);
    pd_grid_free(&s->ctx, &s->grid);
}

TEST(bad_boxes)
{
    scene *s = &test_scene;
    int n[PD_DIM], last = PD_DIM - 1;
    set_cells(n, 10, 10, 10);
    if (!scene_init(s, 3.0, n)) return;
    double hi = s->desc.hi[last], h = s->stencil.h[last];
    s->desc.hi[last] = hi + 1e-9 * h; /* rounding of the input is no offence */
    CHECK_OK(&s->ctx, scene_build(s));
    CHECK_INT(s->grid.n[last], 10);
    pd_grid_free(&s->ctx, &s->grid);
    s->desc.hi[last] = hi + 0.3 * h;
    check_refused(s, PD_ERR_GEOMETRY, "whole number");
    s->desc.hi[last] = hi + 1e-3 * h;
    check_refused(s, PD_ERR_GEOMETRY, "whole number");
    s->desc.hi[last] = s->desc.lo[last] + 0.2 * h;
    check_refused(s, PD_ERR_GEOMETRY, "whole number");
    s->desc.hi[last] = s->desc.lo[last];
    check_refused(s, PD_ERR_GEOMETRY, "axis");
    s->desc.hi[last] = s->desc.lo[last] - h;
    check_refused(s, PD_ERR_GEOMETRY, "axis");
    s->desc.hi[last] = (double)NAN;
    check_refused(s, PD_ERR_GEOMETRY, "axis");
    s->desc.hi[last] = (double)INFINITY;
    check_refused(s, PD_ERR_GEOMETRY, "axis");
    s->desc.hi[last] = hi;
    s->desc.side[1] = (pd_side)7;
    check_refused(s, PD_ERR_ARGUMENT, "side 1");
    s->desc.side[1] = PD_SIDE_WALL;
#if PD_DIM > 1
    for (int d = 0; d < PD_DIM; d++) s->desc.hi[d] = s->desc.lo[d] + (PD_DIM == 2 ? 40000.0 : 1000.0) * s->stencil.h[d];
    check_refused(s, PD_ERR_SIZE, "nodes");
#endif
    scene_free(s);
}

TEST(bad_shapes)
{
    scene *s = &test_scene;
    int n[PD_DIM];
    set_cells(n, 10, 10, 10);
    if (!scene_init(s, 3.0, n)) return;
    pd_shape *shape = &s->shapes[0];
    s->desc.solid = &s->shapes[0];
    s->desc.shapes = NULL;
    check_refused(s, PD_ERR_ARGUMENT, "array of shapes");
    s->desc.shapes = s->shapes;
    shape->type = PD_SHAPE_BALL;
    shape->radius = 0.9;
    shape->a[PD_DIM - 1] = s->desc.hi[PD_DIM - 1] - 0.5; /* sticks out */
    check_refused(s, PD_ERR_GEOMETRY, "outside");
    shape->a[PD_DIM - 1] = 0.0;
    CHECK_OK(&s->ctx, scene_build(s));
    pd_grid_free(&s->ctx, &s->grid);
    shape->radius = 0.01; /* covers no cell centre */
    check_refused(s, PD_ERR_GEOMETRY, "no node");
    shape->type = PD_SHAPE_CYLINDER;
    shape->radius = 100.0;
    check_refused(s, PD_ERR_GEOMETRY, "outside");
    shape->type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        shape->a[d] = s->desc.lo[d];
        shape->b[d] = s->desc.hi[d];
    }
    CHECK_OK(&s->ctx, scene_build(s)); /* solid up to all sides: nothing but solid is admissible */
    CHECK_INT(s->grid.fluid_count, 0);
    pd_grid_free(&s->ctx, &s->grid);
    s->shapes[1] = *shape;
    s->desc.wall = &s->shapes[1];
    check_refused(s, PD_ERR_GEOMETRY, "no node"); /* the wall comes first */
    s->desc.solid = NULL;
    check_refused(s, PD_ERR_GEOMETRY, "every node");
    scene_free(s);
}

TEST_MAIN(ENTRY(numbering) ENTRY(kinds_follow_shapes) ENTRY(ghosts) ENTRY(smaller_than_the_horizon)
              ENTRY(dissolve_equals_fresh) ENTRY(bad_boxes) ENTRY(bad_shapes))
