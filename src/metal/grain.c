/* grain: see grain.h */
#include "metal/grain.h"
#include "core/vec.h"
#include "core/par.h"
#include "core/rng.h"
#include <math.h>
#include <string.h>

/* id values while the grains are built */
#define PDI_GRAIN_FAR (-1)    /* too far from metal to have a grain */
#define PDI_GRAIN_WANTED (-2) /* gets a grain */
#define PDI_GRAIN_UNSURE (-3) /* its nearest seed may not have been made */
#define PDI_GRAIN_NEW (-4)    /* marked in the present sweep */

/* Streams of random numbers. */
#define PDI_GRAIN_STREAM_TURN 0  /* orientation */
#define PDI_GRAIN_STREAM_SHIFT 1 /* shift */
#define PDI_GRAIN_STREAM_CELL 2  /* plus the hash of a cell: the seeds of the cell */

/* Nodes, or cells of seeds, between two looks at the caller. */
#define PDI_GRAIN_POLL 65536
/* A grain is at most this many times as large as the metal. The chance that the metal has a second one is then one over
 * this number. */
#define PDI_GRAIN_ONE 1e6

/* The seed lattice: cell q of edge `edge`, x = axes (q + shift) edge. One seed a cell in the mean. */
typedef struct pdi_grain_lattice {
    uint64_t seed;
    double edge;   /* [m] */
    double jitter; /* largest displacement from the cell centre, in cells; < 0: Poisson process */
    double axes[PD_DIM][PD_DIM], shift[PD_DIM];
} pdi_grain_lattice;

/* Standard deviation of the equivalent diameter over `size` for jitter 0, 1/8, 2/8, .., measured on 3e4 grains and
 * more (2D, 3D) in 1D, 2D and 3D. In 1D the first five are jitter / sqrt(6). */
#define PDI_GRAIN_JITTERS 13
static const double pdi_grain_spread_table[3][PDI_GRAIN_JITTERS] = {
    {0.0, 0.0510, 0.1021, 0.1531, 0.2041, 0.2526, 0.2913, 0.3237, 0.3530, 0.3800, 0.4037, 0.4242, 0.4424},
    {0.0, 0.0338, 0.0640, 0.0935, 0.1248, 0.1536, 0.1728, 0.1862, 0.1975, 0.2073, 0.2151, 0.2209, 0.2258},
    {0.0, 0.0255, 0.0460, 0.0652, 0.0850, 0.1019, 0.1126, 0.1188, 0.1234, 0.1279, 0.1316, 0.1334, 0.1349}};

/* Measure of a grain of diameter 1. */
static double pdi_grain_unit(void)
{
    static const double unit[3] = {1.0, 0.78539816339744831, 0.52359877559829887};
    return unit[PD_DIM - 1];
}

/* Largest displacement for a relative spread; the caller has checked the range. */
static double pdi_grain_jitter(double spread)
{
    const double *table = pdi_grain_spread_table[PD_DIM - 1];
    int k = 1;
    while (k < PDI_GRAIN_JITTERS - 1 && table[k] < spread) k++;
    return 0.125 * (k - 1 + (spread - table[k - 1]) / (table[k] - table[k - 1]));
}

static pd_status pdi_grain_check(pd_ctx *ctx, const pd_grid *grid, const pd_grain_desc *desc)
{
    double coarse = 0.0, most = pdi_grain_spread_table[PD_DIM - 1][PDI_GRAIN_JITTERS - 1];
    for (int d = 0; d < PD_DIM; d++) coarse = pd_max(coarse, grid->h[d]);
    if (!(desc->boundary_width >= 0.0) || !isfinite(desc->boundary_width))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grain", "the boundary width is %g m, expected 0 or more",
                       desc->boundary_width);
    if (desc->centres || desc->centre_count) {
        if (!desc->centres || desc->centre_count < 1)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "grain", "%d centres %s an array", (int)desc->centre_count,
                           desc->centres ? "with" : "without");
        for (int64_t k = 0; k < (int64_t)desc->centre_count * PD_DIM; k++)
            if (!isfinite(desc->centres[k]))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "grain", "centre %d has coordinate %g m", (int)(k / PD_DIM),
                               desc->centres[k]);
        return PD_OK;
    }
    if (!(desc->size >= coarse) || !isfinite(desc->size))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grain", "the grain size is %g m, expected at least the spacing %g m",
                       desc->size, coarse);
    if (!(desc->spread >= 0.0) || !(desc->spread <= most * desc->size))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grain",
                       "the spread of the grain size is %g m, expected 0 (random seeds) or up to %.3f of it, %g m",
                       desc->spread, most, most * desc->size);
    return PD_OK;
}

/* Random orientation: Gram-Schmidt on normal vectors. */
static void pdi_grain_orient(pdi_grain_lattice *lattice)
{
    for (int a = 0; a < PD_DIM; a++) {
        lattice->shift[a] = pdi_rng_uniform(lattice->seed, PDI_GRAIN_STREAM_SHIFT, (uint64_t)a);
        double norm = 0.0;
        for (uint64_t attempt = 0; !(norm > 0.01); attempt++) {
            double *row = lattice->axes[a];
            for (int b = 0; b < PD_DIM; b++) {
                double pair[2];
                uint64_t counter = (attempt * PD_DIM + (uint64_t)a) * PD_DIM + (uint64_t)b;
                pdi_rng_normal(lattice->seed, PDI_GRAIN_STREAM_TURN, counter, pair);
                row[b] = pair[0];
            }
            for (int c = 0; c < a; c++) {
                double dot = pdi_vec_dot(row, lattice->axes[c]);
                for (int b = 0; b < PD_DIM; b++) row[b] -= dot * lattice->axes[c][b];
            }
            norm = pdi_vec_norm(row);
            for (int b = 0; b < PD_DIM; b++) row[b] /= norm > 0.01 ? norm : 1.0;
        }
    }
}

/* Seeds of lattice cell q: their number, and the position of one. */
static uint64_t pdi_grain_stream(const int64_t *q)
{
    /* 21 bits an axis: cells have different numbers up to a million cells from the origin */
    uint64_t stream = 0;
    for (int a = 0; a < PD_DIM; a++) stream = (stream << 21) | ((uint64_t)(q[a] + 1048576) & 2097151u);
    return stream + PDI_GRAIN_STREAM_CELL;
}

static int pdi_grain_cell_count(const pdi_grain_lattice *lattice, uint64_t stream)
{
    if (lattice->jitter >= 0.0) return 1;
    /* Poisson distribution of mean 1 by inversion */
    double u = pdi_rng_uniform(lattice->seed, stream, 0), term = exp(-1.0), sum = term;
    int count = 0;
    while (u > sum && count < 18) {
        count++;
        term /= count;
        sum += term;
    }
    return count;
}

static void pdi_grain_cell_seed(const pdi_grain_lattice *lattice, const int64_t *q, uint64_t stream, int k, double *x)
{
    double at[PD_DIM];
    double width = lattice->jitter < 0.0 ? 0.5 : lattice->jitter;
    for (int a = 0; a < PD_DIM; a++) {
        double u = pdi_rng_uniform(lattice->seed, stream, (uint64_t)(1 + k * PD_DIM + a));
        at[a] = (double)q[a] + 0.5 + lattice->shift[a] + width * (2.0 * u - 1.0);
    }
    for (int b = 0; b < PD_DIM; b++) {
        x[b] = 0.0;
        for (int a = 0; a < PD_DIM; a++) x[b] += lattice->edge * at[a] * lattice->axes[a][b];
    }
}

/* Write (or, centre NULL, count) the seeds inside the box lo .. hi. */
static pd_status pdi_grain_sow(pd_ctx *ctx, const pdi_grain_lattice *lattice, const double *lo, const double *hi,
                               double *centre, int32_t *count)
{
    int64_t first[PD_DIM], last[PD_DIM], q[PD_DIM];
    double cells = 1.0;
    for (int a = 0; a < PD_DIM; a++) {
        double middle = 0.0, half = 0.0;
        for (int b = 0; b < PD_DIM; b++) {
            middle += 0.5 * (lo[b] + hi[b]) * lattice->axes[a][b];
            half += 0.5 * (hi[b] - lo[b]) * fabs(lattice->axes[a][b]);
        }
        double reach = half / lattice->edge + pd_max(lattice->jitter, 0.5) + 1.0;
        double from = middle / lattice->edge - lattice->shift[a];
        if (!(fabs(from) + reach < 1e6))
            return pd_fail(ctx, PD_ERR_SIZE, "grain", "the solid lies %g grains from the origin, expected less than "
                           "1e6", fabs(from) + reach);
        first[a] = (int64_t)floor(from - reach);
        last[a] = (int64_t)floor(from + reach);
        cells *= (double)(last[a] - first[a] + 1);
        q[a] = first[a];
    }
    if (!(cells < 1e9)) return pd_fail(ctx, PD_ERR_SIZE, "grain", "%g grains, expected less than 1e9", cells);
    *count = 0;
    int64_t sown = 0;
    for (int axis = 0; axis < PD_DIM; sown++) {
        uint64_t stream = pdi_grain_stream(q);
        if (sown % PDI_GRAIN_POLL == 0) PD_TRY(pd_check_cancel(ctx, "grains: seeds", sown));
        int seeds = pdi_grain_cell_count(lattice, stream);
        for (int k = 0; k < seeds; k++) {
            double x[PD_DIM];
            int inside = 1;
            pdi_grain_cell_seed(lattice, q, stream, k, x);
            for (int d = 0; d < PD_DIM; d++) inside = inside && x[d] >= lo[d] && x[d] <= hi[d];
            if (!inside) continue;
            if (centre) memcpy(centre + (size_t)*count * PD_DIM, x, sizeof x);
            ++*count;
        }
        for (axis = 0; axis < PD_DIM && ++q[axis] > last[axis]; axis++) q[axis] = first[axis];
    }
    return PD_OK;
}

static int pdi_grain_clamp(double cell, int n) { return cell < 0.0 ? 0 : cell >= (double)n ? n - 1 : (int)cell; }

static int32_t pdi_grain_bin(const pd_grain *grain, const double *x, int *i)
{
    int32_t bin = 0, stride = 1;
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = pdi_grain_clamp(floor((x[d] - grain->bin_lo[d]) / grain->bin_edge), grain->bin_n[d]);
        bin += i[d] * stride;
        stride *= grain->bin_n[d];
    }
    return bin;
}

/* Bins of about one seed over lo .. hi; seeds beyond fall into the border bins, which only puts them nearer than they
 * are. `centre` is sorted by bins, keeping the order within one. */
static pd_status pdi_grain_sort(pd_ctx *ctx, const double *lo, const double *hi, const double *centre, pd_grain *grain)
{
    double total = 1.0;
    int i[PD_DIM];
    for (;; grain->bin_edge *= 2.0) { /* long thin boxes with few seeds: no more bins than nodes */
        total = 1.0;
        for (int d = 0; d < PD_DIM; d++) total *= floor((hi[d] - lo[d]) / grain->bin_edge) + 1.0;
        if (total <= (double)grain->nodes + (double)grain->centre_count) break;
    }
    for (int d = 0; d < PD_DIM; d++) {
        grain->bin_lo[d] = lo[d];
        grain->bin_n[d] = (int)floor((hi[d] - lo[d]) / grain->bin_edge) + 1;
    }
    grain->bins = (int32_t)total;
    PD_TRY(PD_NEW(ctx, "grain", grain->bins + 1, grain->bin_first));
    PD_TRY(PD_NEW(ctx, "grain", (int64_t)grain->centre_count * PD_DIM, grain->centre));
    for (int32_t k = 0; k < grain->centre_count; k++)
        grain->bin_first[pdi_grain_bin(grain, centre + (size_t)k * PD_DIM, i)]++;
    int32_t end = 0;
    for (int32_t b = 0; b <= grain->bins; b++) {
        end += grain->bin_first[b];
        grain->bin_first[b] = end;
    }
    for (int32_t k = grain->centre_count; k-- > 0;) {
        const double *x = centre + (size_t)k * PD_DIM;
        int32_t place = --grain->bin_first[pdi_grain_bin(grain, x, i)];
        memcpy(grain->centre + (size_t)place * PD_DIM, x, PD_DIM * sizeof *x);
    }
    return PD_OK;
}

/* Nearest seed among those of bin b, squared distance in *best; of equal ones the first. */
static void pdi_grain_scan(const pd_grain *grain, int32_t bin, const double *x, double *best, int32_t *nearest)
{
    for (int32_t k = grain->bin_first[bin]; k < grain->bin_first[bin + 1]; k++) {
        double square = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            double gap = x[d] - grain->centre[(size_t)k * PD_DIM + (size_t)d];
            square += gap * gap;
        }
        if (square < *best || (square <= *best && k < *nearest)) {
            *best = square;
            *nearest = k;
        }
    }
}

/* Squared distance from x to bin j, a little less for rounding; *bin becomes its number. -1: no such bin. */
static double pdi_grain_bin_distance(const pd_grain *grain, const double *x, const int *j, int32_t *bin)
{
    double square = 0.0;
    int32_t stride = 1;
    *bin = 0;
    for (int d = 0; d < PD_DIM; d++) {
        if (j[d] < 0 || j[d] >= grain->bin_n[d]) return -1.0;
        double lo = grain->bin_lo[d] + j[d] * grain->bin_edge;
        double gap = pd_max(pd_max(lo - x[d], x[d] - lo - grain->bin_edge), 0.0);
        square += gap * gap;
        *bin += j[d] * stride;
        stride *= grain->bin_n[d];
    }
    return square * (1.0 - 1e-12);
}

/* Bins in rings around that of x until none can hold a nearer seed. */
static int32_t pdi_grain_nearest(const pd_grain *grain, const double *x, double *distance)
{
    int base[PD_DIM], step[PD_DIM], j[PD_DIM], widest = 0;
    double best = HUGE_VAL;
    int32_t nearest = PDI_GRAIN_UNSURE, bin;
    pdi_grain_bin(grain, x, base);
    for (int d = 0; d < PD_DIM; d++) widest = grain->bin_n[d] > widest ? grain->bin_n[d] : widest;
    for (int shell = 0; shell < widest; shell++) {
        double beyond = (shell - 1) * grain->bin_edge * (1.0 - 1e-12);
        if (shell > 1 && best < beyond * beyond) break;
        for (int d = 0; d < PD_DIM; d++) step[d] = -shell;
        for (int axis = 0; axis < PD_DIM;) {
            int on_shell = 0;
            for (int d = 0; d < PD_DIM; d++) {
                on_shell = on_shell || step[d] == shell || step[d] == -shell;
                j[d] = base[d] + step[d];
            }
            double at_least = on_shell ? pdi_grain_bin_distance(grain, x, j, &bin) : -1.0;
            if (at_least >= 0.0 && at_least <= best) pdi_grain_scan(grain, bin, x, &best, &nearest);
            for (axis = 0; axis < PD_DIM; axis++) {
                if (++step[axis] <= shell) break;
                step[axis] = -shell;
            }
        }
    }
    *distance = sqrt(best);
    return nearest;
}

/* Mark the unmarked nodes of a line within `reach` steps behind a marked one; step -stride: before it. */
static void pdi_grain_spread_marks(int32_t *id, int32_t n, int32_t step, int reach)
{
    int32_t since = INT32_MAX / 2;
    for (int32_t k = 0; k < n; k++) {
        int32_t *at = id + k * step;
        since = *at == PDI_GRAIN_WANTED ? 0 : since + 1;
        if (since > 0 && since <= reach) *at = PDI_GRAIN_NEW;
    }
}

/* Mark the nodes within grid->ghost layers of a solid node, axis by axis. */
static void pdi_grain_want(const pd_grid *grid, pd_grain *grain)
{
    for (int32_t node = 0; node < grid->total; node++)
        grain->id[node] = grid->kind[node] == PD_SOLID ? PDI_GRAIN_WANTED : PDI_GRAIN_FAR;
    for (int d = 0; d < PD_DIM; d++) {
        int32_t stride = grid->stride[d], n = (int32_t)grid->padded[d];
        for (int32_t line = 0; line < grid->total; line++) {
            if (line / stride % n) continue;
            pdi_grain_spread_marks(grain->id + line, n, stride, grid->ghost);
            pdi_grain_spread_marks(grain->id + line + (n - 1) * stride, n, -stride, grid->ghost);
        }
        for (int32_t node = 0; node < grid->total; node++)
            if (grain->id[node] == PDI_GRAIN_NEW) grain->id[node] = PDI_GRAIN_WANTED;
    }
}

/* Box of the marked nodes; 0: there are none. */
static int pdi_grain_extent(const pd_grid *grid, const pd_grain *grain, double *lo, double *hi)
{
    int any = 0;
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = HUGE_VAL;
        hi[d] = -HUGE_VAL;
    }
    for (int32_t node = 0; node < grid->total; node++) {
        double x[PD_DIM];
        if (grain->id[node] == PDI_GRAIN_FAR) continue;
        any = 1;
        pd_grid_position(grid, node, x);
        for (int d = 0; d < PD_DIM; d++) {
            lo[d] = pd_min(lo[d], x[d]);
            hi[d] = pd_max(hi[d], x[d]);
        }
    }
    return any;
}

/* Give every marked node its grain. Seeds exist within `margin` of the marked nodes: a node whose nearest seed is
 * farther than that is not sure of it. *unsure: the number of those. */
static pd_status pdi_grain_assign(pd_ctx *ctx, const pd_grid *grid, double margin, pd_grain *grain, int64_t *unsure)
{
    int nt = pd_par_threads(ctx, 100 * (int64_t)grid->total);
    (void)nt;
    for (int32_t first = 0; first < grid->total; first += PDI_GRAIN_POLL) {
        int32_t end = grid->total - first > PDI_GRAIN_POLL ? first + PDI_GRAIN_POLL : grid->total;
        PD_TRY(pd_check_cancel(ctx, "grains: nodes", first));
        PD_PARALLEL_FOR(nt)
        for (int32_t node = first; node < end; node++) {
            double x[PD_DIM], distance;
            if (grain->id[node] == PDI_GRAIN_FAR) continue;
            pd_grid_position(grid, node, x);
            int32_t nearest = pdi_grain_nearest(grain, x, &distance);
            grain->id[node] = distance <= margin ? nearest : PDI_GRAIN_UNSURE;
        }
    }
    *unsure = 0;
    for (int32_t node = 0; node < grid->total; node++) *unsure += grain->id[node] == PDI_GRAIN_UNSURE;
    return PD_OK;
}

static void pdi_grain_drop_seeds(pd_ctx *ctx, pd_grain *grain)
{
    PD_DELETE(ctx, grain->bins + 1, grain->bin_first);
    PD_DELETE(ctx, (int64_t)grain->centre_count * PD_DIM, grain->centre);
}

/* Seeds within `margin` of the box, sorted into bins. */
static pd_status pdi_grain_generate(pd_ctx *ctx, const pdi_grain_lattice *lattice, const double *lo, const double *hi,
                                    double margin, pd_grain *grain)
{
    double from[PD_DIM], to[PD_DIM], *centre = NULL;
    for (int d = 0; d < PD_DIM; d++) {
        from[d] = lo[d] - margin;
        to[d] = hi[d] + margin;
    }
    grain->bin_edge = lattice->edge;
    PD_TRY(pdi_grain_sow(ctx, lattice, from, to, NULL, &grain->centre_count));
    int64_t size = (int64_t)grain->centre_count * PD_DIM;
    PD_TRY(PD_NEW(ctx, "grain", size, centre));
    pd_status status = pdi_grain_sow(ctx, lattice, from, to, centre, &grain->centre_count);
    if (status == PD_OK) status = pdi_grain_sort(ctx, from, to, centre, grain);
    PD_DELETE(ctx, size, centre);
    return status;
}

static pd_status pdi_grain_random(pd_ctx *ctx, const pd_grid *grid, const pd_grain_desc *desc, const double *lo,
                                  const double *hi, pd_grain *grain)
{
    pdi_grain_lattice lattice;
    double most = 0.0;
    for (int d = 0; d < PD_DIM; d++) most += PDI_GRAIN_ONE * (hi[d] - lo[d] + grid->h[d]);
    lattice.seed = desc->seed;
    lattice.edge = pd_min(desc->size, most) * pow(pdi_grain_unit(), 1.0 / PD_DIM);
    lattice.jitter = desc->spread > 0.0 ? pdi_grain_jitter(desc->spread / desc->size) : -1.0;
    pdi_grain_orient(&lattice);
    for (double margin = 3.0 * lattice.edge;; margin *= 2.0) {
        PD_TRY(pdi_grain_generate(ctx, &lattice, lo, hi, margin, grain));
        int64_t unsure;
        PD_TRY(pdi_grain_assign(ctx, grid, margin, grain, &unsure));
        if (unsure == 0) return PD_OK;
        pdi_grain_drop_seeds(ctx, grain);
    }
}

static pd_status pdi_grain_given(pd_ctx *ctx, const pd_grid *grid, const pd_grain_desc *desc, const double *lo,
                                 const double *hi, pd_grain *grain)
{
    double measure = 1.0;
    int64_t unsure;
    for (int d = 0; d < PD_DIM; d++) measure *= pd_max(hi[d] - lo[d], grid->h[d]);
    grain->centre_count = desc->centre_count;
    grain->bin_edge = pow(measure / (double)desc->centre_count, 1.0 / PD_DIM);
    PD_TRY(pdi_grain_sort(ctx, lo, hi, desc->centres, grain));
    return pdi_grain_assign(ctx, grid, HUGE_VAL, grain, &unsure);
}

static pd_status pdi_grain_make(pd_ctx *ctx, const pd_grid *grid, const pd_grain_desc *desc, pd_grain *grain)
{
    double lo[PD_DIM], hi[PD_DIM];
    memset(grain, 0, sizeof *grain);
    PD_TRY(pdi_grain_check(ctx, grid, desc));
    grain->nodes = grid->total;
    grain->boundary_width = desc->boundary_width;
    PD_TRY(PD_NEW(ctx, "grain", grain->nodes, grain->id));
    pdi_grain_want(grid, grain);
    if (!pdi_grain_extent(grid, grain, lo, hi)) return PD_OK;
    return desc->centres ? pdi_grain_given(ctx, grid, desc, lo, hi, grain)
                         : pdi_grain_random(ctx, grid, desc, lo, hi, grain);
}

pd_status pd_grain_build(pd_ctx *ctx, const pd_grid *grid, const pd_grain_desc *desc, pd_grain *grain)
{
    pd_status status = pdi_grain_make(ctx, grid, desc, grain);
    if (status < 0) pd_grain_free(ctx, grain);
    return status;
}

void pd_grain_free(pd_ctx *ctx, pd_grain *grain)
{
    PD_DELETE(ctx, grain->nodes, grain->id);
    pdi_grain_drop_seeds(ctx, grain);
    memset(grain, 0, sizeof *grain);
}

/* Grains around a node: candidates for a boundary that a bond crosses. */
#define PDI_GRAIN_LOCAL 256
typedef struct pdi_grain_local {
    int count;
    int32_t id[PDI_GRAIN_LOCAL];
} pdi_grain_local;

static void pdi_grain_note(pdi_grain_local *local, int32_t id)
{
    for (int k = 0; k < local->count; k++)
        if (local->id[k] == id) return;
    if (local->count < PDI_GRAIN_LOCAL) local->id[local->count++] = id;
}

static double pdi_grain_square(const pd_grain *grain, int32_t id, const double *x)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double gap = x[d] - grain->centre[(size_t)id * PD_DIM + (size_t)d];
        square += gap * gap;
    }
    return square;
}

/* Boundaries between x in grain a and x + xi in grain b. Grains are convex: a third one lies between exactly when it
 * holds the point where the bond leaves the bisector of a and b, and then the count splits there. Bonds counted as one
 * crossing near the edges of grains would lose area in proportion to h. */
static int pdi_grain_crossings(const pd_grain *grain, const pdi_grain_local *local, const double *x, const double *xi,
                               int32_t a, int32_t b, int depth)
{
    if (a == b) return 0;
    double slope = 0.0, level = pdi_grain_square(grain, b, x) - pdi_grain_square(grain, a, x), p[PD_DIM];
    for (int d = 0; d < PD_DIM; d++)
        slope += 2.0 * xi[d] * (grain->centre[(size_t)b * PD_DIM + (size_t)d] -
                                grain->centre[(size_t)a * PD_DIM + (size_t)d]);
    if (local->count < 3 || depth == 0 || !(slope > 0.0)) return 1;
    for (int d = 0; d < PD_DIM; d++) p[d] = x[d] + pd_min(pd_max(level / slope, 0.0), 1.0) * xi[d];
    double best = pdi_grain_square(grain, a, p) * (1.0 - 1e-9);
    int32_t between = a;
    for (int k = 0; k < local->count; k++) {
        double square = pdi_grain_square(grain, local->id[k], p);
        if (local->id[k] == b || !(square < best)) continue;
        best = square;
        between = local->id[k];
    }
    if (between == a) return 1;
    return pdi_grain_crossings(grain, local, x, xi, a, between, depth - 1) +
           pdi_grain_crossings(grain, local, x, xi, between, b, depth - 1);
}

/* sum over bonds of c(n) times the boundaries crossed [1/m] */
static double pdi_grain_area(const pd_stencil *stencil, const pd_grid *grid, const pd_grain *grain, int32_t node)
{
    pdi_grain_local local;
    double x[PD_DIM], area = 0.0;
    local.count = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < stencil->count; k++) {
            int32_t other = node;
            for (int d = 0; d < PD_DIM; d++) other += (int32_t)stencil->offset[k * PD_DIM + d] * grid->stride[d];
            if (pass == 0) pdi_grain_note(&local, grain->id[other]);
            else if (grain->id[other] != grain->id[node] && stencil->area_weight[k] > 0.0)
                area += stencil->area_weight[k] * pdi_grain_crossings(grain, &local, x, stencil->xi + k * PD_DIM,
                                                                      grain->id[node], grain->id[other], 8);
        }
        pdi_grain_note(&local, grain->id[node]);
        if (local.count == 1) return 0.0;
        pd_grid_position(grid, node, x);
    }
    return area;
}

pd_status pd_grain_fraction(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, const pd_grain *grain,
                            float *fraction)
{
    if (grain->nodes != grid->total || stencil->reach > grid->ghost)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grain", "grains of %d nodes, grid of %d: not built on this grid",
                       (int)grain->nodes, (int)grid->total);
    int nt = pd_par_threads(ctx, (int64_t)grid->total * stencil->count);
    (void)nt;
    /* phi_i = min(1, w_gb / 2 sum_n c(n) b(i, i + n)), b: boundaries that the bond crosses  (theory: eq. 10.8) */
    PD_PARALLEL_FOR(nt)
    for (int32_t node = 0; node < grid->total; node++) {
        double width = grain->boundary_width;
        fraction[node] = 0.0f;
        if (grid->kind[node] == PD_SOLID && width > 0.0)
            fraction[node] = (float)pd_min(1.0, 0.5 * width * pdi_grain_area(stencil, grid, grain, node));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_grain_measure(pd_ctx *ctx, const pd_grid *grid, const pd_grain *grain, const float *fraction,
                                   pd_grain_stats *stats)
{
    double *share = NULL, volume = 1.0, sum = 0.0, square = 0.0;
    pdi_compensated_sum boundary = {0.0, 0.0};
    int64_t solid = 0;
    memset(stats, 0, sizeof *stats);
    if (grain->nodes != grid->total)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grain", "grains of %d nodes, grid of %d: not built on this grid",
                       (int)grain->nodes, (int)grid->total);
    PD_TRY(PD_NEW(ctx, "grain", grain->centre_count, share));
    for (int32_t node = 0; node < grid->total; node++) {
        if (grid->kind[node] != PD_SOLID || grain->id[node] < 0) continue;
        share[grain->id[node]] += 1.0;
        solid++;
        if (fraction) pdi_compensated_sum_add(&boundary, (double)fraction[node]);
    }
    for (int d = 0; d < PD_DIM; d++) volume *= grid->h[d];
    for (int32_t k = 0; k < grain->centre_count; k++) {
        if (!(share[k] > 0.0)) continue;
        double diameter = pow(share[k] * volume / pdi_grain_unit(), 1.0 / PD_DIM);
        stats->count++;
        sum += diameter;
        square += diameter * diameter;
    }
    PD_DELETE(ctx, grain->centre_count, share);
    if (stats->count == 0) return PD_OK;
    stats->mean = sum / stats->count;
    stats->deviation = sqrt(pd_max(square / stats->count - stats->mean * stats->mean, 0.0));
    stats->boundary_fraction = pdi_compensated_sum_total(&boundary) / (double)solid;
    return PD_OK;
}
