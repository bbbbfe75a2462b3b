/* bond_surface: which shape a surface at a node is of, and what rows know of surfaces wherever the box is cut.
 * dims: 1 2 3 */
#include "bond_scene.h"

/* Which shape the surface at a node is that of: a ball of metal across a mirror side and a ball of wall each have
 * theirs, ghosts that of their source, and what lies behind a wall side that of the wall. Fluid nodes, and the cells of
 * a mask, have none. */
TEST(shapes_of_surfaces)
{
    scene *s = &test_scene;
    int i[PD_DIM];
    pd_ctx_init(&s->ctx);
    if (!scene_init(s, 2.0, 1.0, 13, 9, 9)) return;
    s->shapes[0].type = s->shapes[1].type = PD_SHAPE_BALL;
    s->shapes[0].radius = s->shapes[1].radius = 2.2;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = s->shapes[1].a[d] = d ? 4.5 : 0.0;
    s->shapes[1].a[0] = 9.5;
    s->desc.solid = &s->shapes[0];
    s->desc.wall = &s->shapes[1];
    s->desc.side[0] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return;
    CHECK(s->grid.solid != s->grid.wall);
    for (int d = 0; d < PD_DIM; d++) i[d] = 4;
    for (i[0] = -2; i[0] < 15; i[0]++) {
        int32_t node = pd_grid_node(&s->grid, i);
        int metal = i[0] < 2, wall = (i[0] > 6 && i[0] < 12) || i[0] == 14; /* the last one is the image of 11 */
        CHECK_INT(pdi_bond_find_surface_shape(&s->grid, node, 0), metal ? s->grid.solid : wall ? s->grid.wall : -1);
        CHECK_INT(pdi_bond_find_surface_shape(&s->grid, node, 1), s->grid.wall);
    }
    scene_free(s);
    if (!scene_init(s, 2.0, 1.0, 13, 9, 9)) return;
    scene_voxels(s);
    memset(s->mask, 1, (size_t)s->cells / 2);
    if (!scene_build(s)) return;
    for (int32_t node = 0; node < s->grid.total; node++)
        for (int walled = 0; walled < 2; walled++) CHECK_INT(pdi_bond_find_surface_shape(&s->grid, node, walled), -1);
    scene_free(s);
}

/* A box from lo to hi along the last axis, from `from` to 9 - from along all others. */
static void slab(pd_shape *shape, double from, double lo, double hi)
{
    shape->type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        shape->a[d] = d == PD_DIM - 1 ? lo : from;
        shape->b[d] = d == PD_DIM - 1 ? hi : 9.0 - from;
    }
}

static void operation(scene *s, int at, pd_shape_type type, int first, int second)
{
    s->shapes[at].type = type;
    s->shapes[at].child[0] = first;
    s->shapes[at].child[1] = second;
    s->shapes[at].child_count = 2;
    s->desc.solid = &s->shapes[at];
}

/* Metal about the middle of the last axis: 0 a box, 1 a box with a pit in it, 2 a ball, 3 a box above the middle alone.
 * cut 0: in a box from -6 to 6; 1: the half of it above a mirror; 2: from 0 to 12 in a periodic box. */
static void middle(scene *s, int metal, int cut)
{
    int a = PD_DIM - 1;
    double low[3] = {-2.0, -3.0, -2.0}, high[3] = {2.0, 3.0, 2.0};
    if (cut == 1) low[0] = low[1] = low[2] = 0.0;
    s->desc.lo[a] = cut ? 0.0 : -6.0;
    s->desc.hi[a] = cut == 2 ? 12.0 : 6.0;
    s->desc.side[2 * a] = s->desc.side[2 * a + 1] = PD_SIDE_PERIODIC;
    if (cut == 1) s->desc.side[2 * a] = s->desc.side[2 * a + 1] = PD_SIDE_MIRROR;
    if (metal == 3) low[0] = 0.0;
    if (metal == 2) {
        s->shapes[0].type = PD_SHAPE_BALL;
        for (int d = 0; d < a; d++) s->shapes[0].a[d] = 4.3;
        s->shapes[0].radius = 2.6;
        s->desc.solid = &s->shapes[0];
        s->shapes[1].type = PD_SHAPE_HALF_SPACE;
        s->shapes[1].b[a] = -1.0;
        s->shapes[2] = s->shapes[0];
        s->shapes[2].a[a] = 12.0;
        if (cut == 1) operation(s, 3, PD_SHAPE_INTERSECT, 0, 1);
        if (cut == 2) operation(s, 3, PD_SHAPE_UNION, 0, 2);
        return;
    }
    int pit = metal == 1;
    slab(&s->shapes[0], 2.0, low[pit], cut == 2 ? fmax(high[pit], 0.0) : high[pit]);
    if (cut == 2) s->shapes[0].a[a] = 0.0;
    s->desc.solid = &s->shapes[0];
    if (pit) {
        slab(&s->shapes[1], 3.0, cut ? 0.0 : low[2], high[2]);
        s->shapes[1].b[0] = 9.0; /* open to one side */
        operation(s, 2, PD_SHAPE_DIFFERENCE, 0, 1);
    }
    if (cut < 2 || metal == 3) return;
    int first = pit ? 2 : 0;
    slab(&s->shapes[3], 2.0, 12.0 - high[pit], 12.0);
    if (pit) {
        slab(&s->shapes[4], 3.0, 12.0 - high[2], 12.0);
        s->shapes[4].b[0] = 9.0;
        operation(s, 5, PD_SHAPE_DIFFERENCE, 3, 4);
    }
    operation(s, 6, PD_SHAPE_UNION, first, pit ? 5 : 3);
}

/* What rows know of the surface is the same wherever the box is cut: metal that ends on a mirror has no surface there,
 * nor where it goes on behind a periodic side. */
TEST(cut_boxes)
{
    static scene cut_scene;
    scene *s = &test_scene, *c = &cut_scene;
    int a = PD_DIM - 1, whole[3] = {9, 9, 9};
    whole[a] = 12;
    for (int metal = 0; metal < 4; metal++)
        for (int cut = 1; cut <= 2; cut++) {
            int part[3] = {9, 9, 9}, rows = 0, other = 0;
            double off = 0.0;
            if ((metal == 3 && cut == 1) || (metal == 1 && PD_DIM == 1)) continue;
            part[a] = cut == 1 ? 6 : 12;
            if (!scene_init(s, 3.0, 1.0, whole[0], whole[1], whole[2])) return;
            middle(s, metal, 0);
            if (!scene_build(s) || !scene_init(c, 3.0, 1.0, part[0], part[1], part[2])) return;
            middle(c, metal, cut);
            if (!scene_build(c)) return;
            for (int32_t i = 0; i < c->grid.total; i++) {
                int at[PD_DIM];
                pd_grid_index(&c->grid, i, at);
                if (!pd_grid_is_inside(&c->grid, at)) continue;
                at[a] = (at[a] + 6) % 12;
                int32_t j = pd_grid_node(&s->grid, at), r = c->bonds.row_of_node[i], q = s->bonds.row_of_node[j];
                CHECK_INT(c->grid.kind[i], s->grid.kind[j]);
                CHECK_INT(r < 0, q < 0);
                if (r < 0 || q < 0) continue;
                rows++;
                other += c->bonds.near_smooth_surface[r] != s->bonds.near_smooth_surface[q];
                for (int w = 0; w < c->bonds.paths.words; w++)
                    other += c->bonds.open_mask[(int64_t)w * c->bonds.capacity + r] !=
                             s->bonds.open_mask[(int64_t)w * s->bonds.capacity + q];
                off = fmax(off, fabs(c->bonds.wall_laplacian[r] / s->bonds.wall_laplacian[q] - 1.0));
                off = fmax(off, fabs(c->bonds.wall_curvature[r] - s->bonds.wall_curvature[q]));
            }
            CHECK(rows > 0);
            CHECK_INT(other, 0);
            CHECK_LE(off, metal == 2 ? 1e-7 : 1e-13); /* round ones by differences */
            scene_free(c);
            scene_free(s);
        }
}

TEST_MAIN(ENTRY(shapes_of_surfaces) ENTRY(cut_boxes))
