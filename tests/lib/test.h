/* test: the harness of the test programs, plain C99.
 *
 *   TEST(square_of_two) { CHECK_NEAR(2.0 * 2.0, 4.0, 0.0); }
 *   TEST_MAIN(ENTRY(square_of_two) SLOW_ENTRY(another))
 *
 * The program runs every test, or those named as arguments (--list prints the names, "(slow)" behind those of
 * SLOW_ENTRY), prints one line for each failing check and ends with "N passed, N failed" (and ", N skipped"), N
 * counting tests. It exits 1 when a test failed and 2 on an unknown name. A test that made no check fails. Every CHECK
 * is an expression, 1 when it held: `if (!CHECK_OK(&ctx, pd_stencil_build(...))) return;`. A SLOW_ENTRY runs when it is
 * named or PD_TEST_ALL=1 stands in the environment, as in `make test-all`; SLOW_ENTRY_IF(PD_DIM == 3, name) is slow in
 * 3D. A comment `dims: 1 2 3` in the first five lines of the file says for which PD_DIM the Makefile builds it
 * (without: 2), and `slow: 3` which of them `make test` leaves out. --times prints the seconds of processor time of
 * every test.
 */
#ifndef PD_TEST_H
#define PD_TEST_H
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct test_entry {
    const char *name;
    void (*run)(void);
    int slow;
} test_entry;

/* State of the running test. */
static struct test_state {
    const char *name;
    int checks, failures, skipped;
} test_now;

/* Failing checks printed for one test: a wrong loop must not flood the log. */
#define TEST_LINES 20

#define TEST(name) static void test_##name(void)
#define ENTRY(name) {#name, test_##name, 0},
#define SLOW_ENTRY(name) {#name, test_##name, 1},
#define SLOW_ENTRY_IF(condition, name) {#name, test_##name, condition},
#define TEST_MAIN(entries) \
    int main(int argc, char **argv) \
    { \
        static const test_entry table[] = {entries}; \
        return test_run(table, (int)(sizeof table / sizeof table[0]), argc, argv); \
    }

#define CHECK(condition) test_check((condition) ? 1 : 0, __FILE__, __LINE__, "%s", #condition)
/* value <= bound; false for NaN. */
#define CHECK_LE(value, bound) test_check_le((double)(value), (double)(bound), __FILE__, __LINE__, #value, #bound)
/* |a - b| <= tol */
#define CHECK_NEAR(a, b, tol) \
    test_check_near((double)(a), (double)(b), (double)(tol), 1.0, __FILE__, __LINE__, #a, #b)
/* |a - b| <= tol |b|: b is the reference */
#define CHECK_REL(a, b, tol) \
    test_check_near((double)(a), (double)(b), (double)(tol), fabs((double)(b)), __FILE__, __LINE__, #a, #b)
#define CHECK_STR(a, b) test_check_str((a), (b), __FILE__, __LINE__, #a)
#define CHECK_INT(a, b) test_check_int((long long)(a), (long long)(b), __FILE__, __LINE__, #a, #b)
/* status is PD_OK; prints the message of the context when not. */
#define CHECK_OK(ctx, status) test_check_ok((int)(status), (ctx)->message, __FILE__, __LINE__, #status)
/* Print a line. */
#define NOTE(...) test_note("note", __VA_ARGS__)
/* Leave the test because what it needs is absent; it counts as skipped. */
#define SKIP(...) \
    do { \
        test_note("skipped", __VA_ARGS__); \
        test_now.skipped = 1; \
        return; \
    } while (0)

#if defined(__GNUC__)
#define TEST_PRINTF_LIKE(f, a) __attribute__((format(printf, f, a)))
#else
#define TEST_PRINTF_LIKE(f, a)
#endif

TEST_PRINTF_LIKE(4, 5)
static inline int test_check(int holds, const char *file, int line, const char *format, ...)
{
    test_now.checks++;
    if (holds) return 1;
    if (++test_now.failures > TEST_LINES) return 0;
    va_list args;
    va_start(args, format);
    printf("%s:%d: %s: ", file, line, test_now.name);
    vprintf(format, args);
    printf("%s\n", test_now.failures == TEST_LINES ? " (further failures of this test not printed)" : "");
    va_end(args);
    return 0;
}

TEST_PRINTF_LIKE(2, 3)
static inline void test_note(const char *label, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    printf("%s: %s: ", label, test_now.name);
    vprintf(format, args);
    printf("\n");
    va_end(args);
}

static inline int test_check_le(double value, double bound, const char *file, int line, const char *text,
                                const char *bound_text)
{
    return test_check(value <= bound, file, line, "%s <= %s: %.17g, bound %.17g", text, bound_text, value, bound);
}

static inline int test_check_near(double a, double b, double tol, double scale, const char *file, int line,
                                  const char *a_text, const char *b_text)
{
    double difference = fabs(a - b);
    return test_check(difference <= tol * scale, file, line, "%s = %.17g, expected %s = %.17g: off by %.3g, bound %.3g",
                      a_text, a, b_text, b, difference, tol * scale);
}

static inline int test_check_str(const char *a, const char *b, const char *file, int line, const char *a_text)
{
    return test_check(a && b && strcmp(a, b) == 0, file, line, "%s = \"%s\", expected \"%s\"", a_text,
                      a ? a : "(null)", b ? b : "(null)");
}

static inline int test_check_int(long long a, long long b, const char *file, int line, const char *a_text,
                                 const char *b_text)
{
    return test_check(a == b, file, line, "%s = %lld, expected %s = %lld", a_text, a, b_text, b);
}

static inline int test_check_ok(int status, const char *message, const char *file, int line, const char *text)
{
    return test_check(status == 0, file, line, "%s: status %d: %s", text, status, message);
}

static inline int test_selected(const test_entry *entry, int all, int names, char **name)
{
    int found = names == 0 && (all || !entry->slow);
    for (int k = 0; k < names; k++) found = found || strcmp(name[k], entry->name) == 0;
    return found;
}

static inline int test_run(const test_entry *table, int count, int argc, char **argv)
{
    int passed = 0, failed = 0, skipped = 0, left = 0;
    int list = argc == 2 && strcmp(argv[1], "--list") == 0;
    int times = argc > 1 && strcmp(argv[1], "--times") == 0;
    int first = 1 + (list || times);
    const char *all = getenv("PD_TEST_ALL");
    setvbuf(stdout, NULL, _IOLBF, BUFSIZ); /* nothing is lost when a test crashes */
    for (int k = first; k < argc; k++) {
        int known = 0;
        for (int t = 0; t < count; t++) known = known || strcmp(argv[k], table[t].name) == 0;
        if (!known) {
            fprintf(stderr, "no test is named '%s'; --list prints the names\n", argv[k]);
            return 2;
        }
    }
    for (int t = 0; t < count; t++) {
        if (list) printf("%s%s\n", table[t].name, table[t].slow ? " (slow)" : "");
        if (list) continue;
        if (!test_selected(&table[t], all && all[0] == '1', argc - first, argv + first)) {
            left += argc == first;
            continue;
        }
        memset(&test_now, 0, sizeof test_now);
        test_now.name = table[t].name;
        clock_t begin = clock();
        table[t].run();
        if (times) test_note("time", "%.2f s", (double)(clock() - begin) / CLOCKS_PER_SEC);
        if (test_now.checks == 0 && !test_now.skipped) test_check(0, __FILE__, __LINE__, "the test made no check");
        if (test_now.failures) failed++;
        else if (test_now.skipped) skipped++;
        else passed++;
    }
    if (list) return 0;
    if (left) printf("left to PD_TEST_ALL=1: %d\n", left);
    printf("%d passed, %d failed", passed, failed);
    if (skipped) printf(", %d skipped", skipped);
    printf("\n");
    return failed > 0;
}

#endif
