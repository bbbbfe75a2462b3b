/* j2_plasticity: see j2_plasticity.h */
#include "solid/j2_plasticity.h"
#include <math.h>
#include <string.h>

enum { PDI_J2_PLASTICITY_TENSOR = PD_DIM * PD_DIM };

PDI_FN void pdi_j2_plasticity_list(pdi_array_visitor *owner, void *object)
{
    pd_j2_plasticity *plastic = (pd_j2_plasticity *)object;
    PDI_ARRAY_STATE(owner, plastic, strain, plastic->count * PDI_J2_PLASTICITY_TENSOR, "1");
    PDI_ARRAY_STATE(owner, plastic, equivalent_strain, plastic->count, "1");
    PDI_ARRAY(owner, plastic, plastic_stress, plastic->count * PDI_J2_PLASTICITY_TENSOR, "Pa");
    PDI_ARRAY(owner, plastic, flow_direction, plastic->count * PDI_J2_PLASTICITY_TENSOR, "1");
    PDI_ARRAY(owner, plastic, tangent_along, plastic->count, "Pa");
    PDI_ARRAY(owner, plastic, tangent_across, plastic->count, "Pa");
}

/* Out-of-plane entry of a traceless tensor in 2D; 0 otherwise. */
static double pdi_j2_plasticity_out_of_plane(const double *a)
{
    return PD_DIM == 2 ? -a[0] - a[PDI_J2_PLASTICITY_TENSOR - 1] : 0.0;
}

/* Frobenius norm of a traceless tensor with its out-of-plane entry. */
static double pdi_j2_plasticity_norm(const double *a)
{
    double normal = pdi_j2_plasticity_out_of_plane(a), sum = normal * normal;
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++) sum += a[k] * a[k];
    return sqrt(sum);
}

/* e [PD_DIM^2]: deviatoric strain of the gradient h, its trace over 3 taken off in 2D, too; in 1D the strain. */
static void pdi_j2_plasticity_strain_deviator(const double *h, double *e)
{
    double trace = 0.0;
    for (int d = 0; d < PD_DIM; d++) trace += h[d * PD_DIM + d];
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++)
            e[p * PD_DIM + q] =
                0.5 * (h[p * PD_DIM + q] + h[q * PD_DIM + p]) - (p == q && PD_DIM > 1 ? trace / 3.0 : 0.0);
}

/* Stress over deviatoric strain [Pa]: 2 mu; in 1D E. */
static double pdi_j2_plasticity_stiffness(const pd_j2_plasticity *p) { return PD_DIM > 1 ? 2.0 * p->shear : p->shear; }
/* Factor by which the norm of a deviator becomes von Mises' stress: sqrt(3/2), in 1D 1. */
static double pdi_j2_plasticity_mises_factor(void) { return PD_DIM > 1 ? sqrt(1.5) : 1.0; }

/* Increment of the equivalent plastic strain of the step of point i to h; 0: elastic. Out: direction: of flow, of unit
 * norm, in an elastic step the trial stress [Pa]; *trial: norm of the trial stress [Pa]. */
static double pdi_j2_plasticity_compute_increment(const pd_j2_plasticity *p, int64_t i, const double *h,
                                                  double *direction, double *trial)
{
    const double *was = p->strain + i * PDI_J2_PLASTICITY_TENSOR;
    double stiffness = pdi_j2_plasticity_stiffness(p), mises = pdi_j2_plasticity_mises_factor(),
           e[PDI_J2_PLASTICITY_TENSOR];
    pdi_j2_plasticity_strain_deviator(h, e);
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++) direction[k] = stiffness * (e[k] - was[k]);
    *trial = pdi_j2_plasticity_norm(direction);
    double beyond = mises * *trial - p->yield - p->hardening * p->equivalent_strain[i];
    if (!(beyond > 0.0)) return 0.0;
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++) direction[k] /= *trial;
    return beyond / (mises * mises * stiffness + p->hardening);
}

PDI_FN void pdi_j2_plasticity_return_map(const pd_j2_plasticity *p, int64_t i, const double *h)
{
    double *relief = p->plastic_stress + i * PDI_J2_PLASTICITY_TENSOR,
           *way = p->flow_direction + i * PDI_J2_PLASTICITY_TENSOR, stress;
    const double *was = p->strain + i * PDI_J2_PLASTICITY_TENSOR;
    double stiffness = pdi_j2_plasticity_stiffness(p), mises = pdi_j2_plasticity_mises_factor();
    double slip = pdi_j2_plasticity_compute_increment(p, i, h, way, &stress);
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++)
        relief[k] = stiffness * (was[k] + (slip > 0.0 ? slip * mises * way[k] : 0.0));
    p->tangent_along[i] = p->tangent_across[i] = 0.0;
    if (!(slip > 0.0)) return;
    p->tangent_along[i] = stiffness * stiffness * mises * mises / (mises * mises * stiffness + p->hardening);
    p->tangent_across[i] = PD_DIM > 1 ? stiffness * stiffness * mises * slip / stress : 0.0;
}

PDI_FN void pdi_j2_plasticity_apply_tangent(const pd_j2_plasticity *p, int64_t i, const double *dh)
{
    double *relief = p->plastic_stress + i * PDI_J2_PLASTICITY_TENSOR, e[PDI_J2_PLASTICITY_TENSOR], share = 0.0;
    const double *way = p->flow_direction + i * PDI_J2_PLASTICITY_TENSOR;
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++) relief[k] = 0.0;
    if (!(p->tangent_along[i] > 0.0)) return;
    pdi_j2_plasticity_strain_deviator(dh, e);
    share = pdi_j2_plasticity_out_of_plane(way) * pdi_j2_plasticity_out_of_plane(e);
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++) share += way[k] * e[k];
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++)
        relief[k] = p->tangent_along[i] * share * way[k] + p->tangent_across[i] * (e[k] - share * way[k]);
}

PDI_FN void pdi_j2_plasticity_commit(const pd_j2_plasticity *p, int64_t i, const double *h)
{
    double way[PDI_J2_PLASTICITY_TENSOR], stress, slip = pdi_j2_plasticity_compute_increment(p, i, h, way, &stress);
    if (!(slip > 0.0)) return;
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++)
        p->strain[i * PDI_J2_PLASTICITY_TENSOR + k] += slip * pdi_j2_plasticity_mises_factor() * way[k];
    p->equivalent_strain[i] += slip;
}

PDI_FN double pdi_j2_plasticity_energy_relief(const pd_j2_plasticity *p, int64_t i, const double *h)
{
    const double *relief = p->plastic_stress + i * PDI_J2_PLASTICITY_TENSOR;
    double e[PDI_J2_PLASTICITY_TENSOR], own = pdi_j2_plasticity_norm(relief), sum;
    pdi_j2_plasticity_strain_deviator(h, e);
    sum = pdi_j2_plasticity_out_of_plane(relief) * pdi_j2_plasticity_out_of_plane(e);
    for (int k = 0; k < PDI_J2_PLASTICITY_TENSOR; k++) sum += relief[k] * e[k];
    return sum - 0.5 * own * own / pdi_j2_plasticity_stiffness(p);
}

PDI_FN double pdi_j2_plasticity_dissipated(const pd_j2_plasticity *p, int64_t i)
{
    return (p->yield + 0.5 * p->hardening * p->equivalent_strain[i]) * p->equivalent_strain[i];
}
