/* test_correspondence: small strains of bodies of any shape, against linear fields and closed forms.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/body_bonds.h"
#include "solid/correspondence.h"
#include "test.h"
#include <math.h>

#define MOST 4000 /* points */
enum { T = PD_DIM * PD_DIM };

typedef struct body_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    double position[MOST * PD_DIM], volume[MOST];
} body_case;

static body_case test_case;

/* A block of n cells an axis with a notch, a hole and a re-entrant corner; `stir` moves points by that share of a
 * cell. */
static body_case *block(int n, double m, double spacing, double stir)
{
    body_case *c = &test_case;
    uint32_t seed = 3;
    int all = 1;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    for (int d = 0; d < PD_DIM; d++) all *= n;
    for (int k = 0; k < all; k++) {
        double x[PD_DIM], corner = 1.0, hole = 0.0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= n) {
            x[d] = (rest % n + 0.5) / n;
            corner = fmin(corner, x[d]);
            hole += (x[d] - 0.35) * (x[d] - 0.35);
        }
        if (PD_DIM > 1 && (corner > 0.6 || hole < 0.02)) continue;
        for (int d = 0; d < PD_DIM; d++)
            c->position[c->desc.count * PD_DIM + d] = (x[d] + stir * (random_share(&seed) - 0.5) / n) * 1e-3;
        c->volume[c->desc.count++] = pow(1e-3 / n, PD_DIM) * (1.0 + stir * (random_share(&seed) - 0.5));
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m * 1e-3 / n;
    c->desc.spacing = spacing * 1e-3 / n;
    return CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body)) ? c : NULL;
}

static double young = 45e9; /* [Pa] */

static int elastic(body_case *c, double nu, pd_plane plane, pd_influence influence)
{
    pd_correspondence_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.young = young;
    desc.poisson = nu;
    desc.plane = plane;
    desc.influence = influence;
    return CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &desc, &c->elastic));
}

static void end(body_case *c)
{
    pd_correspondence_free(&c->ctx, &c->elastic);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

static int cells(void) { return PD_DIM == 1 ? 40 : PD_DIM == 2 ? 20 : 10; }

/* The longest step of motion grows with the root of the density over the modulus, whatever they are. */
TEST(limit)
{
    double first = 0.0;
    for (int k = 0; k < 3; k++) {
        body_case *c = block(8, 2.5, 1.0, 0.2);
        young = 45e9 * pow(1e-20, k);
        int built = c && elastic(c, 0.3, PD_PLANE_STRAIN, (pd_influence)0);
        young = 45e9;
        if (!built) return;
        pd_material_interface solid = pd_correspondence_material(&c->elastic);
        double step = solid.stable_step(solid.self, 7900.0) * pow(1e-10, k);
        if (k == 0) first = step;
        CHECK(first > 0.0 && first < 1e-3 / 8.0 / sqrt(45e9 / 7900.0)); /* sound passes a cell */
        CHECK_REL(step, first, 1e-9);
        CHECK_REL(solid.stable_step(solid.self, 4.0 * 7900.0) * pow(1e-10, k), 2.0 * first, 1e-9);
        end(c);
    }
}

/* u = G x. */
static void linear(const body_case *c, const double *g, double *u)
{
    for (int32_t i = 0; i < c->body.count; i++)
        for (int p = 0; p < PD_DIM; p++) {
            u[i * PD_DIM + p] = 0.0;
            for (int q = 0; q < PD_DIM; q++) u[i * PD_DIM + p] += g[p * PD_DIM + q] * c->position[i * PD_DIM + q];
        }
}

/* ---- families ---- */

/* The search finds what comparing all pairs finds, in the same order for any order of the points. */
TEST(families)
{
    for (int spacing = 0; spacing < 2; spacing++) {
        body_case *c = block(cells(), 2.0, spacing, 0.4);
        if (!c) return;
        double reach = c->desc.horizon + 0.5 * c->desc.spacing;
        int64_t pairs = 0;
        for (int32_t i = 0; i < c->body.count; i++)
            for (int32_t j = 0; j < c->body.count; j++) {
                double square = 0.0;
                for (int d = 0; d < PD_DIM; d++) {
                    double xi = c->position[j * PD_DIM + d] - c->position[i * PD_DIM + d];
                    square += xi * xi;
                }
                pairs += i != j && square < reach * reach;
            }
        CHECK_INT(c->body.bonds, pairs);
        for (int32_t i = 0; i < c->body.count; i++)
            for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i), last = b; pd_body_bonds_next(&b); last = b) {
                const double *q = c->position + b.neighbour * PD_DIM;
                if (b.number) CHECK(c->position[last.neighbour * PD_DIM + PD_DIM - 1] <= q[PD_DIM - 1]);
            }
        end(c);
    }
}

/* ---- linear fields ---- */

/* A uniform strain in a body of any shape: the stress is that of Hooke's law at every point, and the loads of its
 * tractions hold it, for all Poisson ratios, influences and horizons. */
TEST(patch)
{
    static double u[MOST * PD_DIM], force[MOST * PD_DIM], stress[MOST * T];
    static const double ratios[4] = {0.0, 0.25, 0.499, -0.5};
    uint32_t seed = 8;
    double worst = 0.0;
    for (int way = 0; way < 24; way++) {
        double nu = ratios[way % 4], g[T], p[T], size = 0.0, largest = 0.0;
        body_case *c = block(cells(), way % 3 + 1.5, way & 1, way & 2 ? 0.5 : 0.0);
        if (!c || !elastic(c, nu, way & 4 ? PD_PLANE_STRESS : PD_PLANE_STRAIN, (pd_influence)(way % 3))) return;
        for (int k = 0; k < T; k++) g[k] = random_share(&seed) - 0.5;
        double trace = 0.0, lambda = c->elastic.lambda, mu = c->elastic.mu;
        for (int d = 0; d < PD_DIM; d++) trace += g[d * PD_DIM + d];
        for (int k = 0; k < T; k++) {
            int a = k / PD_DIM, b = k % PD_DIM;
            p[k] = mu * (g[k] + g[b * PD_DIM + a]) + (a == b ? lambda * trace : 0.0);
            size = fmax(size, fabs(p[k]));
        }
        linear(c, g, u);
        pd_correspondence_force(&c->ctx, &c->elastic, u, force);
        pd_correspondence_stress(&c->ctx, &c->elastic, u, stress);
        for (int32_t i = 0; i < c->body.count; i++)
            for (int a = 0; a < PD_DIM; a++) {
                double held = force[i * PD_DIM + a];
                for (int b = 0; b < PD_DIM; b++) held -= p[a * PD_DIM + b] * c->elastic.surface_vector[i * PD_DIM + b];
                largest = fmax(largest, fabs(held) * c->desc.horizon);
                for (int b = 0; b < PD_DIM; b++)
                    largest = fmax(largest, fabs(stress[i * T + a * PD_DIM + b] - p[a * PD_DIM + b]));
            }
        worst = fmax(worst, largest / size);
        end(c);
    }
    NOTE("largest deviation %.1e of the stress", worst);
    CHECK_LE(worst, 1e-10);
}

/* The normals of the surface obey the divergence theorem: sum V edge x^T = -(volume) 1, and sum V edge = 0. */
TEST(divergence)
{
    body_case *c = block(cells(), 3.0, 1.0, 0.5);
    if (!c || !elastic(c, 0.3, PD_PLANE_STRAIN, PD_INFLUENCE_CONSTANT)) return;
    double sum[T] = {0.0}, force[PD_DIM] = {0.0}, volume = 0.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        volume += c->volume[i];
        for (int k = 0; k < T; k++)
            sum[k] += c->volume[i] * c->elastic.surface_vector[i * PD_DIM + k / PD_DIM] *
                      c->position[i * PD_DIM + k % PD_DIM];
        for (int d = 0; d < PD_DIM; d++) force[d] += c->volume[i] * c->elastic.surface_vector[i * PD_DIM + d];
    }
    for (int k = 0; k < T; k++) CHECK_NEAR(sum[k], k / PD_DIM == k % PD_DIM ? -volume : 0.0, 1e-12 * volume);
    for (int d = 0; d < PD_DIM; d++) CHECK_NEAR(force[d], 0.0, 1e-12 * volume / c->desc.horizon);
    end(c);
}

/* A cut through all bonds that cross a plane makes two bodies: they part without a force, and each one bears a uniform
 * stress with the loads of its own surface. */
TEST(cut)
{
    static double u[MOST * PD_DIM], force[MOST * PD_DIM];
    body_case *c = block(cells(), 2.0, 1.0, 0.0);
    if (!c) return;
    int64_t broken = 0;
    for (int32_t i = 0; i < c->body.count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);)
            if ((c->position[i * PD_DIM] < 0.2e-3) != (c->position[b.neighbour * PD_DIM] < 0.2e-3)) {
                pdi_body_bonds_mark_broken(&c->body, i, b.number);
                broken++;
            }
    if (!CHECK(broken > 0) || !elastic(c, 0.3, PD_PLANE_STRESS, PD_INFLUENCE_CONSTANT)) return;
    double largest = 0.0, strain = 1e-3, p[2] = {0.0, 0.0};
    for (int32_t i = 0; i < c->body.count; i++)
        for (int d = 0; d < PD_DIM; d++)
            u[i * PD_DIM + d] = (d == 0 ? strain * c->position[i * PD_DIM] : 0.0) +
                                (c->position[i * PD_DIM] < 0.2e-3 ? 0.0 : 1e-4 * (d + 1));
    p[0] = (c->elastic.lambda + 2.0 * c->elastic.mu) * strain;
    p[1] = c->elastic.lambda * strain;
    pd_correspondence_force(&c->ctx, &c->elastic, u, force);
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++)
        largest = fmax(largest, fabs(force[k] - p[k % PD_DIM > 0] * c->elastic.surface_vector[k]));
    CHECK_LE(largest * c->desc.horizon, 1e-10 * p[0]);
    end(c);
}

/* ---- any fields ---- */

static void shake(const body_case *c, uint32_t seed, double *u)
{
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) u[k] = 1e-6 * (random_share(&seed) - 0.5);
}

static double work(const body_case *c, const double *u, const double *force)
{
    double sum = 0.0;
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) sum += c->volume[k / PD_DIM] * u[k] * force[k];
    return sum;
}

/* Forces are the derivative of the energy: symmetric, and their work is twice the energy. They add up to nothing, and
 * so do their moments. */
TEST(balance)
{
    static double u[MOST * PD_DIM], v[MOST * PD_DIM], fu[MOST * PD_DIM], fv[MOST * PD_DIM];
    for (int influence = 0; influence < 3; influence++) {
        body_case *c = block(cells(), 2.5, 1.0, 0.5);
        if (!c || !elastic(c, 0.3, PD_PLANE_STRESS, (pd_influence)influence)) return;
        shake(c, 5, u);
        shake(c, 6, v);
        pd_correspondence_force(&c->ctx, &c->elastic, v, fv);
        pd_correspondence_force(&c->ctx, &c->elastic, u, fu);
        double energy = pd_correspondence_energy(&c->ctx, &c->elastic, u);
        CHECK(energy > 0.0);
        CHECK_REL(work(c, u, fu), -2.0 * energy, 1e-12);
        CHECK_NEAR(work(c, v, fu), work(c, u, fv), 1e-12 * energy);
        double size = 0.0;
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) size += c->volume[k / PD_DIM] * fabs(fu[k]);
        for (int a = 0; a < PD_DIM; a++) {
            double sum = 0.0, moment = 0.0;
            int b = (a + 1) % PD_DIM;
            for (int32_t i = 0; i < c->body.count; i++) {
                const double *x = c->position + i * PD_DIM, *f = fu + i * PD_DIM;
                sum += c->volume[i] * f[a];
                moment += c->volume[i] * (x[a] * f[b] - x[b] * f[a]);
            }
            CHECK_NEAR(sum, 0.0, 1e-13 * size);
            CHECK_NEAR(moment, 0.0, 1e-16 * size);
        }
        end(c);
    }
}

/* A body that moves and turns as a whole has no force and no energy. */
TEST(rigid)
{
    static double u[MOST * PD_DIM], force[MOST * PD_DIM];
    body_case *c = block(cells(), 3.0, 1.0, 0.5);
    if (!c || !elastic(c, 0.4, PD_PLANE_STRAIN, PD_INFLUENCE_INVERSE)) return;
    double g[T] = {0.0}, largest = 0.0, unit = (c->elastic.lambda + 2.0 * c->elastic.mu) / c->desc.horizon;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) g[a * PD_DIM + b] = 0.3 * (a - b);
    linear(c, g, u);
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) u[k] += 7e-4;
    pd_correspondence_force(&c->ctx, &c->elastic, u, force);
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) largest = fmax(largest, fabs(force[k]));
    CHECK_LE(largest, 1e-11 * unit);
    CHECK_LE(pd_correspondence_energy(&c->ctx, &c->elastic, u), 1e-22 * (c->elastic.lambda + 2.0 * c->elastic.mu));
    end(c);
}

/* A pattern of one cell has an energy as bulk material of that shear has, for each influence: correspondence without
 * bond gradients gives it none. */
TEST(no_pattern_without_energy)
{
    static double u[MOST * PD_DIM];
    for (int influence = 0; influence < 3; influence++)
        for (int axis = 0; axis < PD_DIM; axis++) {
            body_case *c = block(cells(), 3.0, 1.0, 0.0);
            if (!c || !elastic(c, 0.3, PD_PLANE_STRAIN, (pd_influence)influence)) return;
            double volume = 0.0, strain = 1e-3, h = 1e-3 / cells();
            for (int32_t i = 0; i < c->body.count; i++) {
                int sum = 0;
                for (int d = 0; d < PD_DIM; d++) sum += (int)floor(c->position[i * PD_DIM + d] / h);
                for (int d = 0; d < PD_DIM; d++) u[i * PD_DIM + d] = 0.0;
                u[i * PD_DIM + axis] = 0.5 * strain * h * (sum & 1 ? 1.0 : -1.0);
                volume += c->volume[i];
            }
            double bulk = 0.5 * c->elastic.mu * strain * strain * volume;
            double share = pd_correspondence_energy(&c->ctx, &c->elastic, u) / bulk;
            NOTE("influence %d, axis %d: %.2f of mu strain^2/2", influence, axis, share);
            CHECK(share > 0.3);
            end(c);
        }
}

/* The order of the points does not matter, to the last bit, and neither do threads. */
TEST(order_and_threads)
{
    static double u[MOST * PD_DIM], force[MOST * PD_DIM], kept[MOST * PD_DIM];
    static double x[MOST * PD_DIM], v[MOST], w[MOST * PD_DIM];
    for (int way = 0; way < 6; way++) {
        int run = way % 3; /* of points beside the places of a lattice, and of a lattice */
        body_case *c = block(cells(), 2.5, 1.0, way < 3 ? 0.5 : 0.0);
        if (!c) return;
        int32_t n = c->body.count;
        shake(c, 9, u);
        if (run == 1) {
            pd_body_free(&c->ctx, &c->body);
            for (int32_t i = 0; i < n; i++) {
                v[n - 1 - i] = c->volume[i];
                memcpy(x + (n - 1 - i) * PD_DIM, c->position + i * PD_DIM, PD_DIM * sizeof *x);
                memcpy(w + (n - 1 - i) * PD_DIM, u + i * PD_DIM, PD_DIM * sizeof *x);
            }
            memcpy(c->position, x, sizeof x);
            memcpy(c->volume, v, sizeof v);
            memcpy(u, w, sizeof w);
            if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return;
        }
        if (run == 2) c->ctx.threads = 3;
        if (!elastic(c, 0.3, PD_PLANE_STRESS, PD_INFLUENCE_LINEAR)) return;
        pd_correspondence_force(&c->ctx, &c->elastic, u, force);
        if (!run) memcpy(kept, force, sizeof kept);
        for (int32_t i = 0; i < n; i++)
            CHECK(memcmp(kept + i * PD_DIM, force + (run == 1 ? n - 1 - i : i) * PD_DIM, PD_DIM * sizeof *x) == 0);
        end(c);
    }
}

/* Points of a lattice go in bands as long as its rows, and with a bond broken in as many: the bits are those that
 * each point has alone. */
TEST(bands)
{
    static double u[MOST * PD_DIM], force[MOST * PD_DIM], alone[MOST * PD_DIM];
    int32_t before = 0;
    for (int breaks = 0; breaks < 2; breaks++) {
        body_case *c = block(cells(), 1.0, 1.0, 0.0);
        if (!c) return;
        int32_t middle = c->body.count / 2;
        pd_bond_iterator b = pd_body_bonds_begin(&c->body, middle);
        if (pd_body_bonds_next(&b) && breaks) pd_body_break(&c->body, middle, b.neighbour);
        if (!elastic(c, 0.3, PD_PLANE_STRESS, PD_INFLUENCE_INVERSE)) return;
        shake(c, 4, u);
        pd_correspondence_force(&c->ctx, &c->elastic, u, force);
        NOTE("%d points in %d bands", (int)c->body.count, (int)c->elastic.band.batches);
        CHECK(4 * c->elastic.band.batches < c->body.count);
        CHECK(breaks == 0 || c->elastic.band.batches == before);
        before = c->elastic.band.batches;
        c->elastic.band.max_points = 1;
        CHECK_OK(&c->ctx, pdi_point_batch_update(&c->ctx, &c->elastic.band));
        CHECK_INT(c->elastic.band.batches, c->body.count);
        pd_correspondence_force(&c->ctx, &c->elastic, u, alone);
        CHECK(memcmp(force, alone, (size_t)c->body.count * PD_DIM * sizeof *force) == 0);
        end(c);
    }
}

/* ---- input ---- */

TEST(bad_input)
{
    body_case *c = block(cells(), 2.0, 0.0, 0.0);
    pd_body bad;
    pd_body_desc desc;
    pd_correspondence_desc moduli;
    if (!c) return;
    desc = c->desc;
    desc.horizon = 0.0;
    CHECK_INT(pd_body_build(&c->ctx, &desc, &bad), PD_ERR_ARGUMENT);
    desc = c->desc;
    desc.count = 0;
    CHECK_INT(pd_body_build(&c->ctx, &desc, &bad), PD_ERR_ARGUMENT);
    desc = c->desc;
    c->volume[2] = NAN;
    CHECK_INT(pd_body_build(&c->ctx, &desc, &bad), PD_ERR_ARGUMENT);
    CHECK(strstr(c->ctx.message, "point 2") != NULL);
    c->volume[2] = c->volume[1];
    memcpy(c->position + 3 * PD_DIM, c->position + 5 * PD_DIM, PD_DIM * sizeof *c->position);
    CHECK_INT(pd_body_build(&c->ctx, &desc, &bad), PD_ERR_GEOMETRY);
    CHECK(strstr(c->ctx.message, "one place") != NULL);
    memset(&moduli, 0, sizeof moduli);
    CHECK_INT(pd_correspondence_build(&c->ctx, &c->body, &moduli, &c->elastic), PD_ERR_ARGUMENT);
    moduli.young = 1.0;
    moduli.poisson = 0.5;
    if (PD_DIM > 1) CHECK_INT(pd_correspondence_build(&c->ctx, &c->body, &moduli, &c->elastic), PD_ERR_ARGUMENT);
    pd_body_free(&c->ctx, &c->body);
    /* points on a line, or one alone: no gradient */
    desc.count = PD_DIM == 1 ? 1 : 6;
    for (int32_t i = 0; i < desc.count; i++)
        for (int d = 0; d < PD_DIM; d++) c->position[i * PD_DIM + d] = i * 1e-5 * (d + 1);
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &desc, &c->body))) return;
    moduli.poisson = 0.3;
    CHECK_INT(pd_correspondence_build(&c->ctx, &c->body, &moduli, &c->elastic), PD_ERR_GEOMETRY);
    CHECK(strstr(c->ctx.message, "point 0") != NULL);
    end(c);
}

TEST_MAIN(ENTRY(families) ENTRY(patch) ENTRY(divergence) ENTRY(cut) ENTRY(balance) ENTRY(rigid)
              ENTRY(no_pattern_without_energy) ENTRY(order_and_threads) ENTRY(limit) ENTRY(bands)
              ENTRY(bad_input))
