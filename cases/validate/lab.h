/* lab: the objects that a validation case works with, built from the descs that it fills in. */
#ifndef VAL_LAB_H
#define VAL_LAB_H
#include "solids.h"

typedef enum val_build {
    VAL_LATTICE = 0, /* stencil, grid and bonds are always built */
    VAL_FLOW = 1,
    VAL_STEADY = 2,  /* with VAL_FLOW */
    VAL_TRANSPORT = 4,
    VAL_DISSOLVE = 8,
    VAL_COUPLE = 16,
    VAL_IMPLICIT = 32, /* with VAL_STEADY */
    VAL_GAS = 64
} val_build;

typedef struct val_lab {
    pd_stencil_desc stencil_desc;
    double surface_m; /* [-] horizon of the surface of metal; 0: that of the stencil */
    pd_grid_desc grid_desc;
    pd_shape shapes[4];
    pd_flow_desc flow_desc;
    pd_steady_desc steady_desc;
    pd_transport_desc transport_desc;
    pd_dissolve_desc dissolve_desc;
    pd_time_loop_desc couple_desc;
    pd_implicit_desc implicit_desc;
    pd_gas_desc gas_desc;
    pd_stencil stencil, across; /* across: of the surface of metal */
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    pd_steady steady;
    pd_transport transport;
    pd_dissolve dissolve;
    pd_quasi_steady quasi;
    pd_time_loop couple;
    pd_implicit implicit;
    pd_gas gas;
    val_solid solid;  /* see solids.h */
    double *field[4]; /* [field_size] work of the case, see lab_fields */
    size_t field_size;
} val_lab;

/* Equal spacings h [m], no shapes, the box from lo to hi [m] along every axis; sides are walls. */
static void lab_box(val_lab *lab, double h, double m, double lo, double hi)
{
    lab->stencil_desc.m = m;
    lab->grid_desc.shapes = lab->shapes;
    for (int d = 0; d < PD_DIM; d++) {
        lab->stencil_desc.h[d] = h;
        lab->grid_desc.lo[d] = lo;
        lab->grid_desc.hi[d] = hi;
    }
}

/* The family of the surface; ghosts as deep as it reaches. */
static pd_status lab_across(pd_ctx *ctx, val_lab *lab)
{
    pd_stencil_desc family = lab->stencil_desc;
    family.m = fmax(family.m, lab->surface_m);
    lab->grid_desc.ghost = (int)ceil(family.m + 0.5) - 1;
    return pd_stencil_build(ctx, &family, &lab->across);
}

static pd_status lab_build(pd_ctx *ctx, val_lab *lab, int parts)
{
    pd_flow *flow = parts & VAL_FLOW ? &lab->flow : NULL;
    pd_steady *steady = parts & VAL_STEADY ? &lab->steady : NULL;
    pd_dissolve *dissolve = parts & VAL_DISSOLVE ? &lab->dissolve : NULL;
    PD_TRY(pd_stencil_build(ctx, &lab->stencil_desc, &lab->stencil));
    if (dissolve) PD_TRY(lab_across(ctx, lab));
    PD_TRY(pd_grid_build(ctx, &lab->stencil, &lab->grid_desc, &lab->grid));
    PD_TRY(pd_bonds_build(ctx, &lab->stencil, &lab->grid, flow ? 0 : PD_BONDS_NO_FLOW, &lab->bonds));
    if (flow) PD_TRY(pd_flow_build(ctx, &lab->grid, &lab->bonds, &lab->flow_desc, flow));
    if (steady) PD_TRY(pd_steady_build(ctx, flow, &lab->steady_desc, steady));
    if (parts & VAL_IMPLICIT)
        PD_TRY(pd_implicit_build(ctx, flow, steady, &lab->implicit_desc, &lab->implicit));
    if (parts & VAL_GAS) PD_TRY(pd_gas_build(ctx, &lab->grid, &lab->bonds, &lab->gas_desc, &lab->gas));
    if (parts & VAL_TRANSPORT)
        PD_TRY(pd_transport_build(ctx, &lab->grid, &lab->bonds, flow, &lab->transport_desc, &lab->transport));
    if (dissolve)
        PD_TRY(
            pd_dissolve_build(ctx, &lab->grid, &lab->across, &lab->transport, &lab->dissolve_desc, &lab->dissolve));
    if (parts & VAL_COUPLE)
        PD_TRY(pd_time_loop_build(ctx, &lab->couple_desc, &lab->grid, lab->transport_desc.given ? NULL : &lab->bonds,
                                  &lab->couple));
    if (parts & VAL_COUPLE && steady)
        PD_TRY(pd_time_loop_add_process(ctx, &lab->couple, pd_quasi_steady_process(flow, steady, &lab->quasi)));
    if (parts & VAL_COUPLE && dissolve)
        PD_TRY(pd_time_loop_add_process(ctx, &lab->couple, pd_dissolve_process(dissolve)));
    return PD_OK;
}

/* The first `count` work fields get `components` values for every node of the padded lattice, zero. */
static pd_status lab_fields(pd_ctx *ctx, val_lab *lab, int count, int components)
{
    lab->field_size = (size_t)lab->grid.total * (size_t)components;
    for (int k = 0; k < count; k++) PD_TRY(PD_NEW(ctx, "validate", lab->field_size, lab->field[k]));
    return PD_OK;
}

static void lab_free(pd_ctx *ctx, val_lab *lab)
{
    for (int k = 0; k < 4; k++) PD_DELETE(ctx, lab->field_size, lab->field[k]);
    solid_free(ctx, &lab->solid);
    pd_gas_free(ctx, &lab->gas);
    pd_implicit_free(ctx, &lab->implicit);
    pd_dissolve_free(ctx, &lab->dissolve);
    pd_transport_free(ctx, &lab->transport);
    pd_steady_free(ctx, &lab->steady);
    pd_flow_free(ctx, &lab->flow);
    pd_bonds_free(ctx, &lab->bonds);
    pd_grid_free(ctx, &lab->grid);
    pd_stencil_free(ctx, &lab->across);
    pd_stencil_free(ctx, &lab->stencil);
}

#endif
