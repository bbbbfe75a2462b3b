/* base, vec, par: the failure path, the allocator and its limit, dense solves, ordered sums.
 * dims: 1 2 3 */
#include "core/base.h"
#include "core/par.h"
#include "test.h"
#include "core/vec.h"
#include <float.h>
#include <stdlib.h>

/* ---- base ---- */

static const int all_statuses[] = {0, 1, 2, -1, -2, -3, -4, -5, -6, -7, -8, -9, -10, -11};
#define STATUSES ((int)(sizeof all_statuses / sizeof all_statuses[0]))

TEST(status_names)
{
    CHECK_STR(pd_status_name(PD_OK), "PD_OK");
    CHECK_STR(pd_status_name(PD_ERR_FILE), "PD_ERR_FILE");
    for (int a = 0; a < STATUSES; a++) {
        const char *name = pd_status_name((pd_status)all_statuses[a]);
        CHECK(strcmp(name, "PD_UNKNOWN") != 0);
        for (int b = 0; b < a; b++) CHECK(strcmp(name, pd_status_name((pd_status)all_statuses[b])) != 0);
    }
    CHECK_STR(pd_status_name((pd_status)-500), "PD_UNKNOWN");
    CHECK_STR(pd_status_name((pd_status)77), "PD_UNKNOWN");
}

TEST(fail_reports)
{
    pd_ctx ctx;
    memset(&ctx, 0x55, sizeof ctx);
    pd_ctx_init(&ctx);
    CHECK_INT(ctx.status, PD_OK);
    CHECK_STR(ctx.message, "");
    CHECK_INT(pd_fail(&ctx, PD_ERR_PARSE, "scene.txt:7", "found %d, expected %s", 3, "a length"), PD_ERR_PARSE);
    CHECK_INT(ctx.status, PD_ERR_PARSE);
    CHECK_STR(ctx.message, "scene.txt:7: found 3, expected a length");
}

TEST(fail_survives_long_messages)
{
    pd_ctx ctx;
    char lengthy[4000];
    memset(lengthy, 'x', sizeof lengthy);
    lengthy[sizeof lengthy - 1] = 0;
    pd_ctx_init(&ctx);
    CHECK_INT(pd_fail(&ctx, PD_ERR_FILE, "a", "%s", lengthy), PD_ERR_FILE);
    CHECK_INT(strlen(ctx.message), PD_MESSAGE_SIZE - 1);
    CHECK(strncmp(ctx.message, "a: xxx", 6) == 0);
    CHECK_INT(pd_fail(&ctx, PD_ERR_FILE, lengthy, "reason"), PD_ERR_FILE);
    CHECK_STR(ctx.message, "reason");
}

TEST(allocator_keeps_account)
{
    pd_ctx ctx;
    double *x = NULL;
    int *none = NULL;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, PD_NEW(&ctx, "test", 1000, x))) return;
    for (int i = 0; i < 1000; i++) CHECK_NEAR(x[i], 0.0, 0.0);
    CHECK_INT(ctx.in_use, 8000);
    for (int i = 0; i < 1000; i++) x[i] = i;
    if (!CHECK_OK(&ctx, PD_GROW(&ctx, "test", 1000, 3000, x))) return;
    for (int i = 0; i < 3000; i++) CHECK_NEAR(x[i], i < 1000 ? i : 0, 0.0);
    CHECK_INT(ctx.in_use, 24000);
    CHECK_OK(&ctx, PD_GROW(&ctx, "test", 3000, 10, x));
    CHECK_NEAR(x[9], 9.0, 0.0);
    CHECK_INT(ctx.in_use, 80);
    CHECK_INT(ctx.peak, 24000);
    CHECK_OK(&ctx, PD_NEW(&ctx, "test", 0, none)); /* NULL always means failure */
    CHECK(none != NULL);
    CHECK_INT(ctx.in_use, 84);
    PD_DELETE(&ctx, 0, none);
    PD_DELETE(&ctx, 10, x);
    CHECK(x == NULL && none == NULL);
    PD_DELETE(&ctx, 10, x); /* twice is allowed */
    CHECK_INT(ctx.in_use, 0);
    CHECK_INT(ctx.peak, 24000);
}

TEST(allocator_limit)
{
    pd_ctx ctx;
    char *a = NULL, *b = NULL;
    pd_ctx_init(&ctx);
    ctx.alloc.limit = 1000;
    CHECK_OK(&ctx, PD_NEW(&ctx, "test", 600, a));
    CHECK_INT(PD_NEW(&ctx, "test", 401, b), PD_ERR_LIMIT);
    CHECK(b == NULL);
    CHECK(strncmp(ctx.message, "test: ", 6) == 0);
    CHECK_OK(&ctx, PD_NEW(&ctx, "test", 400, b));
    CHECK_INT(ctx.in_use, 1000);
    b[399] = 'b';
    CHECK_INT(PD_GROW(&ctx, "test", 400, 401, b), PD_ERR_LIMIT);
    CHECK(b && b[399] == 'b'); /* the old block stays */
    CHECK_INT(ctx.in_use, 1000);
    PD_DELETE(&ctx, 400, b);
    PD_DELETE(&ctx, 600, a);
    CHECK_INT(ctx.in_use, 0);
}

TEST(allocator_overflow)
{
    pd_ctx ctx;
    double *x = NULL;
    pd_ctx_init(&ctx);
    CHECK_INT(PD_NEW(&ctx, "test", (size_t)-1 / 8 + 2, x), PD_ERR_SIZE); /* the product would wrap to 8 bytes */
    CHECK(x == NULL);
    CHECK_INT(PD_NEW(&ctx, "test", (size_t)-1, x), PD_ERR_SIZE);
    CHECK(x == NULL);
    CHECK_INT(ctx.in_use, 0);
}

typedef struct counting_heap {
    size_t live, calls, fail_at; /* fail_at 0: never */
    int wrong_sizes;
} counting_heap;

/* Every block carries its size in front, so that the sizes that pdcorr reports can be checked. */
static void *counting_fn(void *user, void *ptr, size_t old_size, size_t new_size)
{
    counting_heap *heap = (counting_heap *)user;
    double *block = ptr ? (double *)ptr - 2 : NULL; /* two doubles keep the alignment */
    if ((block ? (size_t)block[0] : 0) != old_size) heap->wrong_sizes++;
    if (new_size == 0) {
        heap->live -= old_size;
        free(block);
        return NULL;
    }
    if (++heap->calls == heap->fail_at) return NULL;
    block = (double *)realloc(block, new_size + 2 * sizeof *block);
    if (!block) return NULL;
    block[0] = (double)new_size;
    heap->live = heap->live + new_size - old_size;
    return block + 2;
}

TEST(allocator_of_the_caller)
{
    for (size_t fail_at = 0; fail_at <= 3; fail_at++) {
        pd_ctx ctx;
        counting_heap heap;
        int *x = NULL, *y = NULL;
        memset(&heap, 0, sizeof heap);
        heap.fail_at = fail_at;
        pd_ctx_init(&ctx);
        ctx.alloc.fn = counting_fn;
        ctx.alloc.user = &heap;
        pd_status first = PD_NEW(&ctx, "test", 5, x);
        pd_status second = PD_NEW(&ctx, "test", 0, y);
        pd_status third = x ? PD_GROW(&ctx, "test", 5, 50, x) : PD_OK;
        CHECK_INT(first, fail_at == 1 ? PD_ERR_MEMORY : PD_OK);
        CHECK_INT(second, fail_at == 2 ? PD_ERR_MEMORY : PD_OK);
        CHECK_INT(third, fail_at == 3 ? PD_ERR_MEMORY : PD_OK);
        CHECK((x == NULL) == (fail_at == 1));
        CHECK_INT(ctx.in_use, heap.live);
        PD_DELETE(&ctx, third < 0 ? 5 : 50, x);
        PD_DELETE(&ctx, 0, y);
        CHECK_INT(heap.live, 0);
        CHECK_INT(ctx.in_use, 0);
        CHECK_INT(heap.wrong_sizes, 0);
    }
}

/* ---- vec ---- */

static void hilbert(double *a)
{
    for (int i = 0; i < PD_DIM; i++)
        for (int k = 0; k < PD_DIM; k++) a[i * PD_DIM + k] = 1.0 / (i + k + 1);
}

TEST(inverse_of_hilbert)
{
    /* the inverses of Hilbert matrices are whole numbers */
    static const double exact1[] = {1.0};
    static const double exact2[] = {4.0, -6.0, -6.0, 12.0};
    static const double exact3[] = {9.0, -36.0, 30.0, -36.0, 192.0, -180.0, 30.0, -180.0, 180.0};
    const double *exact = PD_DIM == 1 ? exact1 : PD_DIM == 2 ? exact2 : exact3;
    double a[PD_DIM * PD_DIM], inverse[PD_DIM * PD_DIM], b[PD_DIM], x[PD_DIM];
    hilbert(a);
    CHECK_REL(pdi_vec_invert(a, inverse), PD_DIM == 1 ? 1.0 : PD_DIM == 2 ? 1.0 / 12.0 : 1.0 / 192.0, 1e-12);
    for (int i = 0; i < PD_DIM * PD_DIM; i++) CHECK_REL(inverse[i], exact[i], 1e-13);
    for (int i = 0; i < PD_DIM; i++) b[i] = 1.0 + i;
    CHECK(pdi_vec_solve(a, b, x) > 0.0);
    for (int i = 0; i < PD_DIM; i++) {
        double expected = 0.0;
        for (int k = 0; k < PD_DIM; k++) expected += exact[i * PD_DIM + k] * b[k];
        CHECK_NEAR(x[i], expected, 1e-11);
    }
}

/* Pivots 0.2 and 0.2 in one order, 1 and 0.04 in the other one. */
TEST(factor_in_any_order)
{
    static const double least[2] = {0.1, 0.1}, less[2] = {0.03, 0.03};
    for (int order = 0; order < 2; order++)
        for (int k = 0; k < 2; k++) {
            double a[4] = {0.2, 0.4, 0.4, 1.0};
            if (order) {
                a[0] = 1.0;
                a[3] = 0.2;
            }
            CHECK_INT(pdi_vec_cholesky_any_order(2, 2, k ? less : least, a), k);
        }
}

/* A cyclic permutation has zeros on the diagonal: it needs row exchanges. Scaled far from 1 on purpose. */
TEST(solve_pivots)
{
    double a[PD_DIM * PD_DIM], b[PD_DIM], x[PD_DIM];
    memset(a, 0, sizeof a);
    for (int i = 0; i < PD_DIM; i++) {
        a[i * PD_DIM + (i + 1) % PD_DIM] = 0x1p-300;
        b[i] = 0x1p-290 * (i + 1);
    }
    CHECK_NEAR(pdi_vec_solve(a, b, x), 1.0, 0.0);
    for (int i = 0; i < PD_DIM; i++) CHECK_NEAR(x[(i + 1) % PD_DIM], 1024.0 * (i + 1), 0.0);
}

TEST(solve_refuses_singular)
{
    double a[PD_DIM * PD_DIM], b[PD_DIM], x[PD_DIM];
    for (int rank = 0; rank < PD_DIM; rank++) {
        memset(a, 0, sizeof a);
        for (int i = 0; i < rank; i++) a[i * PD_DIM + i] = 2.0;
        for (int i = 0; i < PD_DIM; i++) b[i] = 1.0, x[i] = 7.0;
        CHECK_NEAR(pdi_vec_solve(a, b, x), 0.0, 0.0);
        for (int i = 0; i < PD_DIM; i++) CHECK_NEAR(x[i], 7.0, 0.0);
    }
}

TEST(dot_and_norm)
{
    static const double a[3] = {3.0, 4.0, 12.0}; /* 3, 5 and 13 are the lengths in 1D, 2D and 3D */
    static const double length[3] = {3.0, 5.0, 13.0};
    CHECK_NEAR(pdi_vec_norm(a), length[PD_DIM - 1], 0.0);
    CHECK_NEAR(pdi_vec_dot(a, a), length[PD_DIM - 1] * length[PD_DIM - 1], 0.0);
}

/* ---- par ---- */

#define LONGEST 1100000 /* more than one batch of blocks */
static const int64_t lengths[] = {0, 1, 3, 4, 5, 2047, 2048, 2049, 65537, LONGEST};
#define LENGTHS ((int)(sizeof lengths / sizeof lengths[0]))

/* NULL counts as a failed check. */
static double *new_array(int64_t n)
{
    double *x = (double *)malloc(sizeof(double) * (size_t)n);
    CHECK(x != NULL);
    return x;
}

TEST(sums_of_whole_numbers)
{
    pd_ctx ctx;
    double *x = new_array(LONGEST), *one = new_array(LONGEST);
    pd_ctx_init(&ctx);
    if (!CHECK(x && one)) return;
    for (int64_t i = 0; i < LONGEST; i++) {
        x[i] = (double)((i + 1) % 1000); /* all partial sums are exact */
        one[i] = 1.0;
    }
    for (int k = 0; k < LENGTHS; k++) {
        int64_t sum = 0, squares = 0;
        for (int64_t i = 1; i <= lengths[k]; i++) sum += i % 1000, squares += (i % 1000) * (i % 1000);
        CHECK_NEAR(pdi_par_dot(&ctx, lengths[k], x, one), (double)sum, 0.0);
        CHECK_NEAR(pdi_par_dot(&ctx, lengths[k], x, x), (double)squares, 0.0);
    }
    free(x);
    free(one);
}

TEST(sums_do_not_depend_on_threads)
{
    pd_ctx ctx;
    double *x = new_array(LONGEST), *y = new_array(LONGEST), *one = new_array(LONGEST);
    pd_ctx_init(&ctx);
    for (int64_t i = 0; x && y && one && i < LONGEST; i++) {
        x[i] = 1.0 / ((double)(i + 1) * (double)(i + 2)); /* telescopes: the first n sum to n / (n + 1) */
        y[i] = cos(0.7 * (double)i);
        one[i] = 1.0;
    }
    for (int k = 0; x && y && one && k < LENGTHS; k++) {
        int64_t n = lengths[k];
        ctx.threads = 1;
        double sum = pdi_par_dot(&ctx, n, x, one), dot = pdi_par_dot(&ctx, n, x, y);
        CHECK_NEAR(sum, (double)n / (double)(n + 1), 1e-14);
        for (ctx.threads = 2; ctx.threads <= 5; ctx.threads++) {
            CHECK_NEAR(pdi_par_dot(&ctx, n, x, one), sum, 0.0);
            CHECK_NEAR(pdi_par_dot(&ctx, n, x, y), dot, 0.0);
        }
    }
    free(x);
    free(y);
    free(one);
}

TEST(vector_updates)
{
    pd_ctx ctx;
    int64_t n = 100000;
    double *x = new_array(n), *y = new_array(n);
    pd_ctx_init(&ctx);
    ctx.threads = 3;
    for (int64_t i = 0; x && y && i < n; i++) x[i] = (double)i, y[i] = 1.0;
    if (x && y) {
        pdi_par_axpy(&ctx, n - 1, -2.0, x, y);
        for (int64_t i = 0; i < n - 1; i++) CHECK_NEAR(y[i], 1.0 - 2.0 * (double)i, 0.0);
        CHECK_NEAR(y[n - 1], 1.0, 0.0); /* one past the end stays */
        pdi_par_copy(&ctx, n - 1, x, y);
        for (int64_t i = 0; i < n - 1; i++) CHECK_NEAR(y[i], (double)i, 0.0);
        CHECK_NEAR(y[n - 1], 1.0, 0.0);
        pdi_par_zero(&ctx, n - 1, y);
        for (int64_t i = 0; i < n - 1; i++) CHECK_NEAR(y[i], 0.0, 0.0);
        CHECK_NEAR(y[n - 1], 1.0, 0.0);
    }
    free(x);
    free(y);
}

TEST(largest_magnitude)
{
    pd_ctx ctx;
    double x[5] = {1.0, -7.0, 3.0, 6.5, 0.0};
    pd_ctx_init(&ctx);
    CHECK_NEAR(pdi_par_max_abs(&ctx, 5, x), 7.0, 0.0);
    CHECK_NEAR(pdi_par_max_abs(&ctx, 0, x), 0.0, 0.0);
    x[4] = -INFINITY;
    CHECK(pdi_par_max_abs(&ctx, 5, x) > DBL_MAX);
    for (int k = 0; k < 5; k++) { /* wherever the NaN stands */
        double keep = x[k];
        x[k] = NAN;
        CHECK(isnan(pdi_par_max_abs(&ctx, 5, x)));
        x[k] = keep;
    }
    enum { MANY = 300000 };
    double *many = (double *)calloc(MANY, sizeof *many);
    if (!CHECK(many != NULL)) return;
    for (int threads = 1; threads <= 4; threads++) {
        ctx.threads = threads;
        for (int k = 7; k < MANY; k += 20011) {
            many[k] = NAN;
            CHECK(isnan(pdi_par_max_abs(&ctx, MANY, many)));
            many[k] = 0.0;
        }
    }
    free(many);
}

/* Neumaier's own example, and 0.1 added ten million times, whose exact sum is known. */
TEST(compensated_sum)
{
    static const double x[4] = {1.0, 1e100, 1.0, -1e100};
    pdi_compensated_sum s;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < 4; k++) pdi_compensated_sum_add(&s, x[k]);
    CHECK_NEAR(pdi_compensated_sum_total(&s), 2.0, 0.0);
    memset(&s, 0, sizeof s);
    for (int k = 0; k < 10000000; k++) pdi_compensated_sum_add(&s, 0.1);
    CHECK_NEAR(pdi_compensated_sum_total(&s), 1e6, 1.2e-10); /* one unit in the last place of 1e6 */
}

TEST(threads)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    CHECK_INT(pd_par_threads(&ctx, 1), 1); /* a fork costs more */
    CHECK(pd_par_threads(&ctx, INT64_MAX) >= 1);
    ctx.threads = 3;
#ifdef _OPENMP
    CHECK_INT(pd_par_threads(&ctx, 1000000), 3);
#else
    CHECK_INT(pd_par_threads(&ctx, 1000000), 1);
#endif
    double start = pd_par_clock();
    volatile double spin = 0.0;
    for (int k = 0; k < 10000000; k++) spin = spin + 1.0;
    CHECK(pd_par_clock() > start);
}

TEST_MAIN(ENTRY(status_names) ENTRY(fail_reports) ENTRY(fail_survives_long_messages) ENTRY(allocator_keeps_account)
          ENTRY(allocator_limit) ENTRY(allocator_overflow) ENTRY(allocator_of_the_caller) ENTRY(inverse_of_hilbert)
          ENTRY(factor_in_any_order) ENTRY(solve_pivots) ENTRY(solve_refuses_singular)
          ENTRY(dot_and_norm) ENTRY(sums_of_whole_numbers)
          ENTRY(sums_do_not_depend_on_threads) ENTRY(vector_updates) ENTRY(largest_magnitude)
          ENTRY(compensated_sum) ENTRY(threads))
