/* area_weights: see area_weights.h
 *
 * The fit is a linear program: minimise t + lambda d.x over x >= 0 with |A_i x - 1| <= t in every sampled direction
 * and A_i x = 1 along the axes, where x_k is the fraction of the area that symmetry class k of bonds carries (an orbit
 * of the symmetry group) and d_k its length in cells. Its dual has the slack basis as a feasible start, so that the
 * primal simplex method on the dual needs no first phase, and x is read off the objective row.
 */
#include "lattice/area_weights.h"
#include "core/array_registry.h"
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

/* lambda of the linear program [-]: penalty per cell of bond length. Keeps weights on short bonds where long ones
 * reduce the anisotropy by next to nothing. Chosen, not derived. */
#define PDI_AREA_WEIGHTS_LENGTH_PENALTY 1e-3
/* Largest number of symmetry classes in the fit, the shortest ones first: only 3D families on unequal spacings with
 * m > 7 have more. */
#define PDI_AREA_WEIGHTS_MAX_CLASSES 200
/* Subdivisions of the octant (2D: quadrant) of directions for the fit, and for the anisotropy that is reported. */
#define PDI_AREA_WEIGHTS_MESH_FIT (PD_DIM == 3 ? 72 : 90)
#define PDI_AREA_WEIGHTS_MESH_CHECK (PD_DIM == 3 ? 110 : 1800)

/* The linear program: unknowns by symmetry class, constraints by direction. */
typedef struct pdi_area_weights_fit {
    int bonds, classes, bond_capacity;
    int directions, direction_capacity;
    int *class_index; /* [bonds] symmetry class of a bond; -1: carries no weight */
    /* [classes][PD_DIM] offset that stands for the class: |n|, sorted among axes of equal spacing */
    int *class_offset;
    double *length;     /* [classes] |n| [-] */
    double *unit_weight; /* [classes] [1/m] weight of one bond of the class when x = 1 */
    double *normal;     /* [directions][PD_DIM] unit normals; the first PD_DIM are the axes */
    double *tableau;    /* [rows + 1][columns] simplex tableau, the objective row last */
    int *basis;         /* [rows] column of the basic variable of a row */
    int rows, columns;  /* without the objective row */
} pdi_area_weights_fit;

/* Describes the arrays of symmetry classes and directions to the array registry. */
static void pdi_area_weights_list_class_arrays(pdi_array_visitor *owner, void *object)
{
    pdi_area_weights_fit *fit = (pdi_area_weights_fit *)object;
    PDI_ARRAY(owner, fit, class_index, fit->bond_capacity, "1");
    PDI_ARRAY(owner, fit, class_offset, fit->bond_capacity * PD_DIM, "1");
    PDI_ARRAY(owner, fit, length, fit->bond_capacity, "1");
    PDI_ARRAY(owner, fit, unit_weight, fit->bond_capacity, "1/m");
    PDI_ARRAY_GROWING(owner, fit, normal, fit->direction_capacity * PD_DIM, "1");
}

/* Describes the simplex tableau to the array registry. */
static void pdi_area_weights_list_tableau_arrays(pdi_array_visitor *owner, void *object)
{
    pdi_area_weights_fit *fit = (pdi_area_weights_fit *)object;
    PDI_ARRAY(owner, fit, tableau, (int64_t)(fit->rows + 1) * fit->columns, "1");
    PDI_ARRAY(owner, fit, basis, fit->rows, "1");
}

PDI_FN double pdi_area_weights_measure_plane(int count, const double *xi, const double *area, const double *normal)
{
    double sum = 0.0;
    for (int k = 0; k < count; k++) {
        double dot = 0.0;
        for (int a = 0; a < PD_DIM; a++) dot += xi[k * PD_DIM + a] * normal[a];
        sum += area[k] * fabs(dot);
    }
    return 0.5 * sum;
}

/* 1: two spacings [m] are equal to rounding. */
static int pdi_area_weights_is_equal_spacing(double a, double b) { return fabs(a - b) <= 1e-9 * fabs(a); }

/* Greatest common divisor of a and b, both >= 0; where one is 0, the other one. */
static int pdi_area_weights_gcd(int a, int b)
{
    while (b) {
        int remainder = a % b;
        a = b;
        b = remainder;
    }
    return a;
}

/* key [PD_DIM] = components |n_a| of the bond xi [m] on the spacings h [m], descending among axes of equal spacing:
 * bonds with equal keys are of one symmetry class. Returns the greatest common divisor of the key; 1: no lattice node
 * lies inside the bond. */
static int pdi_area_weights_compute_class_key(const double *xi, const double *h, int *key)
{
    int divisor = 0;
    for (int a = 0; a < PD_DIM; a++) {
        key[a] = (int)floor(fabs(xi[a]) / h[a] + 0.5);
        divisor = pdi_area_weights_gcd(key[a], divisor);
    }
    for (int a = 0; a < PD_DIM; a++)
        for (int b = a + 1; b < PD_DIM; b++)
            if (pdi_area_weights_is_equal_spacing(h[a], h[b]) && key[b] > key[a]) {
                int swap = key[a];
                key[a] = key[b];
                key[b] = swap;
            }
    return divisor;
}

/* 1: the keys a and b [PD_DIM] are equal: one symmetry class. */
static int pdi_area_weights_is_same_class(const int *a, const int *b)
{
    for (int d = 0; d < PD_DIM; d++)
        if (a[d] != b[d]) return 0;
    return 1;
}

/* Removes the longest classes until at most PDI_AREA_WEIGHTS_MAX_CLASSES are left; with fewer it does nothing.
 * class_index of their bonds becomes -1 (no weight). The last class takes the number of a removed one. */
static void pdi_area_weights_limit_classes(pdi_area_weights_fit *fit)
{
    while (fit->classes > PDI_AREA_WEIGHTS_MAX_CLASSES) {
        int longest = 0, last = fit->classes - 1;
        for (int k = 1; k <= last; k++)
            if (fit->length[k] > fit->length[longest]) longest = k;
        for (int d = 0; d < PD_DIM; d++) fit->class_offset[longest * PD_DIM + d] = fit->class_offset[last * PD_DIM + d];
        fit->length[longest] = fit->length[last];
        for (int b = 0; b < fit->bonds; b++) {
            if (fit->class_index[b] == longest) fit->class_index[b] = -1;
            if (fit->class_index[b] == last) fit->class_index[b] = longest;
        }
        fit->classes = last;
    }
}

/* Sorts the bonds into symmetry classes: sets classes, class_index, class_offset and length of the fit. Bonds of no
 * class (-1) carry no weight: those with beta <= 0, multiples of a shorter bond (2n measures the direction of n), and
 * the longest classes beyond PDI_AREA_WEIGHTS_MAX_CLASSES. PD_ERR_ARGUMENT: bonds b and count-1-b are not opposite, n
 * is not an integer (both within 1e-6 cells), or not 0 < |n| < m + 1/2. */
static pd_status pdi_area_weights_find_symmetry_classes(pd_ctx *ctx, const double *xi, const double *beta, double m,
                                                        const double *h, pdi_area_weights_fit *fit)
{
    for (int b = 0; b < fit->bonds; b++) {
        int *key = fit->class_offset + fit->classes * PD_DIM;
        int divisor = pdi_area_weights_compute_class_key(xi + b * PD_DIM, h, key);
        double square = 0.0;
        for (int a = 0; a < PD_DIM; a++) {
            double n = xi[b * PD_DIM + a] / h[a], opposite = xi[(fit->bonds - 1 - b) * PD_DIM + a] / h[a];
            if (!(fabs(n + opposite) < 1e-6))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "area", "bond %d has offset %g on axis %d and bond %d has %g, "
                               "expected the opposite", b, n, a, fit->bonds - 1 - b, opposite);
            if (!(fabs(fabs(n) - floor(fabs(n) + 0.5)) < 1e-6))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "area", "bond %d has offset %g on axis %d, expected an integer",
                               b, n, a);
            square += n * n;
        }
        if (!(square > 0.25 && sqrt(square) < m + 0.5 + 1e-6))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "area", "bond %d is %g cells long, expected 0 < |n| < m + 1/2 = %g",
                           b, sqrt(square), m + 0.5);
        fit->class_index[b] = -1;
        if (divisor != 1 || !(beta[b] > 0.0)) continue;
        int k = 0;
        while (!pdi_area_weights_is_same_class(fit->class_offset + k * PD_DIM, key)) k++;
        if (k == fit->classes) {
            fit->length[k] = sqrt(square);
            fit->classes++;
        }
        fit->class_index[b] = k;
    }
    pdi_area_weights_limit_classes(fit);
    return PD_OK;
}

/* Appends `direction` [PD_DIM], which is not zero, as a unit vector to fit->normal, and grows that. */
static pd_status pdi_area_weights_add_direction(pd_ctx *ctx, pdi_area_weights_fit *fit, const double *direction)
{
    double square = 0.0;
    for (int a = 0; a < PD_DIM; a++) square += direction[a] * direction[a];
    if (fit->directions == fit->direction_capacity) {
        int grown = 2 * fit->direction_capacity + 256;
        PD_TRY(PD_GROW(ctx, "area", fit->direction_capacity * PD_DIM, grown * PD_DIM, fit->normal));
        fit->direction_capacity = grown;
    }
    for (int a = 0; a < PD_DIM; a++)
        fit->normal[fit->directions * PD_DIM + a] = direction[a] / sqrt(square);
    fit->directions++;
    return PD_OK;
}

/* Appends to fit->normal the directions of a barycentric mesh of the positive octant (2D: quadrant; 1D: none) with
 * `divisions` parts along an edge, stretched by scale [PD_DIM], without the axes themselves. Of directions that an
 * exchange of axes with equal spacing maps onto each other, the one with descending mesh indices is added. */
static pd_status pdi_area_weights_add_direction_mesh(pd_ctx *ctx, pdi_area_weights_fit *fit, const double *h,
                                                     const double *scale, int divisions)
{
    int index[3];
    for (index[0] = 0; index[0] <= divisions; index[0]++)
        for (index[1] = 0; index[1] <= divisions - index[0]; index[1]++) {
            index[2] = divisions - index[0] - index[1];
            if (PD_DIM < 3 && index[2] > 0) continue;
            if (PD_DIM < 2 && index[1] > 0) continue;
            int keep = 1;
            double direction[PD_DIM];
            for (int a = 0; a < PD_DIM; a++) {
                for (int b = a + 1; b < PD_DIM; b++)
                    if (pdi_area_weights_is_equal_spacing(h[a], h[b]) && index[b] > index[a]) keep = 0;
                if (index[a] == divisions) keep = 0;
                direction[a] = index[a] * scale[a];
            }
            if (keep) PD_TRY(pdi_area_weights_add_direction(ctx, fit, direction));
        }
    return PD_OK;
}

/* Replaces the directions of the fit: the axes first, then a mesh in space with `divisions` parts along an edge and, on
 * unequal spacings, one in lattice coordinates, where the kinks of f are evenly distributed. In 2D the kinks themselves
 * (normals of the bonds) are added, at which f has its minima. */
static pd_status pdi_area_weights_build_directions(pd_ctx *ctx, pdi_area_weights_fit *fit, const double *h,
                                                   int divisions)
{
    double ones[PD_DIM], inverse[PD_DIM];
    int unequal = 0;
    fit->directions = 0;
    for (int a = 0; a < PD_DIM; a++) {
        double axis[PD_DIM];
        for (int b = 0; b < PD_DIM; b++) axis[b] = a == b ? 1.0 : 0.0;
        PD_TRY(pdi_area_weights_add_direction(ctx, fit, axis));
        ones[a] = 1.0;
        inverse[a] = h[0] / h[a];
        if (!pdi_area_weights_is_equal_spacing(h[0], h[a])) unequal = 1;
    }
    PD_TRY(pdi_area_weights_add_direction_mesh(ctx, fit, h, ones, divisions));
    if (unequal) PD_TRY(pdi_area_weights_add_direction_mesh(ctx, fit, h, inverse, divisions));
#if PD_DIM == 2
    for (int k = 0; k < fit->classes; k++) {
        const int *key = fit->class_offset + k * PD_DIM;
        double kink[2];
        kink[0] = key[1] * h[1];
        kink[1] = key[0] * h[0];
        if (key[0] && key[1]) PD_TRY(pdi_area_weights_add_direction(ctx, fit, kink));
    }
#endif
    return PD_OK;
}

/* response [classes] [m] = f of the unit vector `normal` when all bonds of that class have the weight 1/m and all
 * others the weight 0: half the sum of |xi.normal| over the bonds of the class. */
static void pdi_area_weights_compute_response(const pdi_area_weights_fit *fit, const double *xi, const double *normal,
                                              double *response)
{
    for (int k = 0; k < fit->classes; k++) response[k] = 0.0;
    for (int b = 0; b < fit->bonds; b++) {
        double dot = 0.0;
        for (int a = 0; a < PD_DIM; a++) dot += xi[b * PD_DIM + a] * normal[a];
        if (fit->class_index[b] >= 0) response[fit->class_index[b]] += 0.5 * fabs(dot);
    }
}

/* Allocates and fills the simplex tableau of the dual; sets rows, columns, basis (slacks) and unit_weight (1 over the
 * mean response of the class). Rows: a class each (response times unit_weight), then the sum of the multipliers (0
 * along axes: equalities), then the objective. Columns: two multipliers (upper and lower bound, opposite signs) of
 * every direction, the slacks, the right-hand side (length penalty of a class; 1). */
static pd_status pdi_area_weights_build_tableau(pd_ctx *ctx, pdi_area_weights_fit *fit, const double *xi)
{
    int orbits = fit->classes, directions = fit->directions;
    int rows = orbits + 1, columns = 2 * directions + rows + 1;
    fit->rows = rows;
    fit->columns = columns;
    PD_TRY(pdi_array_registry_build(ctx, pdi_area_weights_list_tableau_arrays, fit));
    double response[PDI_AREA_WEIGHTS_MAX_CLASSES];
    for (int k = 0; k < orbits; k++) fit->unit_weight[k] = 0.0;
    for (int i = 0; i < directions; i++) {
        pdi_area_weights_compute_response(fit, xi, fit->normal + i * PD_DIM, response);
        for (int k = 0; k < orbits; k++) {
            fit->tableau[k * columns + 2 * i] = response[k];
            fit->unit_weight[k] += response[k] / directions;
        }
    }
    for (int k = 0; k < orbits; k++) fit->unit_weight[k] = 1.0 / fit->unit_weight[k];
    for (int i = 0; i < directions; i++) {
        for (int k = 0; k < orbits; k++) {
            double *entry = fit->tableau + k * columns + 2 * i;
            entry[0] *= fit->unit_weight[k];
            entry[1] = -entry[0];
        }
        double bounded = i < PD_DIM ? 0.0 : 1.0; /* equality along the axes: multipliers without a bound */
        fit->tableau[orbits * columns + 2 * i] = bounded;
        fit->tableau[orbits * columns + 2 * i + 1] = bounded;
        fit->tableau[rows * columns + 2 * i] = -1.0;
        fit->tableau[rows * columns + 2 * i + 1] = 1.0;
    }
    for (int r = 0; r < rows; r++) {
        fit->basis[r] = 2 * directions + r;
        fit->tableau[r * columns + 2 * directions + r] = 1.0;
        fit->tableau[r * columns + columns - 1] = r < orbits ? PDI_AREA_WEIGHTS_LENGTH_PENALTY * fit->length[r] : 1.0;
    }
    return PD_OK;
}

/* One pivot step of the simplex method: `column` enters the basis in place of the variable of `row` (Gauss-Jordan
 * elimination in all rows, the objective row included). The pivot entry must not be 0. */
static void pdi_area_weights_pivot(pdi_area_weights_fit *fit, int row, int column)
{
    double *pivot_row = fit->tableau + row * fit->columns;
    double inverse = 1.0 / pivot_row[column];
    for (int j = 0; j < fit->columns; j++) pivot_row[j] *= inverse;
    pivot_row[column] = 1.0;
    for (int r = 0; r <= fit->rows; r++) {
        double *other = fit->tableau + r * fit->columns;
        double factor = other[column];
        if (r == row || (factor >= 0.0 && factor <= 0.0)) continue;
        for (int j = 0; j < fit->columns; j++) other[j] -= factor * pivot_row[j];
        other[column] = 0.0;
    }
    fit->basis[row] = column;
}

/* Row that leaves the basis for `column`, of those with an entry > 1e-9 there: smallest ratio of the right-hand side
 * (negative counts as 0) to the entry; of ratios equal within 1e-14 the largest entry. -1: no such entry, the problem
 * is unbounded. */
static int pdi_area_weights_find_leaving_row(const pdi_area_weights_fit *fit, int column)
{
    int best = -1;
    double best_ratio = DBL_MAX, best_pivot = 0.0;
    for (int r = 0; r < fit->rows; r++) {
        double pivot = fit->tableau[r * fit->columns + column];
        if (!(pivot > 1e-9)) continue;
        double ratio = pd_max(fit->tableau[r * fit->columns + fit->columns - 1], 0.0) / pivot;
        if (ratio < best_ratio - 1e-14 || (ratio <= best_ratio + 1e-14 && pivot > best_pivot)) {
            best = r;
            best_ratio = ratio;
            best_pivot = pivot;
        }
    }
    return best;
}

/* Solves the linear program by the primal simplex method, until no reduced cost is below -1e-12. The most negative one
 * enters; after half of the permitted 50 (rows + 20) pivots the first one does (Bland), which ends cycles.
 * PD_ERR_INTERNAL: unbounded, or the limit of pivots is reached. */
static pd_status pdi_area_weights_solve_simplex(pd_ctx *ctx, pdi_area_weights_fit *fit)
{
    const double *objective = fit->tableau + fit->rows * fit->columns;
    int limit = 50 * (fit->rows + 20);
    for (int step = 0; step < limit; step++) {
        int enter = -1;
        double lowest = -1e-12;
        for (int j = 0; j < fit->columns - 1; j++)
            if (objective[j] < lowest) {
                enter = j;
                lowest = objective[j];
                /* the first candidate instead of the best one breaks cycles */
                if (step > limit / 2) break;
            }
        if (enter < 0) return PD_OK;
        int leave = pdi_area_weights_find_leaving_row(fit, enter);
        if (leave < 0) return pd_fail(ctx, PD_ERR_INTERNAL, "area", "the fit of the area weights has no solution");
        pdi_area_weights_pivot(fit, leave, enter);
    }
    return pd_fail(ctx, PD_ERR_INTERNAL, "area", "the fit of the area weights did not end in %d pivots", limit);
}

/* area [bonds] [1/m] = weights from the slacks in the objective row, at least 0; 0 for bonds of no class. Then, for
 * each axis, the error 1 - f along it over h is added to both bonds of one cell along it where their weight is > 0; the
 * result is at least 0. */
static void pdi_area_weights_get_solution(const pdi_area_weights_fit *fit, const double *xi, const double *h,
                                          double *area)
{
    const double *slack = fit->tableau + fit->rows * fit->columns + 2 * fit->directions;
    for (int b = 0; b < fit->bonds; b++) {
        int k = fit->class_index[b];
        area[b] = k < 0 ? 0.0 : pd_max(slack[k], 0.0) * fit->unit_weight[k];
    }
    for (int a = 0; a < PD_DIM; a++) {
        double remainder = 1.0 - pdi_area_weights_measure_plane(fit->bonds, xi, area, fit->normal + a * PD_DIM);
        for (int b = 0; b < fit->bonds; b++) {
            int unit = 1;
            for (int d = 0; d < PD_DIM; d++)
                if (fabs(fabs(xi[b * PD_DIM + d]) - (d == a ? h[a] : 0.0)) > 0.5 * h[d]) unit = 0;
            if (unit && area[b] > 0.0) area[b] = pd_max(area[b] + remainder / h[a], 0.0);
        }
    }
}

/* Allocates the arrays of the fit (the caller frees them, on failure too), solves it, and sets area [bonds] [1/m] and
 * *anisotropy [-], the largest |f - 1| over a finer set of directions. PD_ERR_ARGUMENT: as
 * pdi_area_weights_find_symmetry_classes, or |f - 1| along an axis is not below 1e-9, because the family lacks bonds
 * (area is set then). PD_ERR_INTERNAL: the simplex method fails. */
static pd_status pdi_area_weights_fit_minimax(pd_ctx *ctx, pdi_area_weights_fit *fit, const double *xi,
                                              const double *beta, double m, const double *h, double *area,
                                              double *anisotropy)
{
    PD_TRY(pdi_array_registry_build(ctx, pdi_area_weights_list_class_arrays, fit));
    PD_TRY(pdi_area_weights_find_symmetry_classes(ctx, xi, beta, m, h, fit));
    PD_TRY(pdi_area_weights_build_directions(ctx, fit, h, PDI_AREA_WEIGHTS_MESH_FIT));
    PD_TRY(pdi_area_weights_build_tableau(ctx, fit, xi));
    PD_TRY(pdi_area_weights_solve_simplex(ctx, fit));
    pdi_area_weights_get_solution(fit, xi, h, area);
    PD_TRY(pdi_area_weights_build_directions(ctx, fit, h, PDI_AREA_WEIGHTS_MESH_CHECK));
    *anisotropy = 0.0;
    for (int i = 0; i < fit->directions; i++) {
        double error = fabs(pdi_area_weights_measure_plane(fit->bonds, xi, area, fit->normal + i * PD_DIM) - 1.0);
        *anisotropy = pd_max(*anisotropy, error);
        if (i < PD_DIM && !(error < 1e-9))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "area", "planes normal to axis %d are measured with an error of %g: "
                           "the family lacks bonds", i, error);
    }
    return PD_OK;
}

PDI_FN pd_status pdi_area_weights_compute(pd_ctx *ctx, int count, const double *xi, const double *beta, double m,
                                          const double *h, double *area, double *anisotropy)
{
    if (count < 2 * PD_DIM || count > INT_MAX / 8)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "area", "a family of %d bonds, expected at least %d", count, 2 * PD_DIM);
    for (int a = 0; a < PD_DIM; a++)
        if (!(h[a] > 0.0 && h[a] <= DBL_MAX))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "area", "spacing %g on axis %d, expected > 0", h[a], a);
    pdi_area_weights_fit fit;
    memset(&fit, 0, sizeof fit);
    fit.bonds = count;
    fit.bond_capacity = count + 1;
    pd_status status = pdi_area_weights_fit_minimax(ctx, &fit, xi, beta, m, h, area, anisotropy);
    pdi_array_registry_free(ctx, pdi_area_weights_list_class_arrays, &fit);
    pdi_array_registry_free(ctx, pdi_area_weights_list_tableau_arrays, &fit);
    return status;
}
