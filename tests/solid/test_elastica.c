/* elastica: a beam that bends by half its length, against the elastica.
 * dims: 2 */
#include "finite_case.h"
#include "solid/equilibrium.h"

static double u[MOST * PD_DIM], other[MOST * PD_DIM];

/* A beam of ten times its depth, clamped at one end, bends by half its length under a dead load at the other:
 * P L^2/(E I) = 2. The elastica (Bisshopp and Drucker 1945, table 1) goes by 0.4935 L across and 0.1606 L back. */
static double elastica(int n, double *back)
{
    static solid_case room;
    static uint8_t held[MOST * PD_DIM];
    solid_case *c = &room;
    pd_finite_strain_desc d = desc_of(0);
    pd_finite_strain f;
    pd_equilibrium_desc q;
    pd_equilibrium_result r;
    double h = 1e-3 / n, across = 0.0;
    memset(c, 0, sizeof *c);
    memset(held, 0, sizeof held);
    memset(&q, 0, sizeof q);
    pd_ctx_init(&c->ctx);
    for (int k = 0; k < n * (10 * n + 3); k++) { /* three layers are held */
        c->position[k * PD_DIM] = (k / n - 2.5) * h;
        c->position[k * PD_DIM + PD_DIM - 1] = (k % n + 0.5) * h;
        c->volume[k] = h * h;
        for (int a = 0; a < PD_DIM; a++) held[k * PD_DIM + a] = k < 3 * n;
        c->desc.count++;
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = c->desc.spacing = h;
    CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body));
    d.law.plane = PD_PLANE_STRESS;
    d.law.poisson = 0.3;
    pd_material_interface s = build(c, &d, &f);
    q.prescribed = held;
    q.rtol = 1e-8;
    memset(u, 0, sizeof u);
    memset(other, 0, sizeof other);
    for (int step = 1; step <= 4; step++) {
        for (int a = 1; a <= n; a++) /* 2 E I/L^2 on the last layer */
            other[(c->body.count - a) * PD_DIM + PD_DIM - 1] = 2.0 * E / 12.0 * 1e-2 / h * 0.25 * step;
        CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &s, &q, other, u, &r));
    }
    *back = 0.0;
    for (int a = 1; a <= n; a++) {
        across += u[(c->body.count - a) * PD_DIM + PD_DIM - 1] / (n * 1e-2);
        *back -= u[(c->body.count - a) * PD_DIM] / (n * 1e-2);
    }
    end(c, &f);
    return across;
}

TEST(beam)
{
    double back[2], coarse = elastica(3, &back[0]), fine = elastica(6, &back[1]);
    NOTE("across %.4f and %.4f of 0.4935, back %.4f and %.4f of 0.1606", coarse, fine, back[0], back[1]);
    CHECK_LE(fabs(fine - 0.4935), 0.05 * 0.4935);
    CHECK_LE(fabs(back[1] - 0.1606), 0.1 * 0.1606);
    CHECK_LE(fabs(fine - 0.4935), 0.5 * fabs(coarse - 0.4935));
}

TEST_MAIN(SLOW_ENTRY(beam))
