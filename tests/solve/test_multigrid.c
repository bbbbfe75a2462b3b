/* multigrid: iteration counts of the preconditioned Krylov solvers and properties of the cycle.
 * dims: 1 2 3
 * The operator is written a second time here, in double precision, straight from its formula. */
#include "solve/krylov.h"
#include "multigrid.h"

/* y = A x on the padded lattice; the ghosts of y are left alone. */
static void multiply(void *user, const double *x, double *y)
{
    const problem *p = (const problem *)user;
    for (int c = 0; c < p->cells; c++) {
        if (!p->active[c]) {
            y[node(p, c)] = 0.0;
            continue;
        }
        double xc = x[node(p, c)], sum = ((double)p->mass[c] + (double)p->wall[c]) * xc;
        for (int d = 0; d < PD_DIM; d++)
            for (int upper = 0; upper < 2; upper++) {
                int q = neighbour(p, c, d, upper);
                if (q < 0) continue;
                int face = upper ? c : q;
                double xq = x[node(p, q)], out = 0.0;
                if (p->flow) out = upper ? (double)p->flux[d][face] : -(double)p->flux[d][face];
                sum += (double)p->conduct[d][face] * (xc - xq);
                sum += out > 0.0 ? out * xc : out * xq;
            }
        y[node(p, c)] = sum;
    }
}

/* Subtract the mean of every pocket. */
static void project(void *user, double *v)
{
    const problem *p = (const problem *)user;
    for (int k = 0; k < p->pockets; k++) {
        double sum = 0.0, count = 0.0;
        for (int c = 0; c < p->cells; c++)
            if (p->active[c] && p->pocket[c] == k) sum += v[node(p, c)], count += 1.0;
        for (int c = 0; c < p->cells; c++)
            if (p->active[c] && p->pocket[c] == k) v[node(p, c)] -= sum / count;
    }
}

/* The operator and a cycle on vectors whose mean over every pocket is zero: there they are regular. */
static void multiply_projected(void *user, const double *x, double *y)
{
    multiply(user, x, y);
    project(user, y);
}

static void cycle_projected(void *user, const double *x, double *y)
{
    cycle(user, x, y);
    project(user, y);
}

/* Solve A x = A exact for a random x to 1e-8; returns the iterations, checks the residual with the operator above. */
static int count(problem *p, pd_krylov_method method)
{
    pd_krylov k;
    pd_krylov_result r;
    pd_krylov_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(&r, 0, sizeof r);
    desc.method = method;
    desc.n = p->nodes;
    desc.flexible = desc.zero_guess = 1;
    double *exact = random_vector(p), *b = vector(p), *x = vector(p), *y = vector(p);
    multiply_projected(p, exact, b);
    if (CHECK_OK(&p->ctx, build(p)) && CHECK_OK(&p->ctx, setup(p)) &&
        CHECK_OK(&p->ctx, pd_krylov_build(&p->ctx, &desc, &k))) {
        size_t held = p->ctx.in_use, peak = p->ctx.peak;
        CHECK_OK(&p->ctx, pd_krylov_solve(&p->ctx, &k, multiply_projected, cycle_projected, p, b, x, &r));
        CHECK_INT(p->ctx.in_use, held); /* neither the solver nor the cycle allocates */
        CHECK_INT(p->ctx.peak, peak > held ? peak : held);
        pd_krylov_free(&p->ctx, &k);
        multiply(p, x, y);
        memset(exact, 0, (size_t)p->nodes * sizeof *exact);
        CHECK_LE(norm_difference(p, y, b), 1.001e-8 * norm_difference(p, exact, b));
    }
    free(exact);
    free(b);
    free(x);
    free(y);
    pdi_multigrid_free(&p->ctx, &p->mg);
    return r.iterations;
}

static const int sizes[3] = {PD_DIM == 3 ? 16 : 32, PD_DIM == 3 ? 32 : 128,
                             PD_DIM == 3 ? 64 : PD_DIM == 2 ? 256 : 1024};
#define SIZE (PD_DIM == 3 ? 32 : PD_DIM == 2 ? 128 : 500)

/* Zero values half a cell outside: sin(k pi (i + 1/2) / n) has the eigenvalue sum 2 - 2 cos(k pi / n). */
TEST(closed_form)
{
    problem p;
    start(&p, PD_DIM == 3 ? 20 : 48, 0);
    walls(&p, 7, 0);
    double *b = vector(&p), *x = vector(&p), *exact = vector(&p);
    for (int mode = 1; mode <= 3; mode += 2) {
        double value = 0.0;
        for (int d = 0; d < PD_DIM; d++) value += 2.0 - 2.0 * cos(PI * mode / p.n[d]);
        for (int c = 0; c < p.cells; c++) {
            double f = 1.0;
            for (int d = 0; d < PD_DIM; d++) f *= sin(PI * mode * (coordinate(&p, c, d) + 0.5) / p.n[d]);
            b[node(&p, c)] += f;
            exact[node(&p, c)] += f / value;
        }
    }
    pd_krylov k;
    pd_krylov_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.method = PD_KRYLOV_CG;
    desc.n = p.nodes;
    desc.rtol = 1e-12;
    if (CHECK_OK(&p.ctx, build(&p)) && CHECK_OK(&p.ctx, setup(&p)) &&
        CHECK_OK(&p.ctx, pd_krylov_build(&p.ctx, &desc, &k))) {
        CHECK_OK(&p.ctx, pd_krylov_solve(&p.ctx, &k, multiply, cycle, &p, b, x, NULL));
        pd_krylov_free(&p.ctx, &k);
        for (int i = 0; i < p.nodes; i++) CHECK_NEAR(x[i], exact[i], 1e-8);
    }
    free(b);
    free(x);
    free(exact);
    finish(&p);
}

TEST(poisson)
{
    int its[3];
    problem p;
    for (int s = 0; s < 3; s++) {
        start(&p, sizes[s], 0);
        walls(&p, 7, 0);
        its[s] = count(&p, PD_KRYLOV_CG);
        finish(&p);
    }
    NOTE("CG iterations at %d, %d, %d cells an axis: %d %d %d", sizes[0], sizes[1], sizes[2], its[0], its[1], its[2]);
    for (int s = 0; s < 3; s++) CHECK_LE(its[s], 8);
    CHECK_LE(its[2], its[0] + 2);
    start(&p, SIZE, 1);
    walls(&p, 7, 0);
    int odd = count(&p, PD_KRYLOV_CG);
    walls(&p, 1, 0);
    int one = count(&p, PD_KRYLOV_CG), gmres = count(&p, PD_KRYLOV_GMRES);
    finish(&p);
    NOTE("odd sizes %d; walls on one axis: CG %d, GMRES %d", odd, one, gmres);
    CHECK_LE(odd, 8);
    CHECK_LE(one, 8);
    CHECK_LE(gmres, 9);
}

/* Axes that wrap, and streams round them. Red-black sweeps do not wrap an odd number of cells, which takes longer. */
TEST(periodic)
{
    static const int axes[3] = {1, 2, 7};
    for (int a = 0; a < 3; a++)
        for (int odd = 0; odd < 2; odd++) {
            problem p;
            start(&p, SIZE, odd);
            p.periodic = axes[a];
            walls(&p, 7 & ~axes[a], 0);
            for (int c = 0; c < p.cells; c++) p.mass[c] = 1e-3f;
            int cg = count(&p, PD_KRYLOV_CG);
            p.flow = 1; /* round all axes that wrap, and none else */
            for (int d = 0; d < PD_DIM; d++)
                for (int c = 0; c < p.cells; c++) p.flux[d][c] = p.periodic >> d & 1 ? 2.0f - 0.5f * (float)d : 0.0f;
            int gmres = count(&p, PD_KRYLOV_GMRES);
            finish(&p);
            NOTE("axes %d, %s size: CG %d, GMRES with flow %d", axes[a], odd ? "odd" : "even", cg, gmres);
            CHECK_LE(cg, odd ? 60 : 7);
            CHECK_LE(gmres, a < 2 ? 13 : 20);
        }
}

/* Steep sinks and weak ones, down to where the mean of the box drowns in single precision. */
TEST(mass)
{
    static const double ratio[5] = {10.0, 1e-2, 1e-5, 1e-9, 1e-20};
    int its[5];
    problem p;
    for (int k = 0; k < 5; k++) {
        start(&p, SIZE, 0);
        for (int c = 0; c < p.cells; c++) p.mass[c] = (float)ratio[k];
        its[k] = count(&p, PD_KRYLOV_CG);
        finish(&p);
        CHECK_LE(its[k], 9);
    }
    NOTE("CG iterations for mass 10, 1e-2, 1e-5, 1e-9, 1e-20: %d %d %d %d %d", its[0], its[1], its[2], its[3], its[4]);
}

/* A fifth of the cells blocked at random. In one dimension this cuts the box into short pieces. */
TEST(mask)
{
    problem p;
    start(&p, SIZE, 0);
    for (int c = 0; c < p.cells; c++) p.active[c] = uniform() > 0.2;
    walls(&p, 7, 0);
    for (int c = 0; c < p.cells; c++) p.mass[c] = 1e-3f; /* enclosed cells stay regular */
    int closed = count(&p, PD_KRYLOV_CG);
    walls(&p, 7, 1);
    int held = count(&p, PD_KRYLOV_CG);
    finish(&p);
    NOTE("CG iterations: insulating obstacles %d, Dirichlet obstacles %d", closed, held);
    CHECK_LE(closed, 12);
    CHECK_LE(held, 10);
}

/* A wall across most of the box, one cell thick or only closed faces; coarse blocks straddle it. */
TEST(thin_wall)
{
    problem p;
    int its[2];
    for (int faces = 0; faces < 2; faces++) {
        start(&p, SIZE, 0);
        walls(&p, 7, 0);
        for (int c = 0; c < p.cells; c++) {
            if (coordinate(&p, c, 0) != SIZE / 2 - 2) continue;
            if (PD_DIM > 1 && coordinate(&p, c, PD_DIM - 1) < SIZE / 8) continue;
            if (faces)
                p.conduct[0][c] = 0.0f;
            else
                p.active[c] = 0;
        }
        its[faces] = count(&p, PD_KRYLOV_CG);
        finish(&p);
        CHECK_LE(its[faces], 8);
    }
    NOTE("CG iterations: wall of one cell %d, of closed faces %d", its[0], its[1]);
}

/* Spacing ratio r: conductance ratio r^2, strong along the first or the last axis. */
TEST(spacing_ratio)
{
    problem p;
    for (int axis = 0; axis < PD_DIM; axis += PD_DIM > 1 ? PD_DIM - 1 : 1)
        for (int ratio = 10; ratio <= 100; ratio *= 10) {
            start(&p, SIZE, 0);
            for (int c = 0; c < p.cells; c++) p.conduct[axis][c] = (float)(ratio * ratio);
            walls(&p, 7, 0);
            int all = count(&p, PD_KRYLOV_CG);
            walls(&p, PD_DIM > 1 ? 7 & ~(1 << axis) : 1, 0);
            int weak = count(&p, PD_KRYLOV_CG);
            finish(&p);
            NOTE("CG iterations at ratio %d, axis %d: walls on all sides %d, on weak axes %d", ratio, axis, all, weak);
            CHECK_LE(all, 11);
            CHECK_LE(weak, 10);
        }
}

/* Closed pockets, two cells to half the box, without any sink: singular, once for each pocket. */
TEST(singular_pockets)
{
    problem p;
    start(&p, SIZE, 0);
    int cut[4] = {0, 2, 9, SIZE / 2}; /* planes between the pockets along the last axis */
    p.pockets = 4;
    for (int c = 0; c < p.cells; c++) {
        int i = coordinate(&p, c, PD_DIM - 1);
        p.pocket[c] = 3;
        for (int k = 1; k < 4; k++) {
            if (i == cut[k]) p.active[c] = 0;
            if (i < cut[k] && p.pocket[c] == 3) p.pocket[c] = k - 1;
        }
    }
    int its = count(&p, PD_KRYLOV_CG), gmres = count(&p, PD_KRYLOV_GMRES);
    NOTE("four pockets: CG %d, GMRES %d iterations", its, gmres);
    CHECK_LE(its, 8);
    CHECK_LE(gmres, 9);
    /* a right-hand side with a net source in the pockets has no solution, yet the cycle stays of the size of one */
    double *b = vector(&p), *x = vector(&p);
    for (int c = 0; c < p.cells; c++) b[node(&p, c)] = p.active[c] ? 1.0 : 5.0;
    for (p.general = 0; p.general < 4; p.general++) {
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, x);
        for (int i = 0; i < p.nodes; i++) CHECK(fabs(x[i]) <= 2.0 * SIZE * SIZE);
        for (int c = 0; c < p.cells; c++) CHECK(p.active[c] || x[node(&p, c)] == 0.0);
        pdi_multigrid_free(&p.ctx, &p.mg);
    }
    free(b);
    free(x);
    finish(&p);
}

TEST(advection)
{
    static const double peclet[4] = {0.1, 1.0, 10.0, 1000.0};
    static const char *const name[3] = {"along axis 0", "oblique", "vortex"};
    for (int kind = 0; kind < (PD_DIM > 1 ? 3 : 1); kind++) {
        int gmres[4], closed[4];
        for (int k = 0; k < 4; k++) {
            problem p;
            start(&p, SIZE, 0);
            walls(&p, 7, 0);
            flow(&p, peclet[k], kind);
            gmres[k] = count(&p, PD_KRYLOV_GMRES);
            CHECK_LE(gmres[k], kind < 2 ? 11 : PD_DIM == 2 ? 21 : 14);
            closed[k] = 0;
            if (kind == 2) { /* no wall gives way: constants are in the null space */
                walls(&p, 0, 0);
                p.pockets = 1;
                closed[k] = count(&p, PD_KRYLOV_GMRES);
                CHECK_LE(closed[k], PD_DIM == 2 ? 21 : 14);
            }
            finish(&p);
        }
        NOTE("%s, cell Peclet 0.1, 1, 10, 1000: GMRES %d %d %d %d", name[kind], gmres[0], gmres[1], gmres[2],
             gmres[3]);
        if (kind == 2) NOTE("closed vortex: GMRES %d %d %d %d", closed[0], closed[1], closed[2], closed[3]);
    }
}

/* A stream that leaves the lower half of the last axis still: coarser levels have that half alone. A stream everywhere
 * needs none. */
TEST(coarser_levels_where_sweeps_do_not_do)
{
    for (int still = 0; still < 2; still++) {
        problem p;
        start(&p, SIZE, 0);
        walls(&p, 7, 0);
        flow(&p, 1000.0, 0);
        int blocks = 1, last = PD_DIM - 1;
        for (int d = 0; d < PD_DIM; d++) blocks *= (p.n[d] + 1) / 2;
        for (int c = 0; c < p.cells && still && PD_DIM > 1; c++)
            if (coordinate(&p, c, last) < p.n[last] / 2) p.flux[0][c] = p.mass[c] = 0.0f;
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        int coarse = p.mg.levels > 1 ? (int)p.mg.level[1].cells : 0;
        if (!still || PD_DIM == 1) CHECK_INT(coarse, 0);
        else CHECK(2 * coarse >= blocks && 2 * coarse <= blocks + 2 * blocks / p.n[last]);
        pdi_multigrid_free(&p.ctx, &p.mg);
        int gmres = count(&p, PD_KRYLOV_GMRES);
        NOTE("still %d: %d of %d blocks, GMRES %d", still, coarse, blocks, gmres);
        CHECK_LE(gmres, 11);
        finish(&p);
    }
}

static double dot(const problem *p, const double *u, const double *v)
{
    double sum = 0.0;
    for (int i = 0; i < p->nodes; i++) sum += u[i] * v[i];
    return sum;
}

/* <M x, y> = <x, M y> (red-black), <M x, x> > 0, M (x + 2 y) = M x + 2 M y, to single precision. */
TEST(symmetric_linear)
{
    for (int general = 0; general < 4; general++) {
        problem p;
        tangle(&p);
        p.general = general;
        double *x = random_vector(&p), *y = random_vector(&p), *s = vector(&p);
        double *mx = vector(&p), *my = vector(&p), *ms = vector(&p), *zero = vector(&p);
        for (int i = 0; i < p.nodes; i++) s[i] = x[i] + 2.0 * y[i];
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, x, mx);
        cycle(&p, y, my);
        cycle(&p, s, ms);
        double scale = norm_difference(&p, mx, zero) * norm_difference(&p, y, zero);
        if (!(general & 1)) CHECK_NEAR(dot(&p, mx, y), dot(&p, x, my), 1e-6 * scale);
        CHECK(dot(&p, mx, x) > 0.0);
        CHECK(dot(&p, my, y) > 0.0);
        for (int i = 0; i < p.nodes; i++) s[i] = mx[i] + 2.0 * my[i];
        CHECK_LE(norm_difference(&p, ms, s), 1e-6 * norm_difference(&p, ms, zero));
        free(x);
        free(y);
        free(s);
        free(mx);
        free(my);
        free(ms);
        free(zero);
        finish(&p);
    }
}

/* The same bits for any number of threads; nodes outside of the box neither read nor written. */
TEST(threads_and_ghosts)
{
    for (int general = 0; general < 4; general++) {
        problem p;
        start(&p, PD_DIM == 3 ? 40 : PD_DIM == 2 ? 200 : 60000, 1);
        for (int c = 0; c < p.cells; c++) p.active[c] = uniform() > 0.1;
        walls(&p, 7, 0);
        if (general & 1) flow(&p, 5.0, PD_DIM > 1 ? 2 : 0);
        p.general = general;
        double *b = random_vector(&p), *x = vector(&p), *first = vector(&p), *inside = vector(&p);
        for (int c = 0; c < p.cells; c++) inside[node(&p, c)] = 1.0;
        for (int t = 1; t <= 4; t *= 2) {
            p.ctx.threads = t;
            for (int i = 0; i < p.nodes; i++) {
                if (inside[i] == 0.0) b[i] = (double)NAN;
                x[i] = 77.0;
            }
            CHECK_OK(&p.ctx, build(&p));
            CHECK_OK(&p.ctx, setup(&p));
            cycle(&p, b, x);
            pdi_multigrid_free(&p.ctx, &p.mg);
            if (t == 1) memcpy(first, x, (size_t)p.nodes * sizeof *x);
            CHECK(memcmp(first, x, (size_t)p.nodes * sizeof *x) == 0);
            for (int i = 0; i < p.nodes; i++) CHECK(inside[i] > 0.0 ? fabs(x[i]) < 1e12 : x[i] == 77.0);
        }
        free(b);
        free(x);
        free(first);
        free(inside);
        finish(&p);
    }
}

/* Coefficients and right-hand side in other units: powers of two come out bit for bit, far outside of float's range.
 * What is below the range of normal numbers has an answer, too. */
TEST(unit_covariance)
{
    for (int general = 0; general < 4; general++) {
        problem p;
        tangle(&p);
        p.general = general;
        double *b = random_vector(&p), *x = vector(&p), *y = vector(&p);
        CHECK_OK(&p.ctx, build(&p));
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, x);
        for (int c = 0; c < p.cells; c++) {
            p.mass[c] = ldexpf(p.mass[c], -90);
            p.wall[c] = ldexpf(p.wall[c], -90);
            b[node(&p, c)] = ldexp(b[node(&p, c)], -300);
            for (int d = 0; d < PD_DIM; d++) p.conduct[d][c] = ldexpf(p.conduct[d][c], -90);
        }
        CHECK_OK(&p.ctx, setup(&p));
        cycle(&p, b, y);
        for (int i = 0; i < p.nodes; i++) CHECK(y[i] == ldexp(x[i], -210));
        for (int c = 0; c < p.cells; c++) b[node(&p, c)] = ldexp(b[node(&p, c)], -760);
        cycle(&p, b, y);
        for (int i = 0; i < p.nodes; i++) CHECK_NEAR(y[i], ldexp(x[i], -970), ldexp(1.0, -975));
        free(b);
        free(x);
        free(y);
        finish(&p);
    }
}

TEST_MAIN(ENTRY(closed_form) ENTRY(poisson) ENTRY(periodic) ENTRY(mass) ENTRY(mask) ENTRY(thin_wall)
          ENTRY(spacing_ratio) ENTRY(singular_pockets) ENTRY(advection)
          ENTRY(coarser_levels_where_sweeps_do_not_do) ENTRY(symmetric_linear)
          ENTRY(threads_and_ghosts) ENTRY(unit_covariance))
