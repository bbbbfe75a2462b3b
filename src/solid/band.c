/* band: see band.h */
#include "solid/band.h"
#include "core/par.h"
#include <string.h>

/* Doubles in a line of a cache, lines after which addresses meet again in it, and lines by which fields are apart. */
#define PDI_BAND_LINE 8
#define PDI_BAND_LINES 64
#define PDI_BAND_APART 5

PDI_FN void pdi_band_list(pdi_owner *owner, void *object)
{
    pd_band *band = (pd_band *)object;
    int64_t count = band->body ? band->body->count : 0;
    PDI_ARRAY(owner, band, first, count ? count + 1 : 0, "1");
    PDI_ARRAY(owner, band, field, band->stride * (PDI_BAND_FIELDS + (band->flows ? PDI_BAND_TENSOR : 0)), "");
}

PDI_FN pd_status pdi_band_build(pd_ctx *ctx, const pd_body *body, const float *weight, int flows, pd_band *band)
{
    memset(band, 0, sizeof *band);
    band->body = body;
    band->weight = weight;
    band->flows = flows;
    int64_t lines = ((int64_t)body->count + PDI_BAND_LINE - 1) / PDI_BAND_LINE;
    while (lines % PDI_BAND_LINES != PDI_BAND_APART) lines++;
    band->stride = lines * PDI_BAND_LINE;
    pd_status status = pdi_owner_build(ctx, pdi_band_list, band);
    if (status < 0) {
        memset(band, 0, sizeof *band);
        return status;
    }
    for (int32_t i = 0; i < body->count; i++) {
        pdi_band_field(band, PDI_BAND_VOLUME)[i] = body->volume[i];
        for (int d = 0; d < PD_DIM; d++)
            pdi_band_field(band, PDI_BAND_PLACE + d)[i] = body->position[(int64_t)i * PD_DIM + d];
    }
    return PD_OK;
}

PDI_FN void pdi_band_free(pd_ctx *ctx, pd_band *band)
{
    pdi_owner_free(ctx, pdi_band_list, band);
    memset(band, 0, sizeof *band);
}

/* 1: the bonds of point i + 1 are those of point i, one point on. */
static int pdi_band_alike(const pd_band *band, int32_t i)
{
    const pd_body *body = band->body;
    int64_t here = body->row[i], there = body->row[i + 1], length = there - here;
    if (body->row[i + 2] - there != length) return 0;
    for (int64_t b = 0; b < length; b++)
        if (body->column[there + b] != body->column[here + b] + 1 ||
            band->weight[there + b] < band->weight[here + b] || band->weight[there + b] > band->weight[here + b])
            return 0;
    return 1;
}

PDI_FN void pdi_band_find(pd_band *band)
{
    int32_t count = band->body->count;
    band->bands = 0;
    for (int32_t i = 0; i < count;) {
        int32_t end = i + 1;
        while (end < count && end < i + PD_BAND_MOST && pdi_band_alike(band, end - 1)) end++;
        band->first[band->bands++] = i;
        i = end;
    }
    band->first[band->bands] = count;
}

PDI_FN void pdi_band_move(const pd_ctx *ctx, const pd_band *band, const double *u)
{
    int32_t count = band->body->count;
    double *move = pdi_band_field(band, PDI_BAND_MOVE);
    int nt = pdi_par_threads(ctx, (int64_t)count * PD_DIM);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < count; i++)
        for (int d = 0; d < PD_DIM; d++) move[d * band->stride + i] = u[(int64_t)i * PD_DIM + d];
}

/* A bond of count points: w, and the fields of both of its ends. Inlined with a constant for `count`. */
PDI_INLINE void pdi_band_add(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total, double w,
                             int count, pdi_band_sums *PD_RESTRICT sums)
{
    for (int n = 0; n < count; n++) {
        double xi[PD_DIM], eta[PD_DIM], square = 0.0, along = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            xi[d] = far[(PDI_BAND_PLACE + d) * total + n] - own[(PDI_BAND_PLACE + d) * total + n];
            eta[d] = far[(PDI_BAND_MOVE + d) * total + n] - own[(PDI_BAND_MOVE + d) * total + n];
            square += xi[d] * xi[d];
            along += eta[d] * xi[d];
        }
        double over = 1.0 / square, weight = w * far[PDI_BAND_VOLUME * total + n], part = weight * over;
        along *= part * over;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++) {
                sums->pull[p * PD_DIM + q][n] += weight * eta[p] * xi[q];
                sums->turn[p * PD_DIM + q][n] += part * eta[p] * xi[q];
                if (q >= p) sums->along[p * PD_DIM + q][n] += along * xi[p] * xi[q];
            }
    }
}

PDI_FN int32_t pdi_band_collect(const pd_band *band, int32_t k, pdi_band_sums *sums)
{
    const pd_body *body = band->body;
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    const double *own = band->field + i;
    for (int p = 0; p < PDI_BAND_TENSOR; p++)
        for (int n = 0; n < count; n++) sums->pull[p][n] = sums->turn[p][n] = sums->along[p][n] = 0.0;
    for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
        const double *far = band->field + body->column[b];
        double w = (double)band->weight[b];
        if (!(w > 0.0)) continue;
        if (count == 1) pdi_band_add(own, far, band->stride, w, 1, sums);
        else if (count == PD_BAND_MOST) pdi_band_add(own, far, band->stride, w, PD_BAND_MOST, sums);
        else pdi_band_add(own, far, band->stride, w, count, sums);
    }
    return count;
}

/* The force of a bond on count points. T_i - T_j of eq. 8.4 has the tensors of both families in sums. */
PDI_INLINE void pdi_band_pull(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total, double w,
                              double lambda, double mu, int flows, int count,
                              double (*PD_RESTRICT force)[PD_BAND_MOST])
{
    for (int n = 0; n < count; n++) {
        double xi[PD_DIM], eta[PD_DIM], turned[PD_DIM], square = 0.0, along = 0.0, trace = 0.0;
        double share = own[PDI_BAND_SHARE * total + n] + far[PDI_BAND_SHARE * total + n];
        for (int d = 0; d < PD_DIM; d++) {
            xi[d] = far[(PDI_BAND_PLACE + d) * total + n] - own[(PDI_BAND_PLACE + d) * total + n];
            eta[d] = far[(PDI_BAND_MOVE + d) * total + n] - own[(PDI_BAND_MOVE + d) * total + n];
            square += xi[d] * xi[d];
            along += share * eta[d] * xi[d];
        }
        double over = 1.0 / square;
        for (int p = 0; p < PD_DIM; p++) {
            turned[p] = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_BAND_TURN + p * PD_DIM + q) * total + n;
                double both = own[at] + far[at];
                turned[p] += both * xi[q];
                if (p == q) trace += both;
            }
            along -= turned[p] * xi[p];
        }
        double weight = w * far[PDI_BAND_VOLUME * total + n];
        double stretch = lambda * trace + (lambda + mu) * along * over;
        for (int p = 0; p < PD_DIM; p++) {
            double line = stretch * xi[p] + mu * (share * eta[p] + turned[p]), carried = 0.0, relief = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_BAND_CARRY + p * PD_DIM + q) * total + n;
                carried += (own[at] + far[at]) * xi[q];
                at += PDI_BAND_TENSOR * total;
                if (flows) relief += (own[at] + far[at]) * xi[q];
            }
            force[p][n] += weight * (over * (line - relief) + carried);
        }
    }
}

/* Inlined with a constant for `flows` and `count`. */
PDI_INLINE void pdi_band_sum(const pd_band *band, int32_t i, double lambda, double mu, int flows, int count,
                             double (*PD_RESTRICT sum)[PD_BAND_MOST])
{
    const pd_body *body = band->body;
    const double *own = band->field + i;
    for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
        double w = (double)band->weight[b];
        if (w > 0.0)
            pdi_band_pull(own, band->field + body->column[b], band->stride, w, lambda, mu, flows, count, sum);
    }
}

PDI_FN void pdi_band_force(const pd_band *band, int32_t k, double lambda, double mu, double *force)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    double sum[PD_DIM][PD_BAND_MOST];
    for (int d = 0; d < PD_DIM; d++)
        for (int n = 0; n < count; n++) sum[d][n] = 0.0;
    if (band->flows) pdi_band_sum(band, i, lambda, mu, 1, count, sum);
    else if (count == 1) pdi_band_sum(band, i, lambda, mu, 0, 1, sum);
    else if (count == PD_BAND_MOST) pdi_band_sum(band, i, lambda, mu, 0, PD_BAND_MOST, sum);
    else pdi_band_sum(band, i, lambda, mu, 0, count, sum);
    for (int n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++) force[((int64_t)i + n) * PD_DIM + d] = sum[d][n];
}

#undef PDI_BAND_LINE
#undef PDI_BAND_LINES
#undef PDI_BAND_APART
