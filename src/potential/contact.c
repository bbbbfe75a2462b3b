/* contact: see contact.h */
#include "potential/contact.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* [cells] A place this near to the zero level of a shape lies on it. */
#define PDI_CONTACT_TOUCH 1e-3
/* What a bond reaches along a normal that it stands across is rounding: less than this share of its length. */
#define PDI_CONTACT_NONE 1e-9

static void pdi_contact_list(pdi_array_visitor *owner, void *object)
{
    pd_contacts *contacts = (pd_contacts *)object;
    PDI_ARRAY(owner, contacts, list, contacts->capacity, "");
}

/* What a walk knows. */
typedef struct pdi_contact_walk {
    const pd_bonds *bonds;
    const pdi_contact_metal *metal;
    pd_contact at[PD_ELECTRODES]; /* of the node, by electrode: area, and area times way */
    int found;                    /* electrodes that it has */
} pdi_contact_walk;

/* Ghosts stand for what they mirror, so that metal which meets a side is the same there as elsewhere. */
static int32_t pdi_contact_home(const pd_grid *grid, int32_t at, int *flip)
{
    *flip = 0;
    return grid->kind[at] == PD_FLUID || grid->kind[at] == PD_SOLID ? at : pd_grid_find_source(grid, at, flip);
}

/* 1: metal node j is one cell thick along an axis: fluid is at both faces. */
static int pdi_contact_thin(const pd_grid *grid, int32_t j, int axis)
{
    int fluid = 0, flip;
    for (int side = -1; side < 2; side += 2)
        fluid += grid->kind[pdi_contact_home(grid, j + side * (int32_t)grid->stride[axis], &flip)] == PD_FLUID;
    return fluid == 2;
}

/* Normal of the cells around metal node j, towards the fluid. Where it is one cell thick, the fluid behind it, as seen
 * along `from` [m], has another surface. 0: there is none. */
static int pdi_contact_cells(const pdi_contact_walk *w, int32_t j, const double *from, double *normal)
{
    const pd_grid *grid = w->bonds->grid;
    const pd_stencil *s = w->metal->wide;
    int thin[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) normal[d] = 0.0;
    for (int d = 0; d < PD_DIM; d++) thin[d] = pdi_contact_thin(grid, j, d);
    for (int k = 0; k < s->count; k++) {
        int32_t at = j;
        int flip, behind = 0;
        for (int d = 0; d < PD_DIM; d++) at += s->offset[k * PD_DIM + d] * grid->stride[d];
        for (int d = 0; d < PD_DIM; d++) behind |= thin[d] && s->offset[k * PD_DIM + d] * from[d] > 0.0;
        if (behind || grid->kind[pdi_contact_home(grid, at, &flip)] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) normal[d] += s->laplacian_weight[k] * s->xi[k * PD_DIM + d];
    }
    double length = pdi_vec_norm(normal);
    if (!(length > 1e-9 * s->lap_sum * pdi_vec_min(s->h))) return 0;
    for (int d = 0; d < PD_DIM; d++) normal[d] /= length;
    return 1;
}

/* A share of bond k, from node i to metal j, that meets its surface with the normal towards the fluid, `way` off. */
static void pdi_contact_add(pdi_contact_walk *w, int32_t i, int32_t j, int k, double share, const double *normal,
                            double way)
{
    const pd_bonds *bonds = w->bonds;
    int electrode = w->metal->electrode ? w->metal->electrode[j] : 0;
    double reach = -pdi_vec_dot(bonds->stencil->xi + k * PD_DIM, normal);
    double area = share * pdi_bond_get_laplacian_weights(bonds, i)[k] * reach;
    pd_contact *contact = &w->at[electrode];
    if (!(reach > PDI_CONTACT_NONE * pdi_vec_norm(bonds->stencil->xi + k * PD_DIM)) || !(area > 0.0)) return;
    w->found += !(contact->area > 0.0);
    contact->area += area;
    contact->way += area * way;
    for (int d = 0; d < PD_DIM; d++) contact->moment[d] -= 0.5 * area * bonds->stencil->xi[k * PD_DIM + d];
}

/* [m] How much deeper the surface lies than the face of metal j, whose content is part of that of a whole cell. */
static double pdi_contact_lost(const pdi_contact_walk *w, int32_t j, const double *normal)
{
    double thick = 0.0;
    for (int d = 0; d < PD_DIM && w->metal->left; d++) thick = pd_max(thick, fabs(normal[d]) * w->bonds->grid->h[d]);
    return w->metal->left ? thick * (1.0 - w->metal->left[j]) : 0.0;
}

/* Bond k meets the known surface of a smooth shape on metal j: its normal, and the distance of the node from the plane
 * there. */
static int pdi_contact_smooth(const pdi_contact_walk *w, int32_t row, int32_t j, int k, double *normal, double *way)
{
    const pd_bonds *bonds = w->bonds;
    const pd_grid *grid = bonds->grid;
    double place[PD_DIM], x[PD_DIM];
    if (pdi_bond_is_open(bonds, row, k)) return 0;
    int32_t closed = pdi_bond_find_surface_point(bonds, row, k, place, normal);
    if (closed < 0 || grid->kind[pd_grid_find_source(grid, closed, NULL)] != PD_SOLID) return 0;
    double level = pdi_bond_surface_distance(bonds, closed, place);
    if (!(fabs(level) < PDI_CONTACT_TOUCH * pdi_vec_min(grid->h))) return 0;
    pd_grid_position(grid, bonds->node[row], x);
    *way = 0.0;
    for (int d = 0; d < PD_DIM; d++) *way += (x[d] - place[d]) * normal[d];
    if (!(*way > pd_shape_surface_tolerance(grid->h, x))) return 0; /* the bond runs along it */
    *way += pdi_contact_lost(w, j, normal);
    return 1;
}

/* The surface before a closed cell on bond k, whose home is metal j: where the cells say it lies, h_N/2 off the last
 * fluid on the way. `last` [m]: that fluid, from the node. */
static int pdi_contact_rough(const pdi_contact_walk *w, int32_t j, int k, int flip, const double *last, double *normal,
                             double *way)
{
    const double *h = w->bonds->grid->h;
    double thick = 0.0, along = 0.0, from[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) from[d] = w->bonds->stencil->xi[k * PD_DIM + d] * (flip >> d & 1 ? -1.0 : 1.0);
    if (!pdi_contact_cells(w, j, from, normal)) return 0;
    for (int d = 0; d < PD_DIM; d++) {
        if (flip >> d & 1) normal[d] = -normal[d];
        thick = pd_max(thick, fabs(normal[d]) * h[d]);
        along -= last[d] * normal[d];
    }
    *way = 0.5 * thick + pdi_contact_lost(w, j, normal) + pd_max(along, 0.0);
    return 1;
}

/* Follow bond k of node i to the first metal on it, and share it among the closed cells that it meets at once. */
static void pdi_contact_bond(pdi_contact_walk *w, int32_t row, int32_t i, int k)
{
    const pd_bonds *bonds = w->bonds;
    const pd_grid *grid = bonds->grid;
    const pd_stencil *s = bonds->stencil;
    double last[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) last[d] = 0.0;
    for (int g = s->group_first[k]; g < s->group_first[k + 1]; g++) {
        int cells = s->group_cell[g + 1] - s->group_cell[g], metal = 0, fluid = 0, flip;
        double mean[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) mean[d] = 0.0;
        for (int c = s->group_cell[g]; c < s->group_cell[g + 1]; c++) {
            uint8_t kind = grid->kind[pdi_contact_home(grid, i + bonds->paths.cell_shift[c], &flip)];
            metal += kind == PD_SOLID;
            if (kind != PD_FLUID) continue;
            for (int d = 0; d < PD_DIM; d++) mean[d] += s->cell[c * PD_DIM + d] * grid->h[d];
            fluid++;
        }
        for (int d = 0; d < PD_DIM && fluid; d++) last[d] = mean[d] / fluid;
        if (fluid) continue;
        /* where a bond meets a side or a wall, too, the place on its surface is not that of the metal */
        int whole = metal == cells && g == pdi_bond_path_find_closed_group(&bonds->paths, i, k);
        for (int c = s->group_cell[g]; c < s->group_cell[g + 1]; c++) {
            int32_t j = pdi_contact_home(grid, i + bonds->paths.cell_shift[c], &flip);
            double normal[PD_DIM], way;
            if (grid->kind[j] != PD_SOLID) continue;
            if ((whole && pdi_contact_smooth(w, row, j, k, normal, &way)) ||
                pdi_contact_rough(w, j, k, flip, last, normal, &way))
                pdi_contact_add(w, i, j, k, 1.0 / cells, normal, way);
        }
        return;
    }
}

/* The contacts of the node of a row, into list where that is not NULL: how many. */
static int32_t pdi_contact_node(pdi_contact_walk *w, int32_t row, pd_contact *list)
{
    const pd_bonds *bonds = w->bonds;
    int32_t i = bonds->node[row], found = 0;
    for (int k = 0; k < bonds->stencil->count; k++)
        if (pdi_bond_get_laplacian_weights(bonds, i)[k] > 0.0) pdi_contact_bond(w, row, i, k);
    for (int electrode = 0; electrode < PD_ELECTRODES && found < w->found; electrode++) {
        pd_contact *contact = &w->at[electrode];
        if (!(contact->area > 0.0)) continue;
        if (list) {
            list[found] = *contact;
            list[found].node = i;
            list[found].electrode = electrode;
            list[found].way /= contact->area;
            list[found].share = 1.0;
        }
        memset(contact, 0, sizeof *contact);
        found++;
    }
    w->found = 0;
    return found;
}

PDI_FN pd_status pdi_contact_find(pd_ctx *ctx, const pd_bonds *bonds, const pdi_contact_metal *metal,
                                  pd_contacts *contacts)
{
    pdi_contact_walk w;
    int64_t count = 0;
    memset(&w, 0, sizeof w);
    w.bonds = bonds;
    w.metal = metal;
    pdi_contact_free(ctx, contacts);
    for (int32_t r = 0; r < bonds->rows; r++) count += pdi_contact_node(&w, r, NULL);
    if (count > INT32_MAX) return pd_fail(ctx, PD_ERR_SIZE, "contact", "more than 2^31 contacts");
    PD_TRY(pdi_array_registry_rebuild(ctx, pdi_contact_list, contacts, &contacts->capacity, (int32_t)count));
    for (int32_t r = 0; r < bonds->rows; r++)
        contacts->count += pdi_contact_node(&w, r, contacts->list + contacts->count);
    return PD_OK;
}

PDI_FN void pdi_contact_free(pd_ctx *ctx, pd_contacts *contacts)
{
    pdi_array_registry_free(ctx, pdi_contact_list, contacts);
    memset(contacts, 0, sizeof *contacts);
}
