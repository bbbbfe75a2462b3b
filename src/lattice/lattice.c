/* lattice: see lattice.h */
#include "lattice/lattice.h"
#include <string.h>

pd_status pd_lattice_build(pd_ctx *ctx, const pd_lattice_desc *desc, pd_lattice *l)
{
    memset(l, 0, sizeof *l);
    pd_status status = pd_stencil_build(ctx, &desc->stencil, &l->stencil);
    if (status >= 0) status = pd_grid_build(ctx, &l->stencil, &desc->grid, &l->grid);
    if (status >= 0) status = pd_bonds_build(ctx, &l->stencil, &l->grid, 0, &l->bonds);
    if (status < 0) pd_lattice_free(ctx, l);
    return status;
}

/* Grows the list of fields to twice its capacity and 4 more; fields stay. On failure nothing changes. */
static pd_status pdi_lattice_grow_fields(pd_ctx *ctx, pd_lattice *l)
{
    int capacity = 2 * l->capacity + 4;
    int *components = NULL;
    double **field = NULL;
    pd_status status = PD_NEW(ctx, "lattice", capacity, components);
    if (status >= 0) status = PD_NEW(ctx, "lattice", capacity, field);
    if (status < 0) {
        PD_DELETE(ctx, capacity, components);
        return status;
    }
    for (int k = 0; k < l->fields; k++) {
        components[k] = l->components[k];
        field[k] = l->field[k];
    }
    PD_DELETE(ctx, l->capacity, l->components);
    PD_DELETE(ctx, l->capacity, l->field);
    l->capacity = capacity;
    l->components = components;
    l->field = field;
    return PD_OK;
}

pd_status pd_lattice_add_field(pd_ctx *ctx, pd_lattice *l, int components, double **field)
{
    *field = NULL;
    if (components < 1 || components > 1024)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "lattice", "a field of %d components, expected 1 to 1024", components);
    if (l->fields == l->capacity) PD_TRY(pdi_lattice_grow_fields(ctx, l));
    PD_TRY(PD_NEW(ctx, "lattice", (int64_t)components * l->grid.total, l->field[l->fields]));
    l->components[l->fields] = components;
    *field = l->field[l->fields++];
    return PD_OK;
}

void pd_lattice_free(pd_ctx *ctx, pd_lattice *l)
{
    for (int k = 0; k < l->fields; k++) PD_DELETE(ctx, (int64_t)l->components[k] * l->grid.total, l->field[k]);
    PD_DELETE(ctx, l->capacity, l->components);
    PD_DELETE(ctx, l->capacity, l->field);
    pd_bonds_free(ctx, &l->bonds);
    pd_grid_free(ctx, &l->grid);
    pd_stencil_free(ctx, &l->stencil);
    memset(l, 0, sizeof *l);
}
