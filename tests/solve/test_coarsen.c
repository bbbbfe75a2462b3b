/* coarsen: setups of the multigrid, whole and of masses alone, small boxes, memory and bad input.
 * dims: 1 2 3 */
#include "fault.h"
#include "multigrid.h"

/* Setup again, with other masks and couplings, leaves no trace of what was there before. */
TEST(setup_again)
{
    for (int general = 0; general < 4; general++) {
        problem p;
        start(&p, PD_DIM == 3 ? 12 : 40, 0);
        p.general = general;
        double *b = random_vector(&p), *x = vector(&p), *fresh = vector(&p);
        pd_multigrid kept;
        CHECK_OK(&p.ctx, build(&p));
        for (int round = 0; round < 4; round++) {
            for (int c = 0; c < p.cells; c++) {
                p.active[c] = round % 2 ? uniform() > 0.5 : 1;
                for (int d = 0; d < PD_DIM; d++) p.conduct[d][c] = round == 2 && d == 0 ? 1e4f : 1.0f;
            }
            walls(&p, 7, 0);
            CHECK_OK(&p.ctx, setup(&p));
            cycle(&p, b, x);
            kept = p.mg;
            CHECK_OK(&p.ctx, build(&p));
            CHECK_OK(&p.ctx, setup(&p));
            cycle(&p, b, fresh);
            CHECK(memcmp(x, fresh, (size_t)p.nodes * sizeof *x) == 0);
            pdi_multigrid_free(&p.ctx, &p.mg);
            p.mg = kept;
        }
        free(b);
        free(x);
        free(fresh);
        finish(&p);
    }
}

/* Other walls and masses alone give the same bits as all coefficients anew; one beyond the range of the unit holds its
 * cell and spoils no other. */
TEST(other_masses)
{
    for (int general = 0; general < 4; general += 2) {
        problem p;
        tangle(&p);
        p.general = general;
        double *b = random_vector(&p), *x = vector(&p), *fresh = vector(&p);
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, fresh);
        for (int c = 0; c < p.cells; c++) {
            p.mass[c] = c % 3 ? (float)pow(10.0, 6.0 * uniform() - 3.0) : 0.0f;
            p.wall[c] *= 3.0f;
        }
        CHECK_OK(&p.ctx, pdi_multigrid_update_mass(&p.ctx, &p.mg, p.active, p.wall, p.mass));
        cycle(&p, b, x);
        CHECK(norm_difference(&p, x, fresh) > 1e-3 * norm_difference(&p, fresh, b));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, fresh);
        CHECK(memcmp(x, fresh, (size_t)p.nodes * sizeof *x) == 0);
        p.mass[5] = 3e38f;
        p.active[5] = 1;
        CHECK_OK(&p.ctx, pdi_multigrid_update_mass(&p.ctx, &p.mg, p.active, p.wall, p.mass));
        cycle(&p, b, x);
        for (int c = 0; c < p.cells; c++) CHECK(fabs(x[node(&p, c)]) < 1e6);
        CHECK_LE(fabs(x[node(&p, 5)]), 1e-25);
        p.mass[5] = -1.0f;
        CHECK_INT(pdi_multigrid_update_mass(&p.ctx, &p.mg, p.active, p.wall, p.mass), PD_ERR_ARGUMENT);
        free(b);
        free(x);
        free(fresh);
        finish(&p);
    }
}

/* One cell, no cell, a row of single cells: the answer is b over the diagonal. */
TEST(degenerate)
{
    for (int general = 0; general < 4; general++) {
        problem p;
        start(&p, 1, 0);
        p.general = general;
        p.mass[0] = 4.0f;
        double *b = vector(&p), *x = vector(&p);
        b[node(&p, 0)] = 3.0;
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, x);
        CHECK_REL(x[node(&p, 0)], 0.75, 1e-7);
        p.mass[0] = 0.0f; /* 0 x = b */
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, x);
        CHECK_NEAR(x[node(&p, 0)], 0.0, 0.0);
        free(b);
        free(x);
        finish(&p);
        start(&p, 9, 0);
        p.general = general;
        for (int c = 0; c < p.cells; c++) {
            int sum = 0;
            for (int d = 0; d < PD_DIM; d++) sum += coordinate(&p, c, d);
            p.active[c] = sum % 2 == 0;
            p.mass[c] = (float)(1 + c);
        }
        b = random_vector(&p);
        x = vector(&p);
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, x);
        for (int c = 0; c < p.cells; c++)
            if (p.active[c]) CHECK_REL(x[node(&p, c)], b[node(&p, c)] / (1 + c), 1e-6);
        memset(p.active, 0, (size_t)p.cells);
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, x);
        for (int c = 0; c < p.cells; c++) CHECK(x[node(&p, c)] == 0.0);
        free(b);
        free(x);
        finish(&p);
    }
}

/* NaN in the right-hand side comes out as NaN, so that the Krylov solver sees it. */
TEST(not_a_number)
{
    problem p;
    start(&p, 20, 0);
    walls(&p, 7, 0);
    double *b = random_vector(&p), *x = vector(&p);
    CHECK_OK(&p.ctx, build(&p));
    CHECK_OK(&p.ctx, setup(&p));
    for (int kind = 0; kind < 2; kind++) {
        int bad = 0;
        b[node(&p, 7)] = kind ? (double)INFINITY : (double)NAN;
        cycle(&p, b, x);
        for (int c = 0; c < p.cells; c++) bad += !(fabs(x[node(&p, c)]) < 1e300);
        CHECK(bad > 0);
    }
    free(b);
    free(x);
    finish(&p);
}

/* Each allocation fails once; the next setup on the same object then works and gives the same bits. */
TEST(memory)
{
    for (int general = 0; general < 4; general++) {
        problem p;
        fault k;
        tangle(&p);
        p.general = general;
        fault_context(&k, 0, 1, &p.ctx);
        double *b = random_vector(&p), *x = vector(&p), *y = vector(&p);
        CHECK_OK(&p.ctx, build(&p));
        long built = k.calls;
        CHECK_OK(&p.ctx, setup(&p));
        long all = k.calls;
        cycle(&p, b, x);
        CHECK_INT(k.calls, all);
        pdi_multigrid_free(&p.ctx, &p.mg);
        CHECK(all > built && built > 0);
        for (long fail = 1; fail <= all; fail++) {
            k.calls = 0;
            k.fail_at = fail;
            pd_status status = build(&p);
            CHECK_INT(status, fail <= built ? PD_ERR_MEMORY : PD_OK);
            CHECK_INT(setup(&p), fail <= built ? PD_ERR_ARGUMENT : PD_ERR_MEMORY);
            cycle(&p, b, y);
            k.fail_at = 0;
            if (fail > built) {
                CHECK_OK(&p.ctx, setup(&p));
                cycle(&p, b, y);
                CHECK(memcmp(x, y, (size_t)p.nodes * sizeof *x) == 0);
            }
            pdi_multigrid_free(&p.ctx, &p.mg);
            CHECK_INT(p.ctx.in_use, 0);
        }
        free(b);
        free(x);
        free(y);
        finish(&p);
    }
}

TEST(bad_input)
{
    problem p;
    start(&p, 6, 0);
    p.flow = 1;
    CHECK_OK(&p.ctx, build(&p));
    float *field[4] = {p.conduct[PD_DIM - 1], p.flux[0], p.wall, p.mass};
    static const char *const name[4] = {"conduct", "flux", "wall", "mass"};
    static const float value[3] = {-1.0f, (float)NAN, (float)INFINITY};
    for (int f = 0; f < 4; f++)
        for (int v = 0; v < 3; v++) {
            float keep = field[f][3];
            field[f][3] = value[v];
            CHECK_INT(setup(&p), f == 1 && v == 0 ? PD_OK : PD_ERR_ARGUMENT); /* flow may be negative */
            if (!(f == 1 && v == 0)) CHECK(strstr(p.ctx.message, name[f]) != NULL);
            field[f][3] = keep;
        }
    CHECK_OK(&p.ctx, setup(&p));
    CHECK_INT(pdi_multigrid_update_mass(&p.ctx, &p.mg, p.active, p.wall, p.mass), PD_ERR_ARGUMENT); /* not symmetric */
    pdi_multigrid_free(&p.ctx, &p.mg);
    p.flow = 0;
    CHECK_OK(&p.ctx, build(&p));
    CHECK_INT(pdi_multigrid_update_mass(&p.ctx, &p.mg, p.active, p.wall, p.mass), PD_ERR_ARGUMENT); /* not set up */
    p.flow = 1;
    CHECK_INT(setup(&p), PD_ERR_ARGUMENT); /* flux for a symmetric one */
    pdi_multigrid_free(&p.ctx, &p.mg);
    CHECK_INT(setup(&p), PD_ERR_ARGUMENT); /* not built */
    int keep = p.n[0];
    p.n[0] = 0;
    CHECK_INT(build(&p), PD_ERR_ARGUMENT);
    pdi_multigrid_free(&p.ctx, &p.mg);
    p.n[0] = 2000000000;
    CHECK_INT(build(&p), PD_ERR_SIZE);
    pdi_multigrid_free(&p.ctx, &p.mg);
    p.n[0] = keep;
    p.stride[0] = 0;
    CHECK_INT(build(&p), PD_ERR_ARGUMENT);
    finish(&p);
}

TEST_MAIN(ENTRY(setup_again) ENTRY(other_masses) ENTRY(degenerate) ENTRY(not_a_number) ENTRY(memory)
          ENTRY(bad_input))
