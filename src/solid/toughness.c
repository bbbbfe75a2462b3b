/* toughness: see toughness.h */
#include "solid/toughness.h"
#include "solid/crack.h"
#include "solid/criterion.h"
#include "solid/cut.h"
#include "solid/equilibrium.h"
#include <math.h>
#include <string.h>

/* Height of the strip between its held edges, initial crack length and length ahead, in horizons. In 2D the result
 * converges with one over the height, and is 3 % low here; in 3D it does not depend on it (theory: 8.9). */
#define PDI_TOUGHNESS_HEIGHT 12
#define PDI_TOUGHNESS_HEIGHT_3D 8
/* In 3D: layers of points from one step of the crack front to the next, of one cell. With more layers the result
 * differs by at most 4 %. */
#define PDI_TOUGHNESS_LAYERS 2
/* In 3D: allowed horizon over the spacing. With less a straight front needs far more energy than one with steps; with
 * more the strip takes minutes. */
#define PDI_TOUGHNESS_LEAST 1.5
#define PDI_TOUGHNESS_MOST 3.0
/* Crack growth in cells: a period, once the tip has left the pre-crack. */
#define PDI_TOUGHNESS_CELLS 3
/* Fraction of the bonds beyond the critical energy that break at a time, as in quasi_static. */
#define PDI_TOUGHNESS_EAGER 0.5
/* Relative tolerance of the equilibrium, and the margin over the critical energy at which bonds break: rounding. */
#define PDI_TOUGHNESS_RTOL 1e-5
#define PDI_TOUGHNESS_BEYOND 1e-9

#if PD_DIM > 1
/* The strip with its crack. */
typedef struct pdi_toughness {
    int height, held, crack, length; /* cells */
    int layers;          /* 3D: after which the points repeat */
    int32_t count;
    pd_body body;        /* with a spacing of 1 */
    pd_elastic elastic;
    pd_solid solid;
    pd_criterion criterion; /* of the critical energy 1 */
    double factor;       /* [-] largest strain so far */
    double *place;       /* [count][PD_DIM] */
    double *volume;      /* [count] */
    double *moved;       /* [count][PD_DIM] for the strain 1 */
    double *strained;    /* [count][PD_DIM] for the strain `factor` */
    uint8_t *grip;       /* [count][PD_DIM] */
    uint8_t *spared;     /* [count] */
} pdi_toughness;

/* Describes the arrays of the strip. */
static void pdi_toughness_list(pdi_owner *owner, void *object)
{
    pdi_toughness *toughness = (pdi_toughness *)object;
    int64_t count = toughness->count;
    PDI_ARRAY(owner, toughness, place, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, volume, count, "1");
    PDI_ARRAY(owner, toughness, moved, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, strained, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, grip, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, spared, count, "1");
}

/* Points of the strip. Rows at its edges are prescribed as by a strain of 1, and no point moves along the front. */
static void pdi_toughness_points(pdi_toughness *t)
{
    int rows = t->height + 2 * t->held;
    for (int32_t i = 0; i < t->count; i++) {
        double *x = t->place + i * PD_DIM;
        x[0] = i % t->length + 0.5;
        x[1] = i / t->length % rows + 0.5 - t->held - 0.5 * t->height;
        if (PD_DIM == 3) x[PD_DIM - 1] = i / t->length / rows + 0.5;
        t->volume[i] = 1.0;
        t->spared[i] = fabs(x[1]) > 0.5 * t->height;
        for (int d = 0; d < PD_DIM; d++) t->grip[i * PD_DIM + d] = t->spared[i] || d > 1;
        if (t->spared[i]) t->moved[i * PD_DIM + 1] = x[1];
    }
}

/* Body of the strip with its pre-crack, periodic along the front in 3D. */
static pd_status pdi_toughness_strip(pd_ctx *ctx, const pd_body *body, pdi_toughness *t)
{
    double corner[4 * PD_DIM] = {0.0};
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
    if (PD_DIM == 3) { /* the front is a cell ahead from period to period */
        desc.period[0] = 1.0;
        desc.period[PD_DIM - 1] = t->layers;
    }
    PDI_TRY(pd_body_build(ctx, &desc, &t->body));
    cut.corners = PD_DIM == 3 ? 4 : 2;
    cut.corner = corner;
    for (int k = 0; k < cut.corners; k++) { /* wider than all bonds along the front */
        corner[k * PD_DIM] = k == 0 || k == 3 ? -1.0 : t->crack;
        if (PD_DIM == 3) corner[k * PD_DIM + PD_DIM - 1] = k < 2 ? -t->held : t->held + t->layers;
    }
    return pd_body_cut(ctx, &t->body, &cut, 1, &broken);
}

/* Correspondence material of the strip with E = 1. */
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

/* Equilibrium of the remaining bonds at the strain 1. */
static pd_status pdi_toughness_rest(pd_ctx *ctx, pdi_toughness *t)
{
    pd_equilibrium_desc rest;
    pd_equilibrium_result result;
    memset(&rest, 0, sizeof rest);
    rest.held = t->grip;
    rest.rtol = PDI_TOUGHNESS_RTOL;
    PDI_TRY(t->solid.update(ctx, t->solid.self));
    return pd_equilibrium_solve(ctx, &t->solid, &rest, NULL, t->moved, &result);
}

/* J of the remaining bonds at the strain 1. */
static pd_status pdi_toughness_j(pd_ctx *ctx, pdi_toughness *t, const double *tip, double *j)
{
    pd_crack_desc crack;
    memset(&crack, 0, sizeof crack);
    memcpy(crack.tip, tip, sizeof crack.tip);
    crack.way[0] = 1.0;
    crack.front[PD_DIM - 1] = 1.0;
    crack.thickness = t->layers;
    crack.inner = 0.25 * t->height;
    crack.outer = 0.5 * t->height - 1.0;
    PDI_TRY(pdi_toughness_rest(ctx, t));
    return pd_crack_j(ctx, &t->solid, &crack, t->moved, j);
}

/* Raises the strain until the next bond breaks, and breaks it. PD_ERR_STATE: none does. */
static pd_status pdi_toughness_break(pd_ctx *ctx, pdi_toughness *t)
{
    pd_criterion_bond first;
    PDI_TRY(pdi_toughness_rest(ctx, t));
    pd_criterion_first(ctx, &t->criterion, t->moved, &first);
    t->factor = pdi_max(t->factor, first.factor * (1.0 + PDI_TOUGHNESS_BEYOND));
    for (int64_t k = 0; k < (int64_t)t->count * PD_DIM; k++) t->strained[k] = t->factor * t->moved[k];
    if (pd_criterion_break(ctx, &t->criterion, t->strained, PDI_TOUGHNESS_EAGER)) return PD_OK;
    return pdi_fail(ctx, PD_ERR_STATE, "toughness", "a crack in a strip of the lattice does not run");
}

/* Grows the crack by PDI_TOUGHNESS_CELLS. *j_ratio: J at the largest strain over the critical energy; J grows with the
 * square of the strain and does not depend on the crack length. */
static pd_status pdi_toughness_run(pd_ctx *ctx, pdi_toughness *t, double *j_ratio)
{
    static const double way[PD_DIM] = {1.0};
    double tip[PD_DIM] = {0.0}, j;
    pd_criterion_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.kind = PD_CRITERION_ENERGY;
    desc.critical = 1.0;
    desc.spared = t->spared;
    PDI_TRY(pd_criterion_build(ctx, &t->solid, &desc, &t->criterion));
    while (tip[0] < t->crack + PDI_TOUGHNESS_CELLS) {
        PDI_TRY(pdi_toughness_break(ctx, t));
        PDI_TRY(pd_crack_tip(ctx, &t->body, way, 0.0, tip));
    }
    PDI_TRY(pdi_toughness_j(ctx, t, tip, &j));
    *j_ratio = t->factor * t->factor * j;
    return PD_OK;
}

/* Builds the strip and grows its crack. */
static pd_status pdi_toughness_make(pd_ctx *ctx, const pd_body *body, const pd_elastic_desc *elastic, pdi_toughness *t,
                                    double *j_ratio)
{
    int reach = (int)ceil(body->horizon / body->spacing);
    t->height = t->crack = (PD_DIM == 3 ? PDI_TOUGHNESS_HEIGHT_3D : PDI_TOUGHNESS_HEIGHT) * reach;
    t->length = 2 * t->crack;
    t->held = 2 * reach;
    t->layers = PD_DIM == 3 ? PDI_TOUGHNESS_LAYERS : 1;
    t->count = t->layers * (t->height + 2 * t->held) * t->length;
    PDI_TRY(pdi_owner_build(ctx, pdi_toughness_list, t));
    PDI_TRY(pdi_toughness_strip(ctx, body, t));
    PDI_TRY(pdi_toughness_material(ctx, elastic, t));
    return pdi_toughness_run(ctx, t, j_ratio);
}

PDI_FN pd_status pdi_toughness_find(pd_ctx *ctx, const pd_body *body, const pd_elastic_desc *elastic, double fracture,
                                    double *critical)
{
    double most = 0.0, h = body->spacing;
    pdi_toughness t;
    memset(&t, 0, sizeof t);
    if (!(h > 0.0))
        return pdi_fail(ctx, PD_ERR_GEOMETRY, "toughness", "the points are those of no lattice: expected a spacing");
    if (PD_DIM == 3 && (body->horizon < PDI_TOUGHNESS_LEAST * h * (1.0 - PDI_TOUGHNESS_BEYOND) ||
                        body->horizon > PDI_TOUGHNESS_MOST * h * (1.0 + PDI_TOUGHNESS_BEYOND)))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "toughness", "a horizon of %g spacings with the energy of a crack in 3D, "
                        "expected %g to %g", body->horizon / h, PDI_TOUGHNESS_LEAST, PDI_TOUGHNESS_MOST);
    pd_status status = pdi_toughness_make(ctx, body, elastic, &t, &most);
    pd_criterion_free(ctx, &t.criterion);
    pd_elastic_free(ctx, &t.elastic);
    pd_body_free(ctx, &t.body);
    pdi_owner_free(ctx, pdi_toughness_list, &t);
    /* J = most critical of the spacing 1; volumes of bonds grow by h^d, areas over volumes by 1/h */
    if (status >= 0) *critical = fracture / (most * (PD_DIM == 3 ? h * h * h * h : h * h * h));
    return status;
}
#endif

#undef PDI_TOUGHNESS_HEIGHT
#undef PDI_TOUGHNESS_HEIGHT_3D
#undef PDI_TOUGHNESS_LAYERS
#undef PDI_TOUGHNESS_LEAST
#undef PDI_TOUGHNESS_MOST
#undef PDI_TOUGHNESS_CELLS
#undef PDI_TOUGHNESS_EAGER
#undef PDI_TOUGHNESS_RTOL
#undef PDI_TOUGHNESS_BEYOND
