/* structure: see structure.h */
#include "couple/structure.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Strains that are not small: one that is off by a tenth of itself, since Green's strain has half of its square more,
 * and flow by as much as the metal is long. */
#define PDI_STRUCTURE_STRAIN 0.2
#define PDI_STRUCTURE_SLIP 1.0

enum { PDI_STRUCTURE_TENSOR = PD_DIM * PD_DIM };

PDI_FN void pdi_structure_list(pdi_owner *owner, void *object)
{
    pd_structure *structure = (pd_structure *)object;
    PDI_ARRAY(owner, structure, node, structure->count, "1");
    PDI_ARRAY(owner, structure, point, structure->total, "1");
    PDI_ARRAY(owner, structure, held, structure->count * PD_DIM, "1");
    PDI_STATE(owner, structure, stiff, structure->count, "1");
    PDI_ARRAY(owner, structure, stress, (int64_t)structure->count * PDI_STRUCTURE_TENSOR, "Pa");
    PDI_ARRAY(owner, structure, pressure, structure->count, "Pa");
    PDI_ARRAY(owner, structure, mises, structure->count, "Pa");
    PDI_ARRAY(owner, structure, factor, structure->desc.pace ? structure->total : 0, "1");
}

PDI_FN double pdi_structure_broken(const pd_structure *s, int32_t point)
{
    int64_t all = s->body.row[point + 1] - s->body.row[point];
    return all ? 1.0 - (double)pdi_body_intact(&s->body, point) / (double)all : 0.0;
}

/* ---- build ---- */

static pd_status pdi_structure_points(pd_ctx *ctx, pd_structure *s)
{
    const pd_grid *grid = s->grid;
    double *position = NULL, *volume = NULL, cell = 1.0;
    pd_body_desc desc;
    memset(&desc, 0, sizeof desc);
    for (int d = 0; d < PD_DIM; d++) cell *= grid->h[d];
    pd_status status = PDI_NEW(ctx, "structure", (int64_t)s->count * PD_DIM, position);
    if (status == PD_OK) status = PDI_NEW(ctx, "structure", s->count, volume);
    for (int32_t i = 0, k = 0; i < grid->total && status == PD_OK; i++) {
        int at[PD_DIM];
        pdi_grid_index(grid, i, at);
        s->point[i] = -1;
        if (grid->kind[i] != PD_SOLID || !pdi_grid_inside(grid, at)) continue;
        s->node[k] = i;
        s->point[i] = k;
        pd_grid_position(grid, i, position + (int64_t)k * PD_DIM);
        s->stiff[k] = 1.0;
        volume[k++] = cell;
    }
    desc.count = s->count;
    desc.position = position;
    desc.volume = volume;
    desc.spacing = grid->h[0];
    desc.horizon = s->desc.m * grid->h[0];
    if (status == PD_OK) status = pd_body_build(ctx, &desc, &s->body);
    PDI_DELETE(ctx, s->count, volume);
    PDI_DELETE(ctx, (int64_t)s->count * PD_DIM, position);
    return status;
}

static pd_status pdi_structure_count(pd_ctx *ctx, pd_structure *s)
{
    const pd_grid *grid = s->grid;
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(grid->h[d] - grid->h[0]) > 1e-9 * grid->h[0])
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "structure", "spacings of %g and %g m, expected one spacing along all"
                            " axes", grid->h[0], grid->h[d]);
    if (grid->circumference)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "structure", "an axisymmetric lattice, expected a planar one");
    for (int32_t i = 0; i < grid->total; i++) {
        int at[PD_DIM];
        pdi_grid_index(grid, i, at);
        s->count += grid->kind[i] == PD_SOLID && pdi_grid_inside(grid, at);
    }
    if (!s->count) return pdi_fail(ctx, PD_ERR_GEOMETRY, "structure", "no metal, expected a solid that bears loads");
    return PD_OK;
}

/* Break the bonds that cross a cut, a piece of its line after another. */
static pd_status pdi_structure_cut(pd_ctx *ctx, pd_structure *s, const pd_structure_cut *cut)
{
    int pieces = PD_DIM == 2 && cut->corners > 2 ? cut->corners - 1 : 1;
    int64_t broken, all = 0;
    for (int k = 0; k < pieces; k++) {
        char message[PD_MESSAGE_SIZE];
        pd_cut piece;
        piece.corners = PD_DIM == 2 && cut->corners > 2 ? 2 : cut->corners;
        piece.corner = cut->corner + k * PD_DIM;
        pd_status status = pd_body_cut(ctx, &s->body, &piece, 1, &broken);
        memcpy(message, ctx->message, sizeof message);
        if (status < 0) return pdi_fail(ctx, status, "structure", "'%.60s': %.400s", cut->name, message);
        all += broken;
    }
    if (all) return PD_OK;
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "structure", "the cut '%.60s' crosses no bond of the metal", cut->name);
}

static int pdi_structure_bears(const pd_structure *s)
{
    for (int32_t i = 0; i < s->count; i++)
        if (s->elastic.total[i] > 0.0) return 1;
    return 0;
}

static pd_status pdi_structure_make(pd_ctx *ctx, const pd_grid *grid, const pd_structure_desc *desc, pd_structure *s)
{
    pd_quasi_static_desc rest;
    memset(s, 0, sizeof *s);
    memset(&rest, 0, sizeof rest);
    s->desc = *desc;
    s->grid = grid;
    s->total = grid->total;
    s->desc.cuts = NULL;
    PDI_TRY(pdi_structure_count(ctx, s));
    PDI_TRY(pdi_owner_build(ctx, pdi_structure_list, s));
    PDI_TRY(pdi_structure_points(ctx, s));
    for (int k = 0; k < desc->cut_count; k++) PDI_TRY(pdi_structure_cut(ctx, s, &desc->cuts[k]));
    s->desc.elastic.stiff = s->stiff;
    s->desc.elastic.loose = 1;
    PDI_TRY(pd_elastic_build(ctx, &s->body, &s->desc.elastic, &s->elastic));
    if (!pdi_structure_bears(s))
        return pdi_fail(ctx, PD_ERR_GEOMETRY, "structure", "the metal is too thin to bear loads: no node has bonds "
                        "along all directions; choose a smaller h");
    for (int32_t i = 0; i < s->total && desc->pace; i++) s->factor[i] = desc->factor ? desc->factor[i] : 1.0;
    rest.held = s->held;
    rest.load = desc->load;
    rest.user = desc->user;
    rest.criterion.critical = desc->stretch;
    rest.eager = -1.0;
    rest.rtol = desc->rtol;
    pd_solid solid = pd_elastic_solid(&s->elastic);
    return pd_quasi_static_build(ctx, &solid, &rest, &s->rest);
}

pd_status pd_structure_build(pd_ctx *ctx, const pd_grid *grid, const pd_structure_desc *desc, pd_structure *s)
{
    pd_status status = pdi_structure_make(ctx, grid, desc, s);
    if (status < 0) pd_structure_free(ctx, s);
    return status;
}

void pd_structure_free(pd_ctx *ctx, pd_structure *s)
{
    pd_quasi_static_free(ctx, &s->rest);
    pd_elastic_free(ctx, &s->elastic);
    pd_body_free(ctx, &s->body);
    pdi_owner_free(ctx, pdi_structure_list, s);
    memset(s, 0, sizeof *s);
}

/* ---- stress ---- */

/* The stress of the metal that is left, of the present balance. */
static void pdi_structure_stress(pd_ctx *ctx, pd_structure *s)
{
    const pd_solid *solid = &s->rest.solid;
    solid->stress(ctx, solid->self, s->rest.u, s->stress);
    for (int32_t i = 0; i < s->count; i++) {
        double *p = s->stress + (int64_t)i * PDI_STRUCTURE_TENSOR;
        double normal = solid->normal(solid->self, i, p), over = s->stiff[i] > 0.0 ? 1.0 / s->stiff[i] : 0.0;
        for (int k = 0; k < PDI_STRUCTURE_TENSOR; k++) p[k] *= over;
        s->mises[i] = pdi_solid_mises(p, normal * over, &s->pressure[i]);
    }
    s->seen = s->rest.solves;
}

/* Strains have to be small. */
static pd_status pdi_structure_small(pd_ctx *ctx, const pd_structure *s)
{
    double young = s->desc.elastic.young, x[PD_DIM];
    for (int32_t i = 0; i < s->count; i++) {
        double strain = fmax(s->mises[i], fabs(s->pressure[i])) / young;
        double slip = s->elastic.plastic.count ? s->elastic.plastic.slip[i] : 0.0;
        if (strain < PDI_STRUCTURE_STRAIN && slip < PDI_STRUCTURE_SLIP) continue;
        pd_grid_position(s->grid, s->node[i], x);
        return pdi_fail(ctx, PD_ERR_STATE, "structure", "the metal at x = %g m has a stress of %g of E and a plastic "
                        "strain of %g at t = %g s: expected small strains", x[0], strain, slip, s->rest.time);
    }
    return PD_OK;
}

static pd_status pdi_structure_pace(pd_ctx *ctx, pd_structure *s)
{
    pd_structure_at at;
    for (int32_t i = 0; i < s->count && s->desc.pace; i++) {
        int32_t node = s->node[i];
        if (s->grid->kind[node] != PD_SOLID) continue;
        pd_grid_position(s->grid, node, at.x);
        at.t = s->rest.time;
        at.pressure = s->pressure[i];
        at.mises = s->mises[i];
        at.slip = s->elastic.plastic.count ? s->elastic.plastic.slip[i] : 0.0;
        double pace = s->desc.pace(s->desc.pace_user, &at);
        if (!(pace >= 0.0) || !(pace < 1e100))
            return pdi_fail(ctx, PD_ERR_STATE, "structure", "the factor of the speed is %g where the mean stress is %g "
                            "Pa, at x = %g m: expected a finite one of at least 0", pace, at.pressure, at.x[0]);
        s->factor[node] = pace * (s->desc.factor ? s->desc.factor[node] : 1.0);
    }
    if (s->desc.pace && s->dissolve) s->dissolve->reached = 0; /* what it knows of factors */
    return PD_OK;
}

/* ---- a process ---- */

/* Stiffness of the metal that is left; the balance is stale when it is another. */
static void pdi_structure_stiffen(pd_structure *s)
{
    const pd_dissolve *d = s->dissolve;
    for (int32_t i = 0; i < s->count; i++) {
        if (s->grid->kind[s->node[i]] != PD_SOLID) continue;
        double left = d->transport->c[s->node[i]] / pdi_metal_solid(d, s->node[i]);
        if (!(fabs(left - s->stiff[i]) > 0.0)) continue;
        s->stiff[i] = left;
        s->rest.stale = 1;
    }
}

static pd_status pdi_structure_to(pd_ctx *ctx, pd_structure *s, double t)
{
    if (s->dissolve) pdi_structure_stiffen(s);
    pd_status status = pd_quasi_static_to(ctx, &s->rest, t);
    if (status < 0) return status;
    if (s->seen != s->rest.solves) {
        pdi_structure_stress(ctx, s);
        PDI_TRY(pdi_structure_small(ctx, s));
        PDI_TRY(pdi_structure_pace(ctx, s));
    }
    return status;
}

/* Without dissolution it follows whoever asks for a time; with it, the step that has ended. */
static pd_status pdi_structure_at(pd_ctx *ctx, void *self, double t)
{
    pd_structure *s = (pd_structure *)self;
    return s->dissolve && s->rest.known ? PD_OK : pdi_structure_to(ctx, s, t);
}

static pd_status pdi_structure_finish(pd_ctx *ctx, void *self, double t)
{
    return pdi_structure_to(ctx, (pd_structure *)self, t);
}

static pd_status pdi_structure_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    pd_structure *s = (pd_structure *)self;
    (void)ctx;
    for (int32_t k = 0; k < count; k++) {
        int32_t i = s->point[turned[k]];
        if (i < 0) continue;
        pdi_body_release(&s->body, i);
        s->stiff[i] = 0.0;
        s->rest.stale = 1;
    }
    return PD_OK;
}

static pd_status pdi_structure_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_structure *s = (pd_structure *)self;
    pd_process rest = pd_quasi_static_process(&s->rest);
    PDI_TRY(pdi_owner_store(ctx, pdi_structure_list, s, archive));
    PDI_TRY(rest.store(ctx, rest.self, archive));
    if (!archive->reading || !s->rest.known) return PD_OK;
    pdi_structure_stress(ctx, s);
    return pdi_structure_pace(ctx, s);
}

pd_process pd_structure_process(pd_structure *s, pd_dissolve *dissolve)
{
    pd_process p = pd_quasi_static_process(&s->rest);
    s->dissolve = dissolve;
    p.name = "structure";
    p.self = s;
    p.start = pdi_structure_at;
    p.at = pdi_structure_at;
    p.finish = pdi_structure_finish;
    p.changed = pdi_structure_changed;
    p.store = pdi_structure_store;
    return p;
}

#undef PDI_STRUCTURE_STRAIN
#undef PDI_STRUCTURE_SLIP
