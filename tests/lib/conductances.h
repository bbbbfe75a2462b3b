/* Conductances that have followed the metal as it went are those of bonds and transport built afresh. */
#ifndef CONDUCTANCES_H
#define CONDUCTANCES_H

/* A field without any order; exact: in metal and walls, too. */
static inline void conductances_field(const pd_transport *t, int exact, double *x)
{
    const uint8_t *kind = t->grid->kind;
    for (int32_t i = 0; i < t->grid->total; i++) {
        int none = kind[i] == PD_SOLID || kind[i] == PD_WALL || kind[i] == PD_INACTIVE;
        x[i] = !exact && none ? 0.0 : 1.0 + sin(12.9898 * i);
    }
    pd_ghosts_set_scalar(&t->bonds->ghosts, x);
}

/* y = A x */
static inline void conductances_apply(pd_ctx *ctx, const pd_transport *t, int exact, const double *x, double *y)
{
    pd_flux flux = t->flux;
    flux.rate = 0.0;
    flux.exact = exact;
    pdi_flux_apply(ctx, &flux, x, y);
}

static inline void check_conductances(pd_ctx *ctx, pd_transport *t)
{
    pd_bonds bonds;
    pd_transport fresh;
    pd_transport_desc desc = t->desc;
    size_t total = (size_t)t->grid->total;
    double *x = (double *)malloc(3 * total * sizeof *x), *y = x + total, *z = y + total;
    memset(&fresh, 0, sizeof fresh);
    memset(&bonds, 0, sizeof bonds);
    desc.clock = NULL;
    desc.arena = NULL;
    if (CHECK(x != NULL) && CHECK_OK(ctx, pd_bonds_build(ctx, t->bonds->stencil, t->grid, 0, &bonds)) &&
        CHECK_OK(ctx, pd_transport_build(ctx, t->grid, &bonds, t->flow, &desc, &fresh)) &&
        CHECK_OK(ctx, pdi_transport_hold(ctx, &fresh)) && CHECK_OK(ctx, pdi_transport_hold(ctx, t)) &&
        CHECK_OK(ctx, pdi_flux_refresh(ctx, &fresh.flux)) && CHECK_OK(ctx, pdi_flux_refresh(ctx, &t->flux))) {
        memcpy(fresh.absorb, t->absorb, total * sizeof *x);
        for (int exact = 0; exact < 2; exact++) {
            conductances_field(t, exact, x);
            conductances_apply(ctx, t, exact, x, y);
            conductances_apply(ctx, &fresh, exact, x, z);
            for (size_t i = 0; i < total; i++)
                if (t->grid->kind[i] == PD_FLUID) CHECK(y[i] >= z[i] && y[i] <= z[i]);
        }
        CHECK_OK(ctx, pdi_transport_release(ctx, t, PD_OK));
        CHECK_OK(ctx, pdi_transport_release(ctx, &fresh, PD_OK));
    }
    pd_transport_free(ctx, &fresh);
    pd_bonds_free(ctx, &bonds);
    free(x);
}

#endif
