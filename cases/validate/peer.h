/* peer: bond-based corrosion against a code of the same model with explicit steps. */
#ifndef VAL_PEER_H
#define VAL_PEER_H

/* A stored time of the other code. */
typedef struct peer_row {
    int nodes;                 /* solid */
    double solid, fluid, most; /* [mol] in solid and in fluid nodes, [mol/m3] largest concentration of the fluid */
} peer_row;

/* perifast_corrosion_ref.csv, case A, every 25 steps of 0.4 s. */
static const peer_row peer_cube[21] = {
    {15625, 2.203125e-09, 0.0, 0.0}, {15625, 1.95745641e-09, 0.0, 0.0}, {15593, 1.7119658e-09, 0.0, 0.0},
    {14301, 1.47880996e-09, 0.0, 0.0}, {11427, 1.26722888e-09, 0.0, 0.0}, {9511, 1.07975629e-09, 0.0, 0.0},
    {8561, 9.16942108e-10, 0.0, 0.0}, {6623, 7.65347234e-10, 0.0, 0.0}, {6183, 6.36968704e-10, 0.0, 0.0},
    {4731, 5.18762933e-10, 0.0, 0.0}, {4237, 4.19271006e-10, 0.0, 0.0}, {3139, 3.30390038e-10, 0.0, 0.0},
    {2723, 2.56415085e-10, 0.0, 0.0}, {1985, 1.92565854e-10, 0.0, 0.0}, {1569, 1.40217089e-10, 0.0, 0.0},
    {1143, 9.75286763e-11, 0.0, 0.0}, {799, 6.36166614e-11, 0.0, 0.0}, {493, 3.79582736e-11, 0.0, 0.0},
    {275, 1.94541048e-11, 0.0, 0.0}, {147, 7.44753997e-12, 0.0, 0.0}, {33, 1.17972686e-12, 0.0, 0.0}
};

/* The same, case B, every 100 steps of 0.02 s. */
static const peer_row peer_pit[31] = {
    {5205, 5.950356e-09, 2.88144e-12, 4140}, {5205, 5.93833781e-09, 8.93166682e-12, 4603.78975},
    {5205, 5.92648948e-09, 9.51671651e-12, 4687.92373}, {5205, 5.91466995e-09, 9.54772331e-12, 4547.02646},
    {5205, 5.90283073e-09, 9.55541285e-12, 4595.04634}, {5205, 5.89099151e-09, 9.56133685e-12, 4693.56759},
    {5205, 5.87917198e-09, 9.54754839e-12, 4550.46788}, {5205, 5.86733277e-09, 9.55343597e-12, 4592.36784},
    {5205, 5.85548444e-09, 9.56842643e-12, 4691.06691}, {5205, 5.84366491e-09, 9.5546316e-12, 4652.826},
    {5204, 5.83181244e-09, 9.5787632e-12, 4625.53531}, {5196, 5.81974661e-09, 9.848825e-12, 4761.56318},
    {5180, 5.80623368e-09, 1.1066588e-11, 4772.11323}, {5180, 5.79326954e-09, 1.11576644e-11, 4708.39552},
    {5168, 5.77972242e-09, 1.16992146e-11, 4725.15366}, {5144, 5.76536066e-09, 1.29137159e-11, 4708.21203},
    {5144, 5.7502645e-09, 1.35339429e-11, 4800.96336}, {5136, 5.73482531e-09, 1.39250258e-11, 4678.35484},
    {5124, 5.71870012e-09, 1.47301709e-11, 4759.48088}, {5111, 5.70187098e-09, 1.54857093e-11, 4827.47462},
    {5087, 5.68323803e-09, 1.70959186e-11, 4706.36831}, {5071, 5.66390893e-09, 1.81547771e-11, 4788.99186},
    {5067, 5.6446876e-09, 1.83820838e-11, 4825.68457}, {5047, 5.62397426e-09, 1.96410551e-11, 4763.08067},
    {5027, 5.6023138e-09, 2.07468684e-11, 4806.46876}, {5019, 5.58103004e-09, 2.10712311e-11, 4793.58126},
    {5015, 5.55991587e-09, 2.12169034e-11, 4853.21855}, {5007, 5.53868046e-09, 2.14972466e-11, 4829.41846},
    {4991, 5.51618928e-09, 2.26570468e-11, 4770.04952}, {4951, 5.49047254e-09, 2.5259676e-11, 4785.04662},
    {4919, 5.46388518e-09, 2.67896723e-11, 4735.85032}
};

enum {
    PEER_CUBE_ROWS = (int)(sizeof peer_cube / sizeof peer_cube[0]),
    PEER_PIT_ROWS = (int)(sizeof peer_pit / sizeof peer_pit[0])
};

#define PEER_CUBE_CS 141e3          /* [mol/m3] copper */
#define PEER_CUBE_CSAT 5e3
#define PEER_CUBE_FLUX 7.514095666e-3 /* [mol/m2/s] q */
#define PEER_PIT_CS 142.9e3
#define PEER_PIT_CSAT 4.6e3
#define PEER_PIT_FLUX 2.413597096e-2

static double peer_law(void *user, const pd_rate_at *at)
{
    (void)at;
    return *(const double *)user;
}

/* Printed weights, whole cells; box and metal in cells, with a node at the origin. The flux q through the bonds leaves
 * Csat in the nodes: the speed is q/(Cs - Csat). */
static pd_status peer_build(val_job *job, double h, const double box[2][3], const double metal[2][3], int solid)
{
    val_lab *lab = job->lab;
    lab_box(lab, h, job->level.m, 0.0, 0.0);
    lab->stencil_desc.weights = PD_WEIGHTS_PUBLISHED;
    lab->stencil_desc.family = PD_FAMILY_FULL_CELLS;
    for (int d = 0; d < PD_DIM; d++) {
        lab->grid_desc.lo[d] = box[0][d] * h;
        lab->grid_desc.hi[d] = box[1][d] * h;
        lab->shapes[0].a[d] = metal[0][d] * h;
        lab->shapes[0].b[d] = metal[1][d] * h;
    }
    lab->grid_desc.solid = &lab->shapes[solid];
    lab->shapes[0].type = PD_SHAPE_BOX;
    lab->dissolve_desc.model = PD_METAL_BONDS;
    lab->dissolve_desc.kernel = PD_KERNEL_INVERSE;
    lab->dissolve_desc.weights = PD_WEIGHTS_PUBLISHED;
    lab->dissolve_desc.rate = peer_law;
    lab->dissolve_desc.uniform = 1;
    lab->couple_desc.fraction = 0.2;
    job->out->h = h;
    return lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE);
}

/* Metal and fluid with what they hold. */
static peer_row peer_state(const val_lab *lab)
{
    peer_row row = {0, 0.0, 0.0, 0.0};
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double c = lab->transport.c[i];
        row.nodes += lab->grid.kind[i] == PD_SOLID;
        if (lab->grid.kind[i] == PD_SOLID) row.solid += c * lab->stencil.volume;
        if (lab->grid.kind[i] != PD_FLUID) continue;
        row.fluid += c * lab->stencil.volume;
        row.most = fmax(row.most, c);
    }
    return row;
}

static double peer_off(double found, double stored, double scale) { return fabs(found - stored) / scale; }

/* Stored times are `apart` [s] apart, the first of them is the start. Differences are over the metal of the start. The
 * last figure is how far the fluid gets above saturation. */
static pd_status peer_compare(val_job *job, const peer_row *row, double apart)
{
    double *err = job->out->err;
    for (int k = 0; k < job->level.n; k++) {
        if (k) PD_TRY(pd_time_loop_run(job->ctx, &job->lab->couple, k * apart, 0.0, NULL, NULL));
        peer_row found = peer_state(job->lab);
        err[0] = fmax(err[0], peer_off(found.nodes, row[k].nodes, row[0].nodes));
        err[1] = fmax(err[1], peer_off(found.solid, row[k].solid, row[0].solid));
        err[2] = fmax(err[2], peer_off(found.fluid, row[k].fluid, row[0].solid));
        err[3] = fmax(err[3], found.most / job->lab->dissolve_desc.saturation - 1.0);
    }
    job->out->steps = (long)job->lab->couple.steps;
    return PD_OK;
}

/* A copper cube dissolves under activation control. */
static pd_status peer_cube_run(val_job *job)
{
    static const double box[2][3] = {{-19.5, -19.5, -19.5}, {19.5, 19.5, 19.5}};
    static const double metal[2][3] = {{-12.5, -12.5, -12.5}, {12.5, 12.5, 12.5}};
    static double speed = PEER_CUBE_FLUX / (PEER_CUBE_CS - PEER_CUBE_CSAT);
    pd_dissolve_desc *desc = &job->lab->dissolve_desc;
    desc->solid = PEER_CUBE_CS;
    desc->saturation = PEER_CUBE_CSAT;
    desc->activation = 1;
    desc->rate_user = &speed;
    job->lab->transport_desc.given = 1;
    job->lab->couple_desc.max_step = 0.4;
    PD_TRY(peer_build(job, 1e-6, box, metal, 0));
    return peer_compare(job, peer_cube, 10.0);
}

/* 0 on the sides of the box, and not on metal. */
static double peer_held(void *user, const double *x)
{
    const pd_grid_desc *box = (const pd_grid_desc *)user;
    for (int d = 0; d < PD_DIM; d++)
        if (fabs(x[d] - box->lo[d]) < 1e-9 * box->hi[0] || fabs(x[d] - box->hi[d]) < 1e-9 * box->hi[0]) return 0.0;
    return (double)NAN;
}

/* A pit under a salt layer, its mouth in the middle of a passive surface, in a box that is held at 0. */
static pd_status peer_pit_run(val_job *job)
{
    static const double box[2][3] = {{-16.5, -16.5, -12.5}, {16.5, 16.5, 12.5}};
    static const double metal[2][3] = {{-10.5, -10.5, -7.5}, {10.5, 10.5, 4.5}};
    static double speed = PEER_PIT_FLUX / (PEER_PIT_CS - PEER_PIT_CSAT);
    static uint8_t passive[48 * 48 * 40];
    val_lab *lab = job->lab;
    pd_dissolve_desc *desc = &lab->dissolve_desc;
    double h = 2e-6;
    desc->solid = PEER_PIT_CS;
    desc->saturation = PEER_PIT_CSAT;
    lab->transport_desc.diffusivity = 8.6e-11;
    lab->transport_desc.held = peer_held;
    lab->transport_desc.user = &lab->grid_desc;
    desc->rate_user = &speed;
    desc->passive = passive;
    lab->shapes[1].type = PD_SHAPE_BALL;
    lab->shapes[1].radius = 3.4 * h;
    lab->shapes[1].a[2] = 4.5 * h;
    lab->shapes[2].type = PD_SHAPE_DIFFERENCE;
    lab->shapes[2].child[0] = 0;
    lab->shapes[2].child[1] = 1;
    lab->shapes[2].child_count = 2;
    PD_TRY(peer_build(job, h, box, metal, 2));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&lab->grid, i, x);
        passive[i] = pd_shape_distance(lab->shapes, 0, x) > 0.0;
        if (!passive[i] && lab->grid.kind[i] == PD_FLUID) lab->transport.c[i] = 0.9 * PEER_PIT_CSAT;
    }
    return peer_compare(job, peer_pit, 2.0);
}

#define PEER_MEASURES \
    {{"diff_nodes", "solid nodes"}, {"err_solid", "moles in solid"}, {"err_fluid", "moles in fluid"}, \
     {"above", "above saturation"}}, 4
#define PEER_GOALS \
    {{0, 1e-2, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, 0, VAL_GOAL}, {2, 1e-2, 0.0, 0, VAL_GOAL}, \
     {3, 1e-5, 0.0, 0, VAL_GOAL}}, 4
#define PEER_CUBE_MISS \
    "The outer layer of the cube is a fifth of its nodes, and the nodes of a face turn in the same step: what one " \
    "code turns before a stored time the other turns a step later. The largest difference, 486 of 15,625 nodes, is " \
    "six faces of 9 x 9 nodes. Between that and none there is nothing. A node turns here at the end of the step that " \
    "is nearest to its own end (theory: section 11.6), half a step sooner on average than where one waits for it. " \
    "The amounts show how near both are."
#define PEER_PIT_MISS \
    "Bonds of fluid need a free line of sight here, and conduct along metal as along walls. Those of the other code " \
    "pass through metal. The mouth of the pit is seven cells wide."

static const val_part peer_cube_part = {
    "cube", "Copper cube, activation control", "stored times", VAL_BY_N, NULL, 0.0, PEER_MEASURES, PEER_GOALS,
    {{4, 4.02, 0.0}, {PEER_CUBE_ROWS, 4.02, 0.0}}, 2, 1, peer_cube_run, PEER_CUBE_MISS};

static const val_part peer_pit_part = {
    "pit", "Pit under a salt layer", "stored times", VAL_BY_N, NULL, 0.0, PEER_MEASURES, PEER_GOALS,
    {{13, 3.015, 0.0}, {PEER_PIT_ROWS, 3.015, 0.0}}, 2, 1, peer_pit_run, PEER_PIT_MISS};

static const val_part *const peer_parts[] = {&peer_cube_part, &peer_pit_part};

static const val_case peer_case = {
    "perifast", "Bond-based corrosion against another code",
    "Two runs of PeriFast/Corrosion with its weights and whole cells. It takes forward Euler steps: 500 for a copper "
    "cube of 15,625 nodes under activation control, 3000 for a pit that grows from the middle of a passive surface "
    "under a salt layer. Here steps are implicit, as long for the cube, thirty times as long for the pit. Solid nodes "
    "and moles of solid and of fluid at every stored time, over the metal of the start. The fluid of the other "
    "code gets 5.5 % above saturation; the last column shows by how much it does here.",
    "Weights, fluxes and rates that are off by a factor, metal that vanishes where nodes turn, a salt layer that does "
    "not let go.",
    "table `perifast_corrosion_ref.csv`",
    peer_parts, 2};

#endif
