/* test_body: families of a lattice by one table, against those that a search stores; which bonds are broken.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/body_bonds.h"
#include "solid/precrack.h"
#include "solid/finite_strain.h"
#include "solid/microelastic.h"
#include "solid/ordinary_state.h"
#include "test.h"
#include <math.h>

#define MOST 4000 /* points */

/* A body of a lattice with a point that has no bonds, and the same one with that point far off the lattice, so that its
 * families are stored. */
typedef struct pair_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body[2];
    double position[(MOST + 1) * PD_DIM], volume[MOST + 1];
    double u[(MOST + 1) * PD_DIM], du[(MOST + 1) * PD_DIM];
} pair_case;

static pair_case test_case;

static int side(int d) { return (PD_DIM == 1 ? 60 : PD_DIM == 2 ? 22 : 11) - 2 * d; }

/* Points of a box with a hole, in any order where a seed is given. */
static int32_t points(pair_case *c, double h, int hole, uint32_t seed)
{
    int32_t all = 1, count = 0;
    for (int d = 0; d < PD_DIM; d++) all *= side(d);
    for (int32_t k = 0; k < all; k++) {
        double *x = c->position + count * PD_DIM, far = 0.0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= side(d - 1)) {
            x[d] = (rest % side(d) - 0.5 * side(d)) * h;
            far += (x[d] - h) * (x[d] - h);
        }
        count += !hole || far > 5.8 * h * h;
    }
    for (int32_t i = count - 1; seed && i > 0; i--) {
        int32_t j = (int32_t)(random_share(&seed) * (i + 1));
        for (int d = 0; d < PD_DIM; d++) {
            double x = c->position[i * PD_DIM + d];
            c->position[i * PD_DIM + d] = c->position[j * PD_DIM + d];
            c->position[j * PD_DIM + d] = x;
        }
    }
    return count;
}

/* Bonds across a plane are none. */
static int beside(void *user, int32_t i, int32_t j, const double *xi)
{
    const pair_case *c = (const pair_case *)user;
    double plane = 0.3 * c->desc.spacing;
    (void)xi;
    return (c->position[(int64_t)i * PD_DIM] < plane) == (c->position[(int64_t)j * PD_DIM] < plane);
}

static pd_bond_inside_fn joined;

static pair_case *make(double h, double m, pd_partial_volume rim, int hole, uint32_t seed)
{
    pair_case *c = &test_case;
    uint32_t random = 5;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    c->desc.count = points(c, h, hole, seed);
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m * h;
    c->desc.spacing = h;
    c->desc.rim = rim;
    c->desc.joined = joined;
    c->desc.user = c;
    for (int32_t i = 0; i < c->desc.count + 1; i++) {
        c->volume[i] = pow(h, PD_DIM);
        for (int d = 0; d < PD_DIM; d++) {
            c->u[i * PD_DIM + d] = 1e-3 * h * random_real(&random);
            c->du[i * PD_DIM + d] = 1e-3 * h * random_real(&random);
        }
    }
    double *alone = c->position + c->desc.count++ * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) alone[d] = ((d ? 0.0 : side(0) + 5.0) - 0.5 * side(d)) * h;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body[0]))) return NULL;
    alone[0] = 1000.3 * h;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body[1]))) return NULL;
    CHECK_INT(c->body[1].lattice, 0);
    return c;
}

static void end(pair_case *c)
{
    for (int k = 0; k < 2; k++) pd_body_free(&c->ctx, &c->body[k]);
    CHECK_INT(c->ctx.in_use, 0);
}

/* Both bodies have the same bonds, in the same order, and the same of them are broken. */
static void same(const pair_case *c)
{
    static int32_t to[2][MOST];
    static uint8_t broken[2][MOST];
    for (int32_t i = 0; i < c->body[0].count; i++) {
        int32_t n = pd_body_family(&c->body[0], i, to[0], broken[0]);
        if (!CHECK_INT(pd_body_family(&c->body[1], i, to[1], broken[1]), n)) return;
        CHECK_INT(c->body[0].first_bond[i + 1] - c->body[0].first_bond[i], n);
        CHECK(memcmp(to[0], to[1], (size_t)n * sizeof to[0][0]) == 0);
        CHECK(memcmp(broken[0], broken[1], (size_t)n) == 0);
    }
}

/* Families of the table are those that are stored, for horizons of any size, both rims, with a hole, in any order of
 * the points, and where coordinates have no exact multiples. */
TEST(families)
{
    static const double horizons[5] = {1.0, 1.7, 2.0, 2.5, 3.0};
    for (int way = 0; way < 40; way++) {
        double m = horizons[way % 5];
        pair_case *c = make(way & 4 ? 1e-3 / 3.0 : 1.0, m, way & 8 ? PD_PARTIAL_VOLUME_EXACT : PD_PARTIAL_VOLUME_LINEAR,
                            way & 1, way & 2 ? 9u : 0u);
        if (!c) return;
        CHECK(c->body[0].lattice || (2.0 * m - floor(2.0 * m) <= 0.0 && fmod(2.0 * m, 2.0) > 0.0));
        same(c);
        end(c);
    }
}

/* Bonds that leave the body are in no family, neither of the table nor of those that are stored; what breaks is the
 * same in both. */
TEST(bonds_that_leave)
{
    static int32_t to[MOST];
    for (int way = 0; way < 16; way++) {
        double m = 1.0 + way % 4;
        joined = beside;
        pair_case *c =
            make(1e-3, m, way & 8 ? PD_PARTIAL_VOLUME_EXACT : PD_PARTIAL_VOLUME_LINEAR, way & 1, way & 4 ? 9u : 0u);
        joined = NULL;
        if (!c) return;
        same(c);
        int32_t lost = 0, split = -1;
        for (int32_t i = 0; i < c->body[0].count; i++) {
            int32_t n = pd_body_family(&c->body[0], i, to, NULL);
            lost += n < c->body[0].stencil_bonds;
            for (int32_t k = 0; k < n; k++) CHECK(beside(c, i, to[k], NULL));
            for (pd_bond_iterator f = pd_body_bonds_begin(&c->body[0], i); pd_body_bonds_next(&f);) {
                pd_bond_iterator back = pd_body_bonds_begin(&c->body[0], f.neighbour);
                int32_t b = pdi_body_bonds_find(&c->body[0], i, f.neighbour);
                while (back.number < b) pd_body_bonds_next(&back);
                if (b < 0 || back.neighbour != i) split = i;
            }
        }
        CHECK(lost > 0);
        CHECK_INT(split, -1);
        for (int k = 0; k < 2; k++)
            for (int32_t i = 0; i < c->body[k].count; i += 3) pdi_body_bonds_break_all(&c->body[k], i);
        same(c);
        end(c);
    }
}

/* A body of a lattice stores no bond: a bit for each, 4 bytes for each place of the box and its margins, and the rest
 * goes by points. */
TEST(bytes)
{
    for (int m = 1; m <= 3; m++) {
        double places = 1.0, lead = 0.0;
        pair_case *c = make(1e-3, m, PD_PARTIAL_VOLUME_LINEAR, 0, 0);
        if (!c) return;
        end(c);
        int32_t count = --c->desc.count;
        if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body[0]))) return;
        pd_body *body = &c->body[0];
        for (int d = 0; d < PD_DIM; d++) {
            lead += m * places;
            places *= side(d) + m;
        }
        double bytes = (double)count * (8.0 * PD_DIM + 8.0 + 8.0 + 4.0 + 1.0) + (double)body->bonds / 8.0 +
                       4.0 * (places + lead) + 4.0 * body->stencil_bonds;
        NOTE("m = %d: %.1f bytes a point for %.1f bonds", m, (double)c->ctx.in_use / count,
             (double)body->bonds / count);
        CHECK(body->lattice);
        CHECK_LE((double)c->ctx.in_use, bytes + 64.0);
        size_t before = c->ctx.in_use;
        pd_bond_weights weights;
        CHECK_OK(&c->ctx, pdi_bond_weights_build(&c->ctx, body, &weights));
        CHECK_OK(&c->ctx, pdi_bond_weights_compute_influence(&c->ctx, &weights, PD_INFLUENCE_LINEAR));
        CHECK_LE((double)(c->ctx.in_use - before), 4.0 * body->stencil_bonds + 16.0);
        pdi_bond_weights_free(&c->ctx, &weights);
        pd_body_free(&c->ctx, body);
        CHECK_INT(c->ctx.in_use, 0);
    }
}

/* Points that are few in a large box, two at one place, and one a little off its place have no table. */
TEST(no_table)
{
    pair_case *c = make(1e-3, 2.0, PD_PARTIAL_VOLUME_LINEAR, 0, 0);
    if (!c) return;
    end(c);
    c->desc.count = 2;
    c->position[0] = 0.0;
    for (int d = 0; d < PD_DIM; d++) c->position[PD_DIM + d] = c->position[d] + 900e-3;
    CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body[0]));
    CHECK(!c->body[0].lattice && c->body[0].bonds == 0);
    pd_body_free(&c->ctx, &c->body[0]);
    c->desc.count = points(c, 1e-3, 0, 0);
    c->position[7 * PD_DIM] += 1e-9;
    CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body[0]));
    CHECK_INT(c->body[0].lattice, 0);
    pd_body_free(&c->ctx, &c->body[0]);
    memcpy(c->position + 7 * PD_DIM, c->position + 8 * PD_DIM, PD_DIM * sizeof(double));
    CHECK_INT(pd_body_build(&c->ctx, &c->desc, &c->body[0]), PD_ERR_GEOMETRY);
    CHECK(strstr(c->ctx.message, "points 7 and 8") || strstr(c->ctx.message, "points 8 and 7"));
    CHECK_INT(c->ctx.in_use, 0);
}

/* Bonds break at both ends, once; neighbours in the same byte stay. */
TEST(bits)
{
    pair_case *c = make(1e-3, 3.0, PD_PARTIAL_VOLUME_LINEAR, 1, 0);
    if (!c) return;
    CHECK(pd_body_is_intact(&c->body[0]));
    int32_t middle = c->body[0].count / 2, to[MOST], n = pd_body_family(&c->body[0], middle, to, NULL);
    for (int k = 0; k < 2; k++) {
        CHECK_INT(pd_body_break(&c->body[k], middle, to[n / 2]), 1);
        CHECK_INT(pd_body_break(&c->body[k], to[n / 2], middle), 0);
        CHECK_INT(pd_body_break(&c->body[k], middle, middle), 0);
        CHECK_INT(pdi_body_bonds_count_intact(&c->body[k], middle), n - 1);
        CHECK_INT(pdi_body_bonds_break_all(&c->body[k], middle), n - 1);
        CHECK_INT(pdi_body_bonds_count_intact(&c->body[k], middle), 0);
        for (int32_t i = 0; i < n; i++)
            CHECK_INT(pdi_body_bonds_count_intact(&c->body[k], to[i]),
                      c->body[k].first_bond[to[i] + 1] - c->body[k].first_bond[to[i]] - 1);
    }
    CHECK(!pd_body_is_intact(&c->body[0]));
    same(c);
    end(c);
}

/* ---- materials ---- */

typedef struct material_case {
    pd_correspondence elastic;
    pd_finite_strain finite;
    pd_ordinary_state ordinary;
    pd_microelastic springs;
} material_case;

enum { ELASTIC, FINITE, ORDINARY, ORDINARY_ENERGY, SPRINGS, SPRINGS_VOLUME, MATERIALS };

static pd_material_interface material(pair_case *c, pd_body *body, int kind, material_case *m)
{
    pd_material_interface none;
    memset(&none, 0, sizeof none);
    memset(m, 0, sizeof *m);
    if (kind == ELASTIC) {
        pd_correspondence_desc desc;
        memset(&desc, 0, sizeof desc);
        desc.young = 70e9;
        desc.poisson = 0.3;
        desc.influence = PD_INFLUENCE_INVERSE;
        desc.detach_singular = 1;
        CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, body, &desc, &m->elastic));
        return pd_correspondence_material(&m->elastic);
    }
    if (kind == FINITE) {
        pd_finite_strain_desc desc;
        memset(&desc, 0, sizeof desc);
        desc.law.young = 70e9;
        desc.law.poisson = 0.3;
        desc.detach_singular = 1;
        CHECK_OK(&c->ctx, pd_finite_strain_build(&c->ctx, body, &desc, &m->finite));
        return pd_finite_strain_material(&m->finite);
    }
    if (kind == ORDINARY || kind == ORDINARY_ENERGY) {
        pd_ordinary_state_desc desc;
        memset(&desc, 0, sizeof desc);
        desc.young = 70e9;
        desc.poisson = 0.3;
        desc.surface = kind == ORDINARY ? PD_ORDINARY_STATE_POSITION : PD_ORDINARY_STATE_ENERGY;
        desc.detach_singular = 1;
        CHECK_OK(&c->ctx, pd_ordinary_state_build(&c->ctx, body, &desc, &m->ordinary));
        return pd_ordinary_state_material(&m->ordinary);
    }
    pd_microelastic_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.young = 70e9;
    desc.fracture = 1.0;
    desc.surface = kind == SPRINGS ? PD_MICROELASTIC_MOMENTS : PD_MICROELASTIC_VOLUME;
    CHECK_OK(&c->ctx, pd_microelastic_build(&c->ctx, body, &desc, &m->springs));
    return pd_microelastic_material(&m->springs);
}

static void forget(pair_case *c, material_case *m)
{
    if (m->elastic.body) pd_correspondence_free(&c->ctx, &m->elastic);
    if (m->finite.body) pd_finite_strain_free(&c->ctx, &m->finite);
    if (m->ordinary.body) pd_ordinary_state_free(&c->ctx, &m->ordinary);
    if (m->springs.body) pd_microelastic_free(&c->ctx, &m->springs);
}

/* What a material says of the points of the lattice. Returns how many numbers. */
static int64_t look(pair_case *c, const pd_material_interface *solid, double *to)
{
    int64_t n = (int64_t)c->body[0].count * PD_DIM;
    static double all[(MOST + 1) * PD_DIM * PD_DIM];
    double *begin = to;
    CHECK_OK(&c->ctx, solid->force(&c->ctx, solid->self, c->u, all));
    memcpy(to, all, (size_t)n * sizeof *to), to += n;
    solid->tangent(&c->ctx, solid->self, c->du, all);
    memcpy(to, all, (size_t)n * sizeof *to), to += n;
    solid->blocks(&c->ctx, solid->self, all);
    memcpy(to, all, (size_t)n * PD_DIM * sizeof *to), to += n * PD_DIM;
    solid->density(&c->ctx, solid->self, c->u, all);
    memcpy(to, all, (size_t)n / PD_DIM * sizeof *to), to += n / PD_DIM;
    if (solid->stress) solid->stress(&c->ctx, solid->self, c->u, all);
    if (solid->stress) memcpy(to, all, (size_t)n * PD_DIM * sizeof *to), to += n * PD_DIM;
    *to++ = solid->stable_step(solid->self, 2700.0);
    return to - begin;
}

/* All materials of a body of a lattice have the bits of those of a body with stored families, whole, with a cut, and
 * with points that have lost all bonds. */
TEST(materials)
{
    static double found[2][(MOST + 1) * (4 * PD_DIM * PD_DIM + 4)];
    for (int way = 0; way < 2 * MATERIALS; way++) {
        double h = 1e-3 / 3.0;
        material_case m[2];
        pair_case *c = make(h, way % 2 + 2.0, PD_PARTIAL_VOLUME_LINEAR, 1, way < MATERIALS ? 0u : 3u);
        if (!c || !CHECK(c->body[0].lattice)) return;
        pd_material_interface solid[2];
        for (int k = 0; k < 2; k++) solid[k] = material(c, &c->body[k], way % MATERIALS, &m[k]);
        for (int state = 0; state < 3; state++) {
            int64_t n[2];
            for (int k = 0; k < 2; k++) {
                int32_t to[MOST], all = pd_body_family(&c->body[k], 9, to, NULL);
                if (state == 1)
                    for (int32_t b = 0; b < all / 3; b++) pd_body_break(&c->body[k], 9, to[b]);
                if (state == 2) pdi_body_bonds_break_all(&c->body[k], c->body[0].count / 3);
                if (state) CHECK_OK(&c->ctx, solid[k].update(&c->ctx, solid[k].self));
                n[k] = look(c, &solid[k], found[k]);
            }
            CHECK(n[0] == n[1] && memcmp(found[0], found[1], (size_t)n[0] * sizeof **found) == 0);
            same(c);
        }
        for (int k = 0; k < 2; k++) forget(c, &m[k]);
        end(c);
    }
}

/* A bond weighs as much as its ends have bonds. */
static double by_families(const void *self, int32_t i, const pd_bond_iterator *bond)
{
    const pd_body *body = (const pd_body *)self;
    return (double)(body->first_bond[i + 1] - body->first_bond[i] + body->first_bond[bond->neighbour + 1] -
                    body->first_bond[bond->neighbour]);
}

/* Weights that differ beside surfaces: deeper points share those of a whole family, and have no lists. */
TEST(weights_of_the_inside)
{
    pair_case *c = make(1e-3, 1.0, PD_PARTIAL_VOLUME_LINEAR, 0, 0);
    pd_bond_weights weights;
    int64_t longest = 0;
    int inside = 0, deep = 1;
    if (!c) return;
    end(c);
    c->desc.count--;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body[0]))) return;
    const pd_body *body = &c->body[0];
    CHECK(body->lattice);
    CHECK_OK(&c->ctx, pdi_bond_weights_build(&c->ctx, body, &weights));
    CHECK_OK(&c->ctx, pdi_bond_weights_compute(&c->ctx, &weights, by_families, body));
    for (int32_t i = 0; i < body->count; i++)
        if (body->first_bond[i + 1] - body->first_bond[i] > longest)
            longest = body->first_bond[i + 1] - body->first_bond[i];
    for (int32_t i = 0; i < body->count; i++) {
        int whole = 1;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            double weight = by_families(body, i, &f);
            CHECK_NEAR(pdi_bond_weights_get(&weights, i, &f), weight, 0.0);
            whole = whole && weight >= 2.0 * (double)longest;
        }
        inside += whole;
        CHECK(weights.begin != NULL && (weights.begin[i] < 0) == whole);
    }
    for (int d = 0; d < PD_DIM; d++) deep *= side(d) - 4;
    CHECK_INT(inside, deep);
    pdi_bond_weights_free(&c->ctx, &weights);
    end(c);
}

TEST_MAIN(ENTRY(weights_of_the_inside) ENTRY(families) ENTRY(bonds_that_leave) ENTRY(bytes)
              ENTRY(no_table) ENTRY(bits) ENTRY(materials))
