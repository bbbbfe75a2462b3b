/* corrode: see corrode.h */
#include "metal/corrode.h"
#include "core/par.h"
#include "lattice/line.h"
#include "metal/damage.h"
#include <math.h>
#include <string.h>

/* A content below zero that is none, over Csat. */
#define PDI_CORRODE_ROUNDING 1e-12

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
        const double *far = c + r->map.shift[k], *back = c - r->map.shift[k];
        for (int b = 0; b < count; b++) sum[b] += s->lap[k] * ((far[b] - c[b]) + (back[b] - c[b]));
    }
}

PDI_FN void pdi_corrode_spread(const pd_corrode *r, const double *c, int32_t first, int count, double *sum)
{
    if (r->map.role[first] == PDI_ROLE_WHOLE) {
        pdi_corrode_laplacian(r, c, first, count, sum);
        return;
    }
    c += first;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        const double *far = c + r->map.shift[k], lap = r->stencil->lap[k];
        const uint8_t *there = r->map.phase + first + r->map.shift[k];
        for (int b = 0; b < count; b++) sum[b] += pdi_phase_wet(there[b]) ? lap * (far[b] - c[b]) : 0.0;
    }
}

/* Fluid nodes of one role, consecutive along axis 0, gain by diffusion. */
static void pdi_corrode_whole(pd_corrode *r, int32_t first, int count, double dt)
{
    double sum[PDI_PHASE_PIECE];
    pdi_corrode_spread(r, r->c, first, count, sum);
    for (int b = 0; b < count; b++) r->next[first + b] = r->base[first + b] + dt * r->desc.diffusivity * sum[b];
}

/* Runs of nodes of which the sums are not known. */
static int pdi_corrode_stale(const double *sum, int count, int *at)
{
    while (*at < count && !(sum[*at] < 0.0)) ++*at;
    int end = *at;
    while (end < count && sum[end] < 0.0) end++;
    return end - *at;
}

/* Fluid beside metal: sum b f over the metal in reach, times C_j - C_i where the drive is that. */
static void pdi_corrode_reach(const pd_corrode *r, int32_t first, int count, double *PD_RESTRICT metal)
{
    const double *c = r->c + first;
    double ones[PDI_PHASE_PIECE];
    int difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    for (int b = 0; b < count; b++) metal[b] = 0.0;
    for (int b = 0; b < count; b++) ones[b] = 1.0;
    for (int k = 0; k < r->stencil->count; k++) {
        const double *far = c + r->map.shift[k], weight = r->front.weight[k];
        const double *factor = r->factor ? r->factor + first + r->map.shift[k] : ones;
        const uint8_t *there = r->map.phase + first + r->map.shift[k];
        for (int b = 0; b < count; b++)
            metal[b] += there[b] == PDI_PHASE_SOLID ? weight * factor[b] * (difference ? far[b] - c[b] : 1.0) : 0.0;
    }
}

/* Those beside metal or wall also gain from the metal. */
static void pdi_corrode_shore(pd_corrode *r, int32_t first, int count, double dt)
{
    double diffusivity = r->desc.diffusivity, scale = pdi_corrode_scale(r);
    double spread[PDI_PHASE_PIECE], now[PDI_PHASE_PIECE], *metal = r->sum ? r->sum + first : now;
    if (r->desc.activation) memset(spread, 0, sizeof spread);
    else pdi_corrode_spread(r, r->c, first, count, spread);
    if (!r->sum) pdi_corrode_reach(r, first, count, metal);
    for (int at = 0, run; r->sum && (run = pdi_corrode_stale(metal, count, &at)) > 0; at += run)
        pdi_corrode_reach(r, first + at, run, metal + at);
    for (int b = 0; b < count; b++)
        r->next[first + b] =
            r->base[first + b] + dt * (diffusivity * spread[b] + r->speed[first + b] * scale * metal[b]);
}

/* Solid nodes: sum v b over the fluid in reach, times C_i - C_j where the drive is that. All but attacking fluid has
 * the speed 0. */
static void pdi_corrode_attack(const pd_corrode *r, int32_t first, int count, double *PD_RESTRICT loss)
{
    const double *c = r->c + first;
    int difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    for (int b = 0; b < count; b++) loss[b] = 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        const double *far = c + r->map.shift[k], *speed = r->speed + first + r->map.shift[k];
        double weight = r->front.weight[k];
        for (int b = 0; b < count; b++) loss[b] += speed[b] * (weight * (difference ? c[b] - far[b] : 1.0));
    }
}

static void pdi_corrode_exposed(pd_corrode *r, int32_t first, int count, double dt)
{
    double now[PDI_PHASE_PIECE], scale = pdi_corrode_scale(r);
    int kept = r->sum && r->desc.activation;
    double *loss = kept ? r->sum + first : now;
    if (!kept) pdi_corrode_attack(r, first, count, loss);
    for (int at = 0, run; kept && (run = pdi_corrode_stale(loss, count, &at)) > 0; at += run)
        pdi_corrode_attack(r, first + at, run, loss + at);
    for (int b = 0; b < count; b++)
        r->next[first + b] = r->base[first + b] - dt * scale * (r->factor ? loss[b] * r->factor[first + b] : loss[b]);
}

/* Values of ghosts: odd about `bulk` behind held planes. */
PDI_FN void pdi_corrode_ghosts(pd_corrode *r)
{
    for (int32_t g = 0; g < r->map.ghosts; g++) {
        int32_t at = r->map.ghost[g], from = r->map.source[g];
        r->c[at] = r->map.phase[at] == PDI_PHASE_HELD ? 2.0 * r->desc.bulk - r->c[from] : r->c[from];
        r->speed[at] = r->speed[from];
    }
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
    PDI_TRY(PDI_NEW(ctx, "corrode", r->stencil->line_first[r->stencil->kinds], r->line_shift));
    PDI_TRY(PDI_NEW(ctx, "corrode", r->stencil->count, r->scratch));
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->c));
    r->base = r->c;
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->next));
    PDI_TRY(PDI_NEW(ctx, "corrode", total, r->speed));
    if (r->desc.drive == PD_DRIVE_CONSTANT) PDI_TRY(PDI_NEW(ctx, "corrode", total, r->sum));
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
    for (int32_t g = 0; g < r->map.ghosts; g++) r->factor[r->map.ghost[g]] = r->factor[r->map.source[g]];
    return PD_OK;
}

/* Number of mechanical bonds of solid nodes, and where the last of them breaks. */
static pd_status pdi_corrode_bonds(pd_ctx *ctx, pd_corrode *r)
{
    const pd_stencil *s = r->stencil;
    int32_t pieces = pdi_phase_pieces(&r->map);
    int nt = pdi_par_threads(ctx, (int64_t)r->grid->solid_count * s->count);
    (void)nt;
    if (!r->desc.stochastic) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "corrode", r->grid->total, r->bonds));
    PDI_TRY(PDI_NEW(ctx, "corrode", r->grid->total, r->last));
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < pieces; p++) {
        int count;
        int32_t first = pdi_phase_place(&r->map, p, &count);
        for (int32_t i = first; i < first + count; i++) {
            int bonds = 0;
            if (r->map.phase[i] != PDI_PHASE_SOLID) continue;
            for (int k = 0; k < s->count; k++) bonds += r->map.phase[i + r->map.shift[k]] == PDI_PHASE_SOLID;
            r->bonds[i] = (uint16_t)bonds;
            r->last[i] = r->desc.saturation + (1.0 - pdi_damage_last(r->desc.seed, i, bonds)) * r->span;
        }
    }
    return PD_OK;
}

/* What images of node i add to its share [1/s]: behind held planes it counts once more, elsewhere not at all. */
PDI_FN double pdi_corrode_mirrored(const pd_corrode *r, int32_t i)
{
    double sum = 0.0;
    for (int k = 0; k < r->stencil->count && !pdi_phase_deep(&r->map, i); k++) {
        int32_t j = i + r->map.shift[k];
        int odd = r->map.phase[j] == PDI_PHASE_HELD || r->map.phase[j] == PDI_PHASE_NONE;
        if (pdi_grid_image(r->grid, j, NULL) == i) sum += odd ? r->stencil->lap[k] : -r->stencil->lap[k];
    }
    return r->desc.activation ? 0.0 : r->desc.diffusivity * sum;
}

static pd_status pdi_corrode_make(pd_ctx *ctx, pd_grid *grid, const pd_stencil *stencil, const pd_corrode_desc *desc,
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
    PDI_TRY(pdi_phase_build(ctx, grid, stencil, &r->map));
    for (int32_t i = 0; i < grid->total && r->sum; i++) r->sum[i] = -1.0;
    PDI_TRY(pdi_corrode_factors(ctx, r));
    pdi_grid_line_shift(grid, stencil, r->line_shift);
    for (int k = 0; k < stencil->count; k++) r->diffusion += desc->diffusivity * stencil->lap[k];
    for (int32_t b = 0; b < r->map.borders; b++) r->held = fmax(r->held, pdi_corrode_mirrored(r, r->map.border[b]));
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_SOLID) r->c[i] = desc->solid;
        else if (grid->kind[i] == PD_FLUID) r->c[i] = desc->activation ? desc->bulk : desc->initial;
    PDI_TRY(pdi_corrode_bonds(ctx, r));
    pd_corrode_open(r);
    return PD_OK;
}

pd_status pd_corrode_build(pd_ctx *ctx, pd_grid *grid, const pd_stencil *stencil, const pd_corrode_desc *desc,
                           pd_corrode *r)
{
    pd_status status = pdi_corrode_make(ctx, grid, stencil, desc, r);
    if (status < 0) pd_corrode_free(ctx, r);
    return status;
}

static double pdi_corrode_amount(const pd_corrode *r, uint8_t phase)
{
    pdi_sum sum = {0.0, 0.0};
    for (int32_t p = 0; p < pdi_phase_pieces(&r->map); p++) {
        int count;
        int32_t first = pdi_phase_place(&r->map, p, &count);
        for (int32_t i = first; i < first + count; i++)
            if (r->map.phase[i] == phase) pdi_sum_add(&sum, r->c[i]);
    }
    return pdi_sum_total(&sum) * r->stencil->volume;
}

double pd_corrode_solid(const pd_corrode *r) { return pdi_corrode_amount(r, PDI_PHASE_SOLID); }

double pd_corrode_dissolved(const pd_corrode *r) { return pdi_corrode_amount(r, PDI_PHASE_FLUID); }

double pd_corrode_damage(const pd_corrode *r, int32_t node)
{
    double expected = fmin((r->desc.solid - r->c[node]) / r->span, 1.0);
    if (r->map.phase[node] == PDI_PHASE_FLUID) return 1.0;
    if (r->map.phase[node] != PDI_PHASE_SOLID) return 0.0;
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
        if (r->map.role[i] == PDI_ROLE_SHORE && r->c[i] < r->desc.repassivation) r->film[i] = 1;
}

/* 1: there is a passive film in front of fluid node i. */
static int pdi_corrode_passive(const pd_corrode *r, int32_t i)
{
    return (r->desc.passive && r->desc.passive[i]) || (r->film && r->film[i]);
}

PDI_FN pd_status pdi_corrode_law(pd_ctx *ctx, const pd_corrode *r, double t, int32_t i, double c, double *speed)
{
    *speed = 0.0;
    if (pdi_corrode_passive(r, i)) return PD_OK;
    pd_rate_at at;
    at.c = c;
    at.t = t;
    pd_grid_position(r->grid, i, at.x);
    double v = r->desc.rate(r->desc.rate_user, &at);
    if (!(fabs(v) < 1e100)) {
        char place[PDI_GRID_PLACE];
        return pdi_fail(ctx, PD_ERR_STATE, "corrode",
                        "the rate law gives %g m/s at c = %g mol/m3 (node %d at %s m), expected less than 1e100", v,
                        c, (int)i, pdi_grid_place(r->grid, i, place));
    }
    *speed = fmax(v, 0.0);
    return PD_OK;
}

PDI_FN void pdi_corrode_course(const pd_corrode *r, double dt, double *error, double *fastest)
{
    *error = *fastest = 0.0;
    for (int32_t i = 0; i < r->grid->total && !r->desc.steady; i++) {
        pd_rate_at at;
        double v[5], most = 0.0, least = HUGE_VAL;
        if (r->map.role[i] != PDI_ROLE_SHORE) continue;
        pd_grid_position(r->grid, i, at.x);
        at.c = fmin(fmax(r->c[i], 0.0), r->desc.saturation);
        for (int k = 0; k < 5; k++) {
            at.t = r->time + 0.25 * k * dt;
            v[k] = fmax(r->desc.rate(r->desc.rate_user, &at), 0.0);
            most = fmax(most, v[k]);
            least = fmin(least, v[k]);
        }
        for (int k = 0; k < 2; k++) *error = fmax(*error, fabs(0.5 * (v[k] + v[4 - k]) - v[2]));
        if (most > least) *fastest = fmax(*fastest, most);
    }
}

/* Under activation control: the metal in reach of fluid node i loses otherwise than before. */
static void pdi_corrode_alarm(pd_corrode *r, int32_t i)
{
    if (!r->sum || !r->desc.activation) return;
    int deep = pdi_phase_deep(&r->map, i);
    r->alarmed = 1;
    for (int k = 0; k < r->stencil->count; k++) {
        int32_t j = i + r->map.shift[k];
        if (r->map.phase[j] == PDI_PHASE_SOLID) r->sum[pdi_phase_home(&r->map, deep, j)] = -1.0;
    }
}

/* Speeds at the fluid nodes first .. end-1 beside the front, *c and *law: what the law gave last. The salt layer is
 * nothing but a look at c. */
static pd_status pdi_corrode_speeds(pd_ctx *ctx, pd_corrode *r, int32_t first, int32_t end, double *c, double *law)
{
    for (int32_t i = first; i < end; i++) {
        double speed = 0.0;
        if (r->c[i] < r->desc.saturation && !pdi_corrode_passive(r, i)) {
            int other = r->c[i] < *c || r->c[i] > *c || !r->desc.uniform;
            if (other) PDI_TRY(pdi_corrode_law(ctx, r, r->time + r->ahead, i, r->c[i], law));
            *c = r->c[i];
            speed = *law;
        }
        if (speed > r->fastest) r->fastest = speed;
        if (speed < r->speed[i] || speed > r->speed[i]) pdi_corrode_alarm(r, i);
        r->speed[i] = speed;
    }
    return PD_OK;
}

/* Speed of the law at every fluid node beside the front, and how many nodes take part. Metal sees no fluid of another
 * role. */
PDI_FN pd_status pdi_corrode_prepare(pd_ctx *ctx, pd_corrode *r)
{
    pdi_phase_walk walk = {0, 0, 0};
    int32_t i, end;
    double c = -1.0, law = 0.0;
    r->fastest = 0.0;
    r->active = 0;
    r->alarmed = r->desc.activation && r->sum ? 0 : 1;
    for (int32_t n = 0; n < r->changed_count && r->desc.activation; n++) pdi_corrode_rinse(r, r->changed[n]);
    pdi_corrode_repassivate(r);
    while (pdi_phase_next(&r->map, &walk, &i, &end)) {
        uint8_t role = r->map.role[i];
        if (role > PDI_ROLE_WHOLE || (role == PDI_ROLE_WHOLE && !r->desc.activation)) r->active += end - i;
        if (role == PDI_ROLE_SHORE) PDI_TRY(pdi_corrode_speeds(ctx, r, i, end, &c, &law));
    }
    /* where sums are kept, ghosts tell nothing but speeds */
    if (r->alarmed) pdi_corrode_ghosts(r);
    return PD_OK;
}

/* What bonds to held ghosts take from node i [mol/m3/s]. */
static double pdi_corrode_leak(const pd_corrode *r, int32_t i)
{
    int solid = r->map.phase[i] == PDI_PHASE_SOLID, difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    double sum = 0.0, scale = solid ? pdi_corrode_scale(r) : r->desc.activation ? 0.0 : r->desc.diffusivity;
    if (r->map.phase[i] == PDI_PHASE_NONE || r->map.role[i] == PDI_ROLE_IDLE || !(scale > 0.0)) return 0.0;
    for (int k = 0; k < r->stencil->count; k++) {
        int32_t j = i + r->map.shift[k];
        double step = r->c[i] - r->c[j];
        if (r->map.phase[j] != PDI_PHASE_HELD) continue;
        if (solid) sum += r->speed[j] * (r->front.weight[k] * (difference ? step : 1.0));
        else sum += r->stencil->lap[k] * step;
    }
    if (solid && r->factor) sum *= r->factor[i];
    return scale * sum;
}

/* Solid nodes at their end turn fluid; sums of nodes in their reach are not known any more. */
static void pdi_corrode_turn(pd_corrode *r)
{
    for (int32_t n = 0; n < r->changed_count; n++) pdi_grid_dissolve(r->grid, r->changed[n]);
    pdi_phase_turn(&r->map, r->changed, r->changed_count);
    for (int32_t n = 0; n < r->changed_count && r->sum; n++) {
        int deep = pdi_phase_deep(&r->map, r->changed[n]);
        r->sum[r->changed[n]] = -1.0;
        for (int k = 0; k < r->stencil->count; k++)
            r->sum[pdi_phase_home(&r->map, deep, r->changed[n] + r->map.shift[k])] = -1.0;
    }
}

/* Weights of the bonds of node i that lead to metal that does not turn (dry), or to attacking fluid that holds some. */
static double pdi_corrode_behind(const pd_corrode *r, int32_t i, int dry, double *weight)
{
    double sum = 0.0;
    int deep = pdi_phase_deep(&r->map, i);
    for (int k = 0; k < r->stencil->count; k++) {
        int32_t j = i + r->map.shift[k];
        int32_t at = pdi_phase_home(&r->map, deep, j);
        int metal = r->map.phase[j] == PDI_PHASE_SOLID && r->next[at] > pdi_corrode_end(r, at);
        int fluid = r->map.phase[j] == PDI_PHASE_FLUID && r->next[at] > 0.0;
        weight[k] = r->front.weight[k] * (dry ? metal : fluid ? r->speed[at] : 0.0);
        sum += weight[k];
    }
    return sum;
}

/* Metal node i, drained to its end by another one, turns with it. The list stays in order. */
static void pdi_corrode_drained(pd_corrode *r, int32_t i)
{
    int32_t at = r->changed_count;
    while (at > 0 && r->changed[at - 1] > i) at--;
    if (at > 0 && r->changed[at - 1] == i) return; /* it turned, and had been given rounding more than its end */
    memmove(r->changed + at + 1, r->changed + at, (size_t)(r->changed_count++ - at) * sizeof *r->changed);
    r->changed[at] = i;
}

/* Node i takes up to `deficit` from those, in proportion to their weights, and no more than metal has above its end or
 * fluid at all. What is left goes round until it is covered or none has any. Returns it. */
static double pdi_corrode_collect(pd_corrode *r, int32_t i, int dry, double deficit)
{
    double sum, left = deficit;
    int deep = pdi_phase_deep(&r->map, i);
    while (left > 0.0 && (sum = pdi_corrode_behind(r, i, dry, r->scratch)) > 0.0) {
        double given = 0.0;
        int exhausted = 0;
        for (int k = 0; k < r->stencil->count; k++) {
            double part = left * (r->scratch[k] / sum);
            int32_t at = pdi_phase_home(&r->map, deep, i + r->map.shift[k]);
            double *from = &r->next[at], keep = dry ? pdi_corrode_end(r, at) : 0.0;
            if (!(part > 0.0) || !(*from > keep)) continue; /* several bonds may end on one node */
            if (part >= *from - keep) {
                part = *from - keep;
                *from = keep;
                exhausted = 1;
                if (dry) pdi_corrode_drained(r, at);
            } else *from -= part;
            given += part;
        }
        r->next[i] += given;
        left = exhausted ? left - given : 0.0;
    }
    return left;
}

/* Metal in the reach of node i takes what that has above its end, in proportion to the weights, none more than whole
 * metal has. Nodes that turn in the next step take nothing: hand-over within a layer would roughen the front. What is
 * left goes round, and stays where nobody takes it. */
static void pdi_corrode_pass_on(pd_corrode *r, int32_t i)
{
    double left = r->next[i] - pdi_corrode_end(r, i);
    int deep = pdi_phase_deep(&r->map, i), full = 1;
    while (left > 0.0 && full) {
        double sum = 0.0, given = 0.0;
        full = 0;
        for (int k = 0; k < r->stencil->count; k++) {
            int32_t j = i + r->map.shift[k], at = pdi_phase_home(&r->map, deep, j);
            int metal = r->map.phase[j] == PDI_PHASE_SOLID && r->map.role[at] == PDI_ROLE_EXPOSED;
            int takes = metal && r->next[at] < r->desc.solid &&
                        r->next[at] - pdi_corrode_end(r, at) > r->base[at] - r->next[at];
            r->scratch[k] = takes ? r->front.weight[k] : 0.0;
            sum += r->scratch[k];
        }
        if (!(sum > 0.0)) break;
        for (int k = 0; k < r->stencil->count; k++) {
            int32_t at = pdi_phase_home(&r->map, deep, i + r->map.shift[k]);
            double part = left * (r->scratch[k] / sum), room = r->desc.solid - r->next[at];
            if (!(part > 0.0)) continue;
            full |= part >= room;
            part = part < room ? part : fmax(room, 0.0);
            r->next[at] = part < room ? r->next[at] + part : r->desc.solid;
            given += part;
        }
        left = full ? left - given : 0.0;
    }
    r->next[i] = pdi_corrode_end(r, i) + fmax(left, 0.0);
}

/* Nodes that turn before their end pass on what they have above it; those that cannot do not turn yet. */
static void pdi_corrode_advance(pd_corrode *r)
{
    int32_t turning = 0;
    for (int32_t n = 0; n < r->changed_count; n++) {
        int32_t i = r->changed[n];
        if (r->next[i] > pdi_corrode_end(r, i)) pdi_corrode_pass_on(r, i);
        if (r->next[i] <= pdi_corrode_end(r, i)) r->changed[turning++] = i;
    }
    r->changed_count = turning;
}

/* What a node that turns has lost below its end, the metal behind it makes up for. Without any, the fluid that has
 * taken it gives it back, as far as it still has it. Returns the share of the step after which a node that is below
 * zero all the same would have half of Csat. */
static double pdi_corrode_hand_over(pd_corrode *r)
{
    double least = 1.0, half = 0.5 * r->desc.saturation;
    for (int32_t i = 0; i < r->grid->total; i++) /* those that have no part in the step may have to give */
        if (r->map.role[i] == PDI_ROLE_IDLE) r->next[i] = r->c[i];
    for (int32_t n = 0; n < r->changed_count; n++) {
        int32_t i = r->changed[n];
        double lowest = r->next[i], left = pdi_corrode_collect(r, i, 1, pdi_corrode_end(r, i) - lowest);
        while (r->changed[n] != i) n++; /* the list may have grown before it */
        left = pdi_corrode_collect(r, i, 0, left);
        if (left > 0.0 && r->next[i] < -PDI_CORRODE_ROUNDING * r->desc.saturation && r->base[i] > half)
            least = fmin(least, (r->base[i] - half) / (r->base[i] - lowest));
    }
    return least;
}

/* Metal turns at its end or, where the field at the start of the step is kept, at the end of the step that is closest
 * to that. */
PDI_FN double pdi_corrode_spare(pd_corrode *r)
{
    r->changed_count = 0;
    for (int32_t p = 0; p < pdi_phase_pieces(&r->map); p++) {
        int count;
        int32_t first = pdi_phase_place(&r->map, p, &count);
        for (int32_t i = first; i < first + count; i++) {
            if (r->map.role[i] != PDI_ROLE_EXPOSED) continue;
            double half = r->base == r->c ? 0.0 : 0.5 * (r->base[i] - r->next[i]);
            if (r->next[i] - half <= pdi_corrode_end(r, i)) r->changed[r->changed_count++] = i;
        }
    }
    pdi_corrode_advance(r);
    return r->changed_count && !r->desc.keep_deficit ? pdi_corrode_hand_over(r) : 1.0;
}

/* Metal without a part in the step has what it has left after it gave some to nodes that turn. */
static void pdi_corrode_given(pd_corrode *r)
{
    for (int32_t n = 0; n < r->changed_count && !r->desc.keep_deficit; n++) {
        int deep = pdi_phase_deep(&r->map, r->changed[n]);
        for (int k = 0; k < r->stencil->count; k++) {
            int32_t at = pdi_phase_home(&r->map, deep, r->changed[n] + r->map.shift[k]);
            if (r->map.role[at] == PDI_ROLE_IDLE && r->map.phase[at] == PDI_PHASE_SOLID) r->c[at] = r->next[at];
        }
    }
}

PDI_FN void pdi_corrode_commit(pd_corrode *r, double dt)
{
    pdi_phase_walk walk = {0, 0, 0}, again = {0, 0, 0};
    int32_t i, end;
    pdi_sum out;
    out.sum = r->out;
    out.carry = r->out_carry;
    for (int32_t b = 0; b < r->map.borders; b++)
        pdi_sum_add(&out, dt * r->stencil->volume * pdi_corrode_leak(r, r->map.border[b]));
    r->out = out.sum;
    r->out_carry = out.carry;
    while (pdi_phase_next(&r->map, &walk, &i, &end)) {
        uint8_t role = r->map.role[i];
        if (role == PDI_ROLE_IDLE || (role == PDI_ROLE_WHOLE && r->desc.activation)) continue;
        memcpy(r->c + i, r->next + i, (size_t)(end - i) * sizeof *r->c);
    }
    pdi_corrode_given(r);
    while (r->desc.activation && pdi_phase_next(&r->map, &again, &i, &end))
        for (int32_t j = i; j < end && r->map.role[i] == PDI_ROLE_SHORE; j++) pdi_corrode_rinse(r, j);
    if (r->changed_count) pdi_corrode_turn(r);
    r->time += dt;
    r->steps++;
}

PDI_FN void pdi_corrode_sweep(const pd_ctx *ctx, const pd_corrode *r, pdi_corrode_run_fn run, void *user)
{
    int32_t pieces = pdi_phase_pieces(&r->map);
    pdi_par_watch watch;
    int nt = pdi_par_begin(ctx, r->active * r->stencil->count, 1, (uint64_t)(uintptr_t)run, &watch);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < pieces; p++) {
        int count;
        int32_t first = pdi_phase_place(&r->map, p, &count), end = first + count, next;
        for (int32_t i = first; i < end; i = next) {
            next = pdi_phase_same(&r->map, i, end);
            if (r->map.role[i] != PDI_ROLE_IDLE) run(user, i, (int)(next - i));
        }
    }
    pdi_par_end(ctx, &watch);
}

/* The operands of an exchange. */
typedef struct pdi_corrode_exchanging {
    pd_corrode *corrode;
    double dt; /* [s] */
} pdi_corrode_exchanging;

static void pdi_corrode_exchange_run(void *user, int32_t first, int count)
{
    const pdi_corrode_exchanging *e = (const pdi_corrode_exchanging *)user;
    uint8_t role = e->corrode->map.role[first];
    if (role == PDI_ROLE_WHOLE && !e->corrode->desc.activation) pdi_corrode_whole(e->corrode, first, count, e->dt);
    if (role == PDI_ROLE_SHORE) pdi_corrode_shore(e->corrode, first, count, e->dt);
    if (role == PDI_ROLE_EXPOSED) pdi_corrode_exposed(e->corrode, first, count, e->dt);
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
        if (r->map.role[i] == PDI_ROLE_EXPOSED) most = fmax(most, r->base[i] - r->next[i]);
    return most / r->span;
}

PDI_FN pd_status pdi_corrode_store(pd_ctx *ctx, pd_corrode *r, pd_archive *archive)
{
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.c", r->c, r->grid->total));
    if (r->film) PDI_TRY(PDI_KEEP(ctx, archive, "corrode.film", r->film, r->grid->total));
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.time", &r->time, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.start", &r->start, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.out", &r->out, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.out_carry", &r->out_carry, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.steps", &r->steps, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.changed_count", &r->changed_count, 1));
    if (r->changed_count < 0 || r->changed_count > r->changed_capacity)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "'%s' has %d nodes turn fluid, expected 0 to %d",
                        archive->name, (int)r->changed_count, (int)r->changed_capacity);
    PDI_TRY(PDI_KEEP(ctx, archive, "corrode.changed", r->changed, r->changed_count));
    if (archive->reading) pdi_phase_read(&r->map);
    for (int32_t i = 0; i < r->grid->total && r->sum && archive->reading; i++) r->sum[i] = -1.0;
    return PD_OK;
}

void pd_corrode_free(pd_ctx *ctx, pd_corrode *r)
{
    int32_t total = r->grid ? r->grid->total : 0;
    pdi_phase_free(ctx, &r->map);
    pd_front_free(ctx, &r->front);
    PDI_DELETE(ctx, r->stencil ? r->stencil->line_first[r->stencil->kinds] : 0, r->line_shift);
    PDI_DELETE(ctx, r->stencil ? r->stencil->count : 0, r->scratch);
    PDI_DELETE(ctx, total, r->c);
    PDI_DELETE(ctx, total, r->next);
    PDI_DELETE(ctx, total, r->speed);
    PDI_DELETE(ctx, total, r->factor);
    PDI_DELETE(ctx, total, r->bonds);
    PDI_DELETE(ctx, total, r->last);
    PDI_DELETE(ctx, total, r->film);
    PDI_DELETE(ctx, total, r->sum);
    PDI_DELETE(ctx, r->changed_capacity, r->changed);
    memset(r, 0, sizeof *r);
}
