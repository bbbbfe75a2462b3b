/* test_constitutive_law: laws of large strains at one place, against differences and closed forms.
 * dims: 1 2 3 */
#include "finite_case.h"
#include "solid/tensor.h"

/* Stress is the derivative of the energy, and the tangent that of the stress: symmetric. It turns with the place. So
 * also behind a history of yielding. */
TEST(derivatives)
{
    for (int way = 0; way < WAYS; way++) {
        pd_finite_strain_desc d = desc_of(way);
        pdi_constitutive_law_params m = moduli(&d);
        uint32_t seed = 100u + (uint32_t)way;
        double state[PDI_CONSTITUTIVE_LAW_STATE] = {0.0}, f[T], p[T], worst[3] = {0.0}, across = 0.0;
        double *s = d.law.kind == PD_FINITE_STRAIN_J2 ? state : NULL;
        for (int k = 0; k < 3 && s; k++) {
            solid_gradient(&seed, 0.02, f);
            pdi_constitutive_law_commit(&m, f, s);
        }
        solid_gradient(&seed, 0.3, f);
        CHECK(pdi_constitutive_law_compute_stress(&m, f, s, p));
        double tangent[T][T], size = 0.0;
        for (int k = 0; k < T; k++) {
            double df[T] = {0.0}, up[T], down[T], high[T], low[T], h = 1e-6;
            df[k] = 1.0;
            pdi_constitutive_law_apply_tangent(&m, f, s, df, tangent[k]);
            for (int q = 0; q < T; q++) up[q] = f[q] + h * df[q], down[q] = f[q] - h * df[q];
            double slope = (pdi_constitutive_law_compute_energy(&m, up, s, 1) -
                            pdi_constitutive_law_compute_energy(&m, down, s, 1)) /
                           (2.0 * h);
            worst[0] = fmax(worst[0], fabs(slope - p[k]));
            pdi_constitutive_law_compute_stress(&m, up, s, high);
            pdi_constitutive_law_compute_stress(&m, down, s, low);
            for (int q = 0; q < T; q++) {
                worst[1] = fmax(worst[1], fabs((high[q] - low[q]) / (2.0 * h) - tangent[k][q]));
                size = fmax(size, fabs(tangent[k][q]));
            }
        }
        for (int k = 0; k < T; k++)
            for (int q = 0; q < k; q++) across = fmax(across, fabs(tangent[k][q] - tangent[q][k]));
        CHECK_LE(worst[0], 1e-8 * size);
        CHECK_LE(worst[1], 1e-8 * size);
        CHECK_LE(across, 2e-14 * size);
        /* turned */
        double turn[T], both[T], after[T], expected[T];
        solid_gradient(&seed, 0.0, turn);
        pdi_tensor_multiply(turn, f, both);
        pdi_tensor_multiply(turn, p, expected);
        pdi_constitutive_law_compute_stress(&m, both, s, after);
        for (int k = 0; k < T; k++) CHECK_NEAR(after[k], expected[k], 1e-14 * size);
    }
}

/* Principal values that meet: the tangent is that of differences beside. */
TEST(equal_stretches)
{
    for (int way = 0; way < WAYS; way++) {
        pd_finite_strain_desc d = desc_of(way);
        pdi_constitutive_law_params m = moduli(&d);
        for (int k = 0; k < 6; k++) {
            double f[T] = {0.0}, df[T], dp[T], near[T], apart = k ? pow(10.0, -2.0 * k) : 0.0;
            for (int a = 0; a < PD_DIM; a++) f[a * (PD_DIM + 1)] = 1.05 + apart * a;
            for (int q = 0; q < T; q++) df[q] = 0.3 + 0.1 * q;
            pdi_constitutive_law_apply_tangent(&m, f, NULL, df, dp);
            double up[T], down[T], low[T], h = 1e-6;
            for (int q = 0; q < T; q++) up[q] = f[q] + h * df[q], down[q] = f[q] - h * df[q];
            CHECK(pdi_constitutive_law_compute_stress(&m, up, NULL, near));
            CHECK(pdi_constitutive_law_compute_stress(&m, down, NULL, low));
            for (int q = 0; q < T; q++) CHECK_NEAR(dp[q], (near[q] - low[q]) / (2.0 * h), 3e-9 * E);
        }
    }
}

/* Isochoric stretch (e, -e, 0), in 1D a bar of strain e: tau and the plastic strain along it are known in closed form,
 * for linear hardening and saturation, in one step or many, and back. */
TEST(yielding)
{
    for (int way = 0; way < 8; way++) {
        pd_finite_strain_desc d = desc_of(2 + 4 * way);
        d.law.kind = PD_FINITE_STRAIN_J2;
        d.law.plane = PD_PLANE_STRAIN;
        d.law.hardening = way & 1 ? 0.05 * E : 0.0;
        d.law.saturation = way & 2 ? 2.0 * d.law.yield : 0.0;
        pdi_constitutive_law_params m = moduli(&d);
        double shear = PD_DIM == 1 ? E : 2.0 * sqrt(3.0) * m.mu; /* equivalent stress over e */
        double back = PD_DIM == 1 ? E : 3.0 * m.mu, factor = PD_DIM == 1 ? 1.0 : 1.0 / sqrt(3.0);
        double once[PDI_CONSTITUTIVE_LAW_STATE] = {0.0}, steps[PDI_CONSTITUTIVE_LAW_STATE] = {0.0}, f[T], p[T],
               most = 0.02;
        /* the yield stress at the plastic strain a is the stress at the strain (Y + back a)/shear */
        double grown = way & 2 ? d.law.yield * -expm1(-d.law.rate * most) : 0.0;
        double yield = d.law.yield + d.law.hardening * most + grown, strain = (yield + back * most) / shear;
        for (int k = 1; k <= 10; k++) {
            for (int q = 0; q < T; q++) f[q] = q % (PD_DIM + 1) ? 0.0 : 1.0;
            f[0] = exp(strain * k / 10.0);
            if (PD_DIM > 1) f[PD_DIM + 1] = 1.0 / f[0];
            if (k < 10 || way & 4) pdi_constitutive_law_commit(&m, f, steps);
        }
        pdi_constitutive_law_compute_stress(&m, f, once, p);
        CHECK_REL(p[0] * f[0], factor * yield, 1e-13);
        pdi_constitutive_law_compute_stress(&m, f, steps, p);
        CHECK_REL(p[0] * f[0], factor * yield, 1e-12);
        pdi_constitutive_law_commit(&m, f, steps);
        pdi_constitutive_law_commit(&m, f, once);
        CHECK_REL(once[PDI_CONSTITUTIVE_LAW_STATE - 1], most, 1e-12);
        for (int k = 0; k < PDI_CONSTITUTIVE_LAW_STATE; k++) CHECK_NEAR(steps[k], once[k], 1e-14);
        /* back by less than twice the yield stress, and nearly forth: no plastic strain, no drift */
        memcpy(steps, once, sizeof once);
        for (int k = 0; k < 1000; k++) {
            double elastic = 1e-9 + 1.9 * (k % 5) / 4.0, part = strain - elastic * yield / shear;
            f[0] = exp(part);
            if (PD_DIM > 1) f[PD_DIM + 1] = exp(-part);
            pdi_constitutive_law_compute_stress(&m, f, steps, p);
            CHECK_NEAR(p[0] * f[0], factor * yield * (1.0 - elastic), 1e-12 * yield);
            pdi_constitutive_law_commit(&m, f, steps);
        }
        CHECK(memcmp(steps, once, sizeof once) == 0);
        /* and it yields the other way */
        double part = strain - 2.5 * yield / shear, work = once[PDI_CONSTITUTIVE_LAW_STATE - 1];
        f[0] = exp(part);
        if (PD_DIM > 1) f[PD_DIM + 1] = exp(-part);
        pdi_constitutive_law_commit(&m, f, steps);
        CHECK(steps[PDI_CONSTITUTIVE_LAW_STATE - 1] > work);
    }
}

/* Below yield nothing is left behind, and the energy is that of Hencky's law. Flow keeps the volume. */
TEST(plastic_volume)
{
    pd_finite_strain_desc d = desc_of(2);
    pdi_constitutive_law_params m = moduli(&d), elastic = m;
    double state[PDI_CONSTITUTIVE_LAW_STATE] = {0.0}, none[PDI_CONSTITUTIVE_LAW_STATE] = {0.0}, f[T] = {0.0}, g[T];
    uint32_t seed = 4;
    elastic.law.kind = PD_FINITE_STRAIN_HENCKY;
    solid_gradient(&seed, 1e-3, f);
    pdi_constitutive_law_commit(&m, f, state);
    CHECK(memcmp(state, none, sizeof none) == 0);
    CHECK_NEAR(pdi_constitutive_law_compute_energy(&m, f, state, 1),
               pdi_constitutive_law_compute_energy(&elastic, f, NULL, 0), 1e-25 * E);
    for (int k = 0; k < 1000; k++) {
        solid_gradient(&seed, 0.1, f);
        pdi_constitutive_law_commit(&m, f, state);
    }
    for (int p = 0, k = 0; p < PD_DIM; p++)
        for (int q = p; q < PD_DIM; q++, k++) {
            g[p * PD_DIM + q] = state[k] + (p == q ? 1.0 : 0.0);
            g[q * PD_DIM + p] = g[p * PD_DIM + q];
        }
    double turned[T], det = pdi_tensor_compute_cofactor(g, turned);
    if (PD_DIM < 3) det *= pow(1.0 + state[PDI_CONSTITUTIVE_LAW_STATE - 2], 3 - PD_DIM);
    NOTE("after 1000 strains of 10 %%: equivalent plastic strain %.0f, volume off by %.1e",
         state[PDI_CONSTITUTIVE_LAW_STATE - 1], det - 1.0);
    CHECK_NEAR(det, 1.0, 1e-12);
}

/* The neo-Hookean stress in closed form; in plane stress and 1D the directions left out bear none. */
TEST(neo_hookean)
{
    uint32_t seed = 2;
    for (int way = 0; way < 4; way++) {
        pd_finite_strain_desc d = desc_of(0);
        d.law.plane = way & 1 ? PD_PLANE_STRESS : PD_PLANE_STRAIN;
        d.law.poisson = 0.15 * way;
        pdi_constitutive_law_params m = moduli(&d);
        double f[T], p[T], turned[T], low = -3.0, high = 3.0;
        solid_gradient(&seed, 0.5, f);
        double det = pdi_tensor_compute_cofactor(f, turned);
        for (int k = 0; k < 200 && m.free; k++) {
            double y = 0.5 * (low + high), rest = m.mu * (exp(2.0 * y) - 1.0) + m.lambda * (log(det) + m.free * y);
            *(rest > 0.0 ? &high : &low) = y;
        }
        double log_j = log(det) + m.free * low;
        CHECK(pdi_constitutive_law_compute_stress(&m, f, NULL, p));
        for (int k = 0; k < T; k++)
            CHECK_NEAR(p[k], m.mu * (f[k] - turned[k] / det) + m.lambda * log_j * turned[k] / det, 4e-15 * E);
        double sigma[T], across, expected = PD_DIM == 2 && !(way & 1) ? m.lambda * log_j / det : 0.0;
        CHECK(pdi_constitutive_law_compute_cauchy(&m, f, NULL, sigma, &across));
        if (PD_DIM < 3) CHECK_NEAR(across, expected, 4e-15 * E);
    }
}

TEST_MAIN(ENTRY(derivatives) ENTRY(equal_stretches) ENTRY(yielding) ENTRY(plastic_volume) ENTRY(neo_hookean))
