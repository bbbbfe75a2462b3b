/* vessel: a strip of fluid at rest whose species diffuse, move in their potential, react and precipitate, for
 * validation cases and tests. Include pdcorr.h, or react/advance.h, before.
 *
 * The first failure stays in `status`, and nothing is done after it: a caller looks once, at the end.
 */
#ifndef CASES_VESSEL_H
#define CASES_VESSEL_H
#include <math.h>
#include <string.h>

typedef struct vessel {
    pd_ctx *ctx;
    pd_status status;
    pd_side side;  /* behind the ends of axis 0; those of other axes are mirrors */
    int n;         /* cells along axis 0 */
    double h, m;   /* [m], [-] */
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_species species[PD_SPECIES_MAX];
    pd_reaction reaction[PD_REACTION_MAX];
    pd_mineral mineral[PD_MINERAL_MAX];
    int count, reactions, minerals;
    double initial[PD_SPECIES_MAX]; /* [mol/m3] */
    pd_reactive_desc desc;
    pd_reactive reactive;
    pd_reactive_result result;
    int steps;
} vessel;

/* n cells of h [m]; species and reactions are added, then it is filled. */
static inline void vessel_begin(pd_ctx *ctx, vessel *v, int n, double h, double m)
{
    memset(v, 0, sizeof *v);
    v->ctx = ctx;
    v->side = PD_SIDE_WALL;
    v->n = n;
    v->h = h;
    v->m = m;
}

/* Number of a species of diffusivity d [m2/s]; formula NULL: the name is one. */
static inline int vessel_species(vessel *v, const char *name, const char *formula, double d, double initial)
{
    pd_species_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.name = name;
    desc.formula = formula;
    desc.diffusivity = d;
    if (v->status >= 0) v->status = pd_species_read(v->ctx, &desc, &v->species[v->count]);
    v->initial[v->count] = initial;
    return v->count++;
}

/* In equilibrium. */
static inline void vessel_reaction(vessel *v, const char *text, double log10_k)
{
    pd_reaction_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.k = log10_k;
    desc.k_unit = "log10";
    if (v->status >= 0)
        v->status = pd_reaction_read(v->ctx, &desc, v->species, v->count, &v->reaction[v->reactions++]);
}

/* A solid; its reaction is added apart. */
static inline pd_mineral *vessel_mineral(vessel *v, const char *name, double initial)
{
    pd_mineral *m = &v->mineral[v->minerals++];
    m->species = vessel_species(v, name, NULL, 0.0, initial);
    return m;
}

/* v->desc has what is wanted besides. */
static inline void vessel_fill(vessel *v)
{
    pd_stencil_desc stencil;
    pd_grid_desc grid;
    pd_reactive_desc *d = &v->desc;
    memset(&stencil, 0, sizeof stencil);
    memset(&grid, 0, sizeof grid);
    stencil.m = v->m;
    for (int e = 0; e < PD_DIM; e++) {
        stencil.h[e] = v->h;
        grid.hi[e] = (e ? 4 : v->n) * v->h;
        grid.side[2 * e] = grid.side[2 * e + 1] = e ? PD_SIDE_MIRROR : v->side;
    }
    d->species = v->species;
    d->count = v->count;
    d->reactions = v->reaction;
    d->reaction_count = v->reactions;
    d->minerals = v->minerals ? v->mineral : NULL;
    d->mineral_count = v->minerals;
    d->initial = v->initial;
    d->temperature = 298.15;
    if (v->status >= 0) v->status = pd_stencil_build(v->ctx, &stencil, &v->stencil);
    if (v->status >= 0) v->status = pd_grid_build(v->ctx, &v->stencil, &grid, &v->grid);
    if (v->status >= 0) v->status = pd_bonds_build(v->ctx, &v->stencil, &v->grid, PD_BONDS_NO_FLOW, &v->bonds);
    if (v->status >= 0) v->status = pd_reactive_build(v->ctx, &v->grid, &v->bonds, NULL, d, &v->reactive);
}

/* The node of cell k along axis 0, beside the first along the others. */
static inline int32_t vessel_node(const vessel *v, int k)
{
    int at[3] = {0, 1, 1};
    at[0] = k;
    return pd_grid_node(&v->grid, at);
}

/* [m] of cell k. */
static inline double vessel_place(const vessel *v, int k) { return (k + 0.5) * v->h; }

static inline double *vessel_field(vessel *v, int species) { return pd_reactive_field(&v->reactive, species); }

/* Each cell gets what `of` says of its place, in all species. */
static inline void vessel_pour(vessel *v, void (*of)(void *user, double x, double *c), void *user)
{
    double x[PD_DIM], c[PD_SPECIES_MAX];
    for (int32_t i = 0; i < v->grid.total && v->status >= 0; i++) {
        if (v->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&v->grid, i, x);
        memcpy(c, v->initial, sizeof c);
        of(user, x[0], c);
        for (int s = 0; s < v->count; s++)
            if (vessel_field(v, s)) vessel_field(v, s)[i] = c[s];
    }
    if (v->status >= 0) v->status = pd_reactive_begin(v->ctx, &v->reactive);
}

/* A flux [mol/m2/s] of a species enters at the first end of axis 0. */
static inline void vessel_enter(vessel *v, int species, double flux)
{
    double x[PD_DIM];
    for (int32_t i = 0; i < v->grid.total && v->status >= 0; i++) {
        pd_grid_position(&v->grid, i, x);
        if (v->grid.kind[i] == PD_FLUID && x[0] < v->h) pd_reactive_source(&v->reactive, species)[i] = flux / v->h;
    }
}

static inline void vessel_step(vessel *v, double dt)
{
    if (v->status < 0) return;
    v->status = pd_reactive_step(v->ctx, &v->reactive, dt, &v->result);
    if (v->status > 0) /* the case asks for this step */
        v->status = pd_fail(v->ctx, PD_ERR_DIVERGED, "vessel", "a step of %g s was refused", dt);
    v->steps++;
}

/* Largest relative imbalance of elements, charge and what the solvent keeps. */
static inline double vessel_imbalance(const vessel *v)
{
    double worst = 0.0;
    for (int row = 0; row < v->reactive.rows && v->status >= 0; row++) {
        pd_reactive_balance b;
        pd_reactive_balance_of(v->ctx, &v->reactive, row, &b);
        worst = fmax(worst, b.relative);
    }
    return worst;
}

/* The least concentration and amount [mol/m3]. */
static inline double vessel_least(vessel *v)
{
    double least = HUGE_VAL;
    for (int32_t i = 0; i < v->grid.total && v->status >= 0; i++)
        for (int s = 0; s < v->count && v->grid.kind[i] == PD_FLUID; s++)
            if (vessel_field(v, s)) least = fmin(least, vessel_field(v, s)[i]);
    return least;
}

static inline pd_status vessel_end(vessel *v)
{
    pd_reactive_free(v->ctx, &v->reactive);
    pd_bonds_free(v->ctx, &v->bonds);
    pd_grid_free(v->ctx, &v->grid);
    pd_stencil_free(v->ctx, &v->stencil);
    return v->status;
}

#endif
