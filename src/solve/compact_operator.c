/* compact_operator: see compact_operator.h */
#include "solve/compact_operator.h"
#include "core/par.h"
#include <float.h>
#include <math.h>
#include <string.h>

PDI_FN int64_t pdi_compact_operator_cell_index(const pd_grid *grid, const int *i)
{
    int64_t cell = 0;
    for (int d = PD_DIM - 1; d >= 0; d--) cell = cell * grid->n[d] + i[d];
    return cell;
}

PDI_FN void pdi_compact_operator_list(pdi_array_visitor *owner, void *object)
{
    pd_compact_operator *compact = (pd_compact_operator *)object;
    PDI_ARRAY_UNINIT(owner, compact, active, compact->cells, "1");
    PDI_ARRAY_UNINIT(owner, compact, dirichlet, compact->cells, "1");
    PDI_ARRAY_UNINIT(owner, compact, mass, compact->cells, "1/s");
}

PDI_FN void pdi_compact_operator_face_list(pdi_array_visitor *owner, void *object)
{
    pd_compact_operator *compact = (pd_compact_operator *)object;
    for (int d = 0; d < PD_DIM; d++) {
        PDI_ARRAY_UNINIT(owner, compact, conductance[d], compact->cells, "1/s");
        if (compact->with_flux) PDI_ARRAY_UNINIT(owner, compact, flux[d], compact->cells, "1/s");
    }
}

PDI_FN void pdi_compact_operator_init(const pd_grid *grid, int with_flux, pd_compact_operator *c)
{
    memset(c, 0, sizeof *c);
    c->grid = grid;
    c->cells = 1;
    for (int d = 0; d < PD_DIM; d++) c->cells *= grid->n[d];
    c->with_flux = with_flux;
}

/* [-] Ratio of spacings above which a grid counts as stretched. */
#define PDI_COMPACT_OPERATOR_MAX_ASPECT 4.0

/* Diffusivity [m2/s] of the face along axis d between node and other, at least 0: physical plus numerical diffusivity
 * of peridynamic upwinding (none where numerical_diffusivity is NULL), less that of the compact upwind scheme, |u| h/2.
 * |u|: of the mean of both nodes. v->u is not NULL. */
static double pdi_compact_operator_face_diffusion(const pd_grid *grid, const pdi_compact_operator_convection *v,
                                                  double diffusivity, int32_t node, int32_t other, int d)
{
    for (int a = 0; a < PD_DIM; a++) {
        int64_t row = (int64_t)a * grid->total;
        double speed = 0.5 * fabs(v->u[row + node] + v->u[row + other]);
        if (v->numerical_diffusivity) diffusivity += speed * v->numerical_diffusivity[a * PD_DIM + d];
        if (a == d) diffusivity -= 0.5 * speed * grid->h[d];
    }
    return pd_max(diffusivity, 0.0);
}

/* Distance, in spacings along axis d, from a node to the wall behind its lower (up = 0) or upper face, not negative;
 * 0.5 at open sides, without wall_bonds, and for nodes that have no bonds. The friction on a curved wall that nearly
 * touches a node is a thousand times that of a wall half a cell away. */
static double pdi_compact_operator_wall_distance(const pdi_compact_operator_bc *faces, int32_t node, uint8_t kind,
                                                 int d, int up)
{
    const pd_bonds *walls = pdi_grid_is_open(kind) ? NULL : faces->wall_bonds;
    int32_t row = walls ? walls->row_of_node[node] : -1;
    return row >= 0 ? fabs(walls->neighbour_distance[((int64_t)row * PD_DIM + d) * 2 + up]) : 0.5;
}

/* Assemble one fluid cell: conductance and flux of its upper faces to fluid or periodic nodes, and Dirichlet terms of
 * its faces to other nodes as `faces` says; nothing passes a mirror. mass, 1/dt or the like before, is multiplied by
 * the circumference, and the outflow at outlets by the velocity of the node is added; inflow there adds nothing. With
 * numerical_diffusivity a net inflow of the whole cell is added, too. */
static void pdi_compact_operator_assemble_cell(pd_compact_operator *c, int64_t cell, int32_t node, double constant,
                                               const pd_bond_diffusivity *media,
                                               const pdi_compact_operator_convection *v,
                                               const pdi_compact_operator_bc *faces)
{
    const pd_grid *grid = c->grid;
    double wall = 0.0, outflow = 0.0;
    double circumference = pd_grid_circumference(grid, node), mass = circumference * c->mass[cell];
    for (int d = 0; d < PD_DIM; d++) {
        const double *u = v->u ? v->u + (int64_t)d * grid->total : NULL;
        for (int up = 0; up < 2; up++) {
            int32_t other = up ? node + grid->stride[d] : node - grid->stride[d];
            double face = 0.5 * (circumference + pd_grid_circumference(grid, other));
            double inverse = face / (grid->h[d] * grid->h[d]);
            uint8_t kind = grid->kind[other];
            double diffusivity = media ? media->node_value[node] : constant;
            if (kind == PD_IMAGE) {
                if (grid->side[2 * d + up] != PD_SIDE_PERIODIC) continue; /* nothing passes a mirror */
                kind = PD_FLUID;
            }
            if (kind == PD_FLUID) {
                if (u) outflow += (up ? face : -face) * 0.5 * (u[node] + u[other]) / grid->h[d];
                if (!up) continue;
                if (media) diffusivity = pdi_bond_diffusivity_get(media, node, other, media->unit_bond[d]);
                c->conductance[d][cell] =
                    (float)(inverse * (u ? pdi_compact_operator_face_diffusion(grid, v, diffusivity, node, other, d)
                                         : diffusivity));
                if (u) c->flux[d][cell] = (float)(face * 0.5 * (u[node] + u[other]) / grid->h[d]);
                continue;
            }
            int dirichlet = kind == PD_INLET ? faces->inlet : kind == PD_OUTLET ? faces->outlet : faces->wall;
            if (dirichlet) wall += diffusivity * inverse / pdi_compact_operator_wall_distance(faces, node, kind, d, up);
            if (!u || kind != PD_OUTLET) continue;
            mass += face * pd_max((up ? 1.0 : -1.0) * u[node] / grid->h[d], 0.0);
            outflow += face * pd_max((up ? 1.0 : -1.0) * u[node] / grid->h[d], 0.0);
        }
    }
    /* interpolated face velocities are not divergence-free: a net inflow must not accumulate */
    if (v->numerical_diffusivity) mass += pd_max(-outflow, 0.0);
    c->dirichlet[cell] = (float)wall;
    c->mass[cell] = (float)mass;
}

PDI_FN void pdi_compact_operator_assemble(const pd_ctx *ctx, double diffusivity, const pd_bond_diffusivity *media,
                                          const pdi_compact_operator_convection *convection, double mass,
                                          const pdi_compact_operator_bc *faces, pd_compact_operator *c)
{
    const pd_grid *grid = c->grid;
    int nt = pd_par_threads(ctx, c->cells * 20);
    int64_t lines = c->cells / grid->n[0];
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int64_t line = 0; line < lines; line++) {
        int i[PD_DIM];
        int64_t rest = line;
        i[0] = 0;
        for (int d = 1; d < PD_DIM; d++) {
            i[d] = (int)(rest % grid->n[d]);
            rest /= grid->n[d];
        }
        for (; i[0] < grid->n[0]; i[0]++) {
            int64_t cell = line * grid->n[0] + i[0];
            int32_t node = pd_grid_node(grid, i);
            int fluid = grid->kind[node] == PD_FLUID;
            c->active[cell] = (uint8_t)fluid;
            c->dirichlet[cell] = 0.0f;
            c->mass[cell] = fluid ? (float)mass : 0.0f;
            for (int d = 0; d < PD_DIM; d++) {
                c->conductance[d][cell] = 0.0f;
                if (c->flux[d]) c->flux[d][cell] = 0.0f;
            }
            if (fluid) pdi_compact_operator_assemble_cell(c, cell, node, diffusivity, media, convection, faces);
        }
    }
}

PDI_FN int pdi_compact_operator_is_stretched(const double *h)
{
    double smallest = h[0], largest = h[0];
    for (int d = 1; d < PD_DIM; d++) {
        smallest = pd_min(smallest, h[d]);
        largest = pd_max(largest, h[d]);
    }
    return largest > PDI_COMPACT_OPERATOR_MAX_ASPECT * smallest;
}

PDI_FN int pdi_compact_operator_needs_double(const int *n, const double *h)
{
    double length = 0.0, spacing = HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) {
        length = pd_max(length, n[d] * h[d]);
        spacing = pd_min(spacing, h[d]);
    }
    return FLT_EPSILON * length * length > spacing * spacing;
}

PDI_FN void pdi_compact_operator_multigrid_desc(const pd_grid *grid, pd_multigrid_desc *desc)
{
    int origin[PD_DIM];
    memset(desc, 0, sizeof *desc);
    for (int d = 0; d < PD_DIM; d++) {
        origin[d] = 0;
        desc->n[d] = grid->n[d];
        desc->stride[d] = grid->stride[d];
        desc->periodic[d] = grid->side[2 * d] == PD_SIDE_PERIODIC;
    }
    desc->high_contrast = pdi_compact_operator_needs_double(grid->n, grid->h);
    desc->first = pd_grid_node(grid, origin);
    desc->rhs_weight = grid->circumference ? grid->circumference + grid->ghost : NULL;
}

PDI_FN void pdi_compact_operator_upwind_diffusion(const pd_stencil *s, double share, double *spread)
{
    for (int i = 0; i < PD_DIM * PD_DIM; i++) spread[i] = 0.0;
    for (int k = 0; k < s->count; k++)
        for (int a = 0; a < PD_DIM; a++)
            for (int b = 0; b < PD_DIM; b++)
                spread[a * PD_DIM + b] += share * 0.5 * fabs(s->gradient_weight[k * PD_DIM + a]) *
                                          s->xi[k * PD_DIM + b] * s->xi[k * PD_DIM + b];
}

PDI_FN double pdi_compact_operator_inverse_excess(const pd_stencil *s)
{
    double compact = 0.0;
    for (int d = 0; d < PD_DIM; d++) compact += 2.0 / (s->h[d] * s->h[d]);
    return pd_max(1.0 / s->lap_sum - 1.0 / compact, 0.0);
}
