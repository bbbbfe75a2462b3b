/* test_ghost: periodic and mirror sides in any combination: kinds, images, signs, and what operators make of them.
 * dims: 1 2 3 */
#include "fixture.h"
#include "lattice/op.h"
#include <math.h>
#include <string.h>

static const int CELLS[3] = {7, 6, 5};
enum { F, V, OUT }; /* fields: a scalar, a vector, what an operator gives */

static pd_status box_try(scene *s, double m, const pd_side *side, const pd_shape *solid)
{
    scene_box(s, m, 1.0, CELLS[0], CELLS[1], CELLS[2]);
    memcpy(s->grid_desc.side, side, sizeof s->grid_desc.side);
    if (solid) {
        s->shapes[0] = *solid;
        s->grid_desc.solid = &s->shapes[0];
    }
    s->fields = 3;
    return scene_try(s);
}

/* Side kinds of the axes from a number: two bits a side. */
static int sides_of(int code, pd_side *side)
{
    static const pd_side kinds[4] = {PD_SIDE_WALL, PD_SIDE_OUTLET, PD_SIDE_MIRROR, PD_SIDE_INLET};
    for (int d = 0; d < PD_DIM; d++) {
        int pick = code % 6;
        code /= 6;
        side[2 * d] = side[2 * d + 1] = PD_SIDE_PERIODIC;
        if (pick == 1) side[2 * d] = side[2 * d + 1] = PD_SIDE_MIRROR;
        if (pick == 2) side[2 * d] = side[2 * d + 1] = PD_SIDE_WALL;
        if (pick > 2) {
            side[2 * d] = kinds[pick - 2];
            side[2 * d + 1] = kinds[pick == 5 ? 1 : 5 - pick];
        }
    }
    return code == 0;
}

/* Where coordinate x of axis d lies in the periodic or mirrored picture, by repeated moves; *sign: of the component. */
static double unfold(const pd_grid *g, int d, double x, int *sign, int *behind)
{
    double lo = g->lo[d], hi = g->hi[d];
    *sign = 1;
    *behind = 0;
    for (int guard = 0; guard < 20 && (x < lo || x > hi); guard++) {
        int up = x > hi;
        pd_side side = g->side[2 * d + up];
        if (side == PD_SIDE_PERIODIC) x += up ? lo - hi : hi - lo;
        else {
            x = 2.0 * (up ? hi : lo) - x;
            if (side == PD_SIDE_MIRROR) *sign = -*sign;
            else *behind = 1 + (int)side;
        }
    }
    return x;
}

static double smooth(const double *x, int c)
{
    double value = 0.3 * (c + 1);
    for (int d = 0; d < PD_DIM; d++) value += (1.0 + 0.5 * d) * x[d] * (c + 1) + 0.1 * x[d] * x[d];
    return value;
}

/* All combinations of sides: each ghost is of the kind, takes the value and has the signs that moving its position back
 * through the sides asks for, whatever the order of the axes. */
TEST(every_combination_of_sides)
{
    pd_side side[2 * PD_DIM];
    for (int code = 0; sides_of(code, side); code++) {
        scene s_, *s = &s_;
        if (!CHECK_OK(&s->ctx, box_try(s, 3.0, side, NULL))) return;
        const pd_grid *g = &s->grid;
        for (int32_t node = 0; node < g->total; node++) {
            double x[PD_DIM];
            s->field[F][node] = -1e30;
            for (int d = 0; d < PD_DIM; d++) s->field[V][d * g->total + node] = -1e30;
            if (g->kind[node] != PD_FLUID) continue;
            pd_grid_position(g, node, x);
            s->field[F][node] = smooth(x, 0);
            for (int d = 0; d < PD_DIM; d++) s->field[V][d * g->total + node] = smooth(x, d + 1);
        }
        pdi_ghosts_set_pressure(&s->bonds.ghosts, 2.0, s->field[F]);
        pd_ghosts_set_vector(&s->bonds.ghosts, s->field[V]);
        int bad = 0, seen = 0;
        for (int32_t node = 0; node < g->total; node++) {
            double x[PD_DIM];
            int sign[PD_DIM], behind[PD_DIM], ports = 0, walls = 0, outlet = -1, inlet = 0, inside = 1;
            pd_grid_position(g, node, x);
            for (int d = 0; d < PD_DIM; d++) {
                inside = inside && x[d] > g->lo[d] && x[d] < g->hi[d];
                x[d] = unfold(g, d, x[d], &sign[d], &behind[d]);
                walls += behind[d] == 1 + PD_SIDE_WALL;
                ports += behind[d] > 1 + PD_SIDE_WALL;
                inlet += behind[d] == 1 + PD_SIDE_INLET;
                if (behind[d] == 1 + PD_SIDE_OUTLET) outlet = d;
            }
            uint8_t kind = g->kind[node], wanted = PD_IMAGE;
            if (inside) wanted = PD_FLUID;
            else if (walls || ports > 1) wanted = PD_WALL;
            else if (ports == 1) wanted = inlet ? PD_INLET : PD_OUTLET;
            if (kind != wanted && !(wanted == PD_WALL && kind == PD_INACTIVE)) bad++;
            if (kind != PD_IMAGE && kind != PD_OUTLET) continue;
            seen++;
            double p = smooth(x, 0);
            if (s->field[F][node] != (kind == PD_OUTLET ? 4.0 - p : p)) bad++;
            for (int d = 0; d < PD_DIM; d++) {
                double want = sign[d] * smooth(x, d + 1);
                if (kind == PD_OUTLET && d != outlet) want = -want;
                if (s->field[V][d * g->total + node] != want) bad++;
            }
        }
        if (!CHECK_INT(bad, 0)) NOTE("combination %d", code);
        CHECK_INT(seen, s->bonds.ghosts.outlets_end);
        CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
        scene_free(s);
    }
}

/* In a periodic or mirrored box every node sees the whole family and needs no row, in boxes thinner than the horizon
 * too. */
TEST(whole_families)
{
    static const double ms[] = {1.0, 2.0, 3.0, 4.5, 9.0};
    for (int k = 0; k < 5; k++)
        for (int mirror = 0; mirror < 2; mirror++) {
            pd_side side[2 * PD_DIM];
            scene s_, *s = &s_;
            if (PD_DIM == 3 && k == 4) continue; /* a million ghosts */
            for (int d = 0; d < 2 * PD_DIM; d++) side[d] = mirror ? PD_SIDE_MIRROR : PD_SIDE_PERIODIC;
            if (!CHECK_OK(&s->ctx, box_try(s, ms[k], side, NULL))) return;
            CHECK_INT(s->bonds.rows, 0);
            int64_t covered = 0;
            for (int32_t r = 0; r < s->bonds.full_ranges.count; r++) covered += s->bonds.full_ranges.length[r];
            CHECK_INT(covered, s->grid.fluid_count);
            scene_free(s);
        }
}

/* Number of a node in a box whose origin has moved by (d + 1) * move cells along axis d. */
static int place_of(const scene *s, int32_t node, int move)
{
    int i[PD_DIM], place = 0;
    pd_grid_index(&s->grid, node, i);
    for (int d = PD_DIM - 1; d >= 0; d--) place = place * CELLS[d] + (i[d] + (d + 1) * move) % CELLS[d];
    return place;
}

/* A field moved by whole cells gives the moved Laplacian, bit for bit, and the sum of it vanishes. */
TEST(periodic_translation)
{
    static double first[7 * 6 * 5];
    pd_side side[2 * PD_DIM];
    scene s_, *s = &s_;
    for (int d = 0; d < 2 * PD_DIM; d++) side[d] = PD_SIDE_PERIODIC;
    if (!CHECK_OK(&s->ctx, box_try(s, 3.0, side, NULL))) return;
    for (int move = 0; move < 4; move++) {
        int different = 0;
        double sum = 0.0, size = 0.0;
        for (int32_t node = 0; node < s->grid.total; node++)
            if (s->grid.kind[node] == PD_FLUID) s->field[F][node] = sin(1.7 * place_of(s, node, move));
        pd_ghosts_set_scalar(&s->bonds.ghosts, s->field[F]);
        pd_op_laplacian(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (s->grid.kind[node] != PD_FLUID) continue;
            int place = place_of(s, node, move);
            if (move == 0) first[place] = s->field[OUT][node];
            different += s->field[OUT][node] != first[place];
            sum += s->field[OUT][node];
            size += fabs(s->field[OUT][node]);
        }
        CHECK_INT(different, 0);
        CHECK_LE(fabs(sum), 1e-14 * size);
    }
    scene_free(s);
}

/* The divergence of bond fluxes sums to zero over a periodic or mirrored box for any velocity: what passes a bond to an
 * image comes back through its partner. */
TEST(fluxes_close)
{
    pd_side side[2 * PD_DIM];
    for (int code = 0; sides_of(code, side); code++) {
        scene s_, *s = &s_;
        double sum = 0.0, size = 0.0;
        int closed = 1;
        for (int d = 0; d < 2 * PD_DIM; d++) closed = closed && !pd_grid_is_inlet_or_outlet(side[d]);
        if (!closed) continue;
        if (!CHECK_OK(&s->ctx, box_try(s, 3.0, side, NULL))) return;
        for (int32_t node = 0; node < s->grid.total; node++)
            for (int d = 0; d < PD_DIM && s->grid.kind[node] == PD_FLUID; d++)
                s->field[V][d * s->grid.total + node] = sin(3.1 * node + d);
        pd_ghosts_set_vector(&s->bonds.ghosts, s->field[V]);
        pd_op_divergence(&s->ctx, &s->bonds, s->field[V], s->field[OUT]);
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (s->grid.kind[node] != PD_FLUID) continue;
            sum += s->field[OUT][node];
            size += fabs(s->field[OUT][node]);
        }
        CHECK(size > 0.0);
        CHECK_LE(fabs(sum), 1e-14 * size);
        scene_free(s);
    }
}

static void check_same_rows(const pd_bonds *a, const pd_bonds *b)
{
    int different = 0;
    if (!CHECK_INT(a->rows, b->rows)) return;
    for (int32_t r = 0; r < a->rows; r++) {
        different += a->node[r] != b->node[r] || a->wall_laplacian[r] != b->wall_laplacian[r];
        for (int w = 0; w < a->paths.words; w++)
            different += a->open_mask[(int64_t)w * a->capacity + r] != b->open_mask[(int64_t)w * b->capacity + r];
    }
    CHECK_INT(different, 0);
    CHECK_INT(a->ghosts.images_end, b->ghosts.images_end);
}

/* A solid that touches periodic and mirror sides: local updates give the rows of a fresh build, images included. */
TEST(solid_at_sides_dissolves)
{
    for (int mirror = 0; mirror < 2; mirror++) {
        pd_side side[2 * PD_DIM];
        pd_shape shape;
        scene s_, *s = &s_;
        memset(&shape, 0, sizeof shape);
        shape.type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) {
            side[2 * d] = side[2 * d + 1] = mirror ? PD_SIDE_MIRROR : PD_SIDE_PERIODIC;
            shape.a[d] = mirror ? -1.0 : 0.0; /* reaches behind the mirror */
            shape.b[d] = 3.0;
        }
        if (!CHECK_OK(&s->ctx, box_try(s, 3.0, side, &shape))) return;
        for (int round = 0; s->grid.solid_count > 0; round++) {
            int32_t gone = -1;
            for (int32_t node = 0; node < s->grid.total; node++)
                if (s->grid.kind[node] == PD_SOLID && (gone < 0 || (node * 7 + round) % 5 == 0)) gone = node;
            pdi_grid_set_fluid(&s->grid, gone);
            if (!CHECK_OK(&s->ctx, pd_bonds_update(&s->ctx, &gone, 1, &s->bonds))) return;
            pd_bonds fresh;
            if (!CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &fresh))) return;
            check_same_rows(&s->bonds, &fresh);
            pd_bonds_free(&s->ctx, &fresh);
        }
        CHECK_INT(s->bonds.rows, 0);
        scene_free(s);
    }
}

/* Behind an inlet a velocity is odd about what the side holds; what lies across the other sides is what it repeats. */
TEST(inlets_are_odd)
{
    scene s;
    pd_side side[2 * PD_DIM];
    double *held = NULL;
    int64_t inlets = 0;
    for (int k = 0; k < 2 * PD_DIM; k++) side[k] = PD_DIM == 3 && k > 3 ? PD_SIDE_PERIODIC : PD_SIDE_MIRROR;
    side[0] = PD_SIDE_INLET;
    side[1] = PD_SIDE_OUTLET;
    if (!CHECK_OK(&s.ctx, box_try(&s, 2.0, side, NULL))) return;
    const pd_ghosts *g = &s.bonds.ghosts;
    inlets = g->inlets_end - g->outlets_end;
    CHECK(inlets > 0);
    if (!CHECK_OK(&s.ctx, PD_NEW(&s.ctx, "test", PD_DIM * inlets, held))) return;
    for (int32_t i = 0; i < PD_DIM * s.grid.total; i++) s.field[V][i] = sin(1.0 + 3.0 * i);
    for (int64_t i = 0; i < PD_DIM * inlets; i++) held[i] = cos(2.0 * (double)i);
    for (int zero = 0; zero < 2; zero++) {
        pd_ghosts_set_vector(g, s.field[V]);
        pdi_ghosts_set_inlet_velocity(g, zero ? NULL : held, s.field[V]);
        for (int64_t k = 0; k < inlets; k++) {
            int32_t ghost = g->node[g->outlets_end + k];
            int i[PD_DIM];
            pd_grid_index(&s.grid, ghost, i);
            i[0] = -1 - i[0]; /* its mirror image along axis 0, behind the same other sides */
            int32_t inner = pd_grid_node(&s.grid, i);
            for (int d = 0; d < PD_DIM; d++) {
                const double *v = s.field[V] + (int64_t)d * s.grid.total;
                double sum = v[ghost] + v[inner];
                CHECK_NEAR(sum, zero ? 0.0 : 2.0 * held[d * inlets + k], 1e-14);
            }
        }
    }
    PD_DELETE(&s.ctx, PD_DIM * inlets, held);
    scene_free(&s);
}

TEST(one_sided_period_is_refused)
{
    pd_side side[2 * PD_DIM];
    scene s_, *s = &s_;
    for (int d = 0; d < 2 * PD_DIM; d++) side[d] = PD_SIDE_WALL;
    side[1] = PD_SIDE_PERIODIC;
    CHECK_INT(box_try(s, 3.0, side, NULL), PD_ERR_ARGUMENT);
    CHECK(strstr(s->ctx.message, "periodic on one side only") != NULL);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
}

TEST_MAIN(ENTRY(every_combination_of_sides) ENTRY(whole_families) ENTRY(periodic_translation) ENTRY(fluxes_close)
          ENTRY(solid_at_sides_dissolves) ENTRY(inlets_are_odd) ENTRY(one_sided_period_is_refused))
