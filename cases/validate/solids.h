/* solids: bodies that cases of mechanics work with: points of a lattice, a material, loads, displacements. */
#ifndef VAL_SOLIDS_H
#define VAL_SOLIDS_H

enum { SOLID_T = PD_DIM * PD_DIM };

typedef struct val_solid {
    pd_body_desc desc;
    pd_body body;
    pd_correspondence_desc metal;
    pd_correspondence elastic;
    pd_microelastic_desc spring;
    pd_microelastic springs;
    pd_verlet_desc motion;
    pd_verlet verlet;
    pd_material_interface table;         /* of the material that was built last */
    int32_t room;                        /* points that there is room for */
    double *position, *volume;           /* [room][PD_DIM] [m], [room] [m^d] */
    double *u, *load, *force, *stress;   /* [room][PD_DIM] [m], [N/m3] and [N/m3], [room][PD_DIM^2] [Pa] */
    uint8_t *held;                       /* [room][PD_DIM] */
    int iterations;                      /* of all solves */
} val_solid;

/* Part [-] of a cell of width h [m] around x [m] that belongs to the body; below 0: the cell is left out. May move x to
 * the middle of that part. */
typedef double (*solid_part_fn)(const void *user, double h, double *x);

static void solid_free(pd_ctx *ctx, val_solid *s)
{
    size_t n = (size_t)s->room;
    pd_verlet_free(ctx, &s->verlet);
    pd_microelastic_free(ctx, &s->springs);
    pd_correspondence_free(ctx, &s->elastic);
    pd_body_free(ctx, &s->body);
    PD_DELETE(ctx, n * PD_DIM, s->held);
    PD_DELETE(ctx, n * SOLID_T, s->stress);
    PD_DELETE(ctx, n * PD_DIM, s->force);
    PD_DELETE(ctx, n * PD_DIM, s->load);
    PD_DELETE(ctx, n * PD_DIM, s->u);
    PD_DELETE(ctx, n, s->volume);
    PD_DELETE(ctx, n * PD_DIM, s->position);
    memset(s, 0, sizeof *s);
}

static pd_status solid_room(pd_ctx *ctx, val_solid *s, int32_t room)
{
    size_t n = (size_t)room;
    s->room = room;
    PD_TRY(PD_NEW(ctx, "validate", n * PD_DIM, s->position));
    PD_TRY(PD_NEW(ctx, "validate", n, s->volume));
    PD_TRY(PD_NEW(ctx, "validate", n * PD_DIM, s->u));
    PD_TRY(PD_NEW(ctx, "validate", n * PD_DIM, s->load));
    PD_TRY(PD_NEW(ctx, "validate", n * PD_DIM, s->force));
    PD_TRY(PD_NEW(ctx, "validate", n * SOLID_T, s->stress));
    return PD_NEW(ctx, "validate", n * PD_DIM, s->held);
}

/* n cells of width h [m] along each axis from lo [m] on, or those of them that have a part; the horizon is m h. */
static pd_status solid_cells(pd_ctx *ctx, val_solid *s, const int *n, const double *lo, double h, double m,
                             solid_part_fn part, const void *user)
{
    int32_t all = 1;
    for (int d = 0; d < PD_DIM; d++) all *= n[d];
    PD_TRY(solid_room(ctx, s, all));
    for (int32_t k = 0; k < all; k++) {
        double *x = s->position + (int64_t)s->desc.count * PD_DIM;
        for (int32_t d = 0, rest = k; d < PD_DIM; rest /= n[d], d++) x[d] = lo[d] + (rest % n[d] + 0.5) * h;
        double share = part ? part(user, h, x) : 1.0;
        if (share > 0.0) s->volume[s->desc.count++] = share * pow(h, PD_DIM);
    }
    s->desc.position = s->position;
    s->desc.volume = s->volume;
    s->desc.horizon = m * h;
    s->desc.spacing = h;
    return pd_body_build(ctx, &s->desc, &s->body);
}

/* Small strains with s->metal. */
static pd_status solid_elastic(pd_ctx *ctx, val_solid *s)
{
    PD_TRY(pd_correspondence_build(ctx, &s->body, &s->metal, &s->elastic));
    s->table = pd_correspondence_material(&s->elastic);
    return PD_OK;
}

/* Springs with s->spring. */
static pd_status solid_springs(pd_ctx *ctx, val_solid *s)
{
    PD_TRY(pd_microelastic_build(ctx, &s->body, &s->spring, &s->springs));
    s->table = pd_microelastic_material(&s->springs);
    return PD_OK;
}

/* Displacements at rest and, where the material has one, the stress. */
static pd_status solid_rest(pd_ctx *ctx, val_solid *s)
{
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    memset(&desc, 0, sizeof desc);
    desc.prescribed = s->held;
    PD_TRY(pd_equilibrium_solve(ctx, &s->table, &desc, s->load, s->u, &result));
    s->iterations += result.iterations;
    if (s->table.stress) s->table.stress(ctx, s->table.self, s->u, s->stress);
    return PD_OK;
}

#if PD_DIM == 2
static double solid_radius(const double *x)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) square += x[d] * x[d];
    return sqrt(square);
}

/* A body between two circles about 0, which lies at a corner of cells; radii [m] of 0 and HUGE_VAL: none. */
typedef enum solid_cut {
    SOLID_WHOLE = 0, /* cells whose middle lies in the body count, wholly */
    SOLID_PARTS,     /* cells count with their part, and stay where they are */
    SOLID_MIDDLES    /* and stand in the middle of their part */
} solid_cut;

/* 3: as 2, with exact parts at the rim of the horizon. */
static solid_cut solid_cut_of(double p) { return p < 0.5 ? SOLID_WHOLE : p < 1.5 ? SOLID_PARTS : SOLID_MIDDLES; }

typedef struct solid_round {
    double inner, outer;
    solid_cut cut;
} solid_round;

/* Cells are cut into 64 columns of exact heights. A part of less than an eighth is left out. */
static double solid_round_part(const void *user, double h, double *x)
{
    enum { N = 64 };
    const solid_round *body = (const solid_round *)user;
    double r = solid_radius(x), sum = 0.0, moment[2] = {0.0, 0.0};
    if (body->cut == SOLID_WHOLE) return r > body->inner && r < body->outer ? 1.0 : 0.0;
    if (r > body->inner + h && r < body->outer - h) return 1.0;
    for (int k = 0; k < N; k++) {
        double a = x[0] + h * ((k + 0.5) / N - 0.5), low = fabs(x[1]) - 0.5 * h, high = low + h;
        double from = body->inner > fabs(a) ? sqrt(body->inner * body->inner - a * a) : low;
        double to = body->outer > fabs(a) ? sqrt(body->outer * body->outer - a * a) : low;
        low = fmin(high, fmax(low, from));
        high = fmax(low, fmin(high, to));
        sum += (high - low) / (N * h);
        moment[0] += a * (high - low) / (N * h);
        moment[1] += copysign(0.5 * (high + low), x[1]) * (high - low) / (N * h);
    }
    for (int d = 0; d < 2 && body->cut == SOLID_MIDDLES && sum > 0.0; d++) x[d] = moment[d] / sum;
    return sum < 0.125 ? 0.0 : sum;
}
#endif

#endif
