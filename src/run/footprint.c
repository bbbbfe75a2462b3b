/* footprint: see footprint.h */
#include "run/footprint.h"
#include "flow/steady.h"
#include "metal/dissolve.h"
#include <math.h>
#include <string.h>

/* Points of the sample along an axis. */
#define PDI_FOOTPRINT_POINTS (PD_DIM == 1 ? 2000 : PD_DIM == 2 ? 100 : 28)
/* [byte] A plot: pixels, filtered rows, the packed file and the state of the packer. */
#define PDI_FOOTPRINT_PLOT 5.7e6
#define PDI_FOOTPRINT_PACK 0.55e6
/* [byte] What does not grow with the lattice: tables of a run, small matrices of the solvers, the stencil. */
#define PDI_FOOTPRINT_BASE 0.22e6

/* Whole family: offsets with 0 < |n| < m + 1/2. */
static double pdi_footprint_bonds(double m)
{
    int reach = (int)ceil(m + 0.5) - 1, n[3] = {0, 0, 0};
    double bonds = -1.0;
    for (n[2] = PD_DIM > 2 ? -reach : 0; n[2] <= (PD_DIM > 2 ? reach : 0); n[2]++)
        for (n[1] = PD_DIM > 1 ? -reach : 0; n[1] <= (PD_DIM > 1 ? reach : 0); n[1]++)
            for (n[0] = -reach; n[0] <= reach; n[0]++)
                bonds += n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < (m + 0.5) * (m + 0.5);
    return bonds;
}

/* 1: what lies behind the side is closed, or held, within `near_to` of x. */
static int pdi_footprint_beside(const pd_setup *u, const double *x, double near_to)
{
    for (int d = 0; d < PD_DIM; d++)
        for (int end = 0; end < 2; end++) {
            pd_side kind = u->side[2 * d + end].kind;
            double away = end ? u->hi[d] - x[d] : x[d] - u->lo[d];
            if ((kind == PD_SIDE_WALL || kind == PD_SIDE_INLET) && away < near_to * u->h[d]) return 1;
        }
    return 0;
}

/* Kinds of nodes, by the places of a regular sample. */
static void pdi_footprint_sample(const pd_setup *u, double reach, pd_footprint *b)
{
    int count[3] = {1, 1, 1}, i[3];
    double points = 1.0, step = 0.0, fluid = 0.0, solid = 0.0, cut = 0.0, near = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = (u->hi[d] - u->lo[d]) / u->h[d];
        count[d] = cells < PDI_FOOTPRINT_POINTS ? (int)(cells + 0.5) : PDI_FOOTPRINT_POINTS;
        if (count[d] < 1) count[d] = 1;
        points *= count[d];
        step = fmax(step, u->h[d]);
    }
    for (i[2] = 0; i[2] < count[2]; i[2]++)
        for (i[1] = 0; i[1] < count[1]; i[1]++)
            for (i[0] = 0; i[0] < count[0]; i[0]++) {
                double x[PD_DIM], far_away = HUGE_VAL;
                for (int d = 0; d < PD_DIM; d++) x[d] = u->lo[d] + (i[d] + 0.5) * (u->hi[d] - u->lo[d]) / count[d];
                if (u->medium >= 0) near += fabs(pd_shape_distance(u->shape, u->medium, x)) < (u->m + 0.5) * step;
                if (u->wall >= 0) far_away = pd_shape_distance(u->shape, u->wall, x);
                if (far_away < 0.0) continue;
                if (u->solid >= 0) far_away = fmin(far_away, pd_shape_distance(u->shape, u->solid, x));
                solid += far_away < 0.0;
                fluid += !(far_away < 0.0);
                cut += !(far_away < 0.0) && (far_away < reach * step || pdi_footprint_beside(u, x, reach));
            }
    b->fluid = b->cells * fluid / points;
    b->solid = b->cells * solid / points;
    b->cut = b->cells * cut / points;
    b->near = b->cells * near / points;
}

/* [byte] a cell of a multigrid: its finest level, and the coarser ones, which appear in the run. */
static double pdi_footprint_multigrid(int symmetric, int contrast, double *coarse)
{
    double axes = symmetric ? PD_DIM : 2 * PD_DIM;
    *coarse = 4.0 + (4.0 * (4 + contrast) + 16.0 + 8.0 * contrast + 16.0 * 2 * PD_DIM) / ((1 << PD_DIM) - 1);
    return 4.0 * (1.0 + axes + 3.0 + contrast) + 8.0 * contrast + 4.0;
}

/* [byte] a cell of the coefficients that a multigrid is set up with. */
static double pdi_footprint_compact(int with_flux) { return 9.0 + 4.0 * PD_DIM * (1 + with_flux); }

/* 1: the spacings of the lattice call for a multigrid that copes with contrast. */
static int pdi_footprint_contrast(const pd_setup *u)
{
    int n[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) n[d] = (int)fmin(floor((u->hi[d] - u->lo[d]) / u->h[d] + 0.5), (double)INT32_MAX);
    return pdi_compact_contrast(n, u->h);
}

static void pdi_footprint_lattice(const pd_setup *u, pd_footprint *b)
{
    double row = 4.0 + 4.0 * ceil(b->bonds / 32.0) + 17.0 + 16.0 * PD_DIM * PD_DIM;
    b->bytes[PD_PART_GRID] = b->nodes + b->bonds * (70.0 + 12.0 * PD_DIM);
    if (!u->has_corrode)
        b->bytes[PD_PART_GRID] += 4.0 * b->nodes + 1.25 * row * b->cut + 9.0 * (b->nodes - b->cells);
}

static void pdi_footprint_flow(const pd_setup *u, pd_footprint *b)
{
    double coarse_u, coarse_p, bases = PDI_STEADY_RESTART + 1.0, values = 3.0 * PD_DIM + 1.0;
    int contrast = pdi_footprint_contrast(u);
    if (!u->has_flow) return;
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (u->side[s].slides) values = 4.0 * PD_DIM + 1.0;
    if (u->pushed) values += PD_DIM;
    if (u->motion == PD_MOTION_STEADY || u->motion == PD_MOTION_IMPLICIT) {
        values += 7.0 * (PD_DIM + 1) + PD_DIM + 1.0;       /* vectors of the solvers */
        values += 0.5 * (5.0 * PD_DIM + 1.0) + 1.0; /* of the linearised flow, most in single precision */
        b->bytes[PD_PART_FLOW] += 4.0 * bases * (PD_DIM + 1) * (b->fluid + b->solid);
        b->bytes[PD_PART_FLOW] += b->cells * (pdi_footprint_compact(1) + pdi_footprint_compact(0) +
                                              pdi_footprint_multigrid(0, contrast, &coarse_u) +
                                              2.0 * pdi_footprint_multigrid(1, contrast, &coarse_p));
        b->working += b->cells * (coarse_u + 2.0 * coarse_p);
    }
    if (u->motion == PD_MOTION_IMPLICIT) {
        values += 3.0 * PD_DIM + 1.0;
        b->bytes[PD_PART_FLOW] += b->cells * pdi_footprint_multigrid(1, 0, &coarse_p); /* of short steps */
        b->working += b->cells * coarse_p;
    }
    if (u->motion == PD_MOTION_EXPLICIT) values += 3.0 * PD_DIM + 3.0;
    b->bytes[PD_PART_FLOW] += 8.0 * values * b->nodes;
}

static void pdi_footprint_gas(const pd_setup *u, pd_footprint *b)
{
    double fields = PD_GAS_FIELDS * (4.0 + (u->gas_order == PD_GAS_SECOND ? PD_DIM : 0.0));
    if (!u->has_gas) return;
    b->bytes[PD_PART_GAS] = (8.0 * fields + 1.0) * b->nodes + 8.0 * (PD_DIM + 1.0) * 1.25 * b->cut;
}

static void pdi_footprint_transport(const pd_setup *u, pd_footprint *b)
{
    double values = 12.0 + 4.0, coarse, bytes; /* fields and vectors of the solver */
    int repeats = 0, medium = u->medium >= 0, held = 0, contrast = medium || pdi_footprint_contrast(u);
    if (!u->has_transport) return;
    for (int s = 0; s < 2 * PD_DIM; s++) {
        repeats = repeats || u->side[s].kind >= PD_SIDE_PERIODIC;
        held = held || u->side[s].holds;
    }
    for (int k = 0; k < u->wall_count; k++) held = held || u->walls[k].holds;
    values += repeats + 2.5 * medium + held * (4.0 + 2.0 * PD_DIM + 0.125);
    values += 0.5 * (0.5 * PD_DIM * (PD_DIM + 1) + 1.0); /* of the diffusion, in single precision */
    if (u->solid >= 0) values += 0.5 * (0.5 * PD_DIM * (PD_DIM + 1) + PD_DIM);
    if (u->has_flow) values += 2.0 * (PD_DIM + 1.0) + (PD_DIM < 3 ? floor(0.5 * b->bonds) : 0.0);
    if (!u->has_dissolve) values += 4.0;
    bytes = 8.0 * values * b->nodes + 41.0 * (medium ? 8.0 : 4.0) * (b->fluid + b->solid);
    bytes += 8.0 * 1.25 * b->bonds * b->cut + 8.0 * b->bonds * b->near;
    bytes += b->cells * (pdi_footprint_compact(u->has_flow) + pdi_footprint_multigrid(!u->has_flow, contrast, &coarse));
    b->bytes[PD_PART_TRANSPORT] = bytes;
    b->working += b->cells * coarse;
}

static void pdi_footprint_metal(const pd_setup *u, pd_footprint *b)
{
    double coarse, bytes;
    if (u->has_grains) b->bytes[PD_PART_GRAIN] = 12.0 * b->nodes; /* and shares, which do not stay: 4 */
    /* fluid within a horizon of metal, which has at least the surface of a cube */
    double shell = fmin(2.0 * PD_DIM * u->m * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->fluid);
    if (u->has_dissolve)
        b->bytes[PD_PART_DISSOLVE] = 14.0 * b->nodes + 12.0 * b->solid +
                                     (double)pdi_dissolve_shore_size() * (b->solid + shell);
    if (!u->has_corrode) return;
    b->bytes[PD_PART_CORRODE] = (28.0 + (u->passive >= 0)) * b->nodes + 9.0 * (b->nodes - b->cells) + 4.0 * b->cells +
                                4.0 * b->solid;
    if (u->drive == PD_DRIVE_CONSTANT) b->bytes[PD_PART_CORRODE] += 8.0 * b->nodes;
    if (u->has_grains) b->bytes[PD_PART_CORRODE] += 8.0 * b->nodes;
    if (u->stochastic) b->bytes[PD_PART_CORRODE] += 10.0 * b->nodes;
    if (u->repassivation > 0.0) b->bytes[PD_PART_CORRODE] += b->nodes;
    if (u->forward) return;
    bytes = pdi_footprint_compact(0) + pdi_footprint_multigrid(1, pdi_footprint_contrast(u), &coarse);
    b->bytes[PD_PART_CORRODE] += (97.0 + 40.0) * b->nodes + b->cells * bytes;
    b->working += b->cells * coarse;
}

/* Pixels of a field of `cells`, `wanted` of them. */
static double pdi_footprint_pixels(double cells, double wanted)
{
    double each = fmax(1.0, floor(wanted / cells + 0.5));
    return cells > 1400.0 ? cells / ceil(cells / 1400.0) : fmax(cells * each, 120.0);
}

/* Pictures come one by one: the largest counts. */
static double pdi_footprint_pictures(const pd_setup *u)
{
    int right = u->slice_axis == 0 && PD_DIM == 3 ? 1 : 0, up = u->slice_axis == 2 || PD_DIM < 3 ? 1 : 2;
    int plots = pdi_setup_loses(u) || (PD_DIM == 1 && u->images);
    double largest = 0.0;
    for (int k = 0; k < u->monitors; k++) {
        const pd_setup_monitor *m = &u->monitor[k];
        plots = plots || (m->kind == PD_MONITOR_LINE && m->images) || (m->kind == PD_MONITOR_TRANSFER && m->axis >= 0);
    }
    if (plots) largest = PDI_FOOTPRINT_PLOT;
    if (PD_DIM == 1 || !u->images) return largest;
    double lx = u->hi[right] - u->lo[right], ly = u->hi[up] - u->lo[up];
    if (u->axisymmetric && !(u->lo[up] > 0.0)) ly *= 2.0; /* both halves are drawn */
    double scale = fmin(1000.0 / lx, 900.0 / ly);
    double width = pdi_footprint_pixels(lx / u->h[right], scale * lx) + 230.0;
    double height = pdi_footprint_pixels(ly / u->h[up], scale * ly) + 140.0;
    return fmax(largest, 6.0 * width * height + PDI_FOOTPRINT_PACK);
}

/* Fields that files need a copy of, and the largest picture. */
static void pdi_footprint_output(const pd_setup *u, pd_footprint *b)
{
    double copies = 0.0;
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (((u->fields >> k) & 1u) && (k == PD_FIELD_C || k == PD_FIELD_D || k == PD_FIELD_RATE ||
                                        k == PD_FIELD_DENSITY || k == PD_FIELD_P || k == PD_FIELD_ENERGY))
            copies += 8.0;
    b->files = copies * b->nodes + pdi_footprint_pictures(u);
}

void pd_footprint_estimate(const pd_setup *u, pd_footprint *b)
{
    double reach = ceil(u->m + 0.5) - 1.0;
    memset(b, 0, sizeof *b);
    b->nodes = b->cells = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = floor((u->hi[d] - u->lo[d]) / u->h[d] + 0.5);
        b->cells *= cells;
        b->nodes *= cells + 2.0 * reach;
    }
    b->bonds = pdi_footprint_bonds(u->m);
    pdi_footprint_sample(u, reach, b);
    pdi_footprint_lattice(u, b);
    pdi_footprint_flow(u, b);
    pdi_footprint_gas(u, b);
    pdi_footprint_transport(u, b);
    pdi_footprint_metal(u, b);
    pdi_footprint_output(u, b);
    b->all = PDI_FOOTPRINT_BASE + b->working + b->files + PD_SHAPE_MAX * (double)sizeof *u->shape;
    for (int k = 0; k < u->masks; k++) b->all += (double)u->mask_size[k];
    for (int k = 0; k < PD_PART_COUNT; k++) b->all += b->bytes[k];
}

pd_status pd_footprint_check(pd_ctx *ctx, const pd_setup *setup, int dry)
{
    pd_footprint b;
    pd_footprint_estimate(setup, &b);
    if (dry) b.all -= b.files;
    if (!(b.nodes <= (double)INT32_MAX))
        return pdi_fail(ctx, PD_ERR_SIZE, "grid", "the lattice has %.3g nodes, at most %.3g are possible", b.nodes,
                        (double)INT32_MAX);
    double sure = (b.all - PDI_FOOTPRINT_BASE) / (1.0 + PD_FOOTPRINT_ERROR);
    if (ctx->alloc.limit && sure > (double)ctx->alloc.limit)
        return pdi_fail(ctx, PD_ERR_LIMIT, "memory", "the run needs about %.3g MB, the limit is %.3g MB",
                        b.all * 1e-6, (double)ctx->alloc.limit * 1e-6);
    return PD_OK;
}

#undef PDI_FOOTPRINT_POINTS
#undef PDI_FOOTPRINT_PLOT
#undef PDI_FOOTPRINT_PACK
#undef PDI_FOOTPRINT_BASE
