/* test_dynamic_relaxation: damped motion comes to rest where conjugate gradients do.
 * dims: 1 2 3 */
#include "solid/correspondence.h"
#include "solid/microelastic.h"
#include "solid/dynamic_relaxation.h"
#include "test.h"
#include <math.h>

#define MOST 4000 /* points */

typedef struct bar_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    pd_microelastic springs;
    pd_material_interface solid;
    double position[MOST * PD_DIM], volume[MOST], load[MOST * PD_DIM], u[MOST * PD_DIM];
    uint8_t held[MOST * PD_DIM];
} bar_case;

static bar_case test_case;

/* A bar of n cells of 1, held at its left end; stiff 1: springs. */
static bar_case *bar(const int *n, int springs)
{
    bar_case *c = &test_case;
    pd_correspondence_desc elastic;
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
        c->solid = pd_microelastic_material(&c->springs);
    } else {
        if (!CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &elastic, &c->elastic))) return NULL;
        c->solid = pd_correspondence_material(&c->elastic);
    }
    return c;
}

static void end(bar_case *c)
{
    pd_correspondence_free(&c->ctx, &c->elastic);
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

/* Displacements are those of Newton's method. */
TEST(same_rest)
{
    static double kept[MOST * PD_DIM];
    static const int shape[2][3] = {{31, 15, 1}, {14, 4, 4}};
    for (int springs = 0; springs < 2; springs++) {
        const int *n = shape[PD_DIM == 3];
        pd_equilibrium_desc desc;
        pd_equilibrium_result cg, adr;
        bar_case *c = bar(n, springs);
        if (!c) return;
        memset(&desc, 0, sizeof desc);
        desc.prescribed = c->held;
        pull(c, n[0], 1e-3, 1e-4);
        CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &cg));
        memcpy(kept, c->u, sizeof kept);
        memset(c->u, 0, sizeof c->u);
        CHECK_OK(&c->ctx, pd_dynamic_relaxation_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &adr));
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
/* Threads do not matter, to the last bit. */
TEST(threads)
{
    static double kept[MOST * PD_DIM];
    int n[3] = {PD_DIM == 1 ? 300 : 40, PD_DIM == 3 ? 5 : PD_DIM == 2 ? 20 : 1, 5}, steps = 0;
    for (int run = 0; run < 2; run++) {
        pd_equilibrium_desc desc;
        pd_equilibrium_result result;
        bar_case *c = bar(n, 0);
        if (!c) return;
        c->ctx.threads = 1 + run;
        memset(&desc, 0, sizeof desc);
        desc.prescribed = c->held;
        desc.max_iterations = 40;
        pull(c, n[0], 1e-3, 1e-4);
        CHECK_INT(pd_dynamic_relaxation_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &result), PD_NOT_CONVERGED);
        if (!run) memcpy(kept, c->u, sizeof kept);
        else CHECK(memcmp(kept, c->u, sizeof kept) == 0 && steps == result.iterations);
        steps = result.iterations;
        end(c);
    }
}

/* A bar of springs under pressure, pushed sideways, too: both methods find the same rest. */
TEST(pressure)
{
    int n[3] = {20, PD_DIM == 1 ? 1 : 5, 4};
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    double energy[2];
    bar_case *c = bar(n, 1);
    if (!c) return;
    memset(&desc, 0, sizeof desc);
    desc.prescribed = c->held;
    for (int motion = 0; motion < 2; motion++) {
        for (int32_t i = 0; i < c->body.count; i++) {
            memset(c->u + i * PD_DIM, 0, PD_DIM * sizeof *c->u);
            if (c->position[i * PD_DIM] < 17.5) continue;
            memset(c->held + i * PD_DIM, 1, PD_DIM);
            c->u[i * PD_DIM] = -0.7;
            if (PD_DIM > 1) c->u[i * PD_DIM + 1] = 0.1;
        }
        pd_status status = motion ? pd_dynamic_relaxation_solve(&c->ctx, &c->solid, &desc, NULL, c->u, &result)
                                  : pd_equilibrium_solve(&c->ctx, &c->solid, &desc, NULL, c->u, &result);
        if (!CHECK_OK(&c->ctx, status)) return;
        energy[motion] = c->solid.energy(&c->ctx, c->solid.self, c->u);
        CHECK_LE(result.residual, 1e-10);
        NOTE("%s: %d iterations, %d steps", motion ? "motion" : "Newton", result.iterations, result.steps);
    }
    CHECK_REL(energy[1], energy[0], 1e-9);
    end(c);
}

/* What Newton's method refuses is refused. */
TEST(no_rest)
{
    int n[3] = {12, 5, 4};
    for (int way = 0; way < 4; way++) {
        pd_equilibrium_desc desc;
        pd_equilibrium_result result;
        bar_case *c = bar(n, way == 3);
        if (!c) return;
        memset(&desc, 0, sizeof desc);
        if (way == 0) c->load[3] = NAN;
        if (way == 1) c->u[2] = HUGE_VAL;
        if (way == 2) c->load[0] = 1.0;
        if (way == 3)
            for (int d = 0; d < PD_DIM; d++) c->u[d] = c->position[PD_DIM + d] - c->position[d];
        CHECK_INT(pd_dynamic_relaxation_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &result), PD_ERR_STATE);
        CHECK(strncmp(c->ctx.message, "equilibrium: ", 13) == 0);
        end(c);
    }
    if (PD_DIM == 1) return;
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    int small[3] = {6, 5, 3};
    bar_case *c = bar(small, 0);
    memset(&desc, 0, sizeof desc);
    for (int32_t i = 0; c && i < c->body.count; i++) c->load[i * PD_DIM] = c->position[i * PD_DIM + 1] - 2.0;
    if (!c) return;
    CHECK_INT(pd_dynamic_relaxation_solve(&c->ctx, &c->solid, &desc, c->load, c->u, &result), PD_ERR_DIVERGED);
    NOTE("%s", c->ctx.message);
    end(c);
}

TEST_MAIN(ENTRY(same_rest) ENTRY(threads) ENTRY(pressure) ENTRY(no_rest))
