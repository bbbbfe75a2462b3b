/* common: what validate, bench and stability share: clocks, memory, and the reading of numbers on the command line. */
#ifndef CASES_COMMON_H
#define CASES_COMMON_H

/* [s] */
static double clock_seconds(clockid_t clock)
{
    struct timespec t;
    return clock_gettime(clock, &t) == 0 ? (double)t.tv_sec + 1e-9 * (double)t.tv_nsec : 0.0;
}

static double wall_seconds(void) { return clock_seconds(CLOCK_MONOTONIC); }

/* Of all threads. */
static double cpu_seconds(void) { return clock_seconds(CLOCK_PROCESS_CPUTIME_ID); }

/* Of the process since its start. */
static double peak_rss_mb(void)
{
    struct rusage usage_now;
    if (getrusage(RUSAGE_SELF, &usage_now) != 0) return 0.0;
#ifdef __APPLE__
    return (double)usage_now.ru_maxrss / 1048576.0;
#else
    return (double)usage_now.ru_maxrss / 1024.0;
#endif
}

/* Threads that wait for others spin for the time of a waking up and then sleep. A runtime that spins on keeps the
 * processor from what they wait for as soon as another program runs beside: tens of times the wall time. It reads its
 * environment before main, so the program starts itself once more, unless the caller has chosen. 1000 turns are those
 * that libgomp takes where it knows of too few processors; other runtimes follow the policy. */
static void calm_threads(char **argv)
{
#ifdef _OPENMP
    if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT") || getenv("KMP_BLOCKTIME")) return;
    if (setenv("OMP_WAIT_POLICY", "passive", 1) == 0 && setenv("GOMP_SPINCOUNT", "1000", 1) == 0)
        execvp(argv[0], argv); /* it comes back where it failed, and all goes on as it is */
#else
    (void)argv;
#endif
}

/* A number within [lo, hi] and nothing behind it. */
static int parse_number(const char *text, double lo, double hi, double *value)
{
    char *end;
    if (!text || !*text) return 0;
    *value = strtod(text, &end);
    return !*end && *value >= lo && *value <= hi;
}

static int parse_whole(const char *text, double lo, double hi, int *value)
{
    double number;
    if (!parse_number(text, lo, hi, &number) || number != floor(number)) return 0;
    *value = (int)number;
    return 1;
}

/* The text behind an option that takes one; "" when there is none. */
static const char *value_of(int argc, char **argv, int *k) { return *k + 1 < argc ? argv[++*k] : ""; }

/* The program's name without its folder. */
static const char *program_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* The status with which a program ends: what it printed must have arrived. */
static int ended(const char *program, int status)
{
    int lost = fflush(stdout) != 0;
    lost = ferror(stdout) || lost;
    if (!lost) return status;
    fprintf(stderr, "%s: lines of the standard output are lost: it is closed or full\n", program);
    return status ? status : 1;
}

static int usage_error(const char *program, const char *what, const char *found)
{
    fprintf(stderr, "%s: %s%s; see %s --help\n", program, what, found, program);
    return 2;
}

#endif
