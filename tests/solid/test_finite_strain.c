/* test_finite_strain: large strains of bodies of any shape, against uniform fields, closed forms and differences.
 * dims: 1 2 3 */
#include "finite_case.h"
#include "solid/body_bonds.h"
#include "io/archive_file.h"
#include "solid/quasi_static.h"
#include "solid/tensor.h"

static double u[MOST * PD_DIM], v[MOST * PD_DIM], w[MOST * PD_DIM];
static double force[MOST * PD_DIM], other[MOST * PD_DIM], kept[MOST * PD_DIM], stress[MOST * T];

static const char *const names[3] = {"neo-Hookean", "Hencky", "J2"};

/* The moduli of each point are those of the law, and `stiff` times as large. */
TEST(moduli_of_points)
{
    for (int way = 0; way < 6; way++)
        for (int graded = 0; graded < 2; graded++) {
            pd_finite_strain f;
            pd_finite_strain_desc d = desc_of(way);
            pdi_constitutive_law_params m = moduli(&d);
            solid_case *c = solid_block(CELLS / 2, 1.5, 1.0, 0.0);
            static double stiff[MOST];
            if (!c) return;
            for (int32_t i = 0; i < c->body.count; i++) {
                stiff[i] = 1.0 + 0.25 * (i % 3);
                v[i] = w[i] = -1.0;
            }
            d.stiffness_factor = graded ? stiff : NULL;
            pd_material_interface solid = build(c, &d, &f);
            solid.moduli(&c->ctx, solid.self, v, w);
            for (int32_t i = 0; i < c->body.count; i++) {
                double factor = graded ? stiff[i] : 1.0;
                CHECK_REL(w[i], factor * m.mu, 1e-14);
                CHECK_REL(v[i], factor * pdi_constitutive_law_plane_lambda(&m), 1e-14);
            }
            end(c, &f);
        }
}

/* ---- uniform fields ---- */

/* A uniform gradient of any size in a body of any shape: the stress is that of the law at every point, and the loads of
 * its tractions hold it, for all laws, influences, controls and horizons. */
TEST(patch)
{
    double worst = 0.0;
    uint32_t seed = 8;
    for (int way = 0; way < WAYS; way++) {
        pd_finite_strain_desc d = desc_of(way);
        pd_finite_strain f;
        double g[T], p[T], sigma[T], state[PDI_CONSTITUTIVE_LAW_STATE] = {0.0}, size = 0.0, largest = 0.0, across;
        solid_case *c = solid_block(CELLS, way % 2 + 1.5, way & 1, way & 2 ? 0.5 : 0.0);
        if (!c) return;
        pd_material_interface s = build(c, &d, &f);
        pdi_constitutive_law_params m = moduli(&d);
        solid_gradient(&seed, 0.6, g);
        CHECK(pdi_constitutive_law_compute_stress(&m, g, state, p));
        CHECK(pdi_constitutive_law_compute_cauchy(&m, g, state, sigma, &across));
        for (int k = 0; k < T; k++) size = fmax(size, fabs(p[k]) + fabs(sigma[k]));
        solid_stretch(c, g, 0.0, 0, u);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
        s.stress(&c->ctx, s.self, u, stress);
        for (int32_t i = 0; i < c->body.count; i++)
            for (int a = 0; a < PD_DIM; a++) {
                double held = force[i * PD_DIM + a];
                for (int b = 0; b < PD_DIM; b++) held -= p[a * PD_DIM + b] * s.surface_vector[i * PD_DIM + b];
                largest = fmax(largest, fabs(held) * c->desc.horizon);
                for (int b = 0; b < PD_DIM; b++)
                    largest = fmax(largest, fabs(stress[i * T + a * PD_DIM + b] - sigma[a * PD_DIM + b]));
                if (s.out_of_plane_stress)
                    largest = fmax(largest, fabs(s.out_of_plane_stress(s.self, i, stress) - across));
            }
        size = fmax(size, 0.1 * E); /* of what strains would do without yielding */
        double volume = 0.0;
        for (int32_t i = 0; i < c->body.count; i++) volume += c->volume[i];
        CHECK_REL(s.energy(&c->ctx, s.self, u), volume * pdi_constitutive_law_compute_energy(&m, g, state, 0), 1e-12);
        worst = fmax(worst, largest / size);
        end(c, &f);
    }
    NOTE("largest deviation %.1e of the stress", worst);
    CHECK_LE(worst, 1e-12);
}

/* A body that turns as a whole has no force and no energy. */
TEST(rigid)
{
    for (int way = 0; way < 9; way++) {
        pd_finite_strain_desc d = desc_of(way);
        pd_finite_strain f;
        uint32_t seed = 17;
        double g[T], largest = 0.0;
        solid_case *c = solid_block(CELLS, 2.0, 1.0, 0.5);
        if (!c) return;
        pd_material_interface s = build(c, &d, &f);
        solid_gradient(&seed, 0.0, g);
        solid_stretch(c, g, 0.0, 0, u);
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) u[k] += 7e-4;
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) largest = fmax(largest, fabs(force[k]));
        CHECK_LE(largest * c->desc.horizon, 1e-12 * E);
        CHECK_LE(fabs(s.energy(&c->ctx, s.self, u)), 1e-15 * E * pow(1e-3, PD_DIM));
        end(c, &f);
    }
}

/* ---- any fields ---- */

/* Forces and their moments add up to nothing; they are the derivative of the energy; the tangent is theirs, and
 * symmetric. */
TEST(balance)
{
    double worst[3] = {0.0};
    for (int way = 0; way < 18; way++) {
        pd_finite_strain_desc d = desc_of(way);
        pd_finite_strain f;
        uint32_t seed = 20u + (uint32_t)way;
        double g[T], size = 0.0, cell = 1e-3 / CELLS, h = 1e-6 * cell;
        solid_case *c = solid_block(PD_DIM == 3 ? 6 : 12, 2.0, 1.0, 0.3);
        if (!c) return;
        pd_material_interface s = build(c, &d, &f);
        int32_t n = c->body.count * PD_DIM;
        if (s.commit) {
            solid_gradient(&seed, 0.02, g);
            solid_stretch(c, g, 0.01 * cell, 6, u);
            CHECK_OK(&c->ctx, s.commit(&c->ctx, s.self, u));
        }
        solid_gradient(&seed, 0.1, g);
        solid_stretch(c, g, 0.02 * cell, 5, u);
        for (int32_t k = 0; k < n; k++) v[k] = random_real(&seed), w[k] = random_real(&seed);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, kept));
        s.tangent(&c->ctx, s.self, w, other);
        double cross = solid_work(c, v, other), square = 0.0, error = 0.0;
        s.tangent(&c->ctx, s.self, v, other);
        double norm = sqrt(solid_work(c, other, other) * solid_work(c, w, w));
        worst[0] = fmax(worst[0], fabs(cross - solid_work(c, w, other)) / norm);
        for (int32_t k = 0; k < n; k++) size += c->volume[k / PD_DIM] * fabs(kept[k]);
        for (int a = 0; a < PD_DIM; a++) {
            double sum = 0.0, moment = 0.0;
            int b = (a + 1) % PD_DIM;
            for (int32_t i = 0; i < c->body.count; i++) {
                const double *x = c->position + i * PD_DIM, *q = kept + i * PD_DIM, *y = u + i * PD_DIM;
                sum += c->volume[i] * q[a];
                moment += c->volume[i] * ((x[a] + y[a]) * q[b] - (x[b] + y[b]) * q[a]);
            }
            CHECK_NEAR(sum, 0.0, 1e-13 * size);
            CHECK_NEAR(moment, 0.0, 2e-16 * size);
        }
        for (int32_t k = 0; k < n; k++) w[k] = u[k] + h * v[k];
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, w, force));
        double energy = s.energy(&c->ctx, s.self, w);
        for (int32_t k = 0; k < n; k++) w[k] = u[k] - h * v[k];
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, w, stress));
        energy -= s.energy(&c->ctx, s.self, w);
        for (int32_t k = 0; k < n; k++) {
            square += other[k] * other[k];
            error += pow((force[k] - stress[k]) / (2.0 * h) - other[k], 2.0);
        }
        worst[1] = fmax(worst[1], sqrt(error / square));
        if (way % 3 < 2) /* the energy of metal that flows is not all of it: see derivatives */
            worst[2] = fmax(worst[2], fabs(energy / (2.0 * h) + solid_work(c, v, kept)) /
                                          sqrt(solid_work(c, kept, kept) * solid_work(c, v, v)));
        end(c, &f);
    }
    NOTE("tangent: symmetric to %.1e, off differences by %.1e; energy: off by %.1e", worst[0], worst[1], worst[2]);
    CHECK_LE(worst[0], 1e-14);
    CHECK_LE(worst[1], 1e-7);
    CHECK_LE(worst[2], 1e-7);
}

/* Work along a path of large displacements is the energy at its end and what flow has cost, through yielding and
 * back. */
TEST(work)
{
    for (int way = 0; way < 3; way++) {
        pd_finite_strain_desc d = desc_of(way);
        pd_finite_strain f;
        uint32_t seed = 5;
        double sum = 0.0, steps = PD_DIM == 3 ? 60.0 : 200.0, most = 0.0;
        solid_case *c = solid_block(PD_DIM == 3 ? 4 : 10, PD_DIM == 3 ? 1.5 : 2.0, 1.0, 0.0);
        if (!c) return;
        pd_material_interface s = build(c, &d, &f);
        int32_t n = c->body.count * PD_DIM;
        for (int32_t k = 0; k < n; k++) v[k] = 0.3 * c->position[k] + 1e-6 * random_real(&seed);
        for (int32_t k = 0; k < n; k++) w[k] = c->position[k - k % PD_DIM] * (k % PD_DIM ? 0.4 : 0.1);
        for (int step = 0; step < (int)steps; step++) {
            /* Gauss's two places of a step: what has yielded at the first is kept for the second */
            double at[2] = {step + 0.5 - 0.5 / sqrt(3.0), step + 0.5 + 0.5 / sqrt(3.0)};
            for (int gauss = 0; gauss < 2; gauss++) {
                double t = at[gauss] / steps, first = 0.1 * sin(6.0 * t), slope = 0.6 * cos(6.0 * t);
                for (int32_t k = 0; k < n; k++) {
                    u[k] = first * v[k] + t * t * w[k];
                    other[k] = slope * v[k] + 2.0 * t * w[k];
                }
                CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
                sum -= 0.5 * solid_work(c, other, force) / steps;
                if (s.commit) CHECK_OK(&c->ctx, s.commit(&c->ctx, s.self, u));
            }
        }
        for (int32_t k = 0; k < n; k++) u[k] = 0.1 * sin(6.0) * v[k] + w[k];
        if (s.commit) CHECK_OK(&c->ctx, s.commit(&c->ctx, s.self, u));
        double stored = s.energy(&c->ctx, s.self, u), energy = stored + (s.dissipated ? s.dissipated(s.self) : 0.0);
        CHECK((stored < 0.5 * energy) == (way == 2));
        pd_finite_strain_plastic_strain(&c->ctx, &f, stress);
        for (int32_t i = 0; i < c->body.count; i++) most = fmax(most, stress[i]);
        NOTE("%s: work %.8g, energy %.8g, plastic strain %.2g", names[way], sum, energy, most);
        CHECK_REL(sum, energy, way == 2 ? 1e-4 : 1e-8);
        CHECK((most > 0.0) == (way == 2));
        end(c, &f);
    }
}

/* Energies of displacements at point i [Pa] where F is 1: [0] what bonds with gradients of their own hold,
 * (1/w) sum w V (mu eta^2 + (lambda + mu)(eta.n)^2)/(2 r^2);  [1] springs against strays; [2] nothing; [3] a solid of
 * springs of the same shear modulus (theory: eq. 15.1), nu = 1/4. */
static void patterns(const solid_case *c, const pd_finite_strain *f, int32_t i, const double *x, double *energy)
{
    double modulus = 0.0, all = 0.0;
    memset(energy, 0, 4 * sizeof *energy);
    for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);) {
        double xi[PD_DIM], along = 0.0, size = 0.0, r, shear;
        double weight = pdi_bond_weights_get_intact(&f->weights, i, &b) * c->volume[0];
        pdi_body_compute_offset(&c->body, i, b.neighbour, xi);
        r = sqrt(pdi_tensor_dot(xi, xi));
        for (int q = 0; q < PD_DIM; q++) {
            double eta = x[b.neighbour * PD_DIM + q] - x[i * PD_DIM + q];
            along += eta * xi[q] / r;
            size += eta * eta;
        }
        shear = PD_DIM == 1 ? r : xi[0] * xi[0] * xi[PD_DIM - 1] * xi[PD_DIM - 1] / (r * r * r);
        modulus += 0.5 * weight * shear;
        all += weight;
        energy[0] += 0.5 * weight * (f->mu * size + (f->lambda + f->mu) * along * along) / (r * r);
        energy[1] += 0.5 * weight * f->penalty_stiffness * size;
        energy[3] += 0.25 * weight * along * along / r;
    }
    energy[0] /= all;
    energy[3] *= (PD_DIM == 1 ? E : f->mu) / modulus;
}

/* A pattern of one cell in the bulk, where families see no gradient: bonds with gradients of their own and springs
 * against strays resist as their closed forms say, plain correspondence does not at all. */
TEST(checkerboard)
{
    for (int way = 0; way < 9; way++) {
        pd_finite_strain_desc d = desc_of(0);
        pd_finite_strain f;
        int n = PD_DIM == 3 ? 13 : 15; /* two horizons around the centre */
        double strain = 1e-4, cell = 1e-3 / n;
        solid_case *c = solid_cells(n, 3.0, 1.0, 0.0, 1);
        if (!c) return;
        d.law.poisson = 0.25;
        d.control = (pd_zero_energy_control)(way % 3);
        d.influence = (pd_influence)(way / 3);
        pd_material_interface s = build(c, &d, &f);
        for (int32_t i = 0; i < c->body.count; i++) {
            int sum = 0;
            for (int q = 0; q < PD_DIM; q++) sum += (int)floor(c->position[i * PD_DIM + q] / cell);
            for (int q = 0; q < PD_DIM; q++) u[i * PD_DIM + q] = 0.0;
            u[i * PD_DIM] = 0.5 * strain * cell * (sum & 1 ? 1.0 : -1.0);
        }
        memset(v, 0, sizeof v);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, v, force));
        s.tangent(&c->ctx, s.self, u, force);
        int32_t centre = c->body.count / 2;
        double energy = -0.5 * u[centre * PD_DIM] * force[centre * PD_DIM], expected[4];
        patterns(c, &f, centre, u, expected);
        NOTE("influence %d, control %d: %.3f of a solid of springs, %.3f of mu strain^2/2", way / 3, way % 3,
             energy / expected[3], energy / (0.5 * f.mu * strain * strain));
        CHECK_NEAR(energy, expected[way % 3], 1e-10 * expected[3]);
        if (way % 3 == 0) CHECK(energy > 0.4 * expected[3]);
        end(c, &f);
    }
}

/* The longest stable step is no longer than the true one, which power iterations find, and not much shorter. */
TEST(limit)
{
    for (int control = 0; control < 2; control++) {
        pd_finite_strain_desc d = desc_of(0);
        pd_finite_strain f;
        uint32_t seed = 6;
        double density = 7800.0, value = 0.0;
        solid_case *c = solid_block(CELLS, 2.0, 1.0, 0.0);
        if (!c) return;
        d.control = (pd_zero_energy_control)control;
        pd_material_interface s = build(c, &d, &f);
        int32_t n = c->body.count * PD_DIM;
        memset(u, 0, sizeof u);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
        for (int32_t k = 0; k < n; k++) v[k] = random_real(&seed);
        for (int round = 0; round < 100; round++) {
            double size = sqrt(solid_work(c, v, v));
            for (int32_t k = 0; k < n; k++) v[k] /= size;
            s.tangent(&c->ctx, s.self, v, w);
            value = -solid_work(c, v, w);
            memcpy(v, w, sizeof v);
        }
        double longest = 2.0 * sqrt(density / value), given = s.stable_step(s.self, density);
        NOTE("control %d: limit %.3g s, %.2f of the longest stable step", control, given, given / longest);
        CHECK_LE(given, longest);
        CHECK(given > 0.3 * longest);
        end(c, &f);
    }
}

/* Blocks are symmetric, positive, and of the size of the true ones. */
TEST(blocks)
{
    for (int control = 0; control < 3; control++) {
        pd_finite_strain_desc d = desc_of(0);
        pd_finite_strain f;
        double least = HUGE_VAL, most = 0.0;
        solid_case *c = solid_block(PD_DIM == 3 ? 5 : 10, 2.0, 1.0, 0.0);
        if (!c) return;
        d.control = (pd_zero_energy_control)control;
        pd_material_interface s = build(c, &d, &f);
        memset(u, 0, sizeof u);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
        s.blocks(&c->ctx, s.self, stress);
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) {
            memset(v, 0, sizeof v);
            v[k] = 1.0;
            s.tangent(&c->ctx, s.self, v, w);
            double truth = -c->volume[k / PD_DIM] * w[k], given = stress[k / PD_DIM * T + k % PD_DIM * (PD_DIM + 1)];
            least = fmin(least, given / truth);
            most = fmax(most, given / truth);
        }
        NOTE("control %d: blocks are %.2f to %.2f of the true ones", control, least, most);
        CHECK(least > 0.2);
        CHECK_LE(most, 5.0);
        end(c, &f);
    }
}

/* The order of the points does not matter, to the last bit, and neither do threads. */
TEST(order_and_threads)
{
    static double x[MOST * PD_DIM], volume[MOST];
    for (int way = 0; way < 3; way++)
        for (int run = 0; run < 3; run++) {
            pd_finite_strain_desc d = desc_of(way);
            pd_finite_strain f;
            double g[T];
            uint32_t seed = 9;
            solid_case *c = solid_block(CELLS, 2.5, 1.0, 0.5);
            if (!c) return;
            int32_t n = c->body.count;
            solid_gradient(&seed, 0.1, g);
            solid_stretch(c, g, 1e-6, 9, u);
            if (run == 1) {
                pd_body_free(&c->ctx, &c->body);
                for (int32_t i = 0; i < n; i++) {
                    volume[n - 1 - i] = c->volume[i];
                    memcpy(x + (n - 1 - i) * PD_DIM, c->position + i * PD_DIM, PD_DIM * sizeof *x);
                    memcpy(w + (n - 1 - i) * PD_DIM, u + i * PD_DIM, PD_DIM * sizeof *x);
                }
                memcpy(c->position, x, sizeof x);
                memcpy(c->volume, volume, sizeof volume);
                memcpy(u, w, sizeof w);
                if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return;
            }
            if (run == 2) c->ctx.threads = 3;
            pd_material_interface s = build(c, &d, &f);
            if (s.commit) CHECK_OK(&c->ctx, s.commit(&c->ctx, s.self, u));
            for (int32_t k = 0; k < n * PD_DIM; k++) v[k] = 0.9 * u[k];
            CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, v, other));
            s.tangent(&c->ctx, s.self, u, force);
            for (int32_t k = 0; k < n * PD_DIM; k++) force[k] += other[k];
            if (!run) memcpy(kept, force, sizeof kept);
            for (int32_t i = 0; i < n; i++)
                CHECK(memcmp(kept + i * PD_DIM, force + (run == 1 ? n - 1 - i : i) * PD_DIM, PD_DIM * sizeof *x) == 0);
            end(c, &f);
        }
}

/* A factor of the stiffness of points: the law's energy takes it, and the forces are still its derivative. */
TEST(heterogeneous)
{
    static double factor[MOST];
    pd_finite_strain_desc d = desc_of(0);
    pd_finite_strain f;
    uint32_t seed = 3;
    double g[T], h = 1e-10;
    solid_case *c = solid_block(CELLS, 2.0, 1.0, 0.3);
    if (!c) return;
    for (int32_t i = 0; i < c->body.count; i++) factor[i] = random_between(&seed, 0.1, 3.0);
    d.stiffness_factor = factor;
    pd_material_interface s = build(c, &d, &f);
    solid_gradient(&seed, 0.2, g);
    solid_stretch(c, g, 1e-6, 4, u);
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) v[k] = random_real(&seed);
    CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) w[k] = u[k] + h * v[k], other[k] = u[k] - h * v[k];
    double slope = (s.energy(&c->ctx, s.self, w) - s.energy(&c->ctx, s.self, other)) / (2.0 * h);
    CHECK_REL(slope, -solid_work(c, v, force), 1e-6);
    factor[3] = 0.0;
    CHECK_INT(s.update(&c->ctx, s.self), PD_ERR_ARGUMENT);
    CHECK(strstr(c->ctx.message, "point 3") != NULL);
    end(c, &f);
}

/* ---- equilibrium ---- */

/* Rest of the body with points that span it held at v, and the loads `other`. The guess: u, which stretches along x by
 * nearly `more`. */
static pd_equilibrium_result rest(solid_case *c, const pd_material_interface *s, double more, double rtol)
{
    static uint8_t held[MOST * PD_DIM];
    pd_equilibrium_desc d;
    pd_equilibrium_result result;
    int32_t points[3] = {0, c->body.count / 2, c->body.count - 1};
    memset(&d, 0, sizeof d);
    memset(held, 0, sizeof held);
    for (int32_t i = 0; i < c->body.count; i++) u[i * PD_DIM] += 0.95 * more * c->position[i * PD_DIM];
    for (int p = 0; p < PD_DIM; p++)
        for (int a = 0; a < PD_DIM; a++) {
            held[points[p] * PD_DIM + a] = 1;
            u[points[p] * PD_DIM + a] = v[points[p] * PD_DIM + a];
        }
    d.prescribed = held;
    d.rtol = rtol;
    CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, s, &d, other, u, &result));
    return result;
}

/* A neo-Hookean body of any shape that is pulled to twice its length, in steps: the lateral stretch is that without
 * stress across, and displacements are linear. */
TEST(uniaxial)
{
    for (int way = 0; way < (PD_DIM == 2 ? 2 : 1); way++) {
        pd_finite_strain_desc d = desc_of(0);
        pd_finite_strain f;
        int steps = 5, rounds = 0, products = 0;
        double g[T] = {0.0}, p[T], worst = 0.0;
        solid_case *c = solid_block(PD_DIM == 3 ? 4 : 12, 1.5, 1.0, 0.3);
        if (!c) return;
        d.law.plane = way ? PD_PLANE_STRESS : PD_PLANE_STRAIN;
        d.law.poisson = 0.4;
        pd_material_interface s = build(c, &d, &f);
        pdi_constitutive_law_params m = moduli(&d);
        memset(u, 0, sizeof u);
        for (int step = 1; step <= steps; step++) {
            double pull = 1.0 + 1.0 * step / steps, low = 0.1, high = 1.0;
            int sides = PD_DIM == 2 && !way ? 1 : 2;
            for (int k = 0; k < 200; k++) {
                double t = 0.5 * (low + high), rest = m.mu * (t * t - 1.0) + m.lambda * log(pull * pow(t, sides));
                *(rest > 0.0 ? &high : &low) = t;
            }
            for (int a = 0; a < PD_DIM; a++) g[a * (PD_DIM + 1)] = a ? low : pull;
            memset(p, 0, sizeof p);
            p[0] = m.mu * (pull - 1.0 / pull) + m.lambda * log(pull * pow(low, sides)) / pull;
            solid_stretch(c, g, 0.0, 0, v);
            for (int32_t k = 0; k < c->body.count * PD_DIM; k++)
                other[k] = k % PD_DIM ? 0.0 : -p[0] * s.surface_vector[k];
            pd_equilibrium_result r = rest(c, &s, 1.0 / steps, 1e-12);
            rounds += r.steps;
            products += r.iterations;
        }
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) worst = fmax(worst, fabs(u[k] - v[k]));
        NOTE("%d steps to twice the length: %d Newton steps, %d iterations, displacements off by %.1e mm", steps,
             rounds, products, worst * 1e3);
        CHECK_LE(worst, 1e-9 * 1e-3);
        end(c, &f);
    }
}

/* A bar that is pulled beyond yield, let go and pulled again: stress, plastic strain and what is left of its length are
 * known in closed form. In 2D and 3D the bar is free across (plane stress). */
TEST(bar_of_metal)
{
    pd_finite_strain_desc d = desc_of(2);
    pd_finite_strain f;
    double worst = 0.0;
    int rounds = 0, products = 0;
    solid_case *c = solid_block(PD_DIM == 3 ? 4 : 10, 1.5, 1.0, 0.0);
    if (!c) return;
    d.store_tangent = 1;
    d.law.plane = PD_PLANE_STRESS;
    d.law.poisson = 0.3;
    d.law.hardening = 0.05 * E;
    d.law.saturation = 0.0;
    pd_material_interface s = build(c, &d, &f);
    memset(u, 0, sizeof u);
    static const double strains[5] = {2e-3, 0.02, 0.05, 0.0464, 0.08};
    double plastic = 0.0, before = 1.0;
    for (int step = 0; step < 5; step++) {
        double strain = strains[step], tau = E * (strain - plastic), yield = d.law.yield + d.law.hardening * plastic;
        if (tau > yield) {
            double grow = (tau - yield) / (E + d.law.hardening);
            plastic += grow;
            tau -= E * grow;
        }
        double g[T] = {0.0}, across = -0.5 * plastic - d.law.poisson * tau / E;
        for (int a = 0; a < PD_DIM; a++) g[a * (PD_DIM + 1)] = exp(a ? across : strain);
        solid_stretch(c, g, 0.0, 0, v);
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++)
            other[k] = k % PD_DIM ? 0.0 : -tau / g[0] * s.surface_vector[k];
        pd_equilibrium_result r = rest(c, &s, g[0] - before, 1e-11);
        rounds += r.steps;
        products += r.iterations;
        before = g[0];
        for (int32_t k = 0; k < c->body.count * PD_DIM; k++) worst = fmax(worst, fabs(u[k] - v[k]));
        s.stress(&c->ctx, s.self, u, stress);
        CHECK_OK(&c->ctx, s.commit(&c->ctx, s.self, u));
        pd_finite_strain_plastic_strain(&c->ctx, &f, w);
        for (int32_t i = 0; i < c->body.count; i++) {
            CHECK_NEAR(w[i], plastic, 1e-8);
            CHECK_REL(stress[i * T], tau * exp(-(1.0 - 2.0 * d.law.poisson) * tau / E), 1e-6);
        }
    }
    NOTE("5 steps: %d Newton steps, %d iterations, displacements off by %.1e mm", rounds, products, worst * 1e3);
    CHECK_LE(worst, 1e-8 * 1e-3);
    end(c, &f);
}

/* ---- bonds that break ---- */

/* A point whose bonds do not span all directions any more loses them, and the rest of the body is in balance. */
TEST(loose)
{
    pd_finite_strain_desc d = desc_of(0);
    pd_finite_strain f;
    double g[T], p[T], largest = 0.0;
    uint32_t seed = 3;
    solid_case *c = solid_block(CELLS, 2.0, 1.0, 0.2);
    if (!c) return;
    int32_t alone = c->body.count / 2, one;
    pd_bond_iterator first = pd_body_bonds_begin(&c->body, alone);
    pd_body_bonds_next(&first);
    one = first.neighbour;
    for (int32_t j = 0; j < c->body.count; j++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, j); pd_body_bonds_next(&b);)
            if ((j == alone || b.neighbour == alone) && j + b.neighbour != alone + one)
                pdi_body_bonds_mark_broken(&c->body, j, b.number);
    if (PD_DIM > 1) CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_GEOMETRY);
    d.detach_singular = 1;
    pd_material_interface s = build(c, &d, &f);
    pdi_constitutive_law_params m = moduli(&d);
    CHECK((f.detached_bonds > 0) == (PD_DIM > 1));
    solid_gradient(&seed, 0.3, g);
    CHECK(pdi_constitutive_law_compute_stress(&m, g, NULL, p));
    solid_stretch(c, g, 0.0, 0, u);
    CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, force));
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) {
        double held = force[k];
        for (int b = 0; b < PD_DIM; b++) held -= p[k % PD_DIM * PD_DIM + b] * s.surface_vector[k - k % PD_DIM + b];
        largest = fmax(largest, fabs(held) * c->desc.horizon);
    }
    CHECK_LE(largest, 1e-12 * E);
    CHECK(s.stable_step(s.self, 1.0) > 0.0);
    s.blocks(&c->ctx, s.self, stress);
    s.stress(&c->ctx, s.self, u, stress);
    for (int32_t k = 0; k < c->body.count * T; k++) CHECK(fabs(stress[k]) < 1e100);
    end(c, &f);
}

/* Pulls apart the first and the last layer of a box of 1 mm along x. */
static pd_status pulled(pd_ctx *ctx, void *user, double t, double *x, double *load)
{
    const solid_case *c = (const solid_case *)user;
    (void)ctx;
    (void)load;
    for (int32_t i = 0; i < c->body.count; i++)
        for (int a = 0; a < PD_DIM && fabs(c->position[i * PD_DIM] - 0.5e-3) > 0.37e-3; a++)
            x[i * PD_DIM + a] = a == 0 && c->position[i * PD_DIM] > 0.5e-3 ? 1e-3 * t : 0.0;
    return PD_OK;
}

/* A plate of that law that is pulled apart; bonds break beyond `stretch`. */
static solid_case *plate(const pd_finite_strain_desc *d, double stretch, pd_finite_strain *f, pd_quasi_static *rest)
{
    static uint8_t held[MOST * PD_DIM];
    pd_quasi_static_desc q;
    solid_case *c = solid_cells(PD_DIM == 3 ? 5 : 10, PD_DIM == 3 ? 1.0 : 1.5, 1.0, 0.0, 1);
    if (!c) return NULL;
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++)
        held[k] = fabs(c->position[k - k % PD_DIM] - 0.5e-3) > 0.37e-3;
    memset(&q, 0, sizeof q);
    q.prescribed = held;
    q.load = pulled;
    q.user = c;
    q.criterion.critical = stretch;
    q.break_fraction = 1.0;
    pd_material_interface s = build(c, d, f);
    return CHECK_OK(&c->ctx, pd_quasi_static_build(&c->ctx, &s, &q, rest)) ? c : NULL;
}

/* Rubber is pulled until it parts: work is what is stored, what broken bonds had, and what a crack that runs would turn
 * into motion. */
TEST(rubber_parts)
{
    pd_finite_strain_desc d = desc_of(0);
    pd_finite_strain f;
    pd_quasi_static rest;
    double t = 0.0, left = 0.0;
    d.detach_singular = 1;
    d.law.poisson = 0.45;
    solid_case *c = plate(&d, 0.5, &f, &rest);
    if (!c) return;
    for (int step = 1; step <= 40 && !(rest.broken && rest.stored < 1e-6 * rest.work); step++) {
        t = 0.025 * step;
        if (!CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &rest, t))) break;
        if (!rest.broken) left = (rest.work - rest.stored) / rest.work;
        /* the work of a step is that of the mean of the forces at its ends */
        CHECK_LE(rest.stored + rest.released, rest.work * (rest.broken ? 1.001 : 1.015));
    }
    NOTE("parts at %.3g, %d bonds: work %.4g, released %.4g; before bonds break %.1e is left over", t, (int)rest.broken,
         rest.work, rest.released, left);
    CHECK(rest.broken > 0 && rest.released > 0.0);
    CHECK_LE(rest.stored, 1e-6 * rest.work);
    CHECK_LE(fabs(left), 2e-3);
    pd_quasi_static_free(&c->ctx, &rest);
    end(c, &f);
}

/* Metal is pulled by 4 %: work is what is stored and what flow has cost, to second order of the step. */
TEST(work_of_flow)
{
    double left[2];
    for (int fine = 0; fine < 2; fine++) {
        pd_finite_strain_desc d = desc_of(2);
        pd_finite_strain f;
        pd_quasi_static rest;
        int steps = (fine ? 2 : 1) * (PD_DIM == 3 ? 10 : 20);
        d.store_tangent = 1;
        d.law.hardening = 0.02 * E;
        solid_case *c = plate(&d, 0.0, &f, &rest);
        if (!c) return;
        for (int step = 1; step <= steps; step++)
            CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &rest, 0.04 * pow((double)step / steps, 2.0)));
        left[fine] = fabs(rest.work - rest.stored - rest.solid.dissipated(rest.solid.self)) / rest.work;
        CHECK(rest.stored < 0.3 * rest.work);
        pd_quasi_static_free(&c->ctx, &rest);
        end(c, &f);
    }
    NOTE("off by %.1e, by %.1e in half the step", left[0], left[1]);
    CHECK_LE(left[0], 5e-3);
    CHECK_LE(left[1], 0.5 * left[0]); /* where it begins to flow within a step counts, too */
}

/* A state that is stored and read goes on to the last bit. */
TEST(store)
{
    const char *path = PD_DIM == 1 ? "finite_1d.state" : PD_DIM == 2 ? "finite_2d.state" : "finite_3d.state";
    for (int way = 0; way < 2; way++) {
        pd_finite_strain_desc d = desc_of(2 + 3 * way);
        pd_finite_strain f;
        pd_archive_file file;
        double g[T], cost = 0.0;
        for (int run = 0; run < 2; run++) {
            uint32_t seed = 4;
            solid_case *c = solid_block(PD_DIM == 3 ? 5 : 10, 2.0, 1.0, 0.3);
            if (!c) return;
            pd_material_interface s = build(c, &d, &f);
            solid_gradient(&seed, 0.03, g);
            solid_stretch(c, g, 1e-7, 4, u);
            if (!run) {
                pd_bond_iterator first = pd_body_bonds_begin(&c->body, 0);
                pd_body_bonds_next(&first);
                pd_body_break(&c->body, 0, first.neighbour);
                CHECK_OK(&c->ctx, s.update(&c->ctx, s.self));
                CHECK_OK(&c->ctx, s.commit(&c->ctx, s.self, u));
                cost = s.dissipated(s.self);
                CHECK(cost > 0.0);
            }
            if (!CHECK_OK(&c->ctx, run ? pd_archive_file_open(&c->ctx, path, &file)
                                       : pd_archive_file_create(&c->ctx, path, &file)))
                return;
            CHECK_OK(&c->ctx, s.store(&c->ctx, s.self, &file.archive));
            CHECK_OK(&c->ctx, pd_archive_file_close(&c->ctx, &file));
            solid_gradient(&seed, 0.03, g);
            solid_stretch(c, g, 1e-7, 5, u);
            CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, u, run ? force : kept));
            CHECK_NEAR(s.dissipated(s.self), cost, 0.0);
            if (run) CHECK(memcmp(force, kept, (size_t)c->body.count * PD_DIM * sizeof *force) == 0);
            end(c, &f);
        }
    }
    remove(path);
}

/* ---- input ---- */

/* Where bonds are inside out there is no state: the energy is infinite and the stress is no number, at points without
 * stiffness, too. Far from a point that has passed its neighbours both are those of the undeformed body. */
TEST(inside_out)
{
    static double density[MOST], stiff[MOST];
    for (int way = 0; way < 9; way++)
        for (int one = 0; one < 2; one++) {
            pd_finite_strain_desc d = desc_of(way);
            pd_finite_strain f;
            solid_case *c = solid_cells(CELLS, 1.5, 0.0, 0.0, 1);
            int32_t passed = 0, far = 0;
            if (!c) return;
            for (int a = 0; a < PD_DIM; a++) passed = passed * CELLS + CELLS / 2;
            for (int32_t i = 0; i < c->body.count; i++) stiff[i] = i == passed ? 0.0 : 1.0;
            d.stiffness_factor = stiff;
            d.detach_singular = 1;
            pd_material_interface s = build(c, &d, &f);
            for (int32_t k = 0; k < c->body.count * PD_DIM; k++)
                u[k] = one || k % PD_DIM ? 0.0 : -2.0 * c->position[k];
            if (one) u[passed * PD_DIM] = 1.7 * c->desc.horizon;
            s.density(&c->ctx, s.self, u, density);
            s.stress(&c->ctx, s.self, u, stress);
            for (int32_t i = 0; i < c->body.count; i++) {
                int folds = i == passed && d.control == PD_FINITE_STRAIN_BOND_GRADIENT;
                double square = 0.0;
                for (int a = 0; a < PD_DIM; a++)
                    square += pow(c->position[i * PD_DIM + a] - c->position[passed * PD_DIM + a], 2.0);
                if (one && square > 4.0 * c->desc.horizon * c->desc.horizon) {
                    far++;
                    CHECK_NEAR(density[i], 0.0, 0.0);
                    for (int k = 0; k < T; k++) CHECK_NEAR(stress[i * T + k], 0.0, 0.0);
                } else if (!one || folds) {
                    CHECK(density[i] >= HUGE_VAL);
                    for (int k = 0; k < T; k++) CHECK(isnan(stress[i * T + k]));
                    if (s.out_of_plane_stress) CHECK(isnan(s.out_of_plane_stress(s.self, i, stress)));
                }
            }
            CHECK(!one || far > 0);
            end(c, &f);
        }
}

TEST(bad_input)
{
    pd_finite_strain_desc good = desc_of(2), d;
    pd_finite_strain f;
    solid_case *c = solid_block(CELLS, 2.0, 0.0, 0.0);
    if (!c) return;
    d = good, d.law.young = 0.0;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.law.poisson = 0.5;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.law.yield = NAN;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.law.hardening = -1.0;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.law.saturation = 0.5 * d.law.yield;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.law.saturation = NAN;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.control = PD_FINITE_STRAIN_SILLING, d.penalty = 0.0;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    d = good, d.control = (pd_zero_energy_control)3;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &d, &f), PD_ERR_ARGUMENT);
    /* inside out */
    pd_material_interface s = build(c, &good, &f);
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) u[k] = -(k % PD_DIM == 0) * 2.0 * c->position[k];
    CHECK_INT(s.force(&c->ctx, s.self, u, force), PD_RETRY);
    CHECK(s.energy(&c->ctx, s.self, u) > 1e300);
    u[0] = NAN;
    CHECK_INT(s.force(&c->ctx, s.self, u, force), PD_RETRY);
    pd_finite_strain_free(&c->ctx, &f);
    /* bonds of a point that are broken but for one line */
    pd_body_free(&c->ctx, &c->body);
    c->desc.count = PD_DIM == 1 ? 1 : 6;
    for (int32_t i = 0; i < c->desc.count; i++)
        for (int a = 0; a < PD_DIM; a++) c->position[i * PD_DIM + a] = i * 1e-5 * (a + 1);
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return;
    CHECK_INT(pd_finite_strain_build(&c->ctx, &c->body, &good, &f), PD_ERR_GEOMETRY);
    CHECK(strstr(c->ctx.message, "point 0") != NULL);
    end(c, &f);
}

TEST_MAIN(ENTRY(moduli_of_points) ENTRY(patch) ENTRY(rigid) ENTRY(balance) ENTRY(work) ENTRY(checkerboard) ENTRY(limit)
              ENTRY(blocks) ENTRY(order_and_threads) ENTRY(heterogeneous) ENTRY(uniaxial) ENTRY(bar_of_metal)
                  ENTRY(loose) SLOW_ENTRY_IF(PD_DIM == 3, rubber_parts)
                      SLOW_ENTRY_IF(PD_DIM == 3, work_of_flow) ENTRY(store) ENTRY(inside_out) ENTRY(bad_input))
