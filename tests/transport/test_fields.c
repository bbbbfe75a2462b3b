/* test_fields: sums of what leaves nodes by several fields that one flow carries, in blocks, against the formula node
 * by node, bond by bond.
 * dims: 1 2 3 */
#include "fixture.h"
#include "transport/settle.h"
#include <math.h>

static scene test_scene;

enum { FIELDS = 3, SUMS = 2 };

static double held(void *user, const double *x)
{
    (void)user;
    return x[0] < 0.5 ? 1.0 : NAN; /* the wall x = 0 alone, for the lengths below */
}

/* A box whose rows along the last axis are that long, at a wall across axis 0 that holds values. Its fluid moves at a
 * velocity without any order. */
static scene *start(double m, int wide, int rows)
{
    scene *s = &test_scene;
    uint32_t seed = 7;
    scene_box(s, m, 0.25, wide, PD_DIM == 2 ? rows : 5, rows);
    s->with = WITH_TRANSPORT | WITH_FLOW;
    s->flow_desc.rho = s->flow_desc.mu = 1.0;
    s->transport_desc.diffusivity = 0.7;
    s->transport_desc.held = held;
    if (!scene_build(s)) return NULL;
    for (int32_t i = 0; i < s->grid.total; i++)
        for (int d = 0; d < PD_DIM && s->grid.kind[i] == PD_FLUID; d++)
            s->flow.u[(int64_t)d * s->grid.total + i] = 3.0 * random_real(&seed);
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    return s;
}

/* What leaves node i by field n: over bonds with the harmonic mean of what their ends let pass, and into the wall with
 * what the node itself does. */
static double leaves(const scene *s, const pdi_flux_fields *f, int n, int32_t i, double *size)
{
    const pd_flux *t = &s->transport.flux;
    const double *c = f->c + (int64_t)n * s->grid.total, *hold = s->transport.diffusion.wall_rate;
    double sum = 0.0;
    if (hold && !isnan(f->wall[n])) sum = f->ratio[n] * hold[i] * (f->pass ? f->pass[i] : 1.0) * (c[i] - f->wall[n]);
    *size = fabs(sum);
    for (int k = 0; k < s->stencil.count; k++) {
        double flux, bond, share = 1.0;
        int32_t j = i + s->bonds.paths.shift[k];
        if (!pdi_flux_open(t, i, k)) continue;
        pdi_flux_one(t, i, k, &flux, &bond);
        if (f->pass) {
            double both = f->pass[i] + f->pass[j];
            share = both > 0.0 ? 2.0 * f->pass[i] * f->pass[j] / both : 0.0;
        }
        bond *= f->ratio[n] * share;
        /* F (c_i + c_j)/2 less what is conducted or upwinding needs (eq. 6.1) */
        double part = 0.5 * flux * (c[i] + c[j]) - fmax(bond, 0.5 * fabs(flux)) * (c[j] - c[i]);
        sum += part;
        *size += fabs(part);
    }
    return sum;
}

static double c[FIELDS * 40000], pass[40000], y[SUMS * 40000];

/* Rows shorter than a block, as long, and longer: a film that lets pass more or less from node to node, and one that
 * lets pass nothing at some; one of the fields does not see the wall. */
TEST(as_node_by_node)
{
    static const int lengths[4] = {5, 16, 19, 33};
    static const double ratio[FIELDS] = {1.0, 1.9, 0.3};
    const double wall[FIELDS] = {0.4, NAN, 2.0}, weight[SUMS * FIELDS] = {1.0, 0.0, -2.0, 0.5, 1.5, 1.0};
    int held_nodes = 0;
    for (int way = 0; way < 8; way++)
        for (int film = 0; film < 2; film++) {
            uint32_t seed = 3;
            double worst = 0.0;
            scene *s = start(way % 2 ? 1.0 : 2.0, PD_DIM == 1 ? lengths[way / 2] : 6, lengths[way / 2]);
            if (!s) return;
            int32_t total = s->grid.total;
            pdi_flux_fields f;
            if (!CHECK(total <= 40000 && s->transport.diffusion.wall_rate != NULL)) return;
            for (int32_t i = 0; i < total; i++) pass[i] = i % 7 == 3 ? 0.0 : random_share(&seed);
            for (int32_t k = 0; k < FIELDS * total; k++) c[k] = random_share(&seed);
            for (int n = 0; n < FIELDS; n++) pd_ghosts_set_scalar(&s->bonds.ghosts, c + (int64_t)n * total);
            pd_ghosts_set_scalar(&s->bonds.ghosts, pass);
            f.count = FIELDS;
            f.sums = SUMS;
            f.ratio = ratio;
            f.wall = wall;
            f.c = c;
            f.weight = weight;
            f.pass = film ? pass : NULL;
            f.y = y;
            CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, &s->transport));
            CHECK_OK(&s->ctx, pdi_flux_refresh(&s->ctx, &s->transport.flux));
            pdi_flux_apply_fields(&s->ctx, &s->transport.flux, &f);
            for (int32_t i = 0; i < total; i++) {
                if (s->grid.kind[i] != PD_FLUID) continue;
                held_nodes += s->transport.diffusion.wall_rate[i] > 0.0;
                for (int m = 0; m < SUMS; m++) {
                    double expected = 0.0, size = 0.0, one;
                    for (int n = 0; n < FIELDS; n++) {
                        expected += weight[m * FIELDS + n] * leaves(s, &f, n, i, &one);
                        size += fabs(weight[m * FIELDS + n]) * one;
                    }
                    worst = fmax(worst, fabs(y[(int64_t)m * total + i] - expected) / size);
                }
            }
            CHECK_LE(worst, 1e-14);
            CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, &s->transport, PD_OK));
            scene_free(s);
        }
    CHECK(held_nodes > 0);
    NOTE("%d nodes at walls that hold", held_nodes);
}

TEST_MAIN(ENTRY(as_node_by_node))
