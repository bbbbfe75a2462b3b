/* csr: the matrix of an operator by rows against the operator, entry by entry and on random fields.
 * dims: 1 2 3 */
#include "lattice/csr.h"
#include "lattice/op.h"
#include "core/rng.h"
#include "test.h"
#include <stdlib.h>

#define SAME 1e-12 /* [-] of a row's sum of magnitudes */

typedef enum scene_kind { CLOSED, PERIODIC, MIRROR, PORTS, CURVED, RINGS, SCENES } scene_kind;

typedef struct scene {
    pd_ctx ctx;
    pd_stencil stencil;
    pd_shape shape;
    pd_grid grid;
    pd_bonds bonds;
    double *f, *d, *out, *x, *y; /* [PD_DIM][total] each */
} scene;

static scene test_scene;

static double random_real(uint64_t k) { return 2.0 * pdi_rng_uniform(7, 3, k) - 1.0; }

static int scene_init(scene *s, scene_kind kind)
{
    static const int cells[3][3] = {{22, 0, 0}, {11, 12, 0}, {8, 7, 6}};
    pd_stencil_desc sd;
    pd_grid_desc gd;
    memset(s, 0, sizeof *s);
    memset(&sd, 0, sizeof sd);
    memset(&gd, 0, sizeof gd);
    pd_ctx_init(&s->ctx);
    sd.m = PD_DIM == 3 ? 2.0 : 3.0;
    gd.axisymmetric = kind == RINGS;
    for (int d = 0; d < PD_DIM; d++) {
        sd.h[d] = kind == RINGS ? 0.1 : 0.1 * (1.0 + 0.5 * d);
        gd.lo[d] = kind == RINGS ? 0.0 : -0.5 * cells[PD_DIM - 1][d] * sd.h[d];
        gd.hi[d] = gd.lo[d] + cells[PD_DIM - 1][d] * sd.h[d];
        if (kind == PERIODIC) gd.side[2 * d] = gd.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    if (kind == MIRROR || kind == CURVED) gd.side[0] = PD_SIDE_MIRROR;
    if (kind == MIRROR) gd.side[2 * PD_DIM - 1] = PD_SIDE_MIRROR;
    if (kind == RINGS) gd.side[2 * PD_DIM - 2] = PD_SIDE_MIRROR;
    if (kind == PORTS) gd.side[0] = PD_SIDE_INLET;
    if (kind == PORTS) gd.side[1] = PD_SIDE_OUTLET;
    if (kind == CURVED) {
        s->shape.type = PD_SHAPE_BALL;
        s->shape.radius = 0.23;
        s->shape.a[0] = 0.07;
        gd.shapes = &s->shape;
        gd.solid = &s->shape;
    }
    if (!CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &sd, &s->stencil)) ||
        !CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &gd, &s->grid)) ||
        !CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)))
        return 0;
    s->f = (double *)calloc((size_t)s->grid.total * PD_DIM * 5, sizeof(double));
    if (!CHECK(s->f != NULL)) return 0;
    s->d = s->f + (int64_t)PD_DIM * s->grid.total;
    s->out = s->d + (int64_t)PD_DIM * s->grid.total;
    s->x = s->out + (int64_t)PD_DIM * s->grid.total;
    s->y = s->x + (int64_t)PD_DIM * s->grid.total;
    for (int32_t i = 0; i < s->grid.total; i++) s->d[i] = 1.5 + random_real((uint64_t)i);
    pd_ghosts_set_scalar(&s->bonds.ghosts, s->d);
    return 1;
}

static void scene_free(scene *s)
{
    pd_bonds_free(&s->ctx, &s->bonds);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT(s->ctx.in_use, 0);
    free(s->f);
}

/* What the operator makes of the field f [total] (for the divergence: of a vector with that component alone), whose
 * ghosts are filled here: at fluid nodes of out [total]. */
static void apply(scene *s, const pd_csr_desc *desc, double *f, double *out)
{
    int32_t total = s->grid.total;
    double *vector = s->y;
    if (desc->op != PD_CSR_DIVERGENCE) pd_ghosts_set_scalar(&s->bonds.ghosts, f);
    switch (desc->op) {
    case PD_CSR_LAPLACIAN: pd_op_laplacian(&s->ctx, &s->bonds, f, out); break;
    case PD_CSR_DIFFUSE: CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->d, f, out)); break;
    case PD_CSR_GRADIENT:
        pd_op_gradient(&s->ctx, &s->bonds, f, vector);
        memcpy(out, vector + (int64_t)desc->axis * total, (size_t)total * sizeof(double));
        break;
    case PD_CSR_DIVERGENCE:
        memset(vector, 0, (size_t)total * PD_DIM * sizeof(double));
        memcpy(vector + (int64_t)desc->axis * total, f, (size_t)total * sizeof(double));
        pd_ghosts_set_vector(&s->bonds.ghosts, vector);
        memcpy(f, vector + (int64_t)desc->axis * total, (size_t)total * sizeof(double));
        pd_op_divergence(&s->ctx, &s->bonds, vector, out);
        break;
    }
}

static double row_size(const pd_csr *c, int32_t r)
{
    double size = 0.0;
    for (int64_t k = c->row_begin[r]; k < c->row_begin[r + 1]; k++) size += fabs(c->weight[k]);
    for (int64_t k = c->prescribed_begin[r]; k < c->prescribed_begin[r + 1]; k++) size += fabs(c->prescribed_weight[k]);
    return size;
}

/* Rows are ordered, hold their diagonal, and the numbers of nodes go both ways. */
static void check_form(const scene *s, const pd_csr *c)
{
    for (int32_t r = 0; r < c->rows; r++) {
        int diagonal = 0;
        CHECK_INT(c->row_of_node[c->node[r]], r);
        CHECK_INT(s->grid.kind[c->node[r]], PD_FLUID);
        for (int64_t k = c->row_begin[r]; k < c->row_begin[r + 1]; k++) {
            diagonal += c->column[k] == r;
            if (k > c->row_begin[r]) CHECK(c->column[k] > c->column[k - 1]);
        }
        CHECK_INT(diagonal, 1);
    }
}

static double entry(const pd_csr *c, int32_t r, int32_t column)
{
    for (int64_t k = c->row_begin[r]; k < c->row_begin[r + 1]; k++)
        if (c->column[k] == column) return c->weight[k];
    return 0.0;
}

/* The columns that the operator makes of unit fields. */
static void check_entries(scene *s, const pd_csr_desc *desc)
{
    pd_csr c;
    if (!CHECK_OK(&s->ctx, pd_csr_build(&s->ctx, &s->bonds, desc, &c))) return;
    check_form(s, &c);
    CHECK_INT(c.rows, s->grid.fluid_count);
    CHECK_INT(c.prescribed_begin[c.rows], 0);
    for (int32_t j = 0; j < c.rows; j++) {
        memset(s->f, 0, (size_t)s->grid.total * sizeof(double));
        s->f[c.node[j]] = 1.0;
        apply(s, desc, s->f, s->out);
        for (int32_t r = 0; r < c.rows; r++) CHECK_NEAR(entry(&c, r, j), s->out[c.node[r]], SAME * row_size(&c, r));
    }
    pd_csr_free(&s->ctx, &c);
}

/* Random fields; every second node, at random, of the set where `masked`. */
static void check_product(scene *s, pd_csr_desc desc, int masked)
{
    pd_csr c;
    uint8_t *mask = (uint8_t *)calloc((size_t)s->grid.total, 1);
    if (!CHECK(mask != NULL)) return;
    for (int32_t i = 0; i < s->grid.total; i++) mask[i] = random_real((uint64_t)i + 50000) > 0.0;
    if (masked) desc.mask = mask;
    if (!CHECK_OK(&s->ctx, pd_csr_build(&s->ctx, &s->bonds, &desc, &c))) return;
    check_form(s, &c);
    CHECK(masked ? c.rows < s->grid.fluid_count && c.prescribed_begin[c.rows] > 0 : c.rows == s->grid.fluid_count);
    for (int32_t i = 0; i < s->grid.total; i++)
        s->f[i] = pdi_grid_is_open(s->grid.kind[i]) ? random_real((uint64_t)i + 100000) : (double)NAN;
    apply(s, &desc, s->f, s->out);
    for (int32_t r = 0; r < c.rows; r++) s->x[r] = s->f[c.node[r]];
    pd_csr_apply(&c, s->x, s->f, s->y);
    for (int32_t r = 0; r < c.rows; r++) CHECK_NEAR(s->y[r], s->out[c.node[r]], SAME * row_size(&c, r));
    pd_csr_free(&s->ctx, &c);
    free(mask);
}

static void each_operator(scene *s, void (*check)(scene *s, const pd_csr_desc *desc))
{
    for (int op = PD_CSR_LAPLACIAN; op <= PD_CSR_DIVERGENCE; op++)
        for (int axis = 0; axis < (op >= PD_CSR_GRADIENT ? PD_DIM : 1); axis++) {
            pd_csr_desc desc;
            memset(&desc, 0, sizeof desc);
            desc.op = (pd_csr_operator)op;
            desc.axis = axis;
            desc.diffusivity = s->d;
            check(s, &desc);
        }
}

static void check_products(scene *s, const pd_csr_desc *desc)
{
    check_product(s, *desc, 0);
    check_product(s, *desc, 1);
}

TEST(entry_by_entry)
{
    for (int kind = CLOSED; kind < SCENES; kind++) {
        if (kind == PORTS || (kind == RINGS && PD_DIM != 2)) continue;
        if (!scene_init(&test_scene, (scene_kind)kind)) return;
        each_operator(&test_scene, check_entries);
        scene_free(&test_scene);
    }
}

TEST(products_on_random_fields)
{
    for (int kind = CLOSED; kind < SCENES; kind++) {
        if (kind == RINGS && PD_DIM != 2) continue;
        if (!scene_init(&test_scene, (scene_kind)kind)) return;
        each_operator(&test_scene, check_products);
        scene_free(&test_scene);
    }
}

/* Held values at the ends of a strip: the matrix and its right-hand side give the linear profile between them. */
TEST(dirichlet_problem)
{
    scene *s = &test_scene;
    pd_csr_desc desc;
    pd_csr c;
    if (!scene_init(s, PERIODIC)) return;
    uint8_t *mask = (uint8_t *)calloc((size_t)s->grid.total, 1);
    if (!CHECK(mask != NULL)) return;
    memset(&desc, 0, sizeof desc);
    desc.mask = mask;
    /* fluid within three cells of the ends of axis 0 is held, as deep as a family reaches */
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        mask[i] = fabs(x[0]) < s->grid.hi[0] - 3.01 * s->grid.h[0];
        s->f[i] = 2.0 + x[0];
    }
    if (!CHECK_OK(&s->ctx, pd_csr_build(&s->ctx, &s->bonds, &desc, &c))) return;
    memset(s->x, 0, (size_t)c.rows * sizeof(double));
    for (int sweep = 0; sweep < 2000; sweep++) /* Gauss-Seidel */
        for (int32_t r = 0; r < c.rows; r++) {
            double sum = 0.0;
            for (int64_t k = c.row_begin[r]; k < c.row_begin[r + 1]; k++)
                if (c.column[k] != r) sum += c.weight[k] * s->x[c.column[k]];
            for (int64_t k = c.prescribed_begin[r]; k < c.prescribed_begin[r + 1]; k++)
                sum += c.prescribed_weight[k] * s->f[c.prescribed[k]];
            s->x[r] = -sum / entry(&c, r, r);
        }
    for (int32_t r = 0; r < c.rows; r++) CHECK_NEAR(s->x[r], s->f[c.node[r]], 1e-10);
    pd_csr_free(&s->ctx, &c);
    free(mask);
    scene_free(s);
}

/* Images have the diffusivity of their source, whatever the field holds there, in the matrix and in the operator. */
TEST(images_take_the_diffusivity_of_their_source)
{
    scene *s = &test_scene;
    static const scene_kind kinds[] = {PERIODIC, MIRROR, RINGS};
    for (int kind = 0; kind < 3; kind++) {
        pd_csr_desc desc;
        if ((PD_DIM != 2 && kinds[kind] == RINGS) || !scene_init(s, kinds[kind])) continue;
        for (int32_t i = 0; i < s->grid.total; i++) s->f[i] = random_real(100000 + (uint64_t)i);
        pd_ghosts_set_scalar(&s->bonds.ghosts, s->f);
        CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->d, s->f, s->y));
        size_t before = s->ctx.in_use;
        for (int32_t k = 0; k < s->bonds.ghosts.images_end; k++)
            s->d[s->bonds.ghosts.node[k]] = k % 3 == 0 ? NAN : k % 3 == 1 ? -1.0 : 7.0;
        CHECK(s->bonds.ghosts.images_end > 0);
        CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->d, s->f, s->out));
        CHECK_INT(s->ctx.in_use, before);
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) CHECK_NEAR(s->out[i], s->y[i], 0.0);
        memset(&desc, 0, sizeof desc);
        desc.op = PD_CSR_DIFFUSE;
        desc.diffusivity = s->d;
        check_entries(s, &desc);
        scene_free(s);
    }
}

TEST(what_is_refused)
{
    scene *s = &test_scene;
    pd_csr_desc desc;
    pd_csr c;
    if (!scene_init(s, CLOSED)) return;
    memset(&desc, 0, sizeof desc);
    desc.op = PD_CSR_GRADIENT;
    desc.axis = PD_DIM;
    CHECK_INT(pd_csr_build(&s->ctx, &s->bonds, &desc, &c), PD_ERR_ARGUMENT);
    desc.op = PD_CSR_DIFFUSE;
    CHECK_INT(pd_csr_build(&s->ctx, &s->bonds, &desc, &c), PD_ERR_ARGUMENT);
    CHECK_STR(s->ctx.message, "csr: there is no diffusivity");
    desc.diffusivity = s->d;
    for (int32_t i = 0; i < s->grid.total; i++) s->d[i] = -1.0;
    CHECK_INT(pd_csr_build(&s->ctx, &s->bonds, &desc, &c), PD_ERR_ARGUMENT);
    uint8_t *mask = (uint8_t *)calloc((size_t)s->grid.total, 1);
    desc.op = PD_CSR_LAPLACIAN;
    desc.mask = mask;
    CHECK_INT(pd_csr_build(&s->ctx, &s->bonds, &desc, &c), PD_ERR_GEOMETRY);
    CHECK(c.rows == 0 && !c.row_begin);
    free(mask);
    desc.mask = NULL;
    /* every allocation that fails leaves nothing behind */
    size_t before = s->ctx.in_use;
    CHECK_OK(&s->ctx, pd_csr_build(&s->ctx, &s->bonds, &desc, &c));
    size_t after = s->ctx.in_use;
    pd_csr_free(&s->ctx, &c);
    pd_csr_free(&s->ctx, &c);
    CHECK_INT(s->ctx.in_use, before);
    for (size_t limit = before + 1; limit < after; limit += (after - before) / 23 + 1) {
        s->ctx.alloc.limit = limit;
        CHECK_INT(pd_csr_build(&s->ctx, &s->bonds, &desc, &c), PD_ERR_LIMIT);
        CHECK_INT(s->ctx.in_use, before);
    }
    scene_free(s);
}

TEST_MAIN(ENTRY(entry_by_entry) ENTRY(products_on_random_fields) ENTRY(dirichlet_problem)
              ENTRY(images_take_the_diffusivity_of_their_source) ENTRY(what_is_refused))
