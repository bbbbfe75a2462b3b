/* test_period: bodies whose points repeat along the last axis, against the middle one of many copies.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/body_bonds.h"
#include "solid/precrack.h"
#include "solid/correspondence.h"
#include "solid/microelastic.h"
#include "solid/ordinary_state.h"
#include "test.h"
#include <math.h>

enum { COPIES = 13, MOST = 64, ALL = MOST * COPIES, T = PD_DIM * PD_DIM };

/* One period, or so many copies of it, `side` along axis 0 and `long` along the last axis off each other. */
typedef struct repeat {
    pd_body body;
    pd_correspondence elastic;
    pd_ordinary_state ordinary;
    double position[ALL * PD_DIM], volume[ALL], u[ALL * PD_DIM], force[ALL * PD_DIM], density[ALL];
} repeat;

static pd_ctx ctx;
static repeat one, many;

/* A place of the points of a period: `layers` of them along the last axis, stirred. */
static int places(int layers, double stir, double *x, double *volume, double *u)
{
    uint32_t seed = 7;
    int count = layers;
    for (int d = 0; d < PD_DIM - 1; d++) count *= 4;
    for (int k = 0; k < count; k++) {
        for (int d = 0, rest = k; d < PD_DIM; d++) {
            int n = d == PD_DIM - 1 ? layers : 4;
            x[k * PD_DIM + d] = (rest % n + stir * random_real(&seed)) * 1e-3;
            u[k * PD_DIM + d] = 1e-6 * random_real(&seed);
            rest /= n;
        }
        volume[k] = pow(1e-3, PD_DIM) * (1.0 + stir * random_real(&seed));
    }
    return count;
}

static int build(repeat *r, const pd_body_desc *desc, const pd_precrack *cut)
{
    pd_correspondence_desc elastic;
    pd_ordinary_state_desc ordinary;
    int64_t broken;
    memset(&elastic, 0, sizeof elastic);
    memset(&ordinary, 0, sizeof ordinary);
    elastic.young = ordinary.young = 1e9;
    elastic.poisson = ordinary.poisson = 0.3;
    elastic.detach_singular = ordinary.detach_singular = ordinary.linear = 1;
    if (!CHECK_OK(&ctx, pd_body_build(&ctx, desc, &r->body))) return 0;
    if (cut && !CHECK_OK(&ctx, pd_body_apply_precracks(&ctx, &r->body, cut, 1, &broken))) return 0;
    if (cut) CHECK(broken > 0);
    return CHECK_OK(&ctx, pd_correspondence_build(&ctx, &r->body, &elastic, &r->elastic)) &&
           CHECK_OK(&ctx, pd_ordinary_state_build(&ctx, &r->body, &ordinary, &r->ordinary));
}

/* A period into `one`, its copies into `many`. */
static int both(int layers, double stir, double side, const pd_precrack *cut)
{
    double period[PD_DIM] = {0.0};
    pd_body_desc desc;
    memset(&one, 0, sizeof one);
    memset(&many, 0, sizeof many);
    memset(&desc, 0, sizeof desc);
    int count = places(layers, stir, one.position, one.volume, one.u);
    if (PD_DIM > 1) period[0] = side * 1e-3;
    period[PD_DIM - 1] = layers * 1e-3;
    for (int k = 0; k < count * COPIES; k++) {
        many.volume[k] = one.volume[k % count];
        for (int d = 0; d < PD_DIM; d++) {
            many.position[k * PD_DIM + d] = one.position[k % count * PD_DIM + d] + (k / count - COPIES / 2) * period[d];
            many.u[k * PD_DIM + d] = one.u[k % count * PD_DIM + d];
        }
    }
    desc.horizon = 2.2e-3;
    desc.spacing = stir > 0.0 ? 0.0 : 1e-3;
    desc.count = count * COPIES;
    desc.position = many.position;
    desc.volume = many.volume;
    if (!build(&many, &desc, cut)) return 0;
    desc.count = count;
    desc.position = one.position;
    desc.volume = one.volume;
    memcpy(desc.period, period, sizeof period);
    return build(&one, &desc, cut);
}

static void end(repeat *r)
{
    pd_ordinary_state_free(&ctx, &r->ordinary);
    pd_correspondence_free(&ctx, &r->elastic);
    pd_body_free(&ctx, &r->body);
}

/* Forces and energy densities of both materials are those of the middle copy, and so are its bonds. */
static void compare(void)
{
    int32_t count = one.body.count, middle = count * (COPIES / 2);
    for (int kind = 0; kind < 2; kind++) {
        pd_material_interface a =
            kind ? pd_ordinary_state_material(&one.ordinary) : pd_correspondence_material(&one.elastic);
        pd_material_interface b =
            kind ? pd_ordinary_state_material(&many.ordinary) : pd_correspondence_material(&many.elastic);
        double most = 0.0, off = 0.0, energy = 0.0;
        CHECK_OK(&ctx, a.force(&ctx, a.self, one.u, one.force));
        CHECK_OK(&ctx, b.force(&ctx, b.self, many.u, many.force));
        for (int32_t k = 0; k < count * PD_DIM; k++) {
            most = fmax(most, fabs(one.force[k]));
            off = fmax(off, fabs(one.force[k] - many.force[middle * PD_DIM + k]));
        }
        CHECK(most > 0.0 || (PD_DIM == 1 && count == 1)); /* which does not strain */
        CHECK_LE(off, 1e-11 * most);
        a.density(&ctx, a.self, one.u, one.density);
        b.density(&ctx, b.self, many.u, many.density);
        for (int32_t i = 0; i < count; i++) {
            CHECK_REL(one.density[i], many.density[middle + i], 1e-11);
            energy += one.volume[i] * one.density[i];
        }
        CHECK_REL(a.energy(&ctx, a.self, one.u), energy, 1e-12);
    }
    for (int32_t i = 0; i < count; i++) {
        CHECK_INT(one.body.first_bond[i + 1] - one.body.first_bond[i],
                  many.body.first_bond[middle + i + 1] - many.body.first_bond[middle + i]);
        CHECK_INT(pdi_body_bonds_count_intact(&one.body, i), pdi_body_bonds_count_intact(&many.body, middle + i));
        pd_bond_iterator far = pd_body_bonds_begin(&many.body, middle + i);
        for (pd_bond_iterator b = pd_body_bonds_begin(&one.body, i);
             pd_body_bonds_next(&b) && pd_body_bonds_next(&far);) {
            double xi[PD_DIM], back[PD_DIM], copy[PD_DIM];
            pd_bond_iterator other = pd_body_bonds_begin(&one.body, b.neighbour);
            while (pd_body_bonds_next(&other) && other.number < pdi_body_bonds_find_reverse(&one.body, i, &b)) continue;
            CHECK_INT(b.neighbour, far.neighbour % count);
            CHECK_INT(other.neighbour, i);
            CHECK_INT(pd_body_bond_is_broken(&b), pd_body_bond_is_broken(&other));
            CHECK_INT(pd_body_bond_is_broken(&b), pd_body_bond_is_broken(&far));
            pdi_body_bond_vector(&one.body, i, &b, xi);
            pdi_body_bond_vector(&one.body, b.neighbour, &other, back);
            pdi_body_bond_vector(&many.body, middle + i, &far, copy);
            for (int d = 0; d < PD_DIM; d++) {
                CHECK_NEAR(xi[d], -back[d], 0.0);
                CHECK_NEAR(xi[d], copy[d], 1e-15);
            }
        }
    }
    end(&one);
    end(&many);
    CHECK_INT(ctx.in_use, 0);
}

/* Layers of which a family has several images, and more layers than a family has; points of a lattice and others;
 * copies that stand behind each other, and that are shifted. */
TEST(copies)
{
    pd_ctx_init(&ctx);
    for (int k = 0; k < 8; k++)
        if (both(k & 1 ? 4 : 1, k & 2 ? 0.2 : 0.0, k & 4 ? 1.0 : 0.0, NULL)) compare();
}

#if PD_DIM > 1
/* A crack along the period. */
TEST(cracks)
{
    double far = 0.1, corner[4 * PD_DIM] = {0.0};
    pd_precrack cut = {PD_DIM == 3 ? 4 : 2, corner};
    for (int k = 0; k < cut.corners; k++) {
        corner[k * PD_DIM] = 1.5e-3;
        corner[k * PD_DIM + PD_DIM - 1] = k == 0 || k == 3 ? -far : far;
        if (PD_DIM == 3) corner[k * PD_DIM + 1] = k < 2 ? -far : 1.7e-3;
    }
    pd_ctx_init(&ctx);
    if (both(1, 0.0, 0.0, &cut)) compare();
    if (both(4, 0.0, 0.0, &cut)) compare();
}
#endif

TEST(refused)
{
    pd_body_desc desc;
    pd_microelastic_desc springs;
    pd_microelastic metal;
    memset(&desc, 0, sizeof desc);
    memset(&springs, 0, sizeof springs);
    pd_ctx_init(&ctx);
    desc.count = places(4, 0.0, one.position, one.volume, one.u);
    desc.position = one.position;
    desc.volume = one.volume;
    desc.horizon = 2e-3;
    desc.spacing = 1e-3;
    desc.period[PD_DIM - 1] = 3e-3; /* as long as the points are */
    CHECK_INT(pd_body_build(&ctx, &desc, &one.body), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "points that repeat after 0.003 m") != NULL);
    desc.period[PD_DIM - 1] = -4e-3;
    CHECK_INT(pd_body_build(&ctx, &desc, &one.body), PD_ERR_ARGUMENT);
    desc.period[PD_DIM - 1] = 4e-3;
    CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &one.body));
    springs.young = 1e9;
    CHECK_INT(pd_microelastic_build(&ctx, &one.body, &springs, &metal), PD_ERR_ARGUMENT);
    pd_body_free(&ctx, &one.body);
    CHECK_INT(ctx.in_use, 0);
}

#if PD_DIM > 1
TEST_MAIN(ENTRY(copies) ENTRY(cracks) ENTRY(refused))
#else
TEST_MAIN(ENTRY(copies) ENTRY(refused))
#endif
