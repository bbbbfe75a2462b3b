/* limiter: see limiter.h */
#include "limiter.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* One piece of a sweep: the nodes i .. i+count-1, which are the rows from `row` (-1: whole families). */
typedef struct pdi_limiter_piece {
    const double *c; /* [mol/m3] of these nodes */
    int32_t i, row;
    int count;
    double gate[PDI_LANES]; /* 1.0: the bond is open, 0.0: it is not */
    double bend[PDI_LANES]; /* [mol/m5] sum of the weighted steps */
    double size[PDI_LANES]; /* [mol/m5] sum of their sizes */
} pdi_limiter_piece;

/* The gradient of the node needs the moments of its open bonds: some of the others see no held value. */
static int pdi_limiter_cut(const pd_limiter *l, int32_t i)
{
    const pd_diffusion *f = l->diffusion;
    return f->cut[i] > 0.0f && !(f->hold && f->hold[i] > 0.0 && !f->hold_part[i]);
}

/* Which of the rows have bond k open; 0: none. */
static int pdi_limiter_gates(const pd_bonds *bonds, pdi_limiter_piece *p, int k)
{
    pdi_lanes open = pdi_bond_open_lanes(bonds, p->row, k, p->count, p->gate);
    for (int b = 0; b < p->count && open == PDI_LANES_ALL; b++) p->gate[b] = 1.0;
    return open != PDI_LANES_NONE;
}

/* What held walls add to the sums and to the gradient of a node, or the moments of its open bonds (eq. 3.5). */
static void pdi_limiter_walls(const pd_limiter *l, pdi_limiter_piece *p, int b)
{
    const pd_diffusion *f = l->diffusion;
    const pd_bonds *bonds = l->bonds;
    int32_t i = p->i + b;
    int64_t total = bonds->grid->total;
    double c = p->c[b], value = f->field ? f->field[i] : f->desc.diffusivity, sum[PD_DIM], *slope = l->slope + i;
    if (f->hold && f->hold[i] > 0.0) {
        double step = (f->drive[i] - f->hold[i] * c) / value;
        p->bend[b] += step;
        p->size[b] += fabs(step);
    }
    if (!(f->cut[i] > 0.0f)) return;
    if (!pdi_limiter_cut(l, i)) {
        for (int d = 0; d < PD_DIM; d++)
            slope[d * total] += f->hold_grad[d * total + i] - f->hold_lean[d * total + i] * c;
        return;
    }
    const double *moment = bonds->moment + (int64_t)(p->row + b) * PD_DIM * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) sum[d] = slope[d * total] * bonds->norm[d];
    for (int d = 0; d < PD_DIM; d++) {
        slope[d * total] = 0.0;
        for (int e = 0; e < PD_DIM; e++) slope[d * total] += moment[d * PD_DIM + e] * sum[e];
    }
}

/* The share that the sums leave (eq. 5.4). */
static inline double pdi_limiter_share(double bend, double size, double floor_size)
{
    double below = size + floor_size, ratio = below > 0.0 ? (fabs(bend) + floor_size) / below : 1.0;
    return 1.0 - ratio * ratio * ratio * ratio;
}

/* Whole families of PDI_BLOCK nodes: a bond and its opposite one at once. */
static void pdi_limiter_block(const pd_limiter *l, const double *PD_RESTRICT c, int32_t i, double least)
{
    const pd_stencil *s = l->bonds->stencil;
    int64_t total = l->bonds->grid->total;
    double bend[PDI_BLOCK], size[PDI_BLOCK], slope[PD_DIM][PDI_BLOCK];
    double *PD_RESTRICT keep = l->keep + i, *PD_RESTRICT out = l->slope + i, floor_size = least * s->lap_sum;
    memset(bend, 0, sizeof bend);
    memset(size, 0, sizeof size);
    memset(slope, 0, sizeof slope);
    for (int k = 0; k < s->count / 2; k++) {
        const double *ahead = c + l->bonds->shift[k], *behind = c - l->bonds->shift[k], *g = s->grad + k * PD_DIM;
        double a = s->lap[k];
        for (int b = 0; b < PDI_BLOCK; b++) {
            double p = a * (ahead[b] - c[b]), q = a * (behind[b] - c[b]);
            bend[b] += p + q;
            size[b] += fabs(p) + fabs(q);
            for (int d = 0; d < PD_DIM; d++) slope[d][b] += g[d] * (ahead[b] - behind[b]);
        }
    }
    for (int b = 0; b < PDI_BLOCK; b++) keep[b] = pdi_limiter_share(bend[b], size[b], floor_size);
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < PDI_BLOCK; b++) out[d * total + b] = slope[d][b];
}

/* Rows, and runs shorter than a block. */
static void pdi_limiter_lanes(const pd_limiter *l, pdi_limiter_piece *p, double least)
{
    const pd_bonds *bonds = l->bonds;
    const pd_stencil *s = bonds->stencil;
    int64_t total = bonds->grid->total;
    double *slope = l->slope + p->i, *keep = l->keep + p->i, floor_size = least * s->lap_sum;
    for (int b = 0; b < p->count; b++) {
        p->bend[b] = p->size[b] = 0.0;
        p->gate[b] = 1.0;
        for (int d = 0; d < PD_DIM; d++) slope[d * total + b] = 0.0;
    }
    for (int k = 0; k < s->count; k++) {
        const double *far = p->c + bonds->shift[k], *g = s->grad + k * PD_DIM;
        if (p->row >= 0 && !pdi_limiter_gates(bonds, p, k)) continue;
        for (int b = 0; b < p->count; b++) {
            double step = p->gate[b] * (far[b] - p->c[b]), part = s->lap[k] * step;
            p->bend[b] += part;
            p->size[b] += fabs(part);
            for (int d = 0; d < PD_DIM; d++) slope[d * total + b] += g[d] * step;
        }
    }
    for (int b = 0; b < p->count && p->row >= 0; b++) pdi_limiter_walls(l, p, b);
    for (int b = 0; b < p->count; b++) keep[b] = pdi_limiter_share(p->bend[b], p->size[b], floor_size);
}

/* Node `at` of the list beside ports. Outlets show the value of the node; inlets are no part of the moments of eq.
 * 3.5. */
static void pdi_limiter_port(const pd_limiter *l, int32_t at, const double *c, double least)
{
    const pd_stencil *s = l->bonds->stencil;
    int32_t i = l->ports->node[at];
    const int32_t *far = l->ports->far + (int64_t)at * s->count;
    int64_t total = l->bonds->grid->total;
    double slope[PD_DIM] = {0.0};
    int cut = pdi_limiter_cut(l, i);
    pdi_limiter_piece p;
    p.c = c + i;
    p.i = i;
    p.row = l->bonds->row[i];
    p.count = 1;
    p.bend[0] = p.size[0] = 0.0;
    for (int k = 0; k < s->count; k++) {
        double step = c[far[k]] - c[i], part = s->lap[k] * step;
        p.bend[0] += part;
        p.size[0] += fabs(part);
        if (cut && l->bonds->grid->kind[far[k]] == PD_INLET) continue;
        for (int d = 0; d < PD_DIM; d++) slope[d] += s->grad[k * PD_DIM + d] * step;
    }
    for (int d = 0; d < PD_DIM; d++) l->slope[d * total + i] = slope[d];
    if (p.row >= 0) pdi_limiter_walls(l, &p, 0);
    l->keep[i] = pdi_limiter_share(p.bend[0], p.size[0], least * s->lap_sum);
}

/* The operands of a sweep. */
typedef struct pdi_limiter_sweep {
    const pd_limiter *limiter;
    const double *c; /* [mol/m3] */
    double least;    /* [mol/m3] */
} pdi_limiter_sweep;

static void pdi_limiter_blocks(const pdi_limiter_sweep *s, int32_t i, int32_t length)
{
    int count;
    for (int32_t at = 0; at < length; at += count) {
        count = pdi_bond_block(length, &at);
        pdi_limiter_block(s->limiter, s->c + i + at, i + at, s->least);
    }
}

static void pdi_limiter_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_limiter_sweep *s = (const pdi_limiter_sweep *)user;
    pdi_limiter_piece p;
    int32_t part;
    int beside;
    for (int32_t begin = 0; begin < length; begin += part) {
        part = pdi_port_segment(s->limiter->bonds, i + begin, length - begin, &beside);
        if (beside) continue;
        if (row < 0 && part >= PDI_BLOCK) {
            pdi_limiter_blocks(s, i + begin, part);
            continue;
        }
        for (int32_t at = 0; at < part; at += p.count) {
            p.count = pdi_bond_piece(part, PDI_LANES, &at);
            p.i = i + begin + at;
            p.row = row < 0 ? row : row + begin + at;
            p.c = s->c + p.i;
            pdi_limiter_lanes(s->limiter, &p, s->least);
        }
    }
}

PDI_FN void pdi_limiter_update(const pd_ctx *ctx, pd_limiter *l, const double *c, double least)
{
    const pd_bonds *bonds = l->bonds;
    pdi_limiter_sweep s;
    s.limiter = l;
    s.c = c;
    s.least = least;
    pdi_bond_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 4, 0, pdi_limiter_run, &s);
    int nt = pdi_par_threads(ctx, (int64_t)l->ports->count * bonds->stencil->count * PDI_PORT_WORK);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < l->ports->count; p++) pdi_limiter_port(l, p, c, least);
    for (int32_t k = bonds->ghosts.count; k < bonds->ghosts.listed; k++) l->keep[bonds->ghosts.node[k]] = 1.0;
    pd_ghosts_scalar(&bonds->ghosts, l->keep);
    pd_ghosts_vector(&bonds->ghosts, l->slope);
}

PDI_FN pd_status pdi_limiter_build(pd_ctx *ctx, const pd_diffusion *diffusion, const pd_ports *ports,
                                   pd_limiter *l)
{
    int64_t total = diffusion->bonds->grid->total;
    memset(l, 0, sizeof *l);
    l->bonds = diffusion->bonds;
    l->ports = ports;
    l->diffusion = diffusion;
    PDI_TRY(PDI_NEW(ctx, "limiter", PD_DIM * total, l->slope));
    return PDI_NEW(ctx, "limiter", total, l->keep);
}

PDI_FN void pdi_limiter_free(pd_ctx *ctx, pd_limiter *l)
{
    int64_t total = l->bonds ? l->bonds->grid->total : 0;
    PDI_DELETE(ctx, PD_DIM * total, l->slope);
    PDI_DELETE(ctx, total, l->keep);
    memset(l, 0, sizeof *l);
}
