/* terms: see terms.h */
#include "react/terms.h"
#include "core/vec.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* The electrode of a place. */
static void pdi_terms_enter_electrode(const pd_etch *s, int32_t place, pdi_terms *w)
{
    const pd_etch_electrodes *of = &s->desc.electrodes;
    w->electrode = s->electrode && place >= 0 ? s->electrode[place] : -1;
    w->level = w->way = w->flow = w->guess = 0.0;
    w->share = 1.0;
    w->reads = 0;
    if (w->electrode < 0) return;
    w->level = s->level[of->member[w->electrode]];
    w->way = s->area[place] > 0.0 ? s->way[place] : 0.0;
    w->guess = s->flow[place];
    if (s->share) w->share = s->share[place];
    if (of->reads) w->reads = of->reads[w->electrode];
    if (!(s->area[place] > 0.0) || s->open[place]) w->electrode = -1;
}

PDI_FN void pdi_terms_enter(const pd_etch *s, int metal, int32_t node, int32_t place, double thick,
                            pd_components *film, pdi_terms *w)
{
    const pd_components *of = &s->reactive->components;
    w->s = s;
    w->kind = &s->kind[metal];
    w->node = node;
    w->thick = w->still = thick;
    w->creep = 0.0;
    if (place >= 0 && thick > 0.0) {
        w->thick = w->still = thick + s->rise[place] * s->passed[place];
        w->creep = s->rise[place] * s->half;
    }
    pd_reactive_get(s->reactive, s->reactive->c, node, w->c);
    w->davies = pdi_components_compute_ln_gamma(of, w->c);
    for (int n = 0; n < of->solutes; n++) w->at[n] = s->scale[n] * w->c[n];
    w->psi = s->reactive->migration.on ? s->reactive->migration.psi[node] : 0.0;
    w->lift = w->sweep = 0.0;
    w->odd = w->odds = 0;
    memcpy(w->surface, w->c, sizeof w->surface);
    pdi_terms_enter_electrode(s, place, w);
    if (!(thick + w->way > 0.0)) return;
    pdi_etch_activities(of, &s->film, w->davies, film);
    memcpy(w->ln_k, film->ln_k, sizeof w->ln_k);
    pdi_components_compute_totals(of, w->at, w->flows);
}

PDI_FN void pdi_terms_read(const pdi_terms *w, const double *c, double psi, double *ph, double *phi)
{
    const pd_reactive *r = w->s->reactive;
    *ph = *phi = NAN;
    if (r->proton >= 0) *ph = 3.0 - (log(pd_max(c[r->proton], DBL_MIN)) + w->davies) / log(10.0);
    if (r->migration.on) *phi = psi * r->migration.volt - w->level;
}

PDI_FN double pdi_terms_number(const pdi_terms *w, const double *c, double psi)
{
    double ph, phi;
    pdi_terms_read(w, c, psi, &ph, &phi);
    return w->kind->law.law(w->kind->law.user, w->node, c, ph, phi, w->s->time);
}

PDI_FN double pdi_terms_law(const pdi_terms *w, const double *c, double psi)
{
    return pd_max(pdi_terms_number(w, c, psi), 0.0);
}

PDI_FN double pdi_terms_curve(const pdi_terms *w, const double *c, double psi)
{
    const pd_reactive *r = w->s->reactive;
    const pd_etch_electrodes *of = &w->s->desc.electrodes;
    double ph = NAN;
    if (r->proton >= 0) ph = 3.0 - (log(pd_max(c[r->proton], DBL_MIN)) + w->davies) / log(10.0);
    double drop = w->level - psi * r->migration.volt;
    return of->curve(of->user, w->electrode, w->share, c, ph, drop, w->s->time) / PD_FARADAY;
}
