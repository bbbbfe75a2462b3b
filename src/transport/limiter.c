/* limiter: see limiter.h */
#include "transport/limiter.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* One piece of a sweep: the nodes i .. i+count-1, which are the rows from `row` (-1: whole families). */
typedef struct pdi_limiter_piece {
    const double *c; /* [mol/m3] of these nodes */
    const double *x; /* [mol/m3] direction of a derivative there; NULL: none is asked for */
    int32_t i, row;
    int count;
    double gate[PDI_BLOCK]; /* 1.0: the bond is open, 0.0: it is not */
    double bend[PDI_BLOCK]; /* [mol/m5] sum of the weighted steps */
    double size[PDI_BLOCK]; /* [mol/m5] sum of their sizes */
    double bend_by[PDI_BLOCK], size_by[PDI_BLOCK]; /* derivatives of both along x */
} pdi_limiter_piece;

/* The operands of a sweep. */
typedef struct pdi_limiter_sweep {
    const pd_limiter *limiter;
    const double *c;     /* [mol/m3] */
    const double *x;     /* [mol/m3] direction of a derivative, or NULL */
    double least;        /* [mol/m3] */
    double *factor, *slope; /* results, or their derivatives along x */
} pdi_limiter_sweep;

PDI_FN int pdi_limiter_cut(const pd_limiter *l, int32_t i)
{
    const pd_diffusion *f = l->diffusion;
    int32_t place = f->place[i];
    return place >= 0 && !(f->wall_rate && f->wall_rate[i] > 0.0 && !f->wall_part[place]);
}

/* Which of the rows have bond k open; 0: none. */
static int pdi_limiter_gates(const pd_bonds *bonds, pdi_limiter_piece *p, int k)
{
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    pdi_bond_openness open = pdi_bond_find_nodes_open(bonds, p->row, k, p->count, &gate, p->gate);
    for (int b = 0; b < p->count && open == PDI_BOND_OPEN_ALL; b++) p->gate[b] = 1.0;
    return open != PDI_BOND_OPEN_NONE;
}

/* The derivative of the size of a step: none at zero. */
static inline double pdi_limiter_size_by(double step, double step_by)
{
    return step > 0.0 ? step_by : step < 0.0 ? -step_by : 0.0;
}

/* What held walls add to the sums and to the gradient of a node, or the moments of its open bonds (eq. 2.9). */
static void pdi_limiter_walls(const pdi_limiter_sweep *s, pdi_limiter_piece *p, int b)
{
    const pd_limiter *l = s->limiter;
    const pd_diffusion *f = l->diffusion;
    const pd_bonds *bonds = l->bonds;
    int32_t i = p->i + b;
    int64_t total = bonds->grid->total;
    double c = p->c[b], value = f->field ? f->field[i] : f->desc.diffusivity, sum[PD_DIM], *slope = s->slope + i;
    if (f->wall_rate && f->wall_rate[i] > 0.0) {
        double step = (pdi_diffusion_given(f, i) - f->wall_rate[i] * c) / value;
        p->bend[b] += step;
        p->size[b] += fabs(step);
        if (p->x) {
            double step_by = -f->wall_rate[i] * p->x[b] / value;
            p->bend_by[b] += step_by;
            p->size_by[b] += pdi_limiter_size_by(step, step_by);
        }
    }
    int64_t place = f->place[i];
    if (place < 0) return;
    if (!pdi_limiter_cut(l, i)) {
        for (int d = 0; d < PD_DIM; d++) {
            double rate = f->wall_grad_rate[place * PD_DIM + d];
            slope[d * total] += p->x ? -rate * p->x[b] : f->wall_grad[place * PD_DIM + d] - rate * c;
        }
        return;
    }
    const double *moment = bonds->inverse_moment + (int64_t)(p->row + b) * PD_DIM * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) sum[d] = slope[d * total] * bonds->full_moment[d];
    for (int d = 0; d < PD_DIM; d++) {
        slope[d * total] = 0.0;
        for (int e = 0; e < PD_DIM; e++) slope[d * total] += moment[d * PD_DIM + e] * sum[e];
    }
}

/* The share that the sums leave (eq. 6.15). */
static inline double pdi_limiter_factor(double bend, double size, double floor_size)
{
    double below = size + floor_size, ratio = below > 0.0 ? (fabs(bend) + floor_size) / below : 1.0;
    return 1.0 - ratio * ratio * ratio * ratio;
}

/* Its derivative, with those of the sums. */
static inline double pdi_limiter_factor_by(double bend, double size, double bend_by, double size_by, double floor_size)
{
    double below = size + floor_size, ratio = below > 0.0 ? (fabs(bend) + floor_size) / below : 0.0;
    double by = pdi_limiter_size_by(bend, bend_by) - ratio * size_by;
    return below > 0.0 ? -4.0 * ratio * ratio * ratio * by / below : 0.0;
}

/* Whole families of PDI_BLOCK nodes: a bond and its opposite one at once. Compiled for values and for derivatives. */
PDI_INLINE void pdi_limiter_block(const pdi_limiter_sweep *of, int32_t i, int by)
{
    const pd_bonds *bonds = of->limiter->bonds;
    const pd_stencil *s = bonds->stencil;
    int64_t total = bonds->grid->total;
    double bend[PDI_BLOCK], size[PDI_BLOCK], bend_by[PDI_BLOCK], size_by[PDI_BLOCK], slope[PD_DIM][PDI_BLOCK];
    const double *PD_RESTRICT c = of->c + i, *PD_RESTRICT x = by ? of->x + i : c;
    double *PD_RESTRICT factor = of->factor + i, *PD_RESTRICT out = of->slope + i, floor_size = of->least * s->lap_sum;
    memset(bend, 0, sizeof bend);
    memset(size, 0, sizeof size);
    memset(bend_by, 0, sizeof bend_by);
    memset(size_by, 0, sizeof size_by);
    memset(slope, 0, sizeof slope);
    for (int k = 0; k < s->count / 2; k++) {
        int32_t shift = bonds->paths.shift[k];
        const double *ahead = c + shift, *behind = c - shift, *x_ahead = x + shift, *x_behind = x - shift;
        const double *g = s->gradient_weight + k * PD_DIM;
        double a = s->laplacian_weight[k];
        for (int b = 0; b < PDI_BLOCK; b++) {
            double p = a * (ahead[b] - c[b]), q = a * (behind[b] - c[b]);
            bend[b] += p + q;
            size[b] += fabs(p) + fabs(q);
            if (by) {
                double p_by = a * (x_ahead[b] - x[b]), q_by = a * (x_behind[b] - x[b]);
                bend_by[b] += p_by + q_by;
                size_by[b] += pdi_limiter_size_by(p, p_by) + pdi_limiter_size_by(q, q_by);
            }
            for (int d = 0; d < PD_DIM; d++) slope[d][b] += g[d] * (x_ahead[b] - x_behind[b]);
        }
    }
    for (int b = 0; b < PDI_BLOCK; b++)
        factor[b] = by ? pdi_limiter_factor_by(bend[b], size[b], bend_by[b], size_by[b], floor_size)
                      : pdi_limiter_factor(bend[b], size[b], floor_size);
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < PDI_BLOCK; b++) out[d * total + b] = slope[d][b];
}

/* Steps along bond k of the nodes of a piece, of c or of x, where it is open. */
static inline void pdi_limiter_add(pdi_limiter_piece *p, const double *far_c, const double *far_x, double lap,
                                   const double *g, int64_t total, double *slope)
{
    for (int b = 0; b < p->count; b++) {
        double step = p->gate[b] * (far_c[b] - p->c[b]), part = lap * step;
        p->bend[b] += part;
        p->size[b] += fabs(part);
        if (p->x) {
            step = p->gate[b] * (far_x[b] - p->x[b]);
            p->bend_by[b] += lap * step;
            p->size_by[b] += pdi_limiter_size_by(part, lap * step);
        }
        for (int d = 0; d < PD_DIM; d++) slope[d * total + b] += g[d] * step;
    }
}

static void pdi_limiter_piece_start(const pdi_limiter_sweep *s, int32_t i, int32_t row, int count,
                                    pdi_limiter_piece *p)
{
    p->c = s->c + i;
    p->x = s->x ? s->x + i : NULL;
    p->i = i;
    p->row = row;
    p->count = count;
    for (int b = 0; b < count; b++) {
        p->bend[b] = p->size[b] = p->bend_by[b] = p->size_by[b] = 0.0;
        p->gate[b] = 1.0;
        for (int d = 0; d < PD_DIM; d++) s->slope[d * (int64_t)s->limiter->bonds->grid->total + i + b] = 0.0;
    }
}

static void pdi_limiter_piece_end(const pdi_limiter_sweep *s, pdi_limiter_piece *p)
{
    double floor_size = s->least * s->limiter->bonds->stencil->lap_sum, *factor = s->factor + p->i;
    for (int b = 0; b < p->count && p->row >= 0; b++) pdi_limiter_walls(s, p, b);
    for (int b = 0; b < p->count; b++)
        factor[b] = p->x ? pdi_limiter_factor_by(p->bend[b], p->size[b], p->bend_by[b], p->size_by[b], floor_size)
                        : pdi_limiter_factor(p->bend[b], p->size[b], floor_size);
}

/* Rows, runs shorter than a block, and (compiled for these) single nodes at `place` of the list beside inlets and
 * outlets. Outlets show the value of the node; inlets are no part of the moments of eq. 2.9. */
PDI_INLINE_HOT void pdi_limiter_bonds(const pdi_limiter_sweep *of, int32_t i, int32_t row, int32_t place, int count)
{
    const pd_limiter *l = of->limiter;
    const pd_bonds *bonds = l->bonds;
    const pd_stencil *s = bonds->stencil;
    static const double none[PD_DIM] = {0.0};
    pdi_limiter_piece p;
    pdi_limiter_piece_start(of, i, row, count, &p);
    const int32_t *far = place < 0 ? NULL : l->boundary->far_end + (int64_t)place * s->count;
    int beside = place >= 0, cut = beside && pdi_limiter_cut(l, i);
    for (int k = 0; k < s->count; k++) {
        int32_t shift = beside ? far[k] - i : bonds->paths.shift[k];
        int skip = cut && bonds->grid->kind[far[k]] == PD_INLET;
        if (!beside && row >= 0 && !pdi_limiter_gates(bonds, &p, k)) continue;
        pdi_limiter_add(&p, p.c + shift, p.x ? p.x + shift : NULL, s->laplacian_weight[k],
                        skip ? none : s->gradient_weight + k * PD_DIM, bonds->grid->total, of->slope + i);
    }
    pdi_limiter_piece_end(of, &p);
}

static void pdi_limiter_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_limiter_sweep *s = (const pdi_limiter_sweep *)user;
    if (place >= 0) pdi_limiter_bonds(s, i, row, place, 1);
    else if (row >= 0 || count < PDI_BLOCK) pdi_limiter_bonds(s, i, row, -1, count);
    else if (s->x) pdi_limiter_block(s, i, 1);
    else pdi_limiter_block(s, i, 0);
}

static void pdi_limiter_sweep_all(const pd_ctx *ctx, const pdi_limiter_sweep *s, double entering)
{
    const pd_bonds *bonds = s->limiter->bonds;
    pdi_node_loop_by_blocks(ctx, s->limiter->boundary, bonds->grid->fluid_count * bonds->stencil->count * 4,
                            pdi_limiter_nodes, s);
    for (int32_t k = bonds->ghosts.outlets_end; k < bonds->ghosts.inlets_end; k++)
        s->factor[bonds->ghosts.node[k]] = entering;
    pd_ghosts_set_scalar(&bonds->ghosts, s->factor);
    pd_ghosts_set_vector(&bonds->ghosts, s->slope);
}

PDI_FN void pdi_limiter_update(const pd_ctx *ctx, pd_limiter *l, const double *c, double least)
{
    pdi_limiter_sweep s;
    s.limiter = l;
    s.c = c;
    s.x = NULL;
    s.least = least;
    s.factor = l->factor;
    s.slope = l->slope;
    pdi_limiter_sweep_all(ctx, &s, 1.0);
}

PDI_FN void pdi_limiter_derive(const pd_ctx *ctx, const pd_limiter *l, const double *c, const double *x, double least,
                               double *factor_by, double *slope_by)
{
    pdi_limiter_sweep s;
    s.limiter = l;
    s.c = c;
    s.x = x;
    s.least = least;
    s.factor = factor_by;
    s.slope = slope_by;
    pdi_limiter_sweep_all(ctx, &s, 0.0);
}

PDI_FN void pdi_limiter_list(pdi_array_visitor *owner, void *object)
{
    pd_limiter *limiter = (pd_limiter *)object;
    int64_t total = limiter->bonds ? limiter->bonds->grid->total : 0;
    PDI_ARRAY(owner, limiter, slope, PD_DIM * total, "mol/m4");
    PDI_ARRAY(owner, limiter, factor, total, "1");
}
