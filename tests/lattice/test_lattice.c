/* lattice: one object and its fields; a diffusion loop against its decay; no memory left behind.
 * dims: 1 2 3 */
#include "lattice/lattice.h"
#include "lattice/op.h"
#include "test.h"

#define CELLS 24

static pd_lattice lattice;

/* A box of CELLS cells of size 1 along axis 0, a few along the others. */
static void describe(pd_lattice_desc *desc)
{
    memset(desc, 0, sizeof *desc);
    for (int d = 0; d < PD_DIM; d++) {
        desc->stencil.h[d] = 1.0;
        desc->grid.hi[d] = d ? 8.0 : CELLS;
    }
}

/* A cosine between mirrors decays at the rate (pi/L)^2, to the order of h^2. Nothing leaves. */
TEST(diffusion_loop)
{
    pd_ctx ctx;
    pd_lattice_desc desc;
    double *c, *lap, x[PD_DIM], pi = 3.14159265358979323846, dt = 0.02, rate = pi / CELLS * (pi / CELLS);
    double above = 0.0, below = 0.0, sum = 0.0;
    const int steps = 2000;
    pd_ctx_init(&ctx);
    describe(&desc);
    for (int s = 0; s < 2 * PD_DIM; s++) desc.grid.side[s] = PD_SIDE_MIRROR;
    if (!CHECK_OK(&ctx, pd_lattice_build(&ctx, &desc, &lattice)) ||
        !CHECK_OK(&ctx, pd_lattice_add_field(&ctx, &lattice, 1, &c)) ||
        !CHECK_OK(&ctx, pd_lattice_add_field(&ctx, &lattice, 1, &lap)))
        return;
    for (int32_t i = 0; i < lattice.grid.total; i++) {
        pd_grid_position(&lattice.grid, i, x);
        if (lattice.grid.kind[i] == PD_FLUID) c[i] = cos(pi * x[0] / CELLS);
    }
    for (int step = 0; step < steps; step++) {
        pd_ghosts_set_scalar(&lattice.bonds.ghosts, c);
        pd_op_laplacian(&ctx, &lattice.bonds, c, lap);
        for (int32_t i = 0; i < lattice.grid.total; i++) c[i] += dt * lap[i];
    }
    for (int32_t i = 0; i < lattice.grid.total; i++) {
        if (lattice.grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lattice.grid, i, x);
        double mode = cos(pi * x[0] / CELLS);
        above += mode * c[i];
        below += mode * mode;
        sum += c[i];
    }
    CHECK_REL(-log(above / below) / (dt * steps), rate, 0.01);
    CHECK_NEAR(sum, 0.0, 1e-10 * below);
    pd_lattice_free(&ctx, &lattice);
    CHECK_INT(ctx.in_use, 0);
}

TEST(many_fields)
{
    pd_ctx ctx;
    pd_lattice_desc desc;
    double *field[20];
    pd_ctx_init(&ctx);
    describe(&desc);
    if (!CHECK_OK(&ctx, pd_lattice_build(&ctx, &desc, &lattice))) return;
    for (int k = 0; k < 20; k++) {
        int components = 1 + k % 3;
        if (!CHECK_OK(&ctx, pd_lattice_add_field(&ctx, &lattice, components, &field[k]))) return;
        int64_t size = (int64_t)components * lattice.grid.total;
        for (int64_t i = 0; i < size; i++) {
            CHECK_NEAR(field[k][i], 0.0, 0.0);
            field[k][i] = k;
        }
    }
    for (int k = 0; k < 20; k++) CHECK_NEAR(field[k][lattice.grid.total - 1], k, 0.0);
    CHECK_INT(pd_lattice_add_field(&ctx, &lattice, 0, &field[0]), PD_ERR_ARGUMENT);
    CHECK(field[0] == NULL);
    pd_lattice_free(&ctx, &lattice);
    pd_lattice_free(&ctx, &lattice);
    CHECK_INT(ctx.in_use, 0);
}

/* A build or a field for which there is no memory changes nothing. */
TEST(without_memory)
{
    pd_ctx ctx;
    pd_lattice_desc desc;
    double *field;
    pd_ctx_init(&ctx);
    describe(&desc);
    CHECK_OK(&ctx, pd_lattice_build(&ctx, &desc, &lattice));
    size_t built = ctx.in_use;
    ctx.alloc.limit = built + 8;
    CHECK_INT(pd_lattice_add_field(&ctx, &lattice, 1, &field), PD_ERR_LIMIT);
    CHECK(field == NULL && lattice.fields == 0);
    CHECK_INT(ctx.in_use, built);
    ctx.alloc.limit = 0;
    pd_lattice_free(&ctx, &lattice);
    for (size_t limit = 1; limit < built; limit += built / 29 + 1) {
        ctx.alloc.limit = limit;
        CHECK_INT(pd_lattice_build(&ctx, &desc, &lattice), PD_ERR_LIMIT);
        CHECK_INT(ctx.in_use, 0);
        CHECK(!lattice.grid.kind && !lattice.bonds.row_of_node);
    }
    desc.stencil.h[0] = -1.0;
    ctx.alloc.limit = 0;
    CHECK(pd_lattice_build(&ctx, &desc, &lattice) < 0);
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(diffusion_loop) ENTRY(many_fields) ENTRY(without_memory))
