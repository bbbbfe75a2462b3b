/* test_surface_correction: bars of springs: their stiffness by each way to mend cut families; what factors are.
 * dims: 2 3 */
#include "solid/equilibrium.h"
#include "solid/body_bonds.h"
#include "solid/microelastic.h"
#include "test.h"
#include <math.h>

#define MOST 4000 /* points */

typedef struct bar {
    pd_ctx ctx;
    pd_body body;
    pd_microelastic springs;
    double position[MOST * PD_DIM], volume[MOST], u[MOST * PD_DIM], force[MOST * PD_DIM];
    uint8_t held[MOST * PD_DIM];
    int n[3];
} bar;

static bar the_bar;

static void end(bar *c)
{
    pd_microelastic_free(&c->ctx, &c->springs);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

/* `length` by wide cells of width 1, or with slant 1, in 2D, along a diagonal of the lattice: E = 1. */
static bar *make(int length, int wide, int slant, double m, pd_microelastic_surface surface)
{
    bar *c = &the_bar;
    pd_body_desc desc;
    pd_microelastic_desc spring;
    int all = 1;
    memset(c, 0, sizeof *c);
    memset(&desc, 0, sizeof desc);
    memset(&spring, 0, sizeof spring);
    pd_ctx_init(&c->ctx);
    for (int d = 0; d < PD_DIM; d++) all *= c->n[d] = d ? wide : length;
    if (!CHECK(all <= MOST)) return NULL;
    for (int k = 0; k < all; k++) {
        double *x = c->position + k * PD_DIM;
        for (int d = 0, rest = k; d < PD_DIM; rest /= c->n[d], d++) x[d] = rest % c->n[d] - 0.5 * (c->n[d] - 1);
        if (slant) {
            double along = floor(x[0]), across = x[PD_DIM - 1] + 0.5 * (wide - 1);
            x[0] = along;
            x[PD_DIM - 1] = along - across;
        }
        c->volume[k] = 1.0;
    }
    desc.count = all;
    desc.position = c->position;
    desc.volume = c->volume;
    desc.horizon = m;
    desc.spacing = 1.0;
    spring.young = 1.0;
    spring.plane = PD_PLANE_STRESS;
    spring.surface = surface;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &desc, &c->body))) return NULL;
    return CHECK_OK(&c->ctx, pd_microelastic_build(&c->ctx, &c->body, &spring, &c->springs)) ? c : NULL;
}

/* Young's modulus of a bar that is pulled at its ends, from its middle. */
static double modulus(bar *c)
{
    pd_material_interface solid = pd_microelastic_material(&c->springs);
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    double pull = 0.0, far[2] = {0.0, 0.0};
    int length = c->n[0], area = c->body.count / length, points = length / 4;
    memset(&desc, 0, sizeof desc);
    for (int32_t i = 0; i < c->body.count; i++) {
        double x = c->position[i * PD_DIM];
        c->u[i * PD_DIM] = 1e-7 * x;
        c->held[i * PD_DIM] = i % length < 3 || i % length >= length - 3;
    }
    desc.prescribed = c->held;
    desc.rtol = 1e-8;
    if (!CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &solid, &desc, NULL, c->u, &result))) return 0.0;
    if (!CHECK_OK(&c->ctx, solid.force(&c->ctx, solid.self, c->u, c->force))) return 0.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        int at = i % length;
        if (at < 3) pull += c->force[i * PD_DIM];
        if (at == length / 2 - points / 2 || at == length / 2 - points / 2 + points)
            far[at > length / 2 - points / 2] += c->u[i * PD_DIM] / area;
    }
    return pull / area / ((far[1] - far[0]) / points);
}

/* Bars of all widths have the modulus of the bulk, where the other ways are too stiff or too soft. */
TEST(stiffness)
{
    static const int wide[2][4] = {{4, 8, 4, 8}, {3, 5, 3, 5}};
    for (int k = 0; k < 4; k++) {
        double young[4], m = k < 2 ? 2.0 : 3.0;
        int cells = wide[PD_DIM - 2][k];
        for (int way = 0; way < 4; way++) {
            bar *c = make(PD_DIM == 2 ? 12 * cells : 8 * cells, cells, 0, m, (pd_microelastic_surface)way);
            if (!c) return;
            young[way] = modulus(c);
            end(c);
        }
        NOTE("%d cells, m = %.0f: E by moments %.4f, energy %.4f, volume %.4f, none %.4f", cells, m, young[0], young[1],
             young[2], young[3]);
        CHECK_NEAR(young[0], 1.0, 0.01);
        for (int way = 1; way < 4; way++) CHECK(fabs(young[way] - 1.0) > 2.0 * fabs(young[0] - 1.0));
    }
}

/* Weights of all bonds. */
static void keep(const bar *c, float *to)
{
    for (int32_t i = 0; i < c->body.count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);)
            to[pdi_body_bond_number(&b)] = pdi_bond_weights_get(&c->springs.weights, i, &b);
}

/* Factors are within their bounds, the same at both ends and in the mirror image to the bit; whole families that join
 * whole ones have none, and a crack of the bulk takes what it took. */
TEST(factors)
{
    static float kept[2][MOST * 140];
    bar *c = make(PD_DIM == 2 ? 30 : 14, PD_DIM == 2 ? 20 : 14, 0, 2.0, PD_MICROELASTIC_NONE);
    int64_t whole = 0, bulk = 0;
    double least = 1.0, most = 1.0, critical;
    if (!c || !CHECK(c->body.bonds <= MOST * 140)) return;
    keep(c, kept[0]);
    critical = c->springs.critical;
    end(c);
    c = make(c->n[0], c->n[1], 0, 2.0, PD_MICROELASTIC_MOMENTS);
    if (!c) return;
    const pd_body *body = &c->body;
    keep(c, kept[1]);
    CHECK(c->springs.critical <= critical && c->springs.critical >= critical);
    for (int32_t i = 0; i < body->count; i++)
        if (body->first_bond[i + 1] - body->first_bond[i] > whole)
            whole = body->first_bond[i + 1] - body->first_bond[i];
    for (int32_t i = 0; i < body->count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
            int32_t j = b.neighbour, mirror[2] = {i, j};
            int64_t at = pdi_body_bond_number(&b);
            double factor = (double)kept[1][at] / (double)kept[0][at];
            least = fmin(least, factor);
            most = fmax(most, factor);
            int64_t back = body->first_bond[j] + pdi_body_bonds_find(body, i, j);
            CHECK(memcmp(&kept[1][at], &kept[1][back], sizeof(float)) == 0);
            for (int e = 0; e < 2; e++) mirror[e] += c->n[0] - 1 - 2 * (mirror[e] % c->n[0]);
            back = body->first_bond[mirror[1]] + pdi_body_bonds_find(body, mirror[0], mirror[1]);
            CHECK(memcmp(&kept[1][at], &kept[1][back], sizeof(float)) == 0);
            if (body->first_bond[i + 1] - body->first_bond[i] < whole ||
                body->first_bond[j + 1] - body->first_bond[j] < whole)
                continue;
            CHECK(memcmp(&kept[1][at], &kept[0][at], sizeof(float)) == 0);
            bulk++;
        }
    NOTE("factors from %.3f to %.3f; %.0f bonds of the bulk have none", least, most, (double)bulk);
    CHECK(bulk > 0 && least > 0.125 && most < 8.0);
    pd_microelastic_desc wrong;
    pd_microelastic other;
    memset(&wrong, 0, sizeof wrong);
    wrong.young = 1.0;
    wrong.surface = (pd_microelastic_surface)4;
    CHECK_INT(pd_microelastic_build(&c->ctx, &c->body, &wrong, &other), PD_ERR_ARGUMENT);
    end(c);
}

#if PD_DIM == 2
/* Bars along a diagonal of the lattice, whose sides are stairs. */
TEST(slanted)
{
    for (int cells = 6; cells <= 10; cells += 4) {
        double young[2];
        for (int way = 0; way < 2; way++) {
            bar *c = make(60, cells, 1, 2.0, (pd_microelastic_surface)way);
            if (!c) return;
            for (int32_t i = 0; i < c->body.count; i++) { /* stretched along the bar, with free sides */
                double x = c->position[i * 2], y = c->position[i * 2 + 1], e = 1e-7 * 0.5 * (x + y);
                c->u[i * 2] = e + 1e-7 / 3.0 * 0.5 * (y - x);
                c->u[i * 2 + 1] = e + 1e-7 / 3.0 * 0.5 * (x - y);
            }
            double sum = 0.0;
            for (int32_t i = 0; i < c->body.count; i++) /* energy of uniaxial stress, of the middle */
                if (i % 60 >= 20 && i % 60 < 40)
                    for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);) {
                        double xi[2], square, e = 0.0;
                        int32_t j = b.neighbour;
                        pdi_body_compute_offset(&c->body, i, b.neighbour, xi);
                        square = xi[0] * xi[0] + xi[1] * xi[1];
                        for (int d = 0; d < 2; d++) e += xi[d] * (c->u[j * 2 + d] - c->u[i * 2 + d]);
                        e /= 1e-7 * square;
                        double weight = pdi_bond_weights_get_intact(&c->springs.weights, i, &b);
                        sum += 0.5 * c->springs.modulus * weight * e * e * sqrt(square);
                    }
            young[way] = sum / (20.0 * cells);
            end(c);
        }
        NOTE("%d cells along a diagonal: by moments %.4f, by energy %.4f of the energy of the bulk", cells, young[0],
             young[1]);
        CHECK(fabs(young[0] - 1.0) < 0.7 * fabs(young[1] - 1.0));
    }
}
#define OF_2D ENTRY(slanted)
#else
#define OF_2D
#endif

TEST_MAIN(ENTRY(stiffness) ENTRY(factors) OF_2D)
