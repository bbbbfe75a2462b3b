/* sample: see sample.h */
#include "sample.h"
#include "op.h"
#include <math.h>

#define PDI_SAMPLE_NEAR 1e-6 /* [cells] from a face: the point touches the cells on both sides */
#define PDI_SAMPLE_CELLS (1 << PD_DIM)

static const char *const pdi_sample_labels[] = {"C [mol/m3]", "v [m/s]",  "p [Pa]",     "kind",           "grain",
                                                "phase",      "D [m2/s]", "rate [m/s]", "density [kg/m3]", "damage"};

PDI_FN const char *pdi_sample_label(pd_field field) { return pdi_sample_labels[field]; }

static double pdi_sample_density(const pd_model *m, int32_t i)
{
    const pd_setup *u = m->setup;
    if (m->grid.kind[i] == PD_SOLID)
        return pdi_setup_loses(u) ? u->material.density * pdi_model_c(m)[i] / u->solid_c : u->material.density;
    return m->grid.kind[i] == PD_FLUID && u->has_flow ? u->rho : 0.0;
}

PDI_FN double pdi_sample_node(const pd_model *m, pd_field field, int32_t i)
{
    int fluid = m->grid.kind[i] == PD_FLUID;
    const double *diffusivity = m->transport.diffusion.field;
    double square = 0.0;
    switch (field) {
    case PD_FIELD_C: return fluid ? pdi_model_c(m)[i] : 0.0;
    case PD_FIELD_V:
        for (int d = 0; d < PD_DIM && fluid; d++) {
            double u = m->flow.u[(int64_t)d * m->grid.total + i];
            square += u * u;
        }
        return sqrt(square);
    case PD_FIELD_P: return fluid ? m->flow.p[i] * m->flow.rho : 0.0;
    case PD_FIELD_KIND: return m->grid.kind[i];
    case PD_FIELD_GRAIN: return m->grid.kind[i] == PD_SOLID ? m->grain.id[i] : -1.0;
    case PD_FIELD_PHASE: return m->grid.kind[i] == PD_SOLID;
    case PD_FIELD_D: return !fluid ? 0.0 : diffusivity ? diffusivity[i] : m->setup->diffusivity;
    case PD_FIELD_RATE:
        return fluid && m->dissolve.weight[i] > 0.0
                   ? fmax(0.0, m->dissolve.speed[i] + m->dissolve.slope[i] * m->transport.c[i]) : 0.0;
    case PD_FIELD_DENSITY: return pdi_sample_density(m, i);
    case PD_FIELD_DAMAGE: return pd_corrode_damage(&m->corrode, i);
    case PD_FIELD_COUNT: break;
    }
    return 0.0;
}

PDI_FN void pdi_sample_prepare(pd_model *m)
{
    const pd_ghosts *g = &m->bonds.ghosts;
    double *c = m->transport.c;
    /* behind outlets there is no gradient (eq. 5.1); inlets hold their own values */
    for (int32_t k = 0; k < g->count && c; k++) c[g->node[k]] = c[g->source[k]];
}

/* The cells that x touches. */
static int pdi_sample_cells(const pd_grid *grid, const double *x, int32_t *node)
{
    int i[PD_DIM][2], choices[PD_DIM], at[PD_DIM], count = 1;
    for (int d = 0; d < PD_DIM; d++) {
        double place = (x[d] - grid->lo[d]) / grid->h[d];
        int low = (int)floor(place - PDI_SAMPLE_NEAR), high = (int)floor(place + PDI_SAMPLE_NEAR);
        i[d][0] = low < 0 ? 0 : low >= grid->n[d] ? grid->n[d] - 1 : low;
        i[d][1] = high < 0 ? 0 : high >= grid->n[d] ? grid->n[d] - 1 : high;
        choices[d] = i[d][1] > i[d][0] ? 2 : 1;
        count *= choices[d];
    }
    for (int k = 0; k < count; k++) {
        int rest = k;
        for (int d = 0; d < PD_DIM; d++) {
            at[d] = i[d][rest % choices[d]];
            rest /= choices[d];
        }
        node[k] = pd_grid_node(grid, at);
    }
    return count;
}

/* Without bonds: linear between the fluid nodes around x. */
static double pdi_sample_between(const pd_grid *grid, const double *f, const double *x)
{
    double sum = 0.0, weights = 0.0;
    for (int corner = 0; corner < PDI_SAMPLE_CELLS; corner++) {
        double weight = 1.0;
        int i[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) {
            double place = (x[d] - grid->lo[d]) / grid->h[d] - 0.5, low = floor(place);
            int up = (corner >> d) & 1;
            i[d] = (int)low + up;
            weight *= up ? place - low : 1.0 - (place - low);
        }
        if (!pdi_grid_inside(grid, i)) continue;
        int32_t node = pd_grid_node(grid, i);
        if (grid->kind[node] != PD_FLUID) continue;
        sum += weight * f[node];
        weights += weight;
    }
    return sum / weights;
}

PDI_FN double pdi_sample_point(const pd_model *m, pd_field field, int component, const double *x)
{
    int32_t node[PDI_SAMPLE_CELLS];
    int cells = pdi_sample_cells(&m->grid, x, node), fluid = 0;
    const double *f = NULL;
    double sum = 0.0;
    if (field == PD_FIELD_V) f = m->flow.u + (int64_t)component * m->grid.total;
    if (field == PD_FIELD_P) f = m->flow.p;
    if (field == PD_FIELD_C) f = pdi_model_c(m);
    if (!f) return pdi_sample_node(m, field, node[cells - 1]);
    for (int k = 0; k < cells; k++) {
        if (m->grid.kind[node[k]] != PD_FLUID) continue;
        sum += m->bonds.grid ? pdi_op_sample(&m->bonds, f, node[k], x) : pdi_sample_between(&m->grid, f, x);
        fluid++;
    }
    if (!fluid) return (double)NAN;
    return (field == PD_FIELD_P ? m->flow.rho : 1.0) * sum / fluid;
}

PDI_FN int pdi_sample_inside(const pd_model *m, const double *x)
{
    int32_t node[PDI_SAMPLE_CELLS];
    int cells = pdi_sample_cells(&m->grid, x, node);
    for (int k = 0; k < cells; k++)
        if (m->grid.kind[node[k]] == PD_FLUID || m->grid.kind[node[k]] == PD_SOLID) return 1;
    return 0;
}

#undef PDI_SAMPLE_NEAR
#undef PDI_SAMPLE_CELLS
