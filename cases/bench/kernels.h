/* kernels: cases about the speed of single operators. */
#ifndef BENCH_KERNELS_H
#define BENCH_KERNELS_H
#include "../../tests/lib/multigrid_build.h"

enum { KERNELS = 12 };

/* Everything that the operators need, in a periodic box: all families are whole. */
typedef struct kernels {
    pd_ctx *ctx;
    val_lab lab;
    triad triad;
    pd_jacobian jacobian;
    pd_multigrid pressure;          /* symmetric cycle */
    pd_compact_operator compact;
    double *f, *g, *vector, *other; /* [total] twice, [PD_DIM + 1][total] twice */
    bench_job job[KERNELS];
    int holds;                      /* 1: transport has borrowed what a step needs */
    int jobs;
} kernels;

static void kernels_triad(void *user) { triad_run(&((kernels *)user)->triad); }

static void kernels_laplacian(void *user)
{
    kernels *k = (kernels *)user;
    pd_op_laplacian(k->ctx, &k->lab.bonds, k->f, k->g);
}

static void kernels_gradient(void *user)
{
    kernels *k = (kernels *)user;
    pd_op_gradient(k->ctx, &k->lab.bonds, k->f, k->vector);
}

static void kernels_divergence(void *user)
{
    kernels *k = (kernels *)user;
    pd_op_divergence(k->ctx, &k->lab.bonds, k->lab.flow.u, k->g);
}

/* The field of the diffusivity is that of the concentration, which is positive. */
static void kernels_diffuse(void *user)
{
    kernels *k = (kernels *)user;
    pd_op_diffusion(k->ctx, &k->lab.bonds, k->lab.transport.c, k->f, k->g);
}

static void kernels_residual(void *user)
{
    kernels *k = (kernels *)user;
    pdi_flow_assemble_residual(k->ctx, &k->lab.flow, k->vector, k->g);
}

/* As a Newton step needs it: gradient of the pressure, advecting, both convective terms. */
static void kernels_product(void *user)
{
    kernels *k = (kernels *)user;
    pd_flow *flow = &k->lab.flow;
    int64_t split = (int64_t)PD_DIM * flow->grid->total;
    pdi_jacobian_increment step;
    pdi_flow_compute_pressure_gradient(k->ctx, flow, flow->p, flow->pressure_grad);
    pdi_flow_compute_advecting_velocity(k->ctx, flow, flow->u, NULL, k->other);
    step.advecting = k->other;
    step.u = flow->u;
    step.p = flow->p;
    step.grad = flow->pressure_grad;
    pdi_jacobian_apply(k->ctx, &k->jacobian, &step, k->vector, k->vector + split);
}

static void kernels_transport(void *user)
{
    kernels *k = (kernels *)user;
    pdi_transport_residual(k->ctx, &k->lab.transport, k->g);
}

static void kernels_limiter(void *user)
{
    kernels *k = (kernels *)user;
    pdi_transport_anti(k->ctx, &k->lab.transport, k->lab.transport.c, k->g);
}

static void kernels_cycle(void *user)
{
    kernels *k = (kernels *)user;
    pdi_multigrid_cycle(k->ctx, &k->pressure, k->f, k->g);
}

static void kernels_ghosts(void *user)
{
    kernels *k = (kernels *)user;
    pd_ghosts_set_vector(&k->lab.bonds.ghosts, k->lab.flow.u);
    pd_ghosts_set_scalar(&k->lab.bonds.ghosts, k->f);
}

static void kernels_add(kernels *k, const char *name, void (*run)(void *user), double nodes)
{
    bench_job *job = &k->job[k->jobs++];
    job->name = name;
    job->run = run;
    job->user = k;
    job->nodes = nodes;
}

static void kernels_free(kernels *k)
{
    int64_t total = k->lab.grid.total;
    PD_DELETE(k->ctx, total, k->f);
    PD_DELETE(k->ctx, total, k->g);
    PD_DELETE(k->ctx, (PD_DIM + 1) * total, k->vector);
    PD_DELETE(k->ctx, (PD_DIM + 1) * total, k->other);
    pdi_array_registry_free(k->ctx, pdi_jacobian_list_work, &k->jacobian);
    pdi_jacobian_free(k->ctx, &k->jacobian);
    if (k->holds) pdi_transport_release(k->ctx, &k->lab.transport, PD_OK);
    pdi_multigrid_free(k->ctx, &k->pressure);
    pdi_array_registry_free(k->ctx, pdi_compact_operator_list, &k->compact);
    pdi_array_registry_free(k->ctx, pdi_compact_operator_face_list, &k->compact);
    triad_free(k->ctx, &k->triad);
    lab_free(k->ctx, &k->lab);
}

/* Waves of one period in a unit box. */
static double kernels_wave(const double *x, int d)
{
    double value = sin(2.0 * val_pi * x[d]);
    for (int e = 0; e < PD_DIM; e++)
        if (e != d) value *= cos(2.0 * val_pi * x[e]);
    return value;
}

static void kernels_fields(kernels *k)
{
    const pd_grid *grid = &k->lab.grid;
    for (int32_t i = 0; i < grid->total; i++) {
        double x[PD_DIM];
        pd_grid_position(grid, i, x);
        for (int d = 0; d < PD_DIM; d++) k->lab.flow.u[(int64_t)d * grid->total + i] = 0.3 + kernels_wave(x, d);
        k->f[i] = k->lab.flow.p[i] = kernels_wave(x, 0);
        k->lab.transport.c[i] = 2.0 + k->f[i];
    }
    pdi_flow_update_derived_fields(k->ctx, &k->lab.flow);
}

/* The cycle of the pressure as the steady solver builds it. */
static pd_status kernels_multigrid(kernels *k)
{
    pd_multigrid_desc desc;
    pdi_compact_operator_bc faces;
    pdi_compact_operator_convection resting;
    const pd_grid *grid = &k->lab.grid;
    memset(&faces, 0, sizeof faces);
    memset(&resting, 0, sizeof resting);
    pdi_compact_operator_multigrid_desc(grid, &desc); /* periodic all round */
    desc.symmetric = 1;
    pdi_compact_operator_init(grid, 0, &k->compact);
    PD_TRY(pdi_array_registry_build(k->ctx, pdi_compact_operator_list, &k->compact));
    PD_TRY(pdi_array_registry_build(k->ctx, pdi_compact_operator_face_list, &k->compact));
    pdi_compact_operator_assemble(k->ctx, 1.0, NULL, &resting, 1.0, &faces, &k->compact);
    PD_TRY(multigrid_build(k->ctx, &desc, &k->pressure));
    return pdi_multigrid_setup(k->ctx, &k->pressure, k->compact.active, (const float *const *)k->compact.conductance,
                               NULL, k->compact.dirichlet, k->compact.mass);
}

static pd_status kernels_build(bench *b, kernels *k, int n, double m)
{
    val_lab *lab = &k->lab;
    memset(k, 0, sizeof *k);
    k->ctx = b->ctx;
    lab_box(lab, 1.0 / n, m, 0.0, 1.0);
    for (int side = 0; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_PERIODIC;
    lab->flow_desc.rho = lab->flow_desc.report_speed = lab->flow_desc.report_length = 1.0;
    lab->flow_desc.mu = 1e-2;
    lab->transport_desc.diffusivity = 1e-4;
    PD_TRY(lab_build(b->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    int64_t total = lab->grid.total;
    PD_TRY(PD_NEW(b->ctx, "bench", total, k->f));
    PD_TRY(PD_NEW(b->ctx, "bench", total, k->g));
    PD_TRY(PD_NEW(b->ctx, "bench", (PD_DIM + 1) * total, k->vector));
    PD_TRY(PD_NEW(b->ctx, "bench", (PD_DIM + 1) * total, k->other));
    PD_TRY(triad_build(b->ctx, total, &k->triad));
    kernels_fields(k);
    PD_TRY(pdi_jacobian_build(b->ctx, &lab->flow, &k->jacobian));
    PD_TRY(pdi_array_registry_build(b->ctx, pdi_jacobian_list_work, &k->jacobian));
    pdi_jacobian_set_state(b->ctx, &k->jacobian);
    PD_TRY(pdi_transport_hold(b->ctx, &lab->transport));
    k->holds = 1;
    PD_TRY(kernels_multigrid(k));
    double nodes = (double)lab->grid.fluid_count;
    kernels_add(k, "triad", kernels_triad, (double)total);
    kernels_add(k, "laplacian", kernels_laplacian, nodes);
    kernels_add(k, "gradient", kernels_gradient, nodes);
    kernels_add(k, "divergence", kernels_divergence, nodes);
    kernels_add(k, "diffuse", kernels_diffuse, nodes);
    kernels_add(k, "flow_residual", kernels_residual, nodes);
    kernels_add(k, "flow_product", kernels_product, nodes);
    kernels_add(k, "transport", kernels_transport, nodes);
    kernels_add(k, "limiter", kernels_limiter, nodes);
    kernels_add(k, "multigrid", kernels_cycle, nodes);
    /* values, not nodes */
    kernels_add(k, "ghosts", kernels_ghosts, (double)lab->bonds.ghosts.outlets_end * (PD_DIM + 1));
    return PD_OK;
}

/* Jobs named, or all; rates on one and on all threads into rate[job][0 and 1]. */
static void kernels_time(bench *b, kernels *k, const char *part, int n, double m, double rate[][2])
{
    for (int pass = 0; pass < 2; pass++) {
        int threads = pass ? b->threads : 1;
        if (pass && threads == 1) break;
        bench_time(b, k->job, k->jobs, threads);
        for (int j = 0; j < k->jobs; j++) {
            rate[j][pass] = bench_rate(&k->job[j]);
            bench_time_result(b, part, n, m, &k->job[j], &k->job[0], threads);
        }
    }
}

static void kernels_head(bench *b, const char *first)
{
    table_row *head = bench_row(b);
    table_cell(head, "%s", first);
    table_cell(head, "Mnode/s");
    table_cell(head, "ns/node");
    table_cell(head, "triad share");
    if (b->threads == 1) return;
    table_cell(head, "Mnode/s, %d threads", b->threads);
    table_cell(head, "triad share");
    table_cell(head, "speed-up");
}

static void kernels_line(bench *b, const char *name, const double *rate, const double *bound)
{
    table_row *row = bench_row(b);
    table_cell(row, "%s", name);
    table_cell(row, "%.1f", 1e-6 * rate[0]);
    table_cell(row, "%.2f", 1e9 / rate[0]);
    table_cell(row, "%.3f", rate[0] / bound[0]);
    if (b->threads == 1) return;
    table_cell(row, "%.1f", 1e-6 * rate[1]);
    table_cell(row, "%.3f", rate[1] / bound[1]);
    table_cell(row, "%.2f", rate[1] / rate[0]);
}

/* The goals of the project hold for m = 3 at full size. Speed-ups are judged where the threads had their cores to
 * themselves. */
static void kernels_goals(bench *b, const kernels *k, double rate[][2])
{
#if PD_DIM == 2
    bench_judge(b, "Laplacian, 1024^2, m = 3, one thread: share of the triad-bound rate", 1, 0.5,
                rate[1][0] / rate[0][0]);
#elif PD_DIM == 3
    static const int which[3] = {1, 5, 7}; /* of kernels_build */
    char text[96];
    bench_judge(b, "Laplacian, 128^3, m = 3, one thread: share of the triad-bound rate", 1, 0.2,
                rate[1][0] / rate[0][0]);
    bench_judge(b, "Laplacian, 128^3, m = 3, one thread: ns/node", 0, 8.0, 1e9 / rate[1][0]);
    if (b->threads != 2 || !bench_alone(b)) return;
    for (int j = 0; j < 3; j++) {
        snprintf(text, sizeof text, "%s, 128^3, m = 3: speed-up on two threads", k->job[which[j]].name);
        bench_judge(b, text, 1, 1.8, rate[which[j]][1] / rate[which[j]][0]);
    }
#endif
    (void)b, (void)k, (void)rate;
}

/* Cells along an edge. In 3D only the default horizon is timed on the large box. */
static int kernels_size(const bench *b, double m)
{
    if (b->n) return b->n;
    if (PD_DIM == 1) return b->quick ? 1000 : 1 << 20;
    if (PD_DIM == 2) return b->quick ? 32 : 1024;
    return b->quick ? 12 : m > 2.9 && m < 3.1 ? 128 : 64;
}

static pd_status kernels_horizon(bench *b, kernels *k, double m)
{
    char title[96];
    double rate[KERNELS][2];
    int n = kernels_size(b, m);
    memset(rate, 0, sizeof rate);
    PD_TRY(kernels_build(b, k, n, m));
    kernels_time(b, k, "kernels", n, m, rate);
    kernels_head(b, "kernel");
    for (int j = 0; j < k->jobs; j++) kernels_line(b, k->job[j].name, rate[j], rate[0]);
    snprintf(title, sizeof title, "m = %g, %d bonds a family, %d nodes along an edge", m, k->lab.stencil.count, n);
    bench_table(b, title);
    if (m > 2.9 && m < 3.1 && !b->quick && !b->n) kernels_goals(b, k, rate);
    return PD_OK;
}

static pd_status kernels_run(bench *b)
{
    static kernels k;
    double least = b->m > 0.0 ? b->m : b->quick ? 3.0 : 2.0, most = b->m > 0.0 ? b->m : b->quick ? 3.0 : 5.0;
    for (double m = least; m <= most; m += 1.0) {
        pd_status status = kernels_horizon(b, &k, m);
        kernels_free(&k);
        if (status < 0) return status;
    }
    return PD_OK;
}

static const bench_case kernels_case = {
    "kernels", "Operators",
    "One evaluation of every operator in a periodic box, where all families are whole: the operators of `op`, the "
    "residual of the flow with its ghosts and gradients, the linearised product of a Newton step, the operator of "
    "transport with the fluxes of its bonds, the limited fluxes, one multigrid cycle of the pressure, and the "
    "ghosts of a vector and a scalar (for these, each value counts as a node). The share is that of the rate at which "
    "a triad a = b + s c on arrays of the same size runs in the same minute, 24 bytes a node; a kernel that reads one "
    "field and writes one has 16, so short families can come out above 1. Least time of several repetitions, triad "
    "and kernels taking turns; processor time on one thread, wall time on two, so on a machine that is busy with "
    "other work the columns of two threads mean little. Shares compare machines badly: where the arrays of the triad "
    "fit into a cache (32 MB of an AMD EPYC: 1.3 to 2.3 Gnode/s), the Laplacian in 2D is bound by its sums, at 0.2 to "
    "0.26 of it; where they do not (an Intel Xeon), it ran at 0.83. The goals were written beside a triad of 25 GB/s, "
    "1.04 Gnode/s.",
    kernels_run};

/* ---- a matrix in rows ---- */

/* The same Laplacian as a plain matrix: rows, columns and values, the diagonal among them. */
typedef struct matrix {
    pd_ctx *ctx;
    int32_t rows;
    int64_t entries;
    int64_t *row; /* [rows + 1] */
    int32_t *col;
    double *value;
    double *x, *y; /* [rows] */
} matrix;

static void matrix_apply(void *user)
{
    matrix *a = (matrix *)user;
    const int64_t *PD_RESTRICT row = a->row;
    const int32_t *PD_RESTRICT col = a->col;
    const double *PD_RESTRICT value = a->value, *PD_RESTRICT x = a->x;
    double *PD_RESTRICT y = a->y;
    int nt = pd_par_threads(a->ctx, a->entries);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < a->rows; i++) {
        double sum = 0.0;
        for (int64_t k = row[i]; k < row[i + 1]; k++) sum += value[k] * x[col[k]];
        y[i] = sum;
    }
}

static void matrix_free(pd_ctx *ctx, matrix *a)
{
    PD_DELETE(ctx, a->rows + 1, a->row);
    PD_DELETE(ctx, a->entries, a->col);
    PD_DELETE(ctx, a->entries, a->value);
    PD_DELETE(ctx, a->rows, a->x);
    PD_DELETE(ctx, a->rows, a->y);
}

/* Rows in the order of the nodes; number [total]: the row of a node. Far ends behind a side are those that the images
 * repeat. */
static pd_status matrix_build(kernels *k, int32_t *number, matrix *a)
{
    const pd_grid *grid = &k->lab.grid;
    const pd_stencil *st = &k->lab.stencil;
    a->ctx = k->ctx;
    a->rows = 0;
    for (int32_t i = 0; i < grid->total; i++) number[i] = grid->kind[i] == PD_FLUID ? a->rows++ : -1;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_IMAGE) number[i] = number[pd_grid_find_source(grid, i, NULL)];
    a->entries = (int64_t)a->rows * (st->count + 1);
    PD_TRY(PD_NEW(k->ctx, "matrix", a->rows + 1, a->row));
    PD_TRY(PD_NEW(k->ctx, "matrix", a->entries, a->col));
    PD_TRY(PD_NEW(k->ctx, "matrix", a->entries, a->value));
    PD_TRY(PD_NEW(k->ctx, "matrix", a->rows, a->x));
    PD_TRY(PD_NEW(k->ctx, "matrix", a->rows, a->y));
    int64_t at = 0;
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID) continue;
        int64_t diagonal = at + st->count / 2;
        a->x[number[i]] = k->f[i];
        for (int j = 0; j < st->count; j++, at++) {
            if (at == diagonal) a->col[at++] = number[i];
            a->col[at] = number[i + k->lab.bonds.paths.shift[j]];
            a->value[at] = st->laplacian_weight[j];
            a->value[diagonal] -= st->laplacian_weight[j];
        }
        a->row[number[i] + 1] = at;
    }
    return PD_OK;
}

/* The same operator with a row of bonds for every node. */
typedef struct rows_path {
    pd_ctx *ctx;
    pd_bonds bonds;
    double *f, *g;
} rows_path;

static void rows_apply(void *user)
{
    rows_path *r = (rows_path *)user;
    pd_op_laplacian(r->ctx, &r->bonds, r->f, r->g);
}

/* Largest difference of both other ways from the swept one, over its largest value. */
static double csr_differs(const kernels *k, const int32_t *number, const matrix *a)
{
    double off = 0.0, size = 0.0;
    for (int32_t i = 0; i < k->lab.grid.total; i++) {
        if (k->lab.grid.kind[i] != PD_FLUID) continue;
        off = fmax(off, fmax(fabs(a->y[number[i]] - k->g[i]), fabs(k->vector[i] - k->g[i])));
        size = fmax(size, fabs(k->g[i]));
    }
    return off / size;
}

static pd_status csr_compare(bench *b, kernels *k, matrix *a, rows_path *rows, int32_t *number, int n, double m)
{
    bench_job *job = k->job;
    char title[96];
    double rate[KERNELS][2];
    memset(rate, 0, sizeof rate);
    PD_TRY(matrix_build(k, number, a));
    rows->ctx = k->ctx;
    rows->f = k->f;
    rows->g = k->vector;
    PD_TRY(pd_bonds_build(k->ctx, &k->lab.stencil, &k->lab.grid, 1, &rows->bonds));
    k->jobs = 2; /* triad and swept Laplacian */
    kernels_add(k, "rows", rows_apply, job[1].nodes);
    kernels_add(k, "csr", matrix_apply, job[1].nodes);
    job[2].user = rows;
    job[3].user = a;
    kernels_time(b, k, "csr", n, m, rate);
    kernels_head(b, "Laplacian");
    for (int j = 0; j < k->jobs; j++) kernels_line(b, job[j].name, rate[j], rate[0]);
    snprintf(title, sizeof title, "m = %g, %d bonds a family, %d nodes along an edge", m, k->lab.stencil.count, n);
    bench_table(b, title);
    double off = csr_differs(k, number, a);
    bench_result(b, "part=agreement n=%d m=%g err_max=%.3g", n, m, off);
    if (!(off < 1e-9))
        return pd_fail(b->ctx, PD_ERR_INTERNAL, "bench", "the three Laplacians differ by %.3g", off);
    if (PD_DIM == 2 && !b->quick && !b->n)
        bench_judge(b, "Laplacian, 1024^2, m = 3, one thread: rate over that of CSR", 1, 15.0, rate[1][0] / rate[3][0]);
    return PD_OK;
}

static pd_status csr_run(bench *b)
{
    static kernels k;
    static matrix a;
    static rows_path rows;
    int32_t *number = NULL;
    int n = b->n ? b->n : b->quick ? (PD_DIM == 2 ? 32 : 12) : PD_DIM == 2 ? 1024 : 64;
    double m = b->m > 0.0 ? b->m : 3.0;
    memset(&a, 0, sizeof a);
    memset(&rows, 0, sizeof rows);
    pd_status status = kernels_build(b, &k, n, m);
    if (status == PD_OK) status = PD_NEW(b->ctx, "bench", k.lab.grid.total, number);
    if (status == PD_OK) status = csr_compare(b, &k, &a, &rows, number, n, m);
    PD_DELETE(b->ctx, k.lab.grid.total, number);
    matrix_free(b->ctx, &a);
    pd_bonds_free(b->ctx, &rows.bonds);
    kernels_free(&k);
    return status;
}

static const bench_case csr_case = {
    "csr", "Stencil, rows and a matrix",
    "The Laplacian in three ways, which agree to rounding: `laplacian`, swept with the shared stencil; `rows`, bond by "
    "bond with a row for every node, the path of nodes beside walls and metal; `csr`, a plain loop over a matrix in "
    "compressed rows (columns of 4 bytes, values of 8, sorted), the loop that neighbour lists amount to. Triad and "
    "Laplacians take turns.",
    csr_run};

/* ---- triad ---- */

static pd_status triad_sizes_run(bench *b)
{
    table_row *head = bench_row(b);
    triad t;
    table_cell(head, "nodes");
    table_cell(head, "arrays [MB]");
    table_cell(head, "GB/s");
    if (b->threads > 1) table_cell(head, "GB/s, %d threads", b->threads);
    for (int64_t n = 1 << 12; n <= (b->quick ? 1 << 16 : 1 << 24); n *= 16) {
        bench_job job;
        table_row *row = bench_row(b);
        memset(&job, 0, sizeof job);
        PD_TRY(triad_build(b->ctx, n, &t));
        job.name = "triad";
        job.run = triad_run;
        job.user = &t;
        job.nodes = (double)n;
        table_cell(row, "%.0f", (double)n);
        table_cell(row, "%.1f", 24e-6 * (double)n);
        for (int threads = 1; threads <= b->threads; threads += b->threads > 1 ? b->threads - 1 : 1) {
            bench_time(b, &job, 1, threads);
            table_cell(row, "%.1f", 24e-9 * bench_rate(&job));
            bench_time_result(b, "sizes", (int)n, 0.0, &job, &job, threads);
        }
        triad_free(b->ctx, &t);
    }
    bench_table(b, "a = b + s c, 24 bytes a node");
    return PD_OK;
}

static const bench_case triad_case = {
    "triad", "Bandwidth",
    "What the memory of this machine moves. Arrays that fit into a cache are faster than the memory; the share of the "
    "triad-bound rate in the other cases is that of a triad of their own size.",
    triad_sizes_run};

#endif
