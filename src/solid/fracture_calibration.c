/* fracture_calibration: see fracture_calibration.h */
#include "solid/fracture_calibration.h"
#include "solid/crack.h"
#include "solid/bond_failure.h"
#include "solid/precrack.h"
#include "solid/equilibrium.h"
#include <math.h>
#include <string.h>

/* Height of the strip between its held edges, initial crack length and length ahead, in horizons. In 2D the result
 * converges with one over the height, and is 3 % low here; in 3D it does not depend on it (theory: 15.7). */
#define PDI_FRACTURE_CALIBRATION_HEIGHT 12
#define PDI_FRACTURE_CALIBRATION_HEIGHT_3D 8
/* In 3D: layers of points from one step of the crack front to the next, of one cell. With more layers the result
 * differs by at most 4 %. */
#define PDI_FRACTURE_CALIBRATION_LAYERS 2
/* In 3D: allowed horizon over the spacing. With less a straight front needs far more energy than one with steps; with
 * more the strip takes minutes. */
#define PDI_FRACTURE_CALIBRATION_MIN_HORIZON 1.5
#define PDI_FRACTURE_CALIBRATION_MAX_HORIZON 3.0
/* Crack growth in cells: a period, once the tip has left the pre-crack. */
#define PDI_FRACTURE_CALIBRATION_ADVANCE 3
/* Fraction of the bonds beyond the critical energy that break at a time, as in quasi_static. */
#define PDI_FRACTURE_CALIBRATION_BREAK_FRACTION 0.5
/* Relative tolerance of the equilibrium, and the margin over the critical energy at which bonds break: rounding. */
#define PDI_FRACTURE_CALIBRATION_RTOL 1e-5
#define PDI_FRACTURE_CALIBRATION_MARGIN 1e-9

#if PD_DIM > 1
/* The strip with its crack. */
typedef struct pdi_fracture_calibration {
    int height, held_rows, crack_length, length; /* cells */
    int layers;          /* 3D: after which the points repeat */
    int32_t count;
    pd_body body;        /* with a spacing of 1 */
    pd_correspondence elastic;
    pd_material_interface solid;
    pd_bond_failure criterion; /* of the critical energy 1 */
    double factor;       /* [-] largest strain so far */
    double *position;    /* [count][PD_DIM] */
    double *volume;      /* [count] */
    double *unit_solution; /* [count][PD_DIM] for the strain 1 */
    double *loaded;        /* [count][PD_DIM] for the strain `factor` */
    uint8_t *held_dof;     /* [count][PD_DIM] */
    uint8_t *spared;     /* [count] */
} pdi_fracture_calibration;

/* Describes the arrays of the strip. */
static void pdi_fracture_calibration_list(pdi_array_visitor *owner, void *object)
{
    pdi_fracture_calibration *toughness = (pdi_fracture_calibration *)object;
    int64_t count = toughness->count;
    PDI_ARRAY(owner, toughness, position, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, volume, count, "1");
    PDI_ARRAY(owner, toughness, unit_solution, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, loaded, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, held_dof, count * PD_DIM, "1");
    PDI_ARRAY(owner, toughness, spared, count, "1");
}

/* Sets the points of the strip, `spared` and `held_dof`. Rows at its edges are prescribed as by a strain of 1, in
 * unit_solution, and no point moves along the front. */
static void pdi_fracture_calibration_init_points(pdi_fracture_calibration *t)
{
    int rows = t->height + 2 * t->held_rows;
    for (int32_t i = 0; i < t->count; i++) {
        double *x = t->position + i * PD_DIM;
        x[0] = i % t->length + 0.5;
        x[1] = i / t->length % rows + 0.5 - t->held_rows - 0.5 * t->height;
        if (PD_DIM == 3) x[PD_DIM - 1] = i / t->length / rows + 0.5;
        t->volume[i] = 1.0;
        t->spared[i] = fabs(x[1]) > 0.5 * t->height;
        for (int d = 0; d < PD_DIM; d++) t->held_dof[i * PD_DIM + d] = t->spared[i] || d > 1;
        if (t->spared[i]) t->unit_solution[i * PD_DIM + 1] = x[1];
    }
}

/* Body of the strip with its pre-crack, periodic along the front in 3D. */
static pd_status pdi_fracture_calibration_build_strip(pd_ctx *ctx, const pd_body *body, pdi_fracture_calibration *t)
{
    double corner[4 * PD_DIM] = {0.0};
    int64_t broken;
    pd_body_desc desc;
    pd_precrack cut;
    pdi_fracture_calibration_init_points(t);
    memset(&desc, 0, sizeof desc);
    desc.count = t->count;
    desc.position = t->position;
    desc.volume = t->volume;
    desc.horizon = body->horizon / body->spacing;
    desc.spacing = 1.0;
    desc.rim = body->rim;
    if (PD_DIM == 3) { /* the front is a cell ahead from period to period */
        desc.period[0] = 1.0;
        desc.period[PD_DIM - 1] = t->layers;
    }
    PD_TRY(pd_body_build(ctx, &desc, &t->body));
    cut.corners = PD_DIM == 3 ? 4 : 2;
    cut.corner = corner;
    for (int k = 0; k < cut.corners; k++) { /* wider than all bonds along the front */
        corner[k * PD_DIM] = k == 0 || k == 3 ? -1.0 : t->crack_length;
        if (PD_DIM == 3) corner[k * PD_DIM + PD_DIM - 1] = k < 2 ? -t->held_rows : t->held_rows + t->layers;
    }
    return pd_body_apply_precracks(ctx, &t->body, &cut, 1, &broken);
}

/* Correspondence material of the strip with E = 1. */
static pd_status pdi_fracture_calibration_build_material(pd_ctx *ctx, const pd_correspondence_desc *elastic,
                                                         pdi_fracture_calibration *t)
{
    pd_correspondence_desc desc = *elastic;
    desc.stiffness_factor = NULL;
    desc.detach_singular = 1;
    desc.young = 1.0;
    PD_TRY(pd_correspondence_build(ctx, &t->body, &desc, &t->elastic));
    t->solid = pd_correspondence_material(&t->elastic);
    return PD_OK;
}

/* Updates the material, which may detach points, and solves for the equilibrium of the remaining bonds at the strain 1,
 * into unit_solution. */
static pd_status pdi_fracture_calibration_solve_equilibrium(pd_ctx *ctx, pdi_fracture_calibration *t)
{
    pd_equilibrium_desc rest;
    pd_equilibrium_result result;
    memset(&rest, 0, sizeof rest);
    rest.prescribed = t->held_dof;
    rest.rtol = PDI_FRACTURE_CALIBRATION_RTOL;
    PD_TRY(t->solid.update(ctx, t->solid.self));
    return pd_equilibrium_solve(ctx, &t->solid, &rest, NULL, t->unit_solution, &result);
}

/* *j: J of the remaining bonds at the strain 1 around tip [PD_DIM], after a solve for their equilibrium. Lengths are in
 * cells, and E = 1. */
static pd_status pdi_fracture_calibration_compute_j(pd_ctx *ctx, pdi_fracture_calibration *t, const double *tip,
                                                    double *j)
{
    pd_crack_desc crack;
    memset(&crack, 0, sizeof crack);
    memcpy(crack.tip, tip, sizeof crack.tip);
    crack.direction[0] = 1.0;
    crack.front[PD_DIM - 1] = 1.0;
    crack.thickness = t->layers;
    crack.inner = 0.25 * t->height;
    crack.outer = 0.5 * t->height - 1.0;
    PD_TRY(pdi_fracture_calibration_solve_equilibrium(ctx, t));
    return pd_crack_j(ctx, &t->solid, &crack, t->unit_solution, j);
}

/* Raises `factor` until the next bond breaks, and breaks it with those in the upper half of the energies beyond the
 * critical one. `factor` never falls. PD_ERR_STATE: none breaks. */
static pd_status pdi_fracture_calibration_break_bonds(pd_ctx *ctx, pdi_fracture_calibration *t)
{
    pd_first_failure first;
    PD_TRY(pdi_fracture_calibration_solve_equilibrium(ctx, t));
    pd_bond_failure_find_first(ctx, &t->criterion, t->unit_solution, &first);
    t->factor = pd_max(t->factor, first.factor * (1.0 + PDI_FRACTURE_CALIBRATION_MARGIN));
    for (int64_t k = 0; k < (int64_t)t->count * PD_DIM; k++) t->loaded[k] = t->factor * t->unit_solution[k];
    if (pd_bond_failure_break(ctx, &t->criterion, t->loaded, PDI_FRACTURE_CALIBRATION_BREAK_FRACTION)) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "fracture_calibration", "a crack in a strip of the lattice does not run");
}

/* Grows the crack from crack_length by PDI_FRACTURE_CALIBRATION_ADVANCE cells. *j_ratio: J at the largest strain over
 * the critical energy; J grows with the square of the strain and does not depend on the crack length. */
static pd_status pdi_fracture_calibration_grow_crack(pd_ctx *ctx, pdi_fracture_calibration *t, double *j_ratio)
{
    static const double way[PD_DIM] = {1.0};
    double tip[PD_DIM] = {0.0}, j;
    pd_bond_failure_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.kind = PD_BOND_FAILURE_ENERGY;
    desc.critical = 1.0;
    desc.unbreakable = t->spared;
    PD_TRY(pd_bond_failure_build(ctx, &t->solid, &desc, &t->criterion));
    while (tip[0] < t->crack_length + PDI_FRACTURE_CALIBRATION_ADVANCE) {
        PD_TRY(pdi_fracture_calibration_break_bonds(ctx, t));
        PD_TRY(pd_crack_tip(ctx, &t->body, way, 0.0, tip));
    }
    PD_TRY(pdi_fracture_calibration_compute_j(ctx, t, tip, &j));
    *j_ratio = t->factor * t->factor * j;
    return PD_OK;
}

/* Builds the strip and grows its crack; *j_ratio as of pdi_fracture_calibration_grow_crack. Height and pre-crack are 12
 * (3D: 8) times the horizon in whole cells, the length is twice that. The caller frees, after an error too. */
static pd_status pdi_fracture_calibration_solve_strip(pd_ctx *ctx, const pd_body *body,
                                                      const pd_correspondence_desc *elastic,
                                                      pdi_fracture_calibration *t, double *j_ratio)
{
    int reach = (int)ceil(body->horizon / body->spacing);
    t->height = t->crack_length =
        (PD_DIM == 3 ? PDI_FRACTURE_CALIBRATION_HEIGHT_3D : PDI_FRACTURE_CALIBRATION_HEIGHT) * reach;
    t->length = 2 * t->crack_length;
    t->held_rows = 2 * reach;
    t->layers = PD_DIM == 3 ? PDI_FRACTURE_CALIBRATION_LAYERS : 1;
    t->count = t->layers * (t->height + 2 * t->held_rows) * t->length;
    PD_TRY(pdi_array_registry_build(ctx, pdi_fracture_calibration_list, t));
    PD_TRY(pdi_fracture_calibration_build_strip(ctx, body, t));
    PD_TRY(pdi_fracture_calibration_build_material(ctx, elastic, t));
    return pdi_fracture_calibration_grow_crack(ctx, t, j_ratio);
}

PDI_FN pd_status pdi_fracture_calibration_compute_critical(pd_ctx *ctx, const pd_body *body,
                                                           const pd_correspondence_desc *elastic, double fracture,
                                                           double *critical)
{
    double most = 0.0, h = body->spacing;
    pdi_fracture_calibration t;
    memset(&t, 0, sizeof t);
    if (!(h > 0.0))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "fracture_calibration",
                       "the points are those of no lattice: expected a spacing");
    if (PD_DIM == 3 &&
        (body->horizon < PDI_FRACTURE_CALIBRATION_MIN_HORIZON * h * (1.0 - PDI_FRACTURE_CALIBRATION_MARGIN) ||
         body->horizon > PDI_FRACTURE_CALIBRATION_MAX_HORIZON * h * (1.0 + PDI_FRACTURE_CALIBRATION_MARGIN)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "fracture_calibration",
                       "a horizon of %g spacings with the energy of a crack in 3D, "
                       "expected %g to %g",
                       body->horizon / h, PDI_FRACTURE_CALIBRATION_MIN_HORIZON, PDI_FRACTURE_CALIBRATION_MAX_HORIZON);
    pd_status status = pdi_fracture_calibration_solve_strip(ctx, body, elastic, &t, &most);
    pd_bond_failure_free(ctx, &t.criterion);
    pd_correspondence_free(ctx, &t.elastic);
    pd_body_free(ctx, &t.body);
    pdi_array_registry_free(ctx, pdi_fracture_calibration_list, &t);
    /* J = most critical of the spacing 1; volumes of bonds grow by h^d, areas over volumes by 1/h */
    if (status >= 0) *critical = fracture / (most * (PD_DIM == 3 ? h * h * h * h : h * h * h));
    return status;
}
#endif

#undef PDI_FRACTURE_CALIBRATION_HEIGHT
#undef PDI_FRACTURE_CALIBRATION_HEIGHT_3D
#undef PDI_FRACTURE_CALIBRATION_LAYERS
#undef PDI_FRACTURE_CALIBRATION_MIN_HORIZON
#undef PDI_FRACTURE_CALIBRATION_MAX_HORIZON
#undef PDI_FRACTURE_CALIBRATION_ADVANCE
#undef PDI_FRACTURE_CALIBRATION_BREAK_FRACTION
#undef PDI_FRACTURE_CALIBRATION_RTOL
#undef PDI_FRACTURE_CALIBRATION_MARGIN
