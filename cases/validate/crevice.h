/* crevice: corrosion in a long thin gap, against the equation of the gap. */
#ifndef VAL_CREVICE_H
#define VAL_CREVICE_H
#if PD_DIM == 2

/* Half of the wedge between two washers of alloy 625 (crevice_625_setup.csv). */
#define CREVICE_LENGTH 12.7e-3  /* [m] */
#define CREVICE_MOUTH 25e-6     /* [m] half of the gap */
#define CREVICE_END 5e-6        /* [m] */
#define CREVICE_START 3e-3      /* [m] length at 99 % of saturation at first */
#define CREVICE_D 7.2e-10       /* [m2/s] */
#define CREVICE_CS 140e3        /* [mol/m3] */
#define CREVICE_CSAT 5.6e3      /* [mol/m3] */
#define CREVICE_CHARGE (2.374 * 96485.33212) /* [C/mol] */
#define CREVICE_TIME 259200.0   /* [s] 72 h */
#define CREVICE_CELLS 1016      /* of the reference */
#define CREVICE_STEP 80.0       /* [s] of the reference */
#define CREVICE_METAL 25e-6     /* [m] below the mouth */

/* Flux [mol/m2/s] of metal at concentration c [mol/m3]; crevice_625_iC.csv. */
static double crevice_flux(double c)
{
    double acidity = 7.405 * exp(-0.08036e-3 * c) - 6.498; /* pH */
    return 1e4 * pow(10.0, 1.151 * exp(-0.723 * acidity) - 7.647) / CREVICE_CHARGE;
}

static double crevice_law(void *user, const pd_rate_at *at)
{
    (void)user;
    return crevice_flux(at->c) / CREVICE_CS;
}

static double crevice_gap(double x) { return CREVICE_MOUTH - (CREVICE_MOUTH - CREVICE_END) * x / CREVICE_LENGTH; }

static double crevice_initial(double x) { return x > CREVICE_LENGTH - CREVICE_START ? 0.99 * CREVICE_CSAT : 0.0; }

/* The gap as a line: d(g C)/dt = d/dx(D g dC/dx) + q, dg/dt = q/Cs, q what the law gives, less where C = Csat. Cells of
 * constant width, implicit steps, Newton's method with the salt layer as an active set. No code of the header. */
typedef struct crevice_line {
    double gap[CREVICE_CELLS], c[CREVICE_CELLS], next[CREVICE_CELLS], move[CREVICE_CELLS], above[CREVICE_CELLS];
    int full[CREVICE_CELLS];
} crevice_line;

/* One correction of the unknowns; its largest entry over Csat. */
static double crevice_correct(crevice_line *w)
{
    double scale = CREVICE_D / (CREVICE_LENGTH / CREVICE_CELLS) / (CREVICE_LENGTH / CREVICE_CELLS), largest = 0.0;
    for (int i = 0; i < CREVICE_CELLS; i++) { /* forward elimination */
        int last = i == CREVICE_CELLS - 1;
        double c = w->next[i], left = i ? scale * 0.5 * (w->gap[i] + w->gap[i - 1]) : 2.0 * scale * w->gap[0];
        double right = last ? 0.0 : scale * 0.5 * (w->gap[i] + w->gap[i + 1]);
        double q = crevice_flux(c), slope = (crevice_flux(c + 1e-3) - q) / 1e-3, share = 1.0 - c / CREVICE_CS;
        double need = w->gap[i] * (c - w->c[i]) / CREVICE_STEP + left * (c - (i ? w->next[i - 1] : 0.0));
        if (!last) need += right * (c - w->next[i + 1]);
        w->full[i] = w->full[i] ? need <= q * share : c > CREVICE_CSAT;
        double diagonal = w->gap[i] / CREVICE_STEP + left + right - slope * share + q / CREVICE_CS;
        double rest = q * share - need, below = i ? left : 0.0;
        if (w->full[i]) {
            diagonal = 1.0;
            rest = CREVICE_CSAT - c;
            below = right = 0.0;
        }
        diagonal -= i ? below * w->above[i - 1] : 0.0;
        w->above[i] = right / diagonal;
        w->move[i] = (rest + (i ? below * w->move[i - 1] : 0.0)) / diagonal;
    }
    for (int i = CREVICE_CELLS - 1; i >= 0; i--) {
        if (i < CREVICE_CELLS - 1) w->move[i] += w->above[i] * w->move[i + 1];
        w->next[i] += w->move[i];
        largest = fmax(largest, fabs(w->move[i]) / CREVICE_CSAT);
    }
    return largest;
}

/* Recession over one step: what the balance of a cell needs. */
static void crevice_recede(crevice_line *w)
{
    double scale = CREVICE_D / (CREVICE_LENGTH / CREVICE_CELLS) / (CREVICE_LENGTH / CREVICE_CELLS);
    for (int i = 0; i < CREVICE_CELLS; i++) {
        double c = w->next[i], left = i ? scale * 0.5 * (w->gap[i] + w->gap[i - 1]) : 2.0 * scale * w->gap[0];
        double need = w->gap[i] * (c - w->c[i]) / CREVICE_STEP + left * (c - (i ? w->next[i - 1] : 0.0));
        if (i < CREVICE_CELLS - 1) need += scale * 0.5 * (w->gap[i] + w->gap[i + 1]) * (c - w->next[i + 1]);
        w->move[i] = CREVICE_STEP * need / (CREVICE_CS - c);
    }
    for (int i = 0; i < CREVICE_CELLS; i++) {
        w->gap[i] += w->move[i];
        w->c[i] = w->next[i];
    }
}

/* Up to the end; 0: no convergence. */
static int crevice_reference(crevice_line *w)
{
    memset(w, 0, sizeof *w);
    for (int i = 0; i < CREVICE_CELLS; i++) {
        double x = (i + 0.5) * CREVICE_LENGTH / CREVICE_CELLS;
        w->gap[i] = crevice_gap(x);
        w->c[i] = w->next[i] = crevice_initial(x);
    }
    for (int step = 0; step * CREVICE_STEP < CREVICE_TIME - 1.0; step++) {
        int round = 0;
        while (crevice_correct(w) > 1e-9)
            if (++round == 60) return 0;
        crevice_recede(w);
    }
    return 1;
}

/* ---- the same in 2D ---- */

/* The mouth holds 0. */
static double crevice_held(void *user, const double *x)
{
    (void)user;
    return x[0] < 1e-9 * CREVICE_LENGTH ? 0.0 : (double)NAN;
}

static pd_status crevice_build(val_job *job)
{
    val_lab *lab = job->lab;
    double hx = 50e-6 / job->level.n, hy = 2e-6 / job->level.n;
    lab_box(lab, hx, job->level.m, 0.0, CREVICE_LENGTH);
    lab->stencil_desc.h[1] = hy;
    lab->grid_desc.lo[1] = -CREVICE_METAL;
    lab->grid_desc.hi[1] = CREVICE_MOUTH;
    for (int side = 0; side < 4; side++) lab->grid_desc.side[side] = side ? PD_SIDE_MIRROR : PD_SIDE_WALL;
    lab->grid_desc.solid = &lab->shapes[0];
    lab->shapes[0].type = PD_SHAPE_HALF_SPACE;
    lab->shapes[0].b[0] = -(CREVICE_MOUTH - CREVICE_END);
    lab->shapes[0].b[1] = CREVICE_LENGTH;
    lab->transport_desc.diffusivity = CREVICE_D;
    lab->transport_desc.held = crevice_held;
    lab->dissolve_desc.model = PD_METAL_BONDS;
    lab->dissolve_desc.solid = CREVICE_CS;
    lab->dissolve_desc.saturation = CREVICE_CSAT;
    lab->dissolve_desc.rate = crevice_law;
    lab->dissolve_desc.uniform = 1;
    lab->couple_desc.fraction = 0.2;
    return lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE);
}

/* [m] that column i has lost. */
static double crevice_depth(const val_lab *lab, int column)
{
    double sum = 0.0;
    int i[PD_DIM];
    i[0] = column;
    for (i[1] = 0; i[1] < lab->grid.n[1]; i[1]++) {
        double x[PD_DIM];
        int32_t node = pd_grid_node(&lab->grid, i);
        pd_grid_position(&lab->grid, node, x);
        if (CREVICE_MOUTH - x[1] < crevice_gap(x[0])) continue;
        sum += lab->grid.kind[node] == PD_FLUID
                   ? 1.0
                   : (CREVICE_CS - lab->transport.c[node]) / (CREVICE_CS - CREVICE_CSAT);
    }
    return sum * lab->grid.h[1];
}

static void crevice_curves(val_job *job, const crevice_line *w)
{
    val_curve *line = val_add_curve(job, "equation of the gap", PD_SERIES_STYLE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
    if (!job->profile) return;
    job->profile->title = "Metal lost along the crevice after 72 h";
    job->profile->x_label = "distance from the mouth [mm]";
    job->profile->y_label = "depth [um]";
    for (int i = 0; i < CREVICE_CELLS; i++) {
        double x = (i + 0.5) * CREVICE_LENGTH / CREVICE_CELLS;
        val_add_point(line, 1e3 * x, 1e6 * (w->gap[i] - crevice_gap(x)));
    }
    for (int i = 0; i < job->lab->grid.n[0]; i += 4)
        val_add_point(found, 1e3 * (i + 0.5) * job->lab->grid.h[0], 1e6 * crevice_depth(job->lab, i));
}

static pd_status crevice_run(val_job *job)
{
    static crevice_line reference;
    val_lab *lab = job->lab;
    double deepest[2] = {0.0, 0.0}, place[2] = {0.0, 0.0}, mean[2] = {0.0, 0.0};
    if (!crevice_reference(&reference)) return PD_ERR_STATE;
    PD_TRY(crevice_build(job));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&lab->grid, i, x);
        if (lab->grid.kind[i] == PD_FLUID) lab->transport.c[i] = crevice_initial(x[0]);
    }
    PD_TRY(pd_time_loop_run(job->ctx, &lab->couple, CREVICE_TIME, 0.0, NULL, NULL));
    for (int which = 0; which < 2; which++) {
        int cells = which ? lab->grid.n[0] : CREVICE_CELLS;
        for (int i = 0; i < cells; i++) {
            double x = (i + 0.5) * CREVICE_LENGTH / cells;
            double depth = which ? crevice_depth(lab, i) : reference.gap[i] - crevice_gap(x);
            mean[which] += depth / cells;
            if (depth > deepest[which]) {
                deepest[which] = depth;
                place[which] = x;
            }
        }
    }
    crevice_curves(job, &reference);
    job->out->h = lab->grid.h[0];
    job->out->err[0] = fabs(deepest[1] / deepest[0] - 1.0);
    job->out->err[1] = fabs(place[1] - place[0]) / CREVICE_LENGTH;
    job->out->err[2] = fabs(mean[1] / mean[0] - 1.0);
    job->out->err[3] = lab->couple.ledger[0].relative_imbalance;
    job->out->steps = (long)lab->couple.steps;
    return PD_OK;
}

static const val_part crevice_part = {
    "", "", "cells over 50 x 2 um", VAL_BY_N, NULL, 1.0,
    {{"err_depth", "depth of the trench"}, {"err_place", "place, over the length"}, {"err_mean", "mean depth"},
     {"ledger", "imbalance"}}, 4,
    {{3, 1e-12, 0.0, 0, VAL_GOAL}, {0, 0.12, 0.0, 2, VAL_GUARD}, {1, 0.012, 0.0, 2, VAL_GUARD},
     {2, 0.09, 0.0, 2, VAL_GUARD}, {0, 0.2, 0.0, 0, VAL_GUARD}, {2, 0.0, 0.8, 0, VAL_GUARD}}, 6,
    {{1, 4.0, 0.0}, {2, 4.0, 0.0}}, 2, 1, crevice_run, NULL};
static const val_part *const crevice_parts[] = {&crevice_part};

static const val_case crevice_case = {
    "crevice", "Three days in a crevice of alloy 625",
    "Half of a wedge 12.7 mm long and 25 to 5 um wide, over metal whose current grows with what is dissolved, from "
    "9e-4 to 3.2 A/m2 at saturation; the last 3 mm start at 99 % of saturation, the mouth is held at 0. Elliptical "
    "horizon of 4 cells of 25 x 1 um, and of twice that size. Depth and place of the trench that the attack carves "
    "after it has stalled, and the mean loss, against the equation of a gap that is long and thin.",
    "Weights of elliptical horizons, calibration by trial runs, laws that run away, a salt layer that does not let go.",
    "d(g C)/dt = d/dx(D g dC/dx) + q(C), dg/dt = q/Cs, C at most Csat, solved on 1016 cells with steps of 80 s "
    "(3 in a thousand from its limit); tables `crevice_625_setup.csv` and `crevice_625_iC.csv`",
    crevice_parts, 1};

#endif
#endif
