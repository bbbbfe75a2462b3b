/* finite_case: materials of large strains. */
#ifndef FINITE_CASE_H
#define FINITE_CASE_H
#include "solid/finite_strain.h"
#include "solid_case.h"

#define E 45e9
enum { WAYS = 24 };

/* Law way % 3 with control way / 3 % 3, and each influence, plane and Poisson ratio. */
static inline pd_finite_strain_desc desc_of(int way)
{
    static const double ratios[4] = {0.3, 0.0, 0.45, 0.2};
    pd_finite_strain_desc d;
    memset(&d, 0, sizeof d);
    d.law.kind = (pd_constitutive_kind)(way % 3);
    d.control = (pd_zero_energy_control)(way / 3 % 3);
    d.law.young = E;
    d.law.poisson = ratios[way / 2 % 4];
    d.law.plane = way & 1 ? PD_PLANE_STRESS : PD_PLANE_STRAIN;
    d.influence = (pd_influence)(way / 5 % 3);
    d.penalty = 0.5;
    d.store_tangent = way / 3 & 1;
    d.law.yield = 3e-3 * E;
    d.law.hardening = way & 4 ? 0.0 : 0.05 * E;
    d.law.saturation = way & 8 ? 6e-3 * E : 0.0;
    d.law.rate = 20.0;
    return d;
}

static inline pdi_constitutive_law_params moduli(const pd_finite_strain_desc *d)
{
    pd_ctx ctx;
    pdi_constitutive_law_params m;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pdi_constitutive_law_init(&ctx, &d->law, &m));
    return m;
}

static inline pd_material_interface build(solid_case *c, const pd_finite_strain_desc *d, pd_finite_strain *f)
{
    CHECK_OK(&c->ctx, pd_finite_strain_build(&c->ctx, &c->body, d, f));
    return pd_finite_strain_material(f);
}

static inline void end(solid_case *c, pd_finite_strain *f)
{
    pd_finite_strain_free(&c->ctx, f);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

#endif
