/* volumes: plain finite volumes of second order on squares, to compare with. Fields: linear reconstruction with van
 * Leer's limiter, central diffusion, Heun's steps. Flow in a cavity: velocities on the faces, central differences,
 * artificial compressibility (A. J. Chorin, J. Comput. Phys. 2, 1967) up to the steady state. */
#ifndef BENCH_VOLUMES_H
#define BENCH_VOLUMES_H
#if PD_DIM == 2

enum { VOLUMES_GHOST = 2 };

typedef enum volumes_edge {
    VOLUMES_PERIODIC = 0,
    VOLUMES_TURN, /* of Smith and Hutton's problem */
    VOLUMES_OPEN  /* no gradient */
} volumes_edge;

typedef struct volumes {
    int n[2], stride;
    double lo[2], h, diffusivity;
    volumes_edge edge;
    double *c, *start, *before, *rate; /* [size] with ghosts */
    double *u[2];                      /* [size] velocity through the lower face of a cell along each axis */
    int64_t size;
} volumes;

static int64_t volumes_at(const volumes *v, int i, int j)
{
    return (int64_t)(j + VOLUMES_GHOST) * v->stride + i + VOLUMES_GHOST;
}

static void volumes_free(pd_ctx *ctx, volumes *v)
{
    PD_DELETE(ctx, v->size, v->c);
    PD_DELETE(ctx, v->size, v->start);
    PD_DELETE(ctx, v->size, v->before);
    PD_DELETE(ctx, v->size, v->rate);
    for (int d = 0; d < 2; d++) PD_DELETE(ctx, v->size, v->u[d]);
}

static pd_status volumes_build(pd_ctx *ctx, volumes *v, rotation_stream_fn stream)
{
    v->stride = v->n[0] + 2 * VOLUMES_GHOST;
    v->size = (int64_t)v->stride * (v->n[1] + 2 * VOLUMES_GHOST);
    PD_TRY(PD_NEW(ctx, "bench", v->size, v->c));
    PD_TRY(PD_NEW(ctx, "bench", v->size, v->start));
    PD_TRY(PD_NEW(ctx, "bench", v->size, v->before));
    PD_TRY(PD_NEW(ctx, "bench", v->size, v->rate));
    for (int d = 0; d < 2; d++) PD_TRY(PD_NEW(ctx, "bench", v->size, v->u[d]));
    for (int j = 0; j <= v->n[1]; j++)
        for (int i = 0; i <= v->n[0]; i++)
            for (int d = 0; d < 2 && stream; d++) {
                double x[2] = {v->lo[0] + (i + (d ? 0.5 : 0.0)) * v->h, v->lo[1] + (j + (d ? 0.0 : 0.5)) * v->h}, u[2];
                stream(NULL, x, u);
                v->u[d][volumes_at(v, i, j)] = u[d];
            }
    return PD_OK;
}

/* The value behind the side x or y = side of the cell next to it, `inside`, at the middle x of their face. */
static double volumes_beyond(const volumes *v, int side, const double *x, double inside)
{
    if (v->edge == VOLUMES_OPEN || (side == 2 && x[0] > 0.0)) return inside;
    return 2.0 * (side == 2 ? turn_inlet(NULL, x) : TURN_WALL) - inside;
}

static void volumes_ghosts(volumes *v)
{
    for (int d = 0; d < 2; d++)
        for (int along = d ? -VOLUMES_GHOST : 0; along < v->n[1 - d] + (d ? VOLUMES_GHOST : 0); along++)
            for (int g = 0; g < VOLUMES_GHOST; g++)
                for (int up = 0; up < 2; up++) {
                    int ghost[2], from[2];
                    double x[2];
                    ghost[1 - d] = from[1 - d] = along;
                    ghost[d] = up ? v->n[d] + g : -1 - g;
                    from[d] = v->edge == VOLUMES_PERIODIC ? (up ? g : v->n[d] - 1 - g) : up ? v->n[d] - 1 : 0;
                    x[1 - d] = v->lo[1 - d] + (along + 0.5) * v->h;
                    x[d] = v->lo[d] + (up ? v->n[d] * v->h : 0.0);
                    double inside = v->c[volumes_at(v, from[0], from[1])];
                    v->c[volumes_at(v, ghost[0], ghost[1])] =
                        v->edge == VOLUMES_PERIODIC ? inside : volumes_beyond(v, 2 * d + up, x, inside);
                }
}

static double volumes_slope(double left, double right)
{
    return left * right > 0.0 ? 2.0 * left * right / (left + right) : 0.0;
}

/* rate = -div(u c - D grad c). */
static void volumes_rates(volumes *v)
{
    volumes_ghosts(v);
    memset(v->rate, 0, (size_t)v->size * sizeof *v->rate);
    for (int d = 0; d < 2; d++) {
        int64_t step = d ? v->stride : 1;
        for (int j = 0; j < v->n[1] + d; j++)
            for (int i = 0; i < v->n[0] + 1 - d; i++) {
                int64_t at = volumes_at(v, i, j);
                const double *c = v->c + at;
                double u = v->u[d][at], value;
                if (u > 0.0) value = c[-step] + 0.5 * volumes_slope(c[-step] - c[-2 * step], c[0] - c[-step]);
                else value = c[0] - 0.5 * volumes_slope(c[0] - c[-step], c[step] - c[0]);
                double flux = (u * value - v->diffusivity * (c[0] - c[-step]) / v->h) / v->h;
                v->rate[at] += flux;
                v->rate[at - step] -= flux;
            }
    }
}

/* One of Heun's steps. Returns the largest rate at its start. */
static double volumes_step(volumes *v, double dt)
{
    double most = 0.0;
    for (int stage = 0; stage < 2; stage++) {
        volumes_rates(v);
        for (int j = 0; j < v->n[1]; j++)
            for (int i = 0; i < v->n[0]; i++) {
                int64_t at = volumes_at(v, i, j);
                if (!stage) {
                    most = fmax(most, fabs(v->rate[at]));
                    v->before[at] = v->c[at];
                    v->c[at] += dt * v->rate[at];
                } else
                    v->c[at] = 0.5 * (v->before[at] + v->c[at] + dt * v->rate[at]);
            }
    }
    return most;
}

/* Half of the longest step that keeps upwind values within their bounds. */
static double volumes_limit(const volumes *v)
{
    double speed = 0.0;
    for (int j = 0; j < v->n[1]; j++)
        for (int i = 0; i < v->n[0]; i++) {
            int64_t at = volumes_at(v, i, j);
            speed = fmax(speed, fabs(v->u[0][at]) + fabs(v->u[1][at]));
        }
    return 0.5 / (speed / v->h + 4.0 * v->diffusivity / (v->h * v->h));
}

static double volumes_off(const volumes *v)
{
    double off = 0.0, size = 0.0;
    for (int j = 0; j < v->n[1]; j++)
        for (int i = 0; i < v->n[0]; i++) {
            int64_t at = volumes_at(v, i, j);
            off += fabs(v->c[at] - v->start[at]);
            size += v->start[at];
        }
    return off / size;
}

static pd_status volumes_round(pd_ctx *ctx, volumes *v, rotation_field_fn field, rotation_stream_fn stream, double *err)
{
    PD_TRY(volumes_build(ctx, v, stream));
    for (int j = 0; j < v->n[1]; j++)
        for (int i = 0; i < v->n[0]; i++) {
            double x[2] = {(i + 0.5) * v->h, (j + 0.5) * v->h};
            v->c[volumes_at(v, i, j)] = v->start[volumes_at(v, i, j)] = field(x);
        }
    int steps = (int)ceil(1.0 / volumes_limit(v));
    for (int k = 0; k < steps; k++) volumes_step(v, 1.0 / steps);
    *err = volumes_off(v);
    return PD_OK;
}

static pd_status volumes_rotation(pd_ctx *ctx, int n, rotation_field_fn field, rotation_stream_fn stream, double *err)
{
    volumes v;
    memset(&v, 0, sizeof v);
    v.n[0] = v.n[1] = n;
    v.h = 1.0 / n;
    pd_status status = volumes_round(ctx, &v, field, stream, err);
    volumes_free(ctx, &v);
    return status;
}

static pd_status volumes_wave(pd_ctx *ctx, int n, double p, double *err)
{
    (void)p;
    return volumes_rotation(ctx, n, rotation_wave, rotation_along, err);
}
static pd_status volumes_cone(pd_ctx *ctx, int n, double p, double *err)
{
    (void)p;
    return volumes_rotation(ctx, n, rotation_cone, rotation_turn, err);
}
static pd_status volumes_disc(pd_ctx *ctx, int n, double p, double *err)
{
    (void)p;
    return volumes_rotation(ctx, n, rotation_disc, rotation_turn, err);
}

/* To the steady state of Smith and Hutton's problem: until nothing changes by 1e-6 a unit of time, or for 30 units, in
 * which the slowest stream passes fifteen times. */
static pd_status volumes_outlet(pd_ctx *ctx, volumes *v, double peclet, double *err)
{
    double s[VAL_POINTS], f[VAL_POINTS], t = 0.0;
    const turn_table *table = turn_of(peclet);
    int count = 0;
    PD_TRY(volumes_build(ctx, v, turn_velocity));
    double dt = volumes_limit(v);
    for (int j = 0; j < v->n[1]; j++)
        for (int i = 0; i < v->n[0]; i++) v->c[volumes_at(v, i, j)] = TURN_WALL;
    while (t < 30.0 && (volumes_step(v, dt) > 1e-6 || t < 1.0)) t += dt;
    for (int i = v->n[0] / 2; i < v->n[0]; i++) {
        s[count] = v->lo[0] + (i + 0.5) * v->h;
        f[count++] = (9.0 * v->c[volumes_at(v, i, 0)] - v->c[volumes_at(v, i, 1)]) / 8.0;
    }
    s[count] = 1.0;
    f[count++] = TURN_WALL;
    *err = turn_error(table, s, f, count);
    return PD_OK;
}

static pd_status volumes_turn(pd_ctx *ctx, int n, double peclet, double *err)
{
    volumes v;
    memset(&v, 0, sizeof v);
    v.n[0] = 2 * n;
    v.n[1] = n;
    v.lo[0] = -1.0;
    v.h = 1.0 / n;
    v.diffusivity = 1.0 / peclet;
    v.edge = VOLUMES_TURN;
    *err = 0.0;
    pd_status status = volumes_outlet(ctx, &v, peclet, err);
    volumes_free(ctx, &v);
    return status;
}

static pd_status volumes_spread(pd_ctx *ctx, volumes *v, double *err)
{
    double square = 0.0, sum = 0.0;
    PD_TRY(volumes_build(ctx, v, NULL));
    int steps = (int)ceil(GAUSS_TIME / volumes_limit(v));
    for (int pass = 0; pass < 2; pass++) {
        for (int j = 0; j < v->n[1]; j++)
            for (int i = 0; i < v->n[0]; i++) {
                double x[2] = {v->lo[0] + (i + 0.5) * v->h, v->lo[1] + (j + 0.5) * v->h};
                double exact = gauss_field(NULL, x, pass ? GAUSS_TIME : 0.0), *c = &v->c[volumes_at(v, i, j)];
                if (!pass) *c = exact;
                square += pass ? (*c - exact) * (*c - exact) : 0.0;
                sum += pass ? exact * exact : 0.0;
            }
        for (int k = 0; k < steps && !pass; k++) volumes_step(v, GAUSS_TIME / steps);
    }
    *err = sqrt(square / sum);
    return PD_OK;
}

static pd_status volumes_gaussian(pd_ctx *ctx, int n, double p, double *err)
{
    volumes v;
    (void)p;
    memset(&v, 0, sizeof v);
    v.n[0] = v.n[1] = 16 * n;
    v.lo[0] = v.lo[1] = -8.0 * GAUSS_SIGMA;
    v.h = GAUSS_SIGMA / n;
    v.diffusivity = TRANSPORT_D;
    v.edge = VOLUMES_OPEN;
    pd_status status = volumes_spread(ctx, &v, err);
    volumes_free(ctx, &v);
    return status;
}

/* ---- cavity ---- */

/* Velocities on the lower faces of cells: u of axis 0, v of axis 1; p in the middle. Cells from -1 to n. */
typedef struct volumes_cavity {
    int n;
    double h, nu;
    double *u, *v, *p, *du, *dv;
    int64_t size;
} volumes_cavity;

static int64_t cavity_at(const volumes_cavity *k, int i, int j) { return (int64_t)(j + 1) * (k->n + 3) + i + 1; }

static void cavity_ghosts(volumes_cavity *k)
{
    for (int i = -1; i <= k->n + 1; i++) {
        k->u[cavity_at(k, i, -1)] = -k->u[cavity_at(k, i, 0)];
        k->u[cavity_at(k, i, k->n)] = 2.0 - k->u[cavity_at(k, i, k->n - 1)];
        k->v[cavity_at(k, -1, i)] = -k->v[cavity_at(k, 0, i)];
        k->v[cavity_at(k, k->n, i)] = -k->v[cavity_at(k, k->n - 1, i)];
    }
}

/* d a/dt but for the pressure at a place of velocity a, whose axis has the step `s` and the other one `o`; the other
 * velocity b lies around it. */
static double cavity_rate(const volumes_cavity *k, const double *a, const double *b, int64_t s, int64_t o)
{
    double east = 0.5 * (a[0] + a[s]), west = 0.5 * (a[0] + a[-s]);
    double above = 0.25 * (a[0] + a[o]) * (b[o] + b[o - s]), below = 0.25 * (a[0] + a[-o]) * (b[0] + b[-s]);
    return -(east * east - west * west + above - below) / k->h +
           k->nu * (a[s] + a[-s] + a[o] + a[-o] - 4.0 * a[0]) / (k->h * k->h);
}

/* One step. Returns the largest change of a velocity over dt. */
static double cavity_step(volumes_cavity *k, double dt, double stiff)
{
    int64_t row = k->n + 3;
    double most = 0.0;
    cavity_ghosts(k);
    for (int j = 0; j < k->n; j++)
        for (int i = 1; i < k->n; i++) {
            int64_t at = cavity_at(k, i, j), turned = cavity_at(k, j, i);
            k->du[at] = cavity_rate(k, k->u + at, k->v + at, 1, row) - (k->p[at] - k->p[at - 1]) / k->h;
            k->dv[turned] = cavity_rate(k, k->v + turned, k->u + turned, row, 1) -
                            (k->p[turned] - k->p[turned - row]) / k->h;
            most = fmax(most, fmax(fabs(k->du[at]), fabs(k->dv[turned])));
        }
    for (int j = 0; j < k->n; j++)
        for (int i = 1; i < k->n; i++) {
            int64_t at = cavity_at(k, i, j), turned = cavity_at(k, j, i);
            k->u[at] += dt * k->du[at];
            k->v[turned] += dt * k->dv[turned];
        }
    for (int j = 0; j < k->n; j++)
        for (int i = 0; i < k->n; i++) {
            int64_t at = cavity_at(k, i, j);
            k->p[at] -= dt * stiff / k->h * (k->u[at + 1] - k->u[at] + k->v[at + row] - k->v[at]);
        }
    return most;
}

static pd_status cavity_march(pd_ctx *ctx, volumes_cavity *k, const cavity_table *table, double *err)
{
    double s[VAL_POINTS], f[VAL_POINTS], stiff = 2.0;
    double dt = 0.8 * fmin(fmin(2.0 * k->nu, 0.25 * k->h * k->h / k->nu), k->h / (1.0 + sqrt(1.0 + 2.0 * stiff)));
    PD_TRY(PD_NEW(ctx, "bench", k->size, k->u));
    PD_TRY(PD_NEW(ctx, "bench", k->size, k->v));
    PD_TRY(PD_NEW(ctx, "bench", k->size, k->p));
    PD_TRY(PD_NEW(ctx, "bench", k->size, k->du));
    PD_TRY(PD_NEW(ctx, "bench", k->size, k->dv));
    for (int64_t step = 0; cavity_step(k, dt, stiff) > 1e-5 && step * dt < 1e3; step++) continue;
    s[0] = f[0] = 0.0;
    for (int j = 0; j < k->n; j++) {
        s[j + 1] = (j + 0.5) * k->h;
        f[j + 1] = k->u[cavity_at(k, k->n / 2, j)];
    }
    s[k->n + 1] = f[k->n + 1] = 1.0;
    for (int q = 0; q < table->points_u; q++)
        *err = fmax(*err, fabs(enclosed_between(s, f, k->n + 2, 4, table->y[q]) - table->u[q]));
    return PD_OK;
}

static pd_status volumes_lid(pd_ctx *ctx, int n, const cavity_table *table, double *err)
{
    volumes_cavity k;
    memset(&k, 0, sizeof k);
    k.n = n;
    k.h = 1.0 / n;
    k.nu = 1.0 / table->re;
    k.size = (int64_t)(n + 3) * (n + 3);
    *err = 0.0;
    pd_status status = cavity_march(ctx, &k, table, err);
    PD_DELETE(ctx, k.size, k.u);
    PD_DELETE(ctx, k.size, k.v);
    PD_DELETE(ctx, k.size, k.p);
    PD_DELETE(ctx, k.size, k.du);
    PD_DELETE(ctx, k.size, k.dv);
    return status;
}

static pd_status volumes_cavity_400(pd_ctx *ctx, int n, double p, double *err)
{
    (void)p;
    return volumes_lid(ctx, n, &cavity_400, err);
}
static pd_status volumes_cavity_1000(pd_ctx *ctx, int n, double p, double *err)
{
    (void)p;
    return volumes_lid(ctx, n, &cavity_1000, err);
}

#endif
#endif
