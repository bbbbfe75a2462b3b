/* toughness: see toughness.h */
#include "solid/toughness.h"
#include "solid/crack.h"
#include "solid/cut.h"
#include "solid/sequential.h"
#include <math.h>
#include <string.h>

/* The strip, in horizons: its height without what is held, the crack in it, and what lies ahead. The result tends to
 * its limit with one over the height, and is 3 % below it here (theory: 8.9). */
#define PDI_TOUGHNESS_HEIGHT 12
#define PDI_TOUGHNESS_CRACK 16
#define PDI_TOUGHNESS_AHEAD 18
/* By so many cells the tip goes on: a period, once the notch that was cut is behind. */
#define PDI_TOUGHNESS_CELLS 3
/* Balances are for the bond that breaks first alone. */
#define PDI_TOUGHNESS_RTOL 1e-6

#if PD_DIM == 2
typedef struct pdi_toughness {
    int height, held, crack, length; /* cells */
    int32_t count;
    pd_body body;        /* with a spacing of 1 */
    pd_elastic elastic;
    pd_solid solid;
    pd_sequential load;
    double *place;       /* [count][2] */
    double *volume;      /* [count] */
    double *moved;       /* [count][2] for the strain 1: of what is held, and at last of all */
    uint8_t *grip;       /* [count][2] */
    uint8_t *spared;     /* [count] */
} pdi_toughness;

static void pdi_toughness_list(pdi_owner *owner, void *object)
{
    pdi_toughness *toughness = (pdi_toughness *)object;
    PDI_ARRAY(owner, toughness, place, 2 * (int64_t)toughness->count, "1");
    PDI_ARRAY(owner, toughness, volume, toughness->count, "1");
    PDI_ARRAY(owner, toughness, moved, 2 * (int64_t)toughness->count, "1");
    PDI_ARRAY(owner, toughness, grip, 2 * (int64_t)toughness->count, "1");
    PDI_ARRAY(owner, toughness, spared, toughness->count, "1");
}

/* Points of the strip; rows at its edges are held where the strain 1 puts them. */
static void pdi_toughness_points(pdi_toughness *t)
{
    for (int32_t i = 0; i < t->count; i++) {
        double *x = t->place + 2 * i;
        x[0] = i % t->length + 0.5;
        x[1] = i / t->length + 0.5 - t->held - 0.5 * t->height;
        t->volume[i] = 1.0;
        if (fabs(x[1]) < 0.5 * t->height) continue;
        t->grip[2 * i] = t->grip[2 * i + 1] = t->spared[i] = 1;
        t->moved[2 * i + 1] = x[1];
    }
}

static pd_status pdi_toughness_strip(pd_ctx *ctx, const pd_body *body, pdi_toughness *t)
{
    double corner[4] = {-1.0, 0.0, 0.0, 0.0};
    int64_t broken;
    pd_body_desc desc;
    pd_cut cut;
    pdi_toughness_points(t);
    memset(&desc, 0, sizeof desc);
    desc.count = t->count;
    desc.position = t->place;
    desc.volume = t->volume;
    desc.horizon = body->horizon / body->spacing;
    desc.spacing = 1.0;
    desc.rim = body->rim;
    PDI_TRY(pd_body_build(ctx, &desc, &t->body));
    corner[2] = t->crack;
    cut.corners = 2;
    cut.corner = corner;
    return pd_body_cut(ctx, &t->body, &cut, 1, &broken);
}

static pd_status pdi_toughness_material(pd_ctx *ctx, const pd_elastic_desc *elastic, pdi_toughness *t)
{
    pd_elastic_desc desc = *elastic;
    desc.stiff = NULL;
    desc.loose = 1;
    desc.young = 1.0;
    PDI_TRY(pd_elastic_build(ctx, &t->body, &desc, &t->elastic));
    t->solid = pd_elastic_solid(&t->elastic);
    return PD_OK;
}

/* J of the strain 1, with the bonds that are left. */
static pd_status pdi_toughness_j(pd_ctx *ctx, pdi_toughness *t, const double *tip, double *j)
{
    pd_equilibrium_desc rest;
    pd_equilibrium_result result;
    pd_crack_desc crack;
    memset(&rest, 0, sizeof rest);
    memset(&crack, 0, sizeof crack);
    rest.held = t->grip;
    rest.rtol = PDI_TOUGHNESS_RTOL;
    memcpy(crack.tip, tip, sizeof crack.tip);
    crack.way[0] = 1.0;
    crack.inner = 0.25 * t->height;
    crack.outer = 0.5 * t->height - 1.0;
    PDI_TRY(t->solid.update(ctx, t->solid.self));
    PDI_TRY(pd_equilibrium_solve(ctx, &t->solid, &rest, NULL, t->moved, &result));
    return pd_crack_j(ctx, &t->solid, &crack, t->moved, j);
}

/* Largest J of the events until the tip has gone on, over the critical energy. It grows with the square of the strain,
 * and does not depend on where the tip is. */
static pd_status pdi_toughness_run(pd_ctx *ctx, pdi_toughness *t, double *most)
{
    static const double way[2] = {1.0, 0.0};
    double tip[2] = {(double)t->crack, 0.0}, last = t->crack + PDI_TOUGHNESS_CELLS, factor = 0.0, j;
    pd_sequential_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.held = t->grip;
    desc.moved = t->moved;
    desc.criterion.kind = PD_CRITERION_ENERGY;
    desc.criterion.critical = 1.0;
    desc.criterion.spared = t->spared;
    desc.rtol = PDI_TOUGHNESS_RTOL;
    PDI_TRY(pd_sequential_build(ctx, &t->solid, &desc, &t->load));
    while (tip[0] < last) {
        PDI_TRY(pd_sequential_next(ctx, &t->load));
        if (t->load.done)
            return pdi_fail(ctx, PD_ERR_STATE, "toughness", "a crack in a strip of the lattice does not run");
        factor = fmax(factor, t->load.factor);
        PDI_TRY(pd_crack_tip(ctx, &t->body, way, 0.0, tip));
    }
    PDI_TRY(pdi_toughness_j(ctx, t, tip, &j));
    *most = factor * factor * j;
    return PD_OK;
}

static pd_status pdi_toughness_make(pd_ctx *ctx, const pd_body *body, const pd_elastic_desc *elastic, pdi_toughness *t,
                                    double *most)
{
    int reach = (int)ceil(body->horizon / body->spacing);
    t->height = PDI_TOUGHNESS_HEIGHT * reach;
    t->crack = PDI_TOUGHNESS_CRACK * reach;
    t->length = t->crack + PDI_TOUGHNESS_AHEAD * reach;
    t->held = 2 * reach;
    t->count = (t->height + 2 * t->held) * t->length;
    PDI_TRY(pdi_owner_build(ctx, pdi_toughness_list, t));
    PDI_TRY(pdi_toughness_strip(ctx, body, t));
    PDI_TRY(pdi_toughness_material(ctx, elastic, t));
    return pdi_toughness_run(ctx, t, most);
}

PDI_FN pd_status pdi_toughness_find(pd_ctx *ctx, const pd_body *body, const pd_elastic_desc *elastic, double fracture,
                                    double *critical)
{
    double most = 0.0, h = body->spacing;
    pdi_toughness t;
    memset(&t, 0, sizeof t);
    if (!(h > 0.0))
        return pdi_fail(ctx, PD_ERR_GEOMETRY, "toughness", "the points are those of no lattice: expected a spacing");
    pd_status status = pdi_toughness_make(ctx, body, elastic, &t, &most);
    pd_sequential_free(ctx, &t.load);
    pd_elastic_free(ctx, &t.elastic);
    pd_body_free(ctx, &t.body);
    pdi_owner_free(ctx, pdi_toughness_list, &t);
    /* J = most critical of the spacing 1; volumes of bonds grow by h^2, areas by h */
    if (status >= 0) *critical = fracture / (most * h * h * h);
    return status;
}
#endif

#undef PDI_TOUGHNESS_HEIGHT
#undef PDI_TOUGHNESS_CRACK
#undef PDI_TOUGHNESS_AHEAD
#undef PDI_TOUGHNESS_CELLS
#undef PDI_TOUGHNESS_RTOL
