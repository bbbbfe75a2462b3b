/* point_batch: see point_batch.h */
#include "solid/point_batch.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Cache lines after which addresses fall into the same cache set, and the distance between fields modulo that. */
#define PDI_POINT_BATCH_CACHE_SETS 64
#define PDI_POINT_BATCH_SET_OFFSET 5

/* Number base that packs the lattice offsets of a bond along three axes into 32 bits. */
#define PDI_POINT_BATCH_OFFSET_BASE 1024

PDI_FN void pdi_point_batch_list(pdi_array_visitor *owner, void *object)
{
    pd_point_batch *band = (pd_point_batch *)object;
    int64_t count = band->body ? band->body->count : 0;
    PDI_ARRAY(owner, band, first, count ? count + 1 : 0, "1");
    PDI_ARRAY(owner, band, begin, count ? count + 1 : 0, "1");
    PDI_ARRAY(owner, band, field, PD_POINT_BATCH_MAX + band->stride * band->fields, "");
}

/* Stores positions and volumes. The padding before and behind the points gets positions far from all: vector loops read
 * it but do not use it. */
static void pdi_point_batch_init_positions(const pd_point_batch *band)
{
    const pd_body *body = band->body;
    double far = body->horizon;
    for (int64_t k = 0; k < (int64_t)body->count * PD_DIM; k++) far = pd_max(far, fabs(body->position[k]));
    if (pd_body_is_periodic(body)) far += body->period[PD_DIM - 1] + 2.0 * body->horizon; /* of images, too */
    for (int64_t k = 0; k < PD_POINT_BATCH_MAX + band->stride * PD_DIM; k++) band->field[k] = 3.0 * far;
    for (int32_t i = 0; i < body->count; i++) {
        pdi_point_batch_get_field(band, PDI_POINT_BATCH_VOLUME)[i] = body->volume[i];
        for (int d = 0; d < PD_DIM; d++)
            pdi_point_batch_get_field(band, PDI_POINT_BATCH_POSITION + d)[i] = body->position[(int64_t)i * PD_DIM + d];
    }
}

PDI_FN pd_status pdi_point_batch_build(pd_ctx *ctx, const pd_body *body, const pd_bond_weights *weights, int32_t fields,
                                       pd_point_batch *band)
{
    memset(band, 0, sizeof *band);
    band->body = body;
    band->weights = weights;
    band->fields = fields;
    band->max_points = PD_POINT_BATCH_MAX;
    int64_t lines =
        ((int64_t)body->count + PD_POINT_BATCH_MAX + PDI_POINT_BATCH_CACHE_LINE - 1) / PDI_POINT_BATCH_CACHE_LINE;
    while (lines % PDI_POINT_BATCH_CACHE_SETS != PDI_POINT_BATCH_SET_OFFSET) lines++;
    band->stride = lines * PDI_POINT_BATCH_CACHE_LINE;
    pd_status status = pdi_array_registry_build(ctx, pdi_point_batch_list, band);
    if (status < 0) {
        memset(band, 0, sizeof *band);
        return status;
    }
    pdi_point_batch_init_positions(band);
    return PD_OK;
}

PDI_FN void pdi_point_batch_free(pd_ctx *ctx, pd_point_batch *band)
{
    PD_DELETE(ctx, band->capacity, band->bond);
    pdi_array_registry_free(ctx, pdi_point_batch_list, band);
    memset(band, 0, sizeof *band);
}

/* Bond list of a batch under construction; `lanes` holds packed offsets until the masks are known. */
typedef struct pdi_point_batch_bond_list {
    int32_t count;
    pd_point_batch_bond *bond;
} pdi_point_batch_bond_list;

/* Lattice offset of a bond of point i, packed into one number; 0: batches do not compare vectors. */
static uint32_t pdi_point_batch_pack_offset(const pd_point_batch *band, int32_t i, const pd_bond_iterator *f)
{
    double xi[PD_DIM];
    uint32_t steps = 0;
    if (!band->lattice_vectors) return 0;
    pdi_body_bond_vector(band->body, i, f, xi);
    for (int d = 0; d < PD_DIM; d++)
        steps = steps * PDI_POINT_BATCH_OFFSET_BASE +
                (uint32_t)(floor(xi[d] / band->body->spacing + 0.5) + PDI_POINT_BATCH_OFFSET_BASE / 2);
    return steps;
}

/* Lists the bonds of point i with a positive weight; intact 1: only unbroken ones. `mask` of a bond holds its packed
 * lattice offset. */
static void pdi_point_batch_list_bonds(const pd_point_batch *band, int32_t i, int intact,
                                       pdi_point_batch_bond_list *bonds)
{
    bonds->count = 0;
    for (pd_bond_iterator f = pd_body_bonds_begin(band->body, i); pd_body_bonds_next(&f);) {
        float weight = pdi_bond_weights_get(band->weights, i, &f);
        if (!(weight > 0.0f) || (intact && pd_body_bond_is_broken(&f))) continue;
        bonds->bond[bonds->count].offset = f.neighbour - i;
        bonds->bond[bonds->count].image = pdi_body_bond_image(&f);
        bonds->bond[bonds->count].weight = weight;
        bonds->bond[bonds->count++].mask = pdi_point_batch_pack_offset(band, i, &f);
    }
}

/* 1: all bonds of a are in b, in the same order, with the same weights and vectors (packed in `mask`). */
static int pdi_point_batch_is_subset(const pdi_point_batch_bond_list *a, const pdi_point_batch_bond_list *b)
{
    int32_t n = 0;
    for (int32_t k = 0; k < b->count && n < a->count; k++) {
        const pd_point_batch_bond *own = &a->bond[n], *other = &b->bond[k];
        if (own->offset != other->offset || own->image != other->image) continue;
        if (own->weight < other->weight || own->weight > other->weight || own->mask != other->mask) return 0;
        n++;
    }
    return n == a->count;
}

/* Finds the batch that begins at point i: it goes on while the bonds of the next point, broken ones too, are a subset
 * or a superset of those so far, up to max_points. `all` becomes the union; one: work. Returns the first point behind
 * it. */
static int32_t pdi_point_batch_find_batch(const pd_point_batch *band, int32_t i, pdi_point_batch_bond_list *all,
                                          pdi_point_batch_bond_list *one)
{
    int32_t end = i + 1;
    pdi_point_batch_list_bonds(band, i, 0, all);
    for (; end < band->body->count && end < i + band->max_points; end++) {
        pdi_point_batch_list_bonds(band, end, 0, one);
        if (pdi_point_batch_is_subset(one, all)) continue;
        if (!pdi_point_batch_is_subset(all, one)) break;
        memcpy(all->bond, one->bond, (size_t)one->count * sizeof *one->bond);
        all->count = one->count;
    }
    return end;
}

/* Sets the masks of the bonds in `all` to the points from i to end - 1 that have them unbroken, and drops bonds that no
 * point has; one: work. */
static void pdi_point_batch_set_masks(const pd_point_batch *band, int32_t i, int32_t end,
                                      pdi_point_batch_bond_list *all, pdi_point_batch_bond_list *one)
{
    int32_t kept = 0;
    for (int32_t k = 0; k < all->count; k++) all->bond[k].mask = 0;
    for (int32_t n = i; n < end; n++) {
        pdi_point_batch_list_bonds(band, n, 1, one);
        for (int32_t k = 0, own = 0; k < all->count && own < one->count; k++) {
            if (one->bond[own].offset != all->bond[k].offset || one->bond[own].image != all->bond[k].image) continue;
            all->bond[k].mask |= (uint32_t)1 << (n - i);
            own++;
        }
    }
    for (int32_t k = 0; k < all->count; k++)
        if (all->bond[k].mask) all->bond[kept++] = all->bond[k];
    all->count = kept;
}

/* Room for `wanted` bonds in all; it never shrinks. */
static pd_status pdi_point_batch_reserve(pd_ctx *ctx, pd_point_batch *band, int64_t wanted)
{
    int64_t room = band->capacity + band->capacity / 2;
    if (wanted <= band->capacity) return PD_OK;
    if (room < wanted) room = wanted;
    PD_TRY(PD_GROW(ctx, "band", band->capacity, room, band->bond));
    band->capacity = room;
    return PD_OK;
}

/* Divides all points into batches and stores their bond lists; longest: most bonds of a family. */
static pd_status pdi_point_batch_build_batches(pd_ctx *ctx, pd_point_batch *band, int32_t longest,
                                               pdi_point_batch_bond_list *one)
{
    int32_t count = band->body->count;
    int64_t bonds = 0;
    for (int32_t i = 0; i < count;) {
        pdi_point_batch_bond_list all;
        PD_TRY(pdi_point_batch_reserve(ctx, band, bonds + longest));
        all.bond = band->bond + bonds;
        int32_t end = pdi_point_batch_find_batch(band, i, &all, one);
        band->first[band->batches] = i;
        band->begin[band->batches++] = bonds;
        if (end - i > 1 || band->list_single_points) {
            pdi_point_batch_set_masks(band, i, end, &all, one);
            bonds += all.count;
        }
        i = end;
    }
    band->first[band->batches] = count;
    band->begin[band->batches] = bonds;
    return PD_OK;
}

PDI_FN pd_status pdi_point_batch_update(pd_ctx *ctx, pd_point_batch *band)
{
    const pd_body *body = band->body;
    pdi_point_batch_bond_list one = {0, NULL};
    int64_t longest = body->stencil_bonds > 0 ? body->stencil_bonds : 1;
    band->batches = 0;
    pd_status status = PD_NEW(ctx, "band", longest, one.bond);
    if (status == PD_OK) status = pdi_point_batch_build_batches(ctx, band, (int32_t)longest, &one);
    PD_DELETE(ctx, longest, one.bond);
    return status;
}

PDI_FN void pdi_point_batch_set_displacements(const pd_ctx *ctx, const pd_point_batch *band, const double *u)
{
    int32_t count = band->body->count;
    double *move = pdi_point_batch_get_field(band, PDI_POINT_BATCH_DISPLACEMENT);
    int nt = pd_par_threads(ctx, (int64_t)count * PD_DIM);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < count; i++)
        for (int d = 0; d < PD_DIM; d++) move[d * band->stride + i] = u[(int64_t)i * PD_DIM + d];
}

/* 1.0: point n has the bond with this mask; 0.0: it has not. */
static inline double pdi_point_batch_lane_factor(uint32_t lanes, int n) { return (double)(int32_t)(lanes >> n & 1u); }

/* Adds one bond of `count` points to the sums: fields of the points and of their neighbours, shift [m] of a periodic
 * image or NULL, weight w, mask of the points that have it. Inlined with constant shift, mask or count. */
PDI_INLINE_HOT void pdi_point_batch_add_bond(const double *PD_RESTRICT own, const double *PD_RESTRICT other,
                                             int64_t stride, const double *shift, double w, uint32_t mask, int count,
                                             pdi_point_batch_sums *PD_RESTRICT sums)
{
    for (int n = 0; n < count; n++) {
        double xi[PD_DIM], eta[PD_DIM], square = 0.0, along = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            xi[d] =
                other[(PDI_POINT_BATCH_POSITION + d) * stride + n] - own[(PDI_POINT_BATCH_POSITION + d) * stride + n];
            if (shift) xi[d] += shift[d];
            eta[d] = other[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n] -
                     own[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n];
            square += xi[d] * xi[d];
            along += eta[d] * xi[d];
        }
        double inv_r2 = 1.0 / square, weight = w * other[PDI_POINT_BATCH_VOLUME * stride + n];
        if (mask != PDI_POINT_BATCH_FULL_MASK) weight *= pdi_point_batch_lane_factor(mask, n);
        double part = weight * inv_r2;
        along *= part * inv_r2;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++) {
                sums->moment[p * PD_DIM + q][n] += weight * eta[p] * xi[q];
                sums->unit_moment[p * PD_DIM + q][n] += part * eta[p] * xi[q];
                if (q >= p) sums->axial_moment[p * PD_DIM + q][n] += along * xi[p] * xi[q];
            }
    }
}

PDI_FN int32_t pdi_point_batch_compute_sums(const pd_point_batch *band, int32_t k, pdi_point_batch_sums *sums)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i, whole = pdi_point_batch_pad_count(count);
    const double *own = pdi_point_batch_get_field(band, 0) + i;
    double shift[PD_DIM];
    for (int p = 0; p < PDI_POINT_BATCH_TENSOR; p++)
        for (int n = 0; n < whole; n++) sums->moment[p][n] = sums->unit_moment[p][n] = sums->axial_moment[p][n] = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(band->body, i); count == 1 && pd_body_bonds_next(&f);) {
        double w = pdi_bond_weights_get_intact(band->weights, i, &f);
        pdi_point_batch_image_shift(band->body, pdi_body_bond_image(&f), shift);
        if (w > 0.0)
            pdi_point_batch_add_bond(own, own + (f.neighbour - i), band->stride, shift, w, PDI_POINT_BATCH_FULL_MASK, 1,
                                     sums);
    }
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        const double *far = own + band->bond[b].offset;
        double w = (double)band->bond[b].weight;
        uint32_t lanes = band->bond[b].mask;
        if (band->bond[b].image) {
            pdi_point_batch_image_shift(band->body, band->bond[b].image, shift);
            pdi_point_batch_add_bond(own, far, band->stride, shift, w, lanes, whole, sums);
        } else if (lanes == PDI_POINT_BATCH_FULL_MASK)
            pdi_point_batch_add_bond(own, far, band->stride, NULL, w, PDI_POINT_BATCH_FULL_MASK, PD_POINT_BATCH_MAX,
                                     sums);
        else if (whole == PD_POINT_BATCH_MAX)
            pdi_point_batch_add_bond(own, far, band->stride, NULL, w, lanes, PD_POINT_BATCH_MAX, sums);
        else pdi_point_batch_add_bond(own, far, band->stride, NULL, w, lanes, whole, sums);
    }
    return count;
}

/* Adds the force of one bond on `count` points, T_i - T_j of eq. 14.4, to force [PD_DIM] [N/m3], with the fields of
 * both families. flows 1: with plastic stress. */
PDI_INLINE_HOT void pdi_point_batch_add_bond_force(const double *PD_RESTRICT own, const double *PD_RESTRICT other,
                                                   int64_t stride, const double *shift, double w, uint32_t mask,
                                                   double lambda, double mu, int flows, int count,
                                                   double (*PD_RESTRICT force)[PD_POINT_BATCH_MAX])
{
    for (int n = 0; n < count; n++) {
        double xi[PD_DIM], eta[PD_DIM], turned[PD_DIM], square = 0.0, along = 0.0, trace = 0.0;
        double share = own[PDI_POINT_BATCH_STIFFNESS * stride + n] + other[PDI_POINT_BATCH_STIFFNESS * stride + n];
        for (int d = 0; d < PD_DIM; d++) {
            xi[d] =
                other[(PDI_POINT_BATCH_POSITION + d) * stride + n] - own[(PDI_POINT_BATCH_POSITION + d) * stride + n];
            if (shift) xi[d] += shift[d];
            eta[d] = other[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n] -
                     own[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n];
            square += xi[d] * xi[d];
            along += share * eta[d] * xi[d];
        }
        double inv_r2 = 1.0 / square;
        for (int p = 0; p < PD_DIM; p++) {
            turned[p] = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_POINT_BATCH_GRADIENT + p * PD_DIM + q) * stride + n;
                double both = own[at] + other[at];
                turned[p] += both * xi[q];
                if (p == q) trace += both;
            }
            along -= turned[p] * xi[p];
        }
        double weight = w * other[PDI_POINT_BATCH_VOLUME * stride + n];
        if (mask != PDI_POINT_BATCH_FULL_MASK) weight *= pdi_point_batch_lane_factor(mask, n);
        double stretch = lambda * trace + (lambda + mu) * along * inv_r2;
        for (int p = 0; p < PD_DIM; p++) {
            double line = stretch * xi[p] + mu * (share * eta[p] + turned[p]), carried = 0.0, relief = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_POINT_BATCH_FORCE_TENSOR + p * PD_DIM + q) * stride + n;
                carried += (own[at] + other[at]) * xi[q];
                at += PDI_POINT_BATCH_TENSOR * stride;
                if (flows) relief += (own[at] + other[at]) * xi[q];
            }
            force[p][n] += weight * (inv_r2 * (line - relief) + carried);
        }
    }
}

/* Adds the forces of all bonds of batch k to sum [PD_DIM] [N/m3]. Inlined with a constant for `plastic`. */
PDI_INLINE_HOT void pdi_point_batch_sum_forces(const pd_point_batch *band, int32_t k, double lambda, double mu,
                                               int plastic, double (*PD_RESTRICT sum)[PD_POINT_BATCH_MAX])
{
    int32_t i = band->first[k], count = band->first[k + 1] - i, whole = pdi_point_batch_pad_count(count);
    int64_t total = band->stride;
    const double *own = pdi_point_batch_get_field(band, 0) + i;
    double shift[PD_DIM];
    for (pd_bond_iterator f = pd_body_bonds_begin(band->body, i); count == 1 && pd_body_bonds_next(&f);) {
        double w = pdi_bond_weights_get_intact(band->weights, i, &f);
        pdi_point_batch_image_shift(band->body, pdi_body_bond_image(&f), shift);
        if (w > 0.0)
            pdi_point_batch_add_bond_force(own, own + (f.neighbour - i), total, shift, w, PDI_POINT_BATCH_FULL_MASK,
                                           lambda, mu, plastic, 1, sum);
    }
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        const double *far = own + band->bond[b].offset;
        double w = (double)band->bond[b].weight;
        uint32_t lanes = band->bond[b].mask;
        if (band->bond[b].image) {
            pdi_point_batch_image_shift(band->body, band->bond[b].image, shift);
            pdi_point_batch_add_bond_force(own, far, total, shift, w, lanes, lambda, mu, plastic, whole, sum);
        } else if (lanes == PDI_POINT_BATCH_FULL_MASK)
            pdi_point_batch_add_bond_force(own, far, total, NULL, w, PDI_POINT_BATCH_FULL_MASK, lambda, mu, plastic,
                                           PD_POINT_BATCH_MAX, sum);
        else if (whole == PD_POINT_BATCH_MAX)
            pdi_point_batch_add_bond_force(own, far, total, NULL, w, lanes, lambda, mu, plastic, PD_POINT_BATCH_MAX,
                                           sum);
        else pdi_point_batch_add_bond_force(own, far, total, NULL, w, lanes, lambda, mu, plastic, whole, sum);
    }
}

PDI_FN void pdi_point_batch_compute_force(const pd_point_batch *band, int32_t k, double lambda, double mu,
                                          double *force)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    double sum[PD_DIM][PD_POINT_BATCH_MAX];
    for (int d = 0; d < PD_DIM; d++)
        for (int n = 0; n < PD_POINT_BATCH_MAX; n++) sum[d][n] = 0.0;
    if (band->fields > PDI_POINT_BATCH_PLASTIC_STRESS) pdi_point_batch_sum_forces(band, k, lambda, mu, 1, sum);
    else pdi_point_batch_sum_forces(band, k, lambda, mu, 0, sum);
    for (int n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++) force[((int64_t)i + n) * PD_DIM + d] = sum[d][n];
}

#undef PDI_POINT_BATCH_OFFSET_BASE
#undef PDI_POINT_BATCH_CACHE_SETS
#undef PDI_POINT_BATCH_SET_OFFSET
