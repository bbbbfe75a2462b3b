/* common: what validate, bench and stability share: clocks, memory, and the command line. */
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

enum { MAX_CASES = 64 };

/* The command line of these programs. */
typedef struct options {
    const char *program, *out, *scenes;
    int wanted[MAX_CASES]; /* cases named on the command line */
    int named, threads, n;
    double m;
    int quick, check, quiet, list, help;
} options;

/* What one of them takes: its cases, all options but "--out", "--quick" and the like, and the least n. */
typedef struct usage {
    const char *(*name)(int number); /* of a case; NULL behind the last */
    const char *takes;
    double least_n;
} usage;

static int takes(const usage *u, const char *option) { return strstr(u->takes, option) != NULL; }

static int usage_error(const options *o, const char *what, const char *found)
{
    fprintf(stderr, "%s: %s%s; see %s --help\n", o->program, what, found, o->program);
    return 2;
}

/* An option with a value behind it: 1: read, 0: no such option, -1: its value is none. */
static int parse_value(const char *option, const char *value, const usage *u, options *o, const char **expected)
{
    if (strcmp(option, "--out") == 0 || (strcmp(option, "--scenes") == 0 && takes(u, option))) {
        *(option[2] == 'o' ? &o->out : &o->scenes) = value;
        *expected = option[2] == 'o' ? "--out expects a folder" : "--scenes expects a folder";
        return value[0] ? 1 : -1;
    }
    if (strcmp(option, "--threads") != 0 || !takes(u, option)) return 0;
    *expected = "--threads expects a number from 0 to 1024";
    return parse_whole(value, 0.0, 1024.0, &o->threads) ? 1 : -1;
}

/* A flag, a key or the name of a case. 2: wrong usage. */
static int parse_word(const char *a, const usage *u, options *o)
{
    if (strcmp(a, "--help") == 0 || strcmp(a, "-h") == 0) o->help = 1;
    else if (strcmp(a, "--list") == 0) o->list = 1;
    else if (strcmp(a, "--quick") == 0) o->quick = 1;
    else if (strcmp(a, "--quiet") == 0) o->quiet = 1;
    else if (strcmp(a, "--check") == 0 && takes(u, a)) o->check = 1;
    else if (strncmp(a, "m=", 2) == 0 && takes(u, "m=")) {
        if (!parse_number(a + 2, 1.0, 12.0, &o->m)) return usage_error(o, "m expects a number from 1 to 12, found ", a);
    } else if (strncmp(a, "n=", 2) == 0 && takes(u, "n=")) {
        char text[80];
        snprintf(text, sizeof text, "n expects a whole number of at least %g, found ", u->least_n);
        if (!parse_whole(a + 2, u->least_n, 1e7, &o->n)) return usage_error(o, text, a);
    } else if (a[0] == '-' && a[1]) return usage_error(o, "unknown option ", a);
    else if (strchr(a, '=') && takes(u, "m=")) return usage_error(o, "unknown key (m and n can be set): ", a);
    else {
        int k = 0;
        while (k < MAX_CASES && u->name(k) && strcmp(u->name(k), a) != 0) k++;
        if (k == MAX_CASES || !u->name(k)) return usage_error(o, "no case has the name (--list prints them) ", a);
        o->wanted[k] = o->named = 1;
    }
    return 0;
}

/* 0, or 2: wrong usage. */
static int parse(int argc, char **argv, const usage *u, options *o)
{
    const char *slash = strrchr(argv[0], '/'), *expected = "";
    o->program = slash ? slash + 1 : argv[0];
    for (int k = 1; k < argc; k++) {
        int read = parse_value(argv[k], k + 1 < argc ? argv[k + 1] : "", u, o, &expected);
        if (read < 0) return usage_error(o, expected, "");
        if (read) k++;
        else if (parse_word(argv[k], u, o)) return 2;
    }
    return 0;
}

/* The status with which a program ends: what it printed must have arrived. */
static int ended(const options *o, int status)
{
    int lost = fflush(stdout) != 0;
    lost = ferror(stdout) || lost;
    if (!lost) return status;
    fprintf(stderr, "%s: lines of the standard output are lost: it is closed or full\n", o->program);
    return status ? status : 1;
}

#endif
