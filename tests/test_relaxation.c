/* test_relaxation: damped motion comes to rest where conjugate gradients do.
 * dims: 1 2 3 */
#include "solid/elastic.h"
#include "solid/microelastic.h"
#include "solid/relaxation.h"
#include "test.h"
#include <math.h>

#define MOST 4000 /* points */

typedef struct bar_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_elastic elastic;
    pd_microelastic springs;
    pd_solid solid;
    double position[MOST * PD_DIM], volume[MOST], load[MOST * PD_DIM], u[MOST * PD_DIM];
    uint8_t held[MOST * PD_DIM];
} bar_case;

static bar_case test_case;

/* A bar of n cells of 1, held at its left end; stiff 1: springs. */
static bar_case *bar(const int *n, int springs)
{
    bar_case *c = &test_case;
    pd_elastic_desc elastic;
    pd_microelastic_desc spring;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    c->desc.count = 1;
    for (int d = 0; d < PD_DIM; d++) c->desc.count *= n[d];
    if (!CHECK(c->desc.count <= MOST)) return NULL;
    for (int32_t k = 0; k < c->desc.count; k++) {
        for (int32_t d = 0, rest = k; d < PD_DIM; rest /= n[d], d++) c->position[k * PD_DIM + d] = rest % n[d];
        c->volume[k] = 1.0;
        if (c->position[k * PD_DIM] < 2.0) memset(c->held + k * PD_DIM, 1, PD_DIM);
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = 2.0;
    c->desc.spacing = 1.0;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return NULL;
    memset(&elastic, 0, sizeof elastic);
    memset(&spring, 0, sizeof spring);
    elastic.young = spring.young = 1.0;
    elastic.poisson = 0.3;
    elastic.plane = spring.plane = PD_PLANE_STRESS;
    if (springs) {
        if (!CHECK_OK(&c->ctx, pd_microelastic_build(&c->ctx, &c->body, &spring, &c->springs))) return NULL;
        c->solid = pd_microelastic_solid(&c->springs);
    } else {
        if (!CHECK_OK(&c->ctx, pd_elastic_build(&c->ctx, &c->body, &elastic, &c->elastic))) return NULL;
        c->solid = pd_elastic_solid(&c->elastic);
    }
    return c;
}

static void end(bar_case *c)
{
    pd_elastic_free(&c->ctx, &c->elastic);
    pd_microelastic_free(&c->ctx, &c->springs);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

/* Pulled and bent at the right end. */
static void pull(bar_case *c, int length, double along, double across)
{
    for (int32_t i = 0; i < c->body.count; i++) {
        if (c->position[i * PD_DIM] < length - 1.5) continue;
        c->load[i * PD_DIM] = along;
        if (PD_DIM > 1) c->load[i * PD_DIM + 1] = across;
    }
}

TEST(same_rest)
{
    static double kept[MOST * PD_DIM];
    static const int shape[2][3] = {{31, 15, 1}, {20, 5, 5}};
    for (int springs = 0; springs < 2; springs++) {
        const int *n = shape[PD_DIM == 3];
        pd_equilibrium_desc desc;
        pd_equilibrium_result cg, adr;
        bar_case *c = bar(n, springs);
        if (!c) return;
        memset(&desc, 0, sizeof desc);
        desc.held = c->held;
        pull(c, n[0], 1e-3, 1e-4);
        CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &cg));
        memcpy(kept, c->u, sizeof kept);
        memset(c->u, 0, sizeof c->u);
        CHECK_OK(&c->ctx, pd_relaxation_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &adr));
        double off = 0.0, most = 0.0;
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) {
            off = fmax(off, fabs(c->u[k] - kept[k]));
            most = fmax(most, fabs(kept[k]));
        }
        NOTE("%s: %d iterations in %d steps, %d by motion with %d starts, residuals %.1e, %.1e, differ by %.1e",
             c->solid.name, cg.iterations, cg.steps, adr.iterations, adr.steps, cg.residual, adr.residual, off / most);
        CHECK_LE(off, 1e-6 * most);
        end(c);
    }
}
TEST_MAIN(ENTRY(same_rest))
