/* solid: cases about bodies at rest and in motion. */
#ifndef BENCH_SOLID_H
#define BENCH_SOLID_H

typedef struct solid_lab {
    pd_ctx *ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    int32_t room;               /* points that the arrays have room for */
    double *position, *volume;  /* [room][PD_DIM] [m], [room] [m^d] */
    double *u, *load;           /* [room][PD_DIM] [m], [N/m3] */
    uint8_t *held;              /* [room][PD_DIM] */
    pd_equilibrium_result result;
    double build, solve;        /* [s] */
} solid_lab;

static void solid_end(solid_lab *s)
{
    pd_correspondence_free(s->ctx, &s->elastic);
    pd_body_free(s->ctx, &s->body);
    PD_DELETE(s->ctx, (int64_t)s->room * PD_DIM, s->position);
    PD_DELETE(s->ctx, s->room, s->volume);
    PD_DELETE(s->ctx, (int64_t)s->room * PD_DIM, s->u);
    PD_DELETE(s->ctx, (int64_t)s->room * PD_DIM, s->load);
    PD_DELETE(s->ctx, (int64_t)s->room * PD_DIM, s->held);
}

static double solid_distance(const double *x)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) square += x[d] * x[d];
    return sqrt(square);
}

/* Cells of width h of the box from -half to half; ring 1: what of each lies between the radii 1 and 2, with its middle
 * as the place. */
static void solid_points(solid_lab *s, int n, double half, double h, int ring)
{
    enum { parts = PD_DIM == 3 ? 6 : 16 };
    int samples = 1;
    for (int d = 0; d < PD_DIM; d++) samples *= ring ? parts : 1;
    for (int32_t k = 0; k < s->room; k++) {
        double sum[PD_DIM] = {0.0}, x[PD_DIM];
        int count = 0;
        for (int p = 0; p < samples; p++) {
            int32_t cell = k, part = p;
            for (int d = 0; d < PD_DIM; d++, cell /= n, part /= parts)
                x[d] = -half + h * (cell % n + (ring ? (part % parts + 0.5) / parts : 0.5));
            if (ring && !(solid_distance(x) > 1.0 && solid_distance(x) < 2.0)) continue;
            for (int d = 0; d < PD_DIM; d++) sum[d] += x[d];
            count++;
        }
        if (count <= samples / 8) continue;
        for (int d = 0; d < PD_DIM; d++) s->position[(int64_t)s->desc.count * PD_DIM + d] = sum[d] / count;
        s->volume[s->desc.count++] = pow(h, PD_DIM) * count / samples;
    }
}

static pd_status solid_build(bench *b, solid_lab *s, int n, double half, double m, int ring)
{
    double h = 2.0 * half / n;
    pd_correspondence_desc desc;
    memset(s, 0, sizeof *s);
    memset(&desc, 0, sizeof desc);
    s->ctx = b->ctx;
    s->room = 1;
    for (int d = 0; d < PD_DIM; d++) s->room *= n;
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)s->room * PD_DIM, s->position));
    PD_TRY(PD_NEW(b->ctx, "bench", s->room, s->volume));
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)s->room * PD_DIM, s->u));
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)s->room * PD_DIM, s->load));
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)s->room * PD_DIM, s->held));
    solid_points(s, n, half, h, ring);
    s->desc.position = s->position;
    s->desc.volume = s->volume;
    s->desc.horizon = m * h;
    s->desc.spacing = h;
    desc.young = 1.0;
    desc.poisson = 0.3;
    s->build = bench_clock(b->threads);
    PD_TRY(pd_body_build(b->ctx, &s->desc, &s->body));
    PD_TRY(pd_correspondence_build(b->ctx, &s->body, &desc, &s->elastic));
    s->build = bench_clock(b->threads) - s->build;
    return PD_OK;
}

static pd_status solid_solve(bench *b, solid_lab *s, double rtol)
{
    pd_equilibrium_desc desc;
    pd_material_interface solid = pd_correspondence_material(&s->elastic);
    memset(&desc, 0, sizeof desc);
    desc.prescribed = s->held;
    desc.rtol = rtol;
    s->solve = bench_clock(b->threads);
    pd_status status = pd_equilibrium_solve(b->ctx, &solid, &desc, s->load, s->u, &s->result);
    s->solve = bench_clock(b->threads) - s->solve;
    return status;
}

static void solid_force(void *user)
{
    solid_lab *s = (solid_lab *)user;
    pd_correspondence_force(s->ctx, &s->elastic, s->position, s->u);
}

/* One end of the box is held, and the other is sheared. */
static void solid_shear(solid_lab *s)
{
    int shear = PD_DIM > 1;
    memset(s->u, 0, (size_t)s->room * PD_DIM * sizeof *s->u);
    for (int32_t i = 0; i < s->body.count; i++) {
        int64_t first = (int64_t)i * PD_DIM;
        for (int d = 0; d < PD_DIM; d++) s->held[first + d] = s->position[first] < s->desc.horizon - 1.0;
        if (s->position[first] > 0.0) s->load[first + shear] = -s->elastic.surface_vector[first];
    }
}

static pd_status solid_cube(bench *b, solid_lab *s, int n, double m)
{
    bench_job job = {"elastic", solid_force, s, 0.0, 0.0};
    size_t before = b->ctx->in_use;
    table_row *row;
    PD_TRY(solid_build(b, s, n, 1.0, m, 0));
    int64_t arrays = (int64_t)s->room * (int64_t)((3 * PD_DIM + 1) * sizeof(double) + PD_DIM);
    double count = (double)s->body.count, bytes = ((double)(b->ctx->in_use - before) - (double)arrays) / count;
    job.nodes = (double)s->body.bonds;
    bench_time(b, &job, 1, 1);
    solid_shear(s);
    size_t peak = b->ctx->peak = b->ctx->in_use;
    PD_TRY(solid_solve(b, s, 1e-8));
    double more = (double)(b->ctx->peak - peak) / count;
    row = bench_row(b);
    table_cell(row, "%d", (int)s->body.count);
    table_cell(row, "%.1f", job.nodes / count);
    table_cell(row, "%.0f", bytes);
    table_cell(row, "%.0f", more);
    table_cell(row, "%.1f", 1e-6 * bench_rate(&job));
    table_cell(row, "%.2f", s->build);
    table_cell(row, "%d", s->result.iterations);
    table_cell(row, "%.2f", s->solve);
    bench_result(b, "part=cube n=%d m=%g points=%d bonds=%.0f bytes=%.0f solver_bytes=%.0f bond_rate=%.4g build_s=%.4g "
                 "solve_s=%.4g krylov=%d residual=%.3g threads=%d", n, m, (int)s->body.count, job.nodes, bytes, more,
                 bench_rate(&job), s->build, s->solve, s->result.iterations, s->result.residual, b->threads);
    if (PD_DIM == 3 && n == 100)
        bench_judge(b, "3D, 100^3 points at rest to 1e-8: build and solve [s]", 0, 300.0, s->build + s->solve);
    return PD_OK;
}

static void solid_cube_head(bench *b)
{
    static const char *const names[8] = {"points", "bonds a point", "bytes a point", "and of the solver",
                                         "10^6 bonds/s", "build [s]", "iterations", "solve [s]"};
    table_row *head = bench_row(b);
    for (int k = 0; k < 8; k++) table_cell(head, "%s", names[k]);
}

/* Displacement of a ring (plane strain) or shell from 1 to 2 under the pressure 1 inside, E = 1, nu = 0.3. */
static double solid_lame(double r)
{
    double nu = 0.3;
    if (PD_DIM == 3) return ((1.0 - 2.0 * nu) * r + 0.5 * (1.0 + nu) * 8.0 / (r * r)) / 7.0;
    return (1.0 + nu) * ((1.0 - 2.0 * nu) * r + 4.0 / r) / 3.0;
}

static pd_status solid_ring(bench *b, solid_lab *s, int across, double m)
{
    double error = 0.0, size = 0.0;
    table_row *row;
    PD_TRY(solid_build(b, s, 4 * across, 2.0, m, 1));
    for (int64_t k = 0; k < (int64_t)s->body.count * PD_DIM; k++)
        if (solid_distance(s->position + k / PD_DIM * PD_DIM) < 1.5) s->load[k] = s->elastic.surface_vector[k];
    PD_TRY(solid_solve(b, s, 1e-8));
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + (int64_t)i * PD_DIM;
        double r = solid_distance(x), exact = solid_lame(r);
        size += s->volume[i] * exact * exact;
        for (int d = 0; d < PD_DIM; d++) {
            double off = s->u[(int64_t)i * PD_DIM + d] - exact * x[d] / r;
            error += s->volume[i] * off * off;
        }
    }
    row = bench_row(b);
    table_cell(row, "%d", across);
    table_cell(row, "%d", (int)s->body.count);
    table_cell(row, "%.2f", 100.0 * sqrt(error / size));
    table_cell(row, "%d", s->result.iterations);
    table_cell(row, "%.3f", s->build + s->solve);
    bench_result(b, "part=ring across=%d m=%g points=%d error=%.4g krylov=%d wall_s=%.4g threads=%d", across, m,
                 (int)s->body.count, sqrt(error / size), s->result.iterations, s->build + s->solve, b->threads);
    return PD_OK;
}

static pd_status solid_run(bench *b)
{
    static const char *const names[5] = {"cells across", "points", "u off by [%]", "iterations",
                                         "build and solve [s]"};
    solid_lab s;
    char title[96];
    double m = b->m > 0.0 ? b->m : 2.0;
    int first = b->n ? b->n : PD_DIM == 3 ? 8 : 32, last = b->n ? b->n : PD_DIM == 3 ? 100 : 512;
    if (b->quick && !b->n) last = 2 * first;
    solid_cube_head(b);
    for (int n = first; n <= last; n = n == 64 && last == 100 ? 100 : 2 * n) {
        pd_status status = solid_cube(b, &s, n, m);
        solid_end(&s);
        if (status < 0) return status;
    }
    snprintf(title, sizeof title, "A box held at one end and sheared at the other, to 1e-8: m = %g, threads: %d", m,
             b->threads);
    bench_table(b, title);
    if (b->n) return PD_OK;
    table_row *head = bench_row(b);
    for (int k = 0; k < 5; k++) table_cell(head, "%s", names[k]);
    for (int across = PD_DIM == 3 ? 4 : 8; across <= (b->quick ? 8 : PD_DIM == 3 ? 16 : 64); across *= 2) {
        pd_status status = solid_ring(b, &s, across, PD_DIM == 3 ? 1.0 : 2.0);
        solid_end(&s);
        if (status < 0) return status;
    }
    bench_table(b, PD_DIM == 3 ? "Lame's shell under pressure inside, m = 1"
                               : "Lame's ring under pressure inside, m = 2");
    return PD_OK;
}

static const bench_case solid_case = {
    "solid", "Bodies at rest",
    "Small strains by correspondence (`elastic`) in a box of cells: bytes of the body with its bonds and of the "
    "material, and what a solve takes beside them; bonds a second of one evaluation of the forces on one thread, each "
    "bond counted at both of its ends; iterations of conjugate gradients. Beside it what accuracy costs: displacements "
    "against Lame's closed form, root mean square.",
    solid_run};

#if PD_DIM == 2
/* ---- a crack that branches ---- */

typedef struct glass_lab {
    pd_ctx *ctx;
    pd_body body;
    pd_microelastic springs;
    pd_verlet motion;
    int32_t count;
    double *position, *volume, *load; /* [count][2] [m], [count] [m2], [count][2] [N/m3] */
    double *force;                    /* [count][2] [N/m3] */
} glass_lab;

static void glass_free(glass_lab *g)
{
    pd_verlet_free(g->ctx, &g->motion);
    pd_microelastic_free(g->ctx, &g->springs);
    pd_body_free(g->ctx, &g->body);
    PD_DELETE(g->ctx, (int64_t)g->count * 2, g->position);
    PD_DELETE(g->ctx, g->count, g->volume);
    PD_DELETE(g->ctx, (int64_t)g->count * 2, g->load);
    PD_DELETE(g->ctx, (int64_t)g->count * 2, g->force);
}

/* The bonds across y = 0 left of the middle. */
static void glass_notch(pd_body *body)
{
    for (int32_t i = 0; i < body->count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
            const double *p = body->position + 2 * (size_t)i, *q = body->position + 2 * (size_t)b.neighbour;
            if ((p[1] < 0.0) == (q[1] < 0.0) || p[0] - p[1] * (q[0] - p[0]) / (q[1] - p[1]) > 0.0) continue;
            pd_body_break(body, i, b.neighbour);
        }
}

/* 100 x 40 mm of soda-lime glass with a notch to the middle, pulled with 2 MPa at once (examples/08_crack.c). */
static pd_status glass_build(bench *b, glass_lab *g, int n)
{
    int ny = 2 * n / 5;
    double h = 0.1 / n;
    pd_body_desc points;
    pd_microelastic_desc glass;
    pd_verlet_desc motion;
    memset(g, 0, sizeof *g);
    memset(&points, 0, sizeof points);
    memset(&glass, 0, sizeof glass);
    memset(&motion, 0, sizeof motion);
    g->ctx = b->ctx;
    g->count = n * ny;
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)g->count * 2, g->position));
    PD_TRY(PD_NEW(b->ctx, "bench", g->count, g->volume));
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)g->count * 2, g->load));
    PD_TRY(PD_NEW(b->ctx, "bench", (int64_t)g->count * 2, g->force));
    for (int32_t i = 0; i < g->count; i++) {
        g->position[2 * i] = (i % n - 0.5 * (n - 1)) * h;
        g->position[2 * i + 1] = (i / n - 0.5 * (ny - 1)) * h;
        g->volume[i] = h * h;
        g->load[2 * i + 1] = i / n == 0 ? -2e6 / h : i / n == ny - 1 ? 2e6 / h : 0.0;
    }
    points.count = g->count;
    points.position = g->position;
    points.volume = g->volume;
    points.horizon = 3.0 * h;
    points.spacing = h;
    PD_TRY(pd_body_build(b->ctx, &points, &g->body));
    glass_notch(&g->body);
    glass.young = 72e9;
    glass.fracture = 3.8;
    glass.plane = PD_PLANE_STRESS;
    PD_TRY(pd_microelastic_build(b->ctx, &g->body, &glass, &g->springs));
    motion.density = 2440.0;
    motion.load = g->load;
    pd_material_interface solid = pd_microelastic_material(&g->springs);
    return pd_verlet_build(b->ctx, &solid, &motion, &g->motion);
}

static void glass_force(void *user)
{
    glass_lab *g = (glass_lab *)user;
    pd_microelastic_force(g->ctx, &g->springs, g->motion.u, 0, g->force);
}

/* Are both halves equal to the bit? */
static int glass_mirrors(const glass_lab *g, int n)
{
    for (int32_t i = 0; i < g->count; i++) {
        int32_t mirror = i % n + n * (g->count / n - 1 - i / n);
        double along = g->motion.u[2 * i] - g->motion.u[2 * mirror];
        double across = g->motion.u[2 * i + 1] + g->motion.u[2 * mirror + 1];
        if (!(along >= 0.0 && along <= 0.0 && across >= 0.0 && across <= 0.0)) return 0;
    }
    return 1;
}

static pd_status glass_plate(bench *b, glass_lab *g, int n, int steps)
{
    bench_job job = {"springs", glass_force, g, 0.0, 0.0};
    size_t before = b->ctx->in_use;
    double build = bench_clock(b->threads);
    PD_TRY(glass_build(b, g, n));
    build = bench_clock(b->threads) - build;
    double bytes = ((double)(b->ctx->in_use - before) - 7.0 * sizeof(double) * g->count) / g->count;
    double run = bench_clock(b->threads);
    PD_TRY(pd_physics_run(b->ctx, pd_verlet_process(&g->motion), (steps - 1e-6) * g->motion.max_step));
    run = bench_clock(b->threads) - run;
    job.nodes = (double)g->body.bonds;
    bench_time(b, &job, 1, 1);
    double sum = pd_verlet_kinetic(&g->motion) + pd_microelastic_energy(b->ctx, &g->springs, g->motion.u);
    double off = (sum + g->springs.released) / g->motion.work - 1.0;
    table_row *row = bench_row(b);
    table_cell(row, "%d", (int)g->count);
    table_cell(row, "%.1f", job.nodes / g->count);
    table_cell(row, "%.0f", bytes);
    table_cell(row, "%.0f", 1e-6 * bench_rate(&job));
    table_cell(row, "%.2f", build);
    table_cell(row, "%d", (int)g->motion.steps);
    table_cell(row, "%.2f", run);
    table_cell(row, "%d", (int)g->motion.broken);
    table_cell(row, "%.1e", off);
    table_cell(row, "%s", glass_mirrors(g, n) ? "equal" : "differ");
    bench_result(b, "part=glass n=%d points=%d bonds=%.0f bytes=%.0f bond_rate=%.4g build_s=%.4g steps=%d run_s=%.4g "
                 "broken=%d energy=%.3g unequal=%d threads=%d", n, (int)g->count, job.nodes, bytes, bench_rate(&job),
                 build, (int)g->motion.steps, run, (int)g->motion.broken, off, !glass_mirrors(g, n), b->threads);
    if (n == 1660) bench_judge(b, "2D, crack in 1.1e6 points of glass, 660 steps [s]", 0, 300.0, run);
    return PD_OK;
}

static pd_status glass_run(bench *b)
{
    static const char *const names[10] = {"points", "bonds a point", "bytes a point", "10^6 bonds/s", "build [s]",
                                          "steps", "run [s]", "broken", "energies off by", "halves"};
    glass_lab g;
    char title[96];
    int first = b->n ? b->n : 200, last = b->n ? b->n : b->quick ? 200 : 400;
    table_row *head = bench_row(b);
    for (int k = 0; k < 10; k++) table_cell(head, "%s", names[k]);
    for (int n = first; n <= last; n *= 2) {
        pd_status status = glass_plate(b, &g, n, 660);
        glass_free(&g);
        if (status < 0) return status;
    }
    if (!b->n && !b->quick) {
        pd_status status = glass_plate(b, &g, 1660, 660);
        glass_free(&g);
        if (status < 0) return status;
    }
    snprintf(title, sizeof title, "A notched plate of glass under 2 MPa, m = 3, threads: %d", b->threads);
    bench_table(b, title);
    return PD_OK;
}

static const bench_case glass_case = {
    "glass", "A crack that branches",
    "Springs that break (`microelastic`), moved by `verlet`: bytes of the body with its bonds, of the material and of "
    "the motion; bonds a second of one evaluation of the forces on one thread, each bond counted at both of its ends; "
    "660 steps on all threads with the bonds that broke in them, and whether kinetic, elastic and released energy are "
    "the work of the loads.",
    glass_run};
#endif

#endif
