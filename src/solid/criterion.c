/* criterion: see criterion.h */
#include "solid/criterion.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Measures that differ by less, over the largest, are the same. */
#define PDI_CRITERION_TIE 1e-9
/* Directions along which cracks are looked at, for the anisotropy. */
#define PDI_CRITERION_WAYS 64

PDI_FN void pdi_criterion_list(pdi_owner *owner, void *object)
{
    pd_criterion *criterion = (pd_criterion *)object;
    int64_t count = criterion->solid.body ? criterion->solid.body->count : 0;
    int energy = criterion->desc.kind == PD_CRITERION_ENERGY, stress = criterion->desc.kind >= PD_CRITERION_PRINCIPAL;
    PDI_ARRAY(owner, criterion, force, energy ? count * PD_DIM : 0, "N/m3");
    PDI_ARRAY(owner, criterion, stress, stress ? count * PD_DIM * PD_DIM : 0, "Pa");
    PDI_ARRAY(owner, criterion, scalar, stress ? count : 0, "Pa");
    PDI_ARRAY(owner, criterion, most, count, "");
}

/* ---- calibration ---- */

/* Sum of beta V r over a whole family of the lattice, or of beta V |n.xi| [m^(d+1)]. */
static double pdi_criterion_sum(const pd_body *body, const double *n)
{
    int reach = (int)ceil(body->horizon / body->spacing + 0.5), wide = 2 * reach + 1, all = 1;
    double volume = 1.0, sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) all *= wide, volume *= body->spacing;
    for (int k = 0; k < all; k++) {
        double xi[PD_DIM], along = 0.0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= wide) {
            xi[d] = (rest % wide - reach) * body->spacing;
            along += n ? n[d] * xi[d] : 0.0;
        }
        double r = pdi_vec_norm(xi);
        if (!(r > 0.0) || !(r < body->horizon + 0.5 * body->spacing)) continue;
        sum += volume * pdi_body_weight(body, PD_INFLUENCE_CONSTANT, r) * (n ? fabs(along) : r);
    }
    return sum;
}

PDI_FN double pdi_criterion_crack(const pd_criterion *c, const double *n)
{
    return 0.5 * c->critical * pdi_criterion_sum(c->solid.body, n) / pdi_vec_norm(n);
}

/* The critical energy whose cracks take `fracture`, mean over all directions. */
static void pdi_criterion_calibrate(pd_criterion *c)
{
    static const double mean[3] = {1.0, 2.0 / PDI_PI, 0.5}; /* of |n.e| */
    double least = HUGE_VAL, most = 0.0;
    c->critical = 2.0 * c->desc.fracture / (mean[PD_DIM - 1] * pdi_criterion_sum(c->solid.body, NULL));
    for (int k = 0; k < PDI_CRITERION_WAYS; k++) {
        double n[3] = {1.0, 0.0, 0.0}, turn = 0.5 * PDI_PI * k / PDI_CRITERION_WAYS;
        if (PD_DIM > 1) n[1] = tan(0.5 * turn);
        if (PD_DIM > 2) n[2] = n[1] * (k % 4) / 3.0;
        double energy = pdi_criterion_crack(c, n);
        least = fmin(least, energy);
        most = fmax(most, energy);
    }
    c->anisotropy = most / least;
}

/* ---- measures ---- */

/* Largest principal stress, or von Mises' one, of a stress in the plane or in space [Pa]. */
static double pdi_criterion_scalar(const pd_criterion *c, const double *stress)
{
    double s[9] = {0.0}, trace = 0.0, second = 0.0, third;
    for (int p = 0; p < PD_DIM; p++) {
        trace += stress[p * PD_DIM + p];
        for (int q = 0; q < PD_DIM; q++) s[3 * p + q] = 0.5 * (stress[p * PD_DIM + q] + stress[q * PD_DIM + p]);
    }
    if (PD_DIM == 2 && c->desc.plane == PD_PLANE_STRAIN) {
        s[8] = c->desc.poisson * trace;
        trace += s[8];
    }
    for (int p = 0; p < 3; p++) s[4 * p] -= trace / 3.0;
    for (int p = 0; p < 9; p++) second += 0.5 * s[p] * s[p];
    if (c->desc.kind == PD_CRITERION_MISES) return sqrt(3.0 * second);
    if (!(second > 0.0)) return trace / 3.0;
    third = s[0] * (s[4] * s[8] - s[5] * s[5]) - s[1] * (s[1] * s[8] - s[5] * s[2]) + s[2] * (s[1] * s[5] - s[4] * s[2]);
    double size = sqrt(second / 3.0), turn = 0.5 * third / (size * size * size); /* = cos(3 angle) */
    return trace / 3.0 + 2.0 * size * cos(acos(fmax(-1.0, fmin(1.0, turn))) / 3.0);
}

/* Stretch of bond b of point i; of small displacements where forces are linear. *r: its length [m]. */
static double pdi_criterion_stretch(const pd_criterion *c, const double *u, int32_t i, int64_t b, double *r)
{
    const double *own = u + (int64_t)i * PD_DIM, *far = u + (int64_t)c->solid.body->column[b] * PD_DIM;
    double xi[PD_DIM], square = 0.0, along = 0.0, more = 0.0;
    pdi_body_bond(c->solid.body, i, b, xi);
    for (int d = 0; d < PD_DIM; d++) {
        double eta = far[d] - own[d];
        square += xi[d] * xi[d];
        along += xi[d] * eta;
        more += eta * (2.0 * xi[d] + eta);
    }
    *r = sqrt(square);
    return c->solid.linear ? along / square : more / (*r * (sqrt(fmax(square + more, 0.0)) + *r));
}

/* Measure of bond b of point i; 0: it does not break. */
static double pdi_criterion_measure(const pd_criterion *c, const double *u, int32_t i, int64_t b)
{
    const pd_body *body = c->solid.body;
    int32_t j = body->column[b];
    double r;
    if (body->broken[b] || (c->desc.spared && (c->desc.spared[i] || c->desc.spared[j]))) return 0.0;
    if (c->desc.kind >= PD_CRITERION_PRINCIPAL) return 0.5 * (c->scalar[i] + c->scalar[j]);
    double stretch = pdi_criterion_stretch(c, u, i, b, &r);
    if (c->desc.kind == PD_CRITERION_STRETCH) return stretch;
    if (!(stretch > 0.0)) return 0.0;
    return c->solid.bond_energy(c->solid.self, u, i, b) / pdi_body_weight(body, PD_INFLUENCE_CONSTANT, r);
}

/* What measures at u need, and the largest one of each point. A bond belongs to the point with the lower number, so
 * both of its ends see the same. */
static pd_status pdi_criterion_look(pd_ctx *ctx, pd_criterion *c, const double *u)
{
    const pd_body *body = c->solid.body;
    int nt = pdi_par_threads(ctx, body->bonds * 20);
    (void)nt;
    if (c->desc.kind == PD_CRITERION_ENERGY) {
        pd_status status = c->solid.force(ctx, c->solid.self, u, c->force);
        if (status != PD_OK) return status;
    }
    if (c->desc.kind >= PD_CRITERION_PRINCIPAL) {
        c->solid.stress(ctx, c->solid.self, u, c->stress);
        for (int64_t i = 0; i < body->count; i++)
            c->scalar[i] = pdi_criterion_scalar(c, c->stress + i * PD_DIM * PD_DIM);
    }
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        c->most[i] = 0.0;
        for (int64_t b = body->row[i]; b < body->row[i + 1]; b++)
            if (body->column[b] > i) c->most[i] = fmax(c->most[i], pdi_criterion_measure(c, u, i, b));
    }
    return PD_OK;
}

/* ---- what breaks ---- */

/* Take the measures of at least `least` to `values`, or break their bonds where that is NULL; how many there are. */
static int64_t pdi_criterion_take(pd_criterion *c, const double *u, double least, int breaks, double *values)
{
    pd_body *body = c->solid.body;
    int64_t found = 0;
    for (int32_t i = 0; i < body->count; i++) {
        if (!(c->most[i] >= least)) continue;
        for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
            int32_t j = body->column[b];
            double measure = j > i ? pdi_criterion_measure(c, u, i, b) : 0.0;
            if (!(measure >= least)) continue;
            if (values) values[found] = measure;
            found++;
            if (!breaks) continue;
            body->broken[b] = 1;
            body->broken[pdi_body_back(body, i, j)] = 1;
        }
    }
    return found;
}

static int pdi_criterion_descend(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p < q) - (p > q);
}

pd_status pd_criterion_break(pd_ctx *ctx, pd_criterion *c, const double *u, int64_t worst, int64_t *broken)
{
    double least = c->critical, *values = NULL;
    *broken = 0;
    pd_status status = pdi_criterion_look(ctx, c, u);
    if (status != PD_OK) return status;
    int64_t found = pdi_criterion_take(c, u, least, 0, NULL);
    if (worst > 0 && found > worst) {
        PDI_TRY(PDI_NEW(ctx, "criterion", found, values));
        pdi_criterion_take(c, u, least, 0, values);
        qsort(values, (size_t)found, sizeof *values, pdi_criterion_descend);
        least = fmax(least, values[worst - 1] - PDI_CRITERION_TIE * values[0]);
        PDI_DELETE(ctx, found, values);
    }
    *broken = pdi_criterion_take(c, u, least, 1, NULL);
    return PD_OK;
}

pd_status pd_criterion_first(pd_ctx *ctx, pd_criterion *c, const double *u, pd_criterion_bond *first)
{
    const pd_body *body = c->solid.body;
    memset(first, 0, sizeof *first);
    first->bond = -1;
    pd_status status = pdi_criterion_look(ctx, c, u);
    if (status != PD_OK) return status;
    for (int32_t i = 0; i < body->count; i++)
        if (c->most[i] > first->measure) {
            first->measure = c->most[i];
            first->from = i;
        }
    if (!(first->measure > 0.0)) return PD_OK;
    for (int64_t b = body->row[first->from]; b < body->row[first->from + 1] && first->bond < 0; b++)
        if (body->column[b] > first->from && pdi_criterion_measure(c, u, first->from, b) >= first->measure)
            first->bond = b;
    first->to = body->column[first->bond];
    for (int d = 0; d < PD_DIM; d++)
        first->place[d] = 0.5 * (body->position[(int64_t)first->from * PD_DIM + d] +
                                 body->position[(int64_t)first->to * PD_DIM + d]);
    first->factor = c->critical / first->measure;
    if (c->desc.kind == PD_CRITERION_ENERGY) first->factor = sqrt(first->factor);
    return PD_OK;
}

/* ---- build ---- */

static pd_status pdi_criterion_check(pd_ctx *ctx, const pd_solid *solid, const pd_criterion_desc *desc)
{
    int energy = desc->kind == PD_CRITERION_ENERGY, derived = energy && !(desc->critical > 0.0);
    if ((int)desc->kind < 0 || desc->kind > PD_CRITERION_MISES)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "criterion", "kind %d, expected 0 to %d", (int)desc->kind,
                        (int)PD_CRITERION_MISES);
    if (!(desc->critical >= 0.0) || !(desc->critical < HUGE_VAL) || !(desc->fracture >= 0.0) ||
        !(desc->fracture < HUGE_VAL) || (!derived && !(desc->critical > 0.0)) || (derived && !(desc->fracture > 0.0)))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "criterion", "a critical value of %g and %g J/m2 of a crack, expected a "
                        "positive value, or for the energy of bonds that of a crack", desc->critical, desc->fracture);
    if (derived && !(solid->body->spacing > 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "criterion", "the points are those of no lattice: expected a spacing, or "
                        "a critical energy");
    if (!(fabs(desc->poisson) < 1.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "criterion", "nu = %g, expected -1 to 0.5", desc->poisson);
    if ((energy && !solid->bond_energy) || (desc->kind >= PD_CRITERION_PRINCIPAL && !solid->stress))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "criterion", "the material %s has no %s", solid->name,
                        energy ? "energies of bonds" : "stress");
    return PD_OK;
}

static pd_status pdi_criterion_make(pd_ctx *ctx, const pd_solid *solid, const pd_criterion_desc *desc, pd_criterion *c)
{
    memset(c, 0, sizeof *c);
    PDI_TRY(pdi_criterion_check(ctx, solid, desc));
    c->desc = *desc;
    c->solid = *solid;
    c->critical = desc->critical;
    c->anisotropy = 1.0;
    if (!(desc->critical > 0.0)) pdi_criterion_calibrate(c);
    return pdi_owner_build(ctx, pdi_criterion_list, c);
}

pd_status pd_criterion_build(pd_ctx *ctx, const pd_solid *solid, const pd_criterion_desc *desc, pd_criterion *criterion)
{
    pd_status status = pdi_criterion_make(ctx, solid, desc, criterion);
    if (status < 0) pd_criterion_free(ctx, criterion);
    return status;
}

void pd_criterion_free(pd_ctx *ctx, pd_criterion *criterion)
{
    pdi_owner_free(ctx, pdi_criterion_list, criterion);
    memset(criterion, 0, sizeof *criterion);
}

#undef PDI_CRITERION_TIE
#undef PDI_CRITERION_WAYS
