/* corrode: see corrode.h */
#include "corrode.h"
#include "damage.h"
#include "line.h"
#include "par.h"
#include <math.h>
#include <string.h>

PDI_FN double pdi_corrode_scale(const pd_corrode *r)
{
    return r->desc.drive == PD_DRIVE_CONSTANT ? r->span : r->log_ratio;
}

PDI_FN void pdi_corrode_laplacian(const pd_corrode *r, const double *c, int32_t first, int count, double *sum)
{
    const pd_stencil *s = r->stencil;
    if (count >= PDI_VECTOR) {
        pdi_lines lines;
        lines.grid = r->grid;
        lines.stencil = s;
        lines.shift = r->line_shift;
        pdi_line_laplacian(&lines, c, first, count, sum);
        return;
    }
    c += first;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    for (int k = 0; k < s->count / 2; k++) {
        const double *far = c + r->shift[k], *back = c - r->shift[k];
        for (int b = 0; b < count; b++) sum[b] += s->lap[k] * ((far[b] - c[b]) + (back[b] - c[b]));
    }
}

PDI_FN void pdi_corrode_spread(const pd_corrode *r, const double *c, int32_t first, int count, double *sum)
{
    if (r->role[first] == PDI_CORRODE_WHOLE) {
        pdi_corrode_laplacian(r, c, first, count, sum);
        return;
    }
    c += first;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        const double *far = c + r->shift[k], lap = r->stencil->lap[k];
        const uint8_t *there = r->phase + first + r->shift[k];
        for (int b = 0; b < count; b++) sum[b] += pdi_corrode_wet(there[b]) ? lap * (far[b] - c[b]) : 0.0;
    }
}

/* Fluid nodes of one role, consecutive along axis 0, gain by diffusion. */
static void pdi_corrode_whole(pd_corrode *r, int32_t first, int count, double dt)
{
    double sum[PDI_CORRODE_PIECE];
    pdi_corrode_spread(r, r->c, first, count, sum);
    for (int b = 0; b < count; b++) r->next[first + b] = r->base[first + b] + dt * r->desc.diffusivity * sum[b];
}

/* Those beside metal or wall also gain from the metal. */
static void pdi_corrode_shore(pd_corrode *r, int32_t first, int count, double dt)
{
    const double *c = r->c + first;
    double diffusivity = r->desc.diffusivity, scale = pdi_corrode_scale(r);
    double spread[PDI_CORRODE_PIECE], metal[PDI_CORRODE_PIECE], ones[PDI_CORRODE_PIECE];
    int difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    if (r->desc.activation) memset(spread, 0, sizeof spread);
    else pdi_corrode_spread(r, r->c, first, count, spread);
    memset(metal, 0, sizeof metal);
    for (int b = 0; b < count; b++) ones[b] = 1.0;
    for (int k = 0; k < r->stencil->count; k++) {
        const double *far = c + r->shift[k], weight = r->front.weight[k];
        const double *factor = r->factor ? r->factor + first + r->shift[k] : ones;
        const uint8_t *there = r->phase + first + r->shift[k];
        for (int b = 0; b < count; b++)
            metal[b] += there[b] == PDI_CORRODE_SOLID ? weight * factor[b] * (difference ? far[b] - c[b] : 1.0) : 0.0;
    }
    for (int b = 0; b < count; b++)
        r->next[first + b] =
            r->base[first + b] + dt * (diffusivity * spread[b] + r->speed[first + b] * scale * metal[b]);
}

/* Solid nodes lose to attacking fluid; all others have the speed 0. */
static void pdi_corrode_exposed(pd_corrode *r, int32_t first, int count, double dt)
{
    const double *c = r->c + first;
    double loss[PDI_CORRODE_PIECE], scale = pdi_corrode_scale(r);
    int difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    memset(loss, 0, sizeof loss);
    for (int k = 0; k < r->stencil->count; k++) {
        const double *far = c + r->shift[k], *speed = r->speed + first + r->shift[k], weight = r->front.weight[k];
        for (int b = 0; b < count; b++) loss[b] += speed[b] * (weight * (difference ? c[b] - far[b] : 1.0));
    }
    for (int b = 0; b < count && r->factor; b++) loss[b] *= r->factor[first + b];
    for (int b = 0; b < count; b++) r->next[first + b] = r->base[first + b] - dt * scale * loss[b];
}

/* Pieces of the rows of the box, and the first node and length of one. */
static int32_t pdi_corrode_pieces(const pd_grid *grid)
{
    int32_t rows = 1;
    for (int d = 1; d < PD_DIM; d++) rows *= (int32_t)grid->n[d];
    return rows * (int32_t)((grid->n[0] + PDI_CORRODE_PIECE - 1) / PDI_CORRODE_PIECE);
}

static int32_t pdi_corrode_place(const pd_grid *grid, int32_t piece, int *count)
{
    int32_t per_row = (int32_t)((grid->n[0] + PDI_CORRODE_PIECE - 1) / PDI_CORRODE_PIECE), row = piece / per_row;
    int i[PD_DIM];
    i[0] = (int)(piece % per_row) * PDI_CORRODE_PIECE;
    for (int d = 1; d < PD_DIM; d++) {
        i[d] = (int)(row % grid->n[d]);
        row /= (int32_t)grid->n[d];
    }
    *count = grid->n[0] - i[0] < PDI_CORRODE_PIECE ? grid->n[0] - i[0] : PDI_CORRODE_PIECE;
    return pd_grid_node(grid, i);
}

static uint8_t pdi_corrode_role(const pd_corrode *r, int32_t i)
{
    uint8_t here = r->phase[i];
    int wet = 0;
    if (here == PDI_CORRODE_NONE) return PDI_CORRODE_IDLE;
    for (int k = 0; k < r->stencil->count; k++) wet += pdi_corrode_wet(r->phase[i + r->shift[k]]);
    if (here == PDI_CORRODE_SOLID) return wet ? PDI_CORRODE_EXPOSED : PDI_CORRODE_IDLE;
    return wet == r->stencil->count ? PDI_CORRODE_WHOLE : PDI_CORRODE_SHORE;
}

static void pdi_corrode_roles(pd_corrode *r)
{
    for (int32_t p = 0; p < pdi_corrode_pieces(r->grid); p++) {
        int count;
        int32_t first = pdi_corrode_place(r->grid, p, &count);
        for (int32_t i = first; i < first + count; i++) r->role[i] = pdi_corrode_role(r, i);
    }
}

/* Behind an odd number of held planes. */
static int pdi_corrode_is_held(const pd_grid *grid, int32_t node)
{
    int i[PD_DIM], held = 0;
    pdi_grid_index(grid, node, i);
    for (int d = 0; d < PD_DIM; d++)
        if (i[d] < 0 || i[d] >= grid->n[d]) held ^= pdi_grid_port(grid->side[2 * d + (i[d] < 0 ? 0 : 1)]);
    return held;
}

/* The phase of a ghost is that of its source. Solid is not continued behind held planes. */
static void pdi_corrode_ghost_phases(pd_corrode *r)
{
    for (int32_t g = 0; g < r->ghosts; g++) {
        uint8_t phase = r->phase[r->source[g]];
        if (pdi_corrode_is_held(r->grid, r->ghost[g]))
            phase = phase == PDI_CORRODE_FLUID ? PDI_CORRODE_HELD : PDI_CORRODE_NONE;
        r->phase[r->ghost[g]] = phase;
    }
}

/* Phases and roles of all nodes, from their kinds. */
static void pdi_corrode_phases(pd_corrode *r)
{
    for (int32_t i = 0; i < r->grid->total; i++) {
        if (r->grid->kind[i] == PD_SOLID) r->phase[i] = PDI_CORRODE_SOLID;
        if (r->grid->kind[i] == PD_FLUID) r->phase[i] = PDI_CORRODE_FLUID;
    }
    pdi_corrode_ghost_phases(r);
    pdi_corrode_roles(r);
}

/* Values of ghosts: odd about `bulk` behind held planes. */
PDI_FN void pdi_corrode_ghosts(pd_corrode *r)
{
    for (int32_t g = 0; g < r->ghosts; g++) {
        int32_t at = r->ghost[g], from = r->source[g];
        r->c[at] = r->phase[at] == PDI_CORRODE_HELD ? 2.0 * r->desc.bulk - r->c[from] : r->c[from];
        r->speed[at] = r->speed[from];
    }
}

/* 1 for nodes of the box within reach of a held side. */
static int pdi_corrode_is_border(const pd_grid *grid, int32_t node)
{
    int i[PD_DIM], near_side = 0;
    pdi_grid_index(grid, node, i);
    if (!pdi_grid_inside(grid, i)) return 0;
    for (int d = 0; d < PD_DIM; d++)
        near_side |= (i[d] < grid->ghost && pdi_grid_port(grid->side[2 * d])) ||
                     (i[d] >= grid->n[d] - grid->ghost && pdi_grid_port(grid->side[2 * d + 1]));
    return near_side;
}

static pd_status pdi_corrode_list_ghosts(pd_ctx *ctx, pd_corrode *r)
{
    const pd_grid *grid = r->grid;
    int32_t inside = 1;
    for (int d = 0; d < PD_DIM; d++) {
        inside *= (int32_t)grid->n[d];
        if ((pdi_grid_port(grid->side[2 * d]) || pdi_grid_port(grid->side[2 * d + 1])) && grid->n[d] < grid->ghost)
            return pdi_fail(ctx, PD_ERR_GEOMETRY, "corrode",
                            "the box is %d cells long on axis %d, with held sides expected at least a horizon: %d",
                            grid->n[d], d, grid->ghost);
    }
    PDI_TRY(PDI_NEW(ctx, "corrode", grid->total - inside, r->ghost));
    PDI_TRY(PDI_NEW(ctx, "corrode", grid->total - inside, r->source));
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        pdi_grid_index(grid, node, i);
        if (pdi_grid_inside(grid, i)) continue;
        r->ghost[r->ghosts] = node;
        r->source[r->ghosts++] = pdi_grid_image(grid, node, NULL);
    }
    PDI_TRY(PDI_NEW(ctx, "corrode", inside, r->border));
    for (int32_t node = 0; node < grid->total; node++)
        if (pdi_corrode_is_border(grid, node)) r->border[r->borders++] = node;
    return PD_OK;
}

static pd_status pdi_corrode_check(pd_ctx *ctx, const pd_grid *grid, const pd_corrode_desc *desc)
{
    if (!(desc->solid > desc->saturation) || !(desc->solid < 1e100) || !(desc->saturation > 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "Cs = %g and Csat = %g mol/m3, expected Cs > Csat > 0",
                        desc->solid, desc->saturation);
    if (!(desc->initial >= 0.0) || !(desc->initial < desc->solid) || !(desc->bulk >= 0.0) ||
        !(desc->bulk < desc->solid))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode",
                        "the fluid starts at %g mol/m3 and is held at %g mol/m3, expected 0 to below Cs = %g",
                        desc->initial, desc->bulk, desc->solid);
    if (!(desc->diffusivity >= 0.0) || !(desc->diffusivity < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "D = %g m2/s, expected a finite value of at least 0",
                        desc->diffusivity);
    if (!(desc->share >= 0.0) || desc->share > 1.0 || !(desc->overshoot >= 0.0) || !(desc->overshoot < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode",
                        "a share of %g and an overshoot of %g, expected 0 to 1 and at least 0", desc->share,
                        desc->overshoot);
    if (!(desc->repassivation >= 0.0) || desc->repassivation > desc->saturation)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode",
                        "repassivation below %g mol/m3, expected 0 to Csat = %g mol/m3", desc->repassivation,
                        desc->saturation);
    if ((int)desc->drive < PD_DRIVE_CONSTANT || (int)desc->drive > PD_DRIVE_DIFFERENCE)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "drive %d, expected 0 or 1", (int)desc->drive);
    if (!desc->rate) return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "no rate law is given");
    if (grid->circumference)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "the grid is axisymmetric, expected a planar one");
    return PD_OK;
}

static pd_status pdi_corrode_allocate(pd_ctx *ctx, pd_corrode *r)
{
    int32_t total = r->grid->total;
    PDI_TRY(PDI_NEW(ctx, "corrode", r->stencil->count, r->shift));
    PDI_TRY(PDI_NEW(ctx, "corrode", r->stencil->line_first[r->stencil->kinds], r->line_shift));
    PDI_TRY(PDI_NEW(ctx, "corrode", r->stencil->count, r->scratch));
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->c));
    r->base = r->c;
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->next));
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->speed));
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->phase));
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->role));
    if (r->desc.repassivation > 0.0) PDI_TRY(PDI_NEW(ctx, "corrode", total, r->film));
    r->changed_capacity = (int32_t)r->grid->solid_count;
    return PDI_NEW(ctx, "corrode", r->changed_capacity, r->changed);
}

/* Ghosts of metal dissolve like the metal that they repeat. */
static pd_status pdi_corrode_factors(pd_ctx *ctx, pd_corrode *r)
{
    const double *given = r->desc.factor;
    r->highest = 1.0;
    if (!given) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "corrode", r->grid->total, r->factor));
    for (int32_t i = 0; i < r->grid->total; i++) {
        if (r->grid->kind[i] != PD_SOLID) continue;
        if (!(given[i] >= 0.0) || !(given[i] < 1e100))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "a factor of %g, expected a finite one of at least 0",
                            given[i]);
        r->factor[i] = given[i];
        r->highest = fmax(r->highest, given[i]);
    }
    for (int32_t g = 0; g < r->ghosts; g++) r->factor[r->ghost[g]] = r->factor[r->source[g]];
    return PD_OK;
}

/* Number of mechanical bonds of solid nodes, and where the last of them breaks. */
static pd_status pdi_corrode_bonds(pd_ctx *ctx, pd_corrode *r)
{
    const pd_stencil *s = r->stencil;
    int32_t pieces = pdi_corrode_pieces(r->grid);
    int nt = pdi_par_threads(ctx, (int64_t)r->grid->solid_count * s->count);
    (void)nt;
    if (!r->desc.stochastic) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "corrode", r->grid->total, r->bonds));
    PDI_TRY(PDI_NEW(ctx, "corrode", r->grid->total, r->last));
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < pieces; p++) {
        int count;
        int32_t first = pdi_corrode_place(r->grid, p, &count);
        for (int32_t i = first; i < first + count; i++) {
            int bonds = 0;
            if (r->phase[i] != PDI_CORRODE_SOLID) continue;
            for (int k = 0; k < s->count; k++) bonds += r->phase[i + r->shift[k]] == PDI_CORRODE_SOLID;
            r->bonds[i] = (uint16_t)bonds;
            r->last[i] = r->desc.saturation + (1.0 - pdi_damage_last(r->desc.seed, i, bonds)) * r->span;
        }
    }
    return PD_OK;
}

pd_status pd_corrode_build(pd_ctx *ctx, pd_grid *grid, const pd_stencil *stencil, const pd_corrode_desc *desc,
                           pd_corrode *r)
{
    memset(r, 0, sizeof *r);
    r->grid = grid;
    r->stencil = stencil;
    r->desc = *desc;
    PDI_TRY(pdi_corrode_check(ctx, grid, desc));
    if (!(r->desc.share > 0.0)) r->desc.share = 0.01;
    if (!(r->desc.overshoot > 0.0)) r->desc.overshoot = 0.05;
    r->span = desc->solid - desc->saturation;
    r->log_ratio = log(desc->solid / desc->saturation);
    PDI_TRY(pd_front_build(ctx, stencil, desc->kernel, desc->weights, &r->front));
    PDI_TRY(pdi_corrode_allocate(ctx, r));
    PDI_TRY(pdi_corrode_list_ghosts(ctx, r));
    PDI_TRY(pdi_corrode_factors(ctx, r));
    pdi_grid_line_shift(grid, stencil, r->line_shift);
    for (int k = 0; k < stencil->count; k++) {
        for (int d = 0; d < PD_DIM; d++) r->shift[k] += (int32_t)stencil->offset[k * PD_DIM + d] * grid->stride[d];
        r->diffusion += desc->diffusivity * stencil->lap[k];
    }
    pdi_corrode_phases(r);
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] == PD_SOLID) r->c[i] = desc->solid;
        if (grid->kind[i] == PD_FLUID) r->c[i] = desc->activation ? desc->bulk : desc->initial;
    }
    PDI_TRY(pdi_corrode_bonds(ctx, r));
    pd_corrode_open(r);
    return PD_OK;
}

static double pdi_corrode_amount(const pd_corrode *r, uint8_t phase)
{
    pdi_sum sum = {0.0, 0.0};
    for (int32_t p = 0; p < pdi_corrode_pieces(r->grid); p++) {
        int count;
        int32_t first = pdi_corrode_place(r->grid, p, &count);
        for (int32_t i = first; i < first + count; i++)
            if (r->phase[i] == phase) pdi_sum_add(&sum, r->c[i]);
    }
    return pdi_sum_total(&sum) * r->stencil->volume;
}

double pd_corrode_solid(const pd_corrode *r) { return pdi_corrode_amount(r, PDI_CORRODE_SOLID); }

double pd_corrode_dissolved(const pd_corrode *r) { return pdi_corrode_amount(r, PDI_CORRODE_FLUID); }

double pd_corrode_damage(const pd_corrode *r, int32_t node)
{
    double expected = fmin((r->desc.solid - r->c[node]) / r->span, 1.0);
    if (r->phase[node] == PDI_CORRODE_FLUID) return 1.0;
    if (r->phase[node] != PDI_CORRODE_SOLID) return 0.0;
    return r->bonds ? pdi_damage_broken(r->desc.seed, node, r->bonds[node], expected) : expected;
}

/* Content [mol/m3] at which solid node i turns fluid. */
static double pdi_corrode_end(const pd_corrode *r, int32_t i) { return r->last ? r->last[i] : r->desc.saturation; }

void pd_corrode_open(pd_corrode *r)
{
    r->start = pd_corrode_solid(r) + pd_corrode_dissolved(r);
    r->out = r->out_carry = 0.0;
}

double pd_corrode_imbalance(const pd_corrode *r)
{
    double now = pd_corrode_solid(r) + pd_corrode_dissolved(r) + (r->out + r->out_carry);
    return r->start > 0.0 ? fabs(now - r->start) / r->start : fabs(now);
}

/* Activation control: fluid node i gives away what it holds above bulk. */
static void pdi_corrode_rinse(pd_corrode *r, int32_t i)
{
    pdi_sum out;
    out.sum = r->out;
    out.carry = r->out_carry;
    pdi_sum_add(&out, (r->c[i] - r->desc.bulk) * r->stencil->volume);
    r->c[i] = r->desc.bulk;
    r->out = out.sum;
    r->out_carry = out.carry;
}

PDI_FN void pdi_corrode_repassivate(pd_corrode *r)
{
    for (int32_t i = 0; i < r->grid->total && r->film; i++)
        if (r->role[i] == PDI_CORRODE_SHORE && r->c[i] < r->desc.repassivation) r->film[i] = 1;
}

PDI_FN pd_status pdi_corrode_law(pd_ctx *ctx, const pd_corrode *r, int32_t i, double c, double *speed)
{
    *speed = 0.0;
    if ((r->desc.passive && r->desc.passive[i]) || (r->film && r->film[i])) return PD_OK;
    double v = r->desc.rate(r->desc.rate_user, c);
    if (!(fabs(v) < 1e100)) {
        double x[PD_DIM];
        pd_grid_position(r->grid, i, x);
        return pdi_fail(ctx, PD_ERR_STATE, "corrode",
                        "the rate law gives %g m/s at c = %g mol/m3 (node %d at x = %g m), expected a finite speed", v,
                        c, (int)i, x[0]);
    }
    *speed = fmax(v, 0.0);
    return PD_OK;
}

/* Speed of the law at every fluid node beside the front, and how many nodes take part. The salt layer is nothing but a
 * look at c. */
static pd_status pdi_corrode_prepare(pd_ctx *ctx, pd_corrode *r)
{
    r->fastest = 0.0;
    r->active = 0;
    for (int32_t n = 0; n < r->changed_count && r->desc.activation; n++) pdi_corrode_rinse(r, r->changed[n]);
    pdi_corrode_repassivate(r);
    for (int32_t p = 0; p < pdi_corrode_pieces(r->grid); p++) {
        int count;
        int32_t first = pdi_corrode_place(r->grid, p, &count);
        for (int32_t i = first; i < first + count; i++) {
            uint8_t role = r->role[i];
            r->active += role > PDI_CORRODE_WHOLE || (role == PDI_CORRODE_WHOLE && !r->desc.activation);
            /* metal sees no fluid of another role */
            if (role != PDI_CORRODE_SHORE) continue;
            r->speed[i] = 0.0;
            if (!(r->c[i] < r->desc.saturation)) continue;
            PDI_TRY(pdi_corrode_law(ctx, r, i, r->c[i], r->speed + i));
            r->fastest = fmax(r->fastest, r->speed[i]);
        }
    }
    pdi_corrode_ghosts(r);
    return PD_OK;
}

/* Rates [1/s] at most: of a fluid node towards its neighbours, of a solid node as a share of Cs - Csat. */
static void pdi_corrode_rates(const pd_corrode *r, double *field, double *loss)
{
    double cross = r->fastest * r->highest * r->front.total;
    int difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    *loss = cross * (difference ? r->log_ratio * r->desc.solid / r->span : 1.0);
    *field = (r->desc.activation ? 0.0 : r->diffusion) + (difference ? cross * r->log_ratio : 0.0);
}

/* A node that turns fluid and keeps what it has lost has not less than none; another one loses no more than it had. */
static double pdi_corrode_longest(const pd_corrode *r)
{
    double field, loss;
    pdi_corrode_rates(r, &field, &loss);
    double drop = r->desc.keep_deficit ? loss * r->span / r->desc.saturation : loss;
    double rate = fmax(field, r->desc.drive == PD_DRIVE_CONSTANT ? drop : 0.0);
    return rate > 0.0 ? 1.0 / rate : HUGE_VAL;
}

/* Longest step that the share and the overshoot allow. */
static double pdi_corrode_accurate(const pd_corrode *r)
{
    double field, loss, share = r->desc.share;
    pdi_corrode_rates(r, &field, &loss);
    if (!r->desc.activation) share = fmin(share, r->desc.overshoot * r->desc.saturation / r->span);
    return loss > 0.0 ? share / loss : HUGE_VAL;
}

pd_status pd_corrode_limit(pd_ctx *ctx, pd_corrode *r, double *limit)
{
    PDI_TRY(pdi_corrode_prepare(ctx, r));
    *limit = pdi_corrode_longest(r);
    return PD_OK;
}

/* What bonds to held ghosts take from node i [mol/m3/s]. */
static double pdi_corrode_leak(const pd_corrode *r, int32_t i)
{
    int solid = r->phase[i] == PDI_CORRODE_SOLID, difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    double sum = 0.0, scale = solid ? pdi_corrode_scale(r) : r->desc.activation ? 0.0 : r->desc.diffusivity;
    if (r->phase[i] == PDI_CORRODE_NONE || r->role[i] == PDI_CORRODE_IDLE || !(scale > 0.0)) return 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        int32_t j = i + r->shift[k];
        double step = r->c[i] - r->c[j];
        if (r->phase[j] != PDI_CORRODE_HELD) continue;
        if (solid) sum += r->speed[j] * (r->front.weight[k] * (difference ? step : 1.0));
        else sum += r->stencil->lap[k] * step;
    }
    if (solid && r->factor) sum *= r->factor[i];
    return scale * sum;
}

/* Solid nodes at their end turn fluid; roles within one reach of them and of their ghosts change. */
static void pdi_corrode_turn(pd_corrode *r)
{
    for (int32_t n = 0; n < r->changed_count; n++) {
        r->phase[r->changed[n]] = PDI_CORRODE_FLUID;
        pdi_grid_dissolve(r->grid, r->changed[n]);
    }
    pdi_corrode_ghost_phases(r);
    for (int32_t n = 0; n < r->changed_count; n++) {
        int32_t at = r->changed[n];
        r->role[at] = pdi_corrode_role(r, at);
        for (int k = 0; k < r->stencil->count; k++) {
            int32_t near_node = pdi_grid_image(r->grid, at + r->shift[k], NULL);
            r->role[near_node] = pdi_corrode_role(r, near_node);
        }
    }
}

/* Weights of the bonds of node i that lead to metal that does not turn (dry), or to attacking fluid that holds some. */
static double pdi_corrode_behind(const pd_corrode *r, int32_t i, int dry, double *weight)
{
    double sum = 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        int32_t j = i + r->shift[k];
        int32_t at = pdi_grid_image(r->grid, j, NULL);
        int metal = r->phase[j] == PDI_CORRODE_SOLID && r->c[at] > pdi_corrode_end(r, at);
        int fluid = r->phase[j] == PDI_CORRODE_FLUID && r->c[at] > 0.0;
        weight[k] = r->front.weight[k] * (dry ? metal : fluid ? r->speed[at] : 0.0);
        sum += weight[k];
    }
    return sum;
}

/* Node i takes up to `deficit` from those, in proportion to their weights, and no more than metal has above its end or
 * fluid at all. What is left goes round until it is covered or none has any. Returns it. */
static double pdi_corrode_collect(pd_corrode *r, int32_t i, int dry, double deficit)
{
    double sum, left = deficit;
    while (left > 0.0 && (sum = pdi_corrode_behind(r, i, dry, r->scratch)) > 0.0) {
        double given = 0.0;
        int exhausted = 0;
        for (int k = 0; k < r->stencil->count; k++) {
            double part = left * (r->scratch[k] / sum);
            int32_t at = pdi_grid_image(r->grid, i + r->shift[k], NULL);
            double *from = &r->c[at], keep = dry ? pdi_corrode_end(r, at) : 0.0;
            if (!(part > 0.0)) continue;
            if (part >= *from - keep) {
                part = fmax(*from - keep, 0.0);
                *from = fmin(*from, keep);
                exhausted = 1;
            } else *from -= part;
            given += part;
        }
        r->c[i] += given;
        left = exhausted ? left - given : 0.0;
    }
    return left;
}

/* What a node that turns has lost below its end, the metal behind it makes up for. Without any, the fluid that has
 * taken it gives it back, as far as it still has it. */
static void pdi_corrode_hand_over(pd_corrode *r)
{
    for (int32_t n = 0; n < r->changed_count; n++) {
        int32_t i = r->changed[n];
        double left = pdi_corrode_collect(r, i, 1, pdi_corrode_end(r, i) - r->c[i]);
        pdi_corrode_collect(r, i, 0, left);
    }
}

/* Metal in reach of metal node i that could make up for it [mol/m3]: what that has left above Csat in `next`. */
static double pdi_corrode_backing(const pd_corrode *r, int32_t i)
{
    double sum = 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        int32_t j = i + r->shift[k];
        if (r->phase[j] == PDI_CORRODE_SOLID)
            sum += fmax(r->next[pdi_grid_image(r->grid, j, NULL)] - r->desc.saturation, 0.0);
    }
    return sum;
}

PDI_FN double pdi_corrode_spare(const pd_corrode *r)
{
    double least = 1.0, half = 0.5 * r->desc.saturation;
    if (r->desc.activation || r->desc.keep_deficit) return 1.0;
    for (int32_t i = 0; i < r->grid->total; i++) {
        if (r->role[i] != PDI_CORRODE_EXPOSED || r->next[i] >= 0.0 || !(r->base[i] > r->desc.saturation)) continue;
        if (pdi_corrode_backing(r, i) < r->desc.saturation - r->next[i])
            least = fmin(least, (r->base[i] - half) / (r->base[i] - r->next[i]));
    }
    return least;
}

PDI_FN void pdi_corrode_commit(pd_corrode *r, double dt)
{
    pdi_sum out;
    out.sum = r->out;
    out.carry = r->out_carry;
    for (int32_t b = 0; b < r->borders; b++)
        pdi_sum_add(&out, dt * r->stencil->volume * pdi_corrode_leak(r, r->border[b]));
    r->out = out.sum;
    r->out_carry = out.carry;
    r->changed_count = 0;
    for (int32_t p = 0; p < pdi_corrode_pieces(r->grid); p++) {
        int count;
        int32_t first = pdi_corrode_place(r->grid, p, &count);
        for (int32_t i = first; i < first + count; i++) {
            uint8_t role = r->role[i];
            if (role == PDI_CORRODE_IDLE || (role == PDI_CORRODE_WHOLE && r->desc.activation)) continue;
            r->c[i] = r->next[i];
            if (role == PDI_CORRODE_EXPOSED && r->c[i] <= pdi_corrode_end(r, i)) r->changed[r->changed_count++] = i;
        }
    }
    if (!r->desc.keep_deficit) pdi_corrode_hand_over(r);
    for (int32_t i = 0; i < r->grid->total && r->desc.activation; i++)
        if (r->role[i] == PDI_CORRODE_SHORE) pdi_corrode_rinse(r, i);
    if (r->changed_count) pdi_corrode_turn(r);
    r->time += dt;
    r->steps++;
}

PDI_FN void pdi_corrode_sweep(const pd_ctx *ctx, const pd_corrode *r, pdi_corrode_run_fn run, void *user)
{
    int32_t pieces = pdi_corrode_pieces(r->grid);
    int nt = pdi_par_threads(ctx, r->active * r->stencil->count);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < pieces; p++) {
        int count;
        int32_t first = pdi_corrode_place(r->grid, p, &count), end = first + count, next;
        for (int32_t i = first; i < end; i = next) {
            for (next = i + 1; next < end && r->role[next] == r->role[i];) next++;
            if (r->role[i] != PDI_CORRODE_IDLE) run(user, i, (int)(next - i));
        }
    }
}

/* The operands of an exchange. */
typedef struct pdi_corrode_exchanging {
    pd_corrode *corrode;
    double dt; /* [s] */
} pdi_corrode_exchanging;

static void pdi_corrode_exchange_run(void *user, int32_t first, int count)
{
    const pdi_corrode_exchanging *e = (const pdi_corrode_exchanging *)user;
    uint8_t role = e->corrode->role[first];
    if (role == PDI_CORRODE_WHOLE && !e->corrode->desc.activation) pdi_corrode_whole(e->corrode, first, count, e->dt);
    if (role == PDI_CORRODE_SHORE) pdi_corrode_shore(e->corrode, first, count, e->dt);
    if (role == PDI_CORRODE_EXPOSED) pdi_corrode_exposed(e->corrode, first, count, e->dt);
}

PDI_FN void pdi_corrode_exchange(pd_ctx *ctx, pd_corrode *r, double dt)
{
    pdi_corrode_exchanging e;
    e.corrode = r;
    e.dt = dt;
    pdi_corrode_sweep(ctx, r, pdi_corrode_exchange_run, &e);
}

PDI_FN double pdi_corrode_lost(const pd_corrode *r)
{
    double most = 0.0;
    for (int32_t i = 0; i < r->grid->total; i++)
        if (r->role[i] == PDI_CORRODE_EXPOSED) most = fmax(most, r->base[i] - r->next[i]);
    return most / r->span;
}

pd_status pd_corrode_step(pd_ctx *ctx, pd_corrode *r, double dt)
{
    double limit;
    PDI_TRY(pd_corrode_limit(ctx, r, &limit));
    if (!(dt > 0.0) || !(dt < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "a step of %g s, expected a positive one", dt);
    if (dt > limit * (1.0 + 1e-12))
        return pdi_fail(ctx, PD_RETRY, "corrode", "the step of %g s exceeds the limit of %g s", dt, limit);
    pdi_corrode_exchange(ctx, r, dt);
    pdi_corrode_commit(r, dt);
    return PD_OK;
}

pd_status pd_corrode_run(pd_ctx *ctx, pd_corrode *r, double t_end)
{
    while (r->time < t_end) {
        double left = t_end - r->time, limit;
        PDI_TRY(pd_corrode_limit(ctx, r, &limit));
        limit = fmin(limit, pdi_corrode_accurate(r));
        double count = ceil(left / limit * (1.0 - 1e-12));
        double dt = count > 1.0 ? left / count : left;
        pdi_corrode_exchange(ctx, r, dt);
        double spare = pdi_corrode_spare(r);
        if (spare < 1.0) {
            dt *= spare;
            count = 2.0;
            pdi_corrode_exchange(ctx, r, dt);
        }
        pdi_corrode_commit(r, dt);
        if (!(count > 1.0)) r->time = t_end; /* no last step of rounding's length */
    }
    return PD_OK;
}

PDI_FN pd_status pdi_corrode_store(pd_ctx *ctx, pd_corrode *r, pd_store *store)
{
    PDI_TRY(PDI_STORE(ctx, store, "corrode.c", r->c, r->grid->total));
    if (r->film) PDI_TRY(PDI_STORE(ctx, store, "corrode.film", r->film, r->grid->total));
    PDI_TRY(PDI_STORE(ctx, store, "corrode.time", &r->time, 1));
    PDI_TRY(PDI_STORE(ctx, store, "corrode.start", &r->start, 1));
    PDI_TRY(PDI_STORE(ctx, store, "corrode.out", &r->out, 1));
    PDI_TRY(PDI_STORE(ctx, store, "corrode.out_carry", &r->out_carry, 1));
    PDI_TRY(PDI_STORE(ctx, store, "corrode.steps", &r->steps, 1));
    PDI_TRY(PDI_STORE(ctx, store, "corrode.changed_count", &r->changed_count, 1));
    if (r->changed_count < 0 || r->changed_count > r->changed_capacity)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "'%s' has %d nodes turn fluid, expected 0 to %d",
                        store->file.path, (int)r->changed_count, (int)r->changed_capacity);
    PDI_TRY(PDI_STORE(ctx, store, "corrode.changed", r->changed, r->changed_count));
    if (store->reading) pdi_corrode_phases(r);
    return PD_OK;
}

void pd_corrode_free(pd_ctx *ctx, pd_corrode *r)
{
    int32_t total = r->grid ? r->grid->total : 0, inside = r->grid ? 1 : 0;
    for (int d = 0; d < PD_DIM && r->grid; d++) inside *= (int32_t)r->grid->n[d];
    pd_front_free(ctx, &r->front);
    PDI_DELETE(ctx, r->stencil ? r->stencil->count : 0, r->shift);
    PDI_DELETE(ctx, r->stencil ? r->stencil->line_first[r->stencil->kinds] : 0, r->line_shift);
    PDI_DELETE(ctx, r->stencil ? r->stencil->count : 0, r->scratch);
    PDI_DELETE(ctx, total, r->c);
    PDI_DELETE(ctx, total, r->next);
    PDI_DELETE(ctx, total, r->speed);
    PDI_DELETE(ctx, total, r->factor);
    PDI_DELETE(ctx, total, r->bonds);
    PDI_DELETE(ctx, total, r->last);
    PDI_DELETE(ctx, total, r->film);
    PDI_DELETE(ctx, total, r->phase);
    PDI_DELETE(ctx, total, r->role);
    PDI_DELETE(ctx, inside, r->border);
    PDI_DELETE(ctx, total - inside, r->ghost);
    PDI_DELETE(ctx, total - inside, r->source);
    PDI_DELETE(ctx, r->changed_capacity, r->changed);
    memset(r, 0, sizeof *r);
}
