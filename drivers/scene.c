/* pd1d, pd2d, pd3d: run a scene file.
 *
 *   pd2d SCENE [key=value ...] [--estimate-error] [--accuracy SHARE] [--out DIR] [--checkpoint TIME] [--resume]
 *        [--sweep KEY=VALUES] [--fit KEY=LOW..HIGH] [--to FILE] [--threads N] [--memory-limit SIZE] [--follow]
 *        [--live] [--progress TIME] [--quiet] [--check] [--new [NAME]] [--keys [SECTION]]
 *        [--speciate] [--titrate REAGENT] [--version] [--help]
 *
 * Exit status: 0 done, 1 the run failed or was interrupted, 2 wrong usage or bad input, 3 stopped, --resume goes on.
 */
#define _POSIX_C_SOURCE 200809L
#ifndef PDCORR_LINKED /* with a library that is compiled apart */
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"

#include "machine.h"
#include "calm.h"
#include "screen.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if !defined(__wasi__)
#include <signal.h>
#endif
#if !defined(_WIN32) && !defined(__wasi__)
#include <sys/wait.h>
#endif

#define CHECKPOINT_EVERY 600.0 /* [s] unless --checkpoint says otherwise */
#define PROGRESS_EVERY 60.0    /* [s] unless --progress says otherwise */

enum { MAX_OVERRIDES = 64 };

typedef struct options {
    const char *program, *scene, *out;
    const char *overrides[MAX_OVERRIDES];
    int count, threads, quiet, check, help, resume, checkpoints;
    double checkpoint_every; /* [s] */
    int follow, live, progress;
    double progress_every;   /* [s] where there is no terminal */
    const char *sweeps[PD_PARAMETER_SWEEP_MAX_AXES];
    int sweep_count;
    int estimate;    /* of the error, after the run */
    double accuracy; /* [-] wanted; 0: settings as they are */
    double memory;   /* [byte] limit; 0: none */
    const char *ranges[PD_LEAST_SQUARES_PARAMETERS], *data; /* of a fit; its points, NULL: those of the scene */
    int range_count;
    int speciate;              /* the equilibrium alone */
    const char *titrate;       /* the same with a reagent; NULL: none */
    int begins, asks;          /* --new, --keys */
    const char *begin, *ask;   /* what stands behind them, NULL: nothing */
    int version;
} options;

/* A number within [lo, hi] and nothing behind it. */
static int parse_number(const char *text, double lo, double hi, double *value)
{
    char *end;
    if (!*text) return 0;
    *value = strtod(text, &end);
    return !*end && *value >= lo && *value <= hi;
}

/* ---- signals ---- */

/* A signal this soon after the first is the same one, sent twice: to the program and its group, as timeout(1) does. */
#define ECHO 1.0 /* [s] */

#if defined(__wasi__)
static volatile int interrupted; /* by no one */
#else
static volatile sig_atomic_t interrupted;

/* A second signal, this one or the other, ends the program at once. */
static void on_interrupt(int number)
{
    static double first;
    if (!interrupted) first = wall_seconds();
    else if (wall_seconds() - first > ECHO) {
        signal(number, SIG_DFL);
        raise(number);
    }
#if defined(_WIN32)
    signal(number, on_interrupt); /* it goes with each signal there */
#endif
    interrupted = 1;
}
#endif

static void catch_signals(void)
{
#if defined(_WIN32)
    signal(SIGINT, on_interrupt);
    signal(SIGTERM, on_interrupt);
#elif !defined(__wasi__)
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    sigaddset(&action.sa_mask, SIGINT);
    sigaddset(&action.sa_mask, SIGTERM);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
#endif
}

static int is_interrupted(void *user)
{
    (void)user;
    return interrupted != 0;
}

static int is_interrupted_within(void *user, const char *doing, int64_t count)
{
    (void)user;
    (void)doing;
    (void)count;
    return interrupted != 0;
}

/* ---- the runs of --sweep, side by side in processes of their own, as many as there are threads ---- */

enum { MAX_JOBS = 256 };

/* Exit status of a run: 0 done, 1 failed, 3 stopped. */
static int sweep_one(pd_ctx *ctx, const pd_parameter_sweep *sweep, int index, const pd_run_desc *desc)
{
    pd_status status = pd_parameter_sweep_run(ctx, sweep, index, desc);
    return status < 0 ? 1 : status == PD_RETRY ? 3 : 0;
}

static void sweep_tell(const pd_parameter_sweep *sweep, int index, int status)
{
    char label[PD_PARAMETER_SWEEP_MAX_AXES * PD_PARAMETER_SWEEP_VALUE_BYTES];
    pd_parameter_sweep_label(sweep, index, label, sizeof label);
    printf("%s: %s\n", label, status == 0 ? "done" : status == 3 ? "stopped" : "failed, see sweep.csv");
    fflush(stdout);
}

#if !defined(_WIN32) && !defined(__wasi__)
/* Wait for one process; its place is free again. 0: there was none. */
static int sweep_reap(const pd_parameter_sweep *sweep, pid_t *child, int *index, int jobs)
{
    int status;
    pid_t ended = waitpid(-1, &status, 0);
    if (ended < 0 && errno == EINTR) {
        for (int k = 0; k < jobs && interrupted; k++)
            if (child[k] > 0) kill(child[k], SIGTERM); /* they may not have heard it */
        return 1;
    }
    for (int k = 0; k < jobs && ended > 0; k++) {
        if (child[k] != ended) continue;
        child[k] = 0;
        sweep_tell(sweep, index[k], WIFEXITED(status) ? WEXITSTATUS(status) : 1);
    }
    return ended > 0;
}

static void sweep_side_by_side(pd_ctx *ctx, const pd_parameter_sweep *sweep, const pd_run_desc *desc, int jobs)
{
    pid_t child[MAX_JOBS];
    int index[MAX_JOBS], next = 0, busy = 1;
    memset(child, 0, sizeof child);
    fflush(stdout);
    fflush(stderr);
    while (busy) {
        busy = 0;
        for (int k = 0; k < jobs; k++) {
            if (child[k] == 0 && next < sweep->runs && !interrupted) {
                index[k] = next++;
                child[k] = fork();
                if (child[k] == 0) _exit(sweep_one(ctx, sweep, index[k], desc));
                if (child[k] < 0) { /* no more processes: here, then */
                    child[k] = 0;
                    sweep_tell(sweep, index[k], sweep_one(ctx, sweep, index[k], desc));
                }
            }
            busy = busy || child[k] > 0;
        }
        if (busy && !sweep_reap(sweep, child, index, jobs)) break;
        busy = busy || (next < sweep->runs && !interrupted);
    }
}

#endif

/* 0: all runs are done, 1: one failed, 3: stopped. */
static int sweep_runs(pd_ctx *ctx, const pd_parameter_sweep *sweep, const pd_run_desc *desc, int threads)
{
    long cores = processors();
    int all = threads > 0 ? threads : cores > 0 && cores < MAX_JOBS ? (int)cores : 1;
    int jobs = sweep->runs < all ? sweep->runs : all;
    pd_parameter_sweep_count count;
    if (jobs > MAX_JOBS) jobs = MAX_JOBS;
#if defined(_WIN32) || defined(__wasi__)
    jobs = 1; /* processes cannot be split */
#endif
    ctx->threads = all / jobs;
#if !defined(_WIN32) && !defined(__wasi__)
    if (jobs > 1) sweep_side_by_side(ctx, sweep, desc, jobs);
#endif
    for (int k = 0; k < sweep->runs && jobs == 1 && !interrupted; k++)
        sweep_tell(sweep, k, sweep_one(ctx, sweep, k, desc));
    if (pd_parameter_sweep_write(ctx, sweep, &count) < 0) {
        fprintf(stderr, "%s\n", ctx->message);
        return 1;
    }
    printf("sweep %s: %d done, %d failed, %d stopped; %s/sweep.csv\n", sweep->name, count.done, count.failed,
           count.stopped, sweep->folder);
    return count.stopped || interrupted ? 3 : count.failed ? 1 : 0;
}

static void help(const char *program)
{
    printf("%s SCENE [key=value ...] [--estimate-error] [--accuracy SHARE] [--out DIR] [--checkpoint TIME]\n"
           "     [--resume] [--sweep KEY=VALUES] [--fit KEY=LOW..HIGH] [--to FILE] [--threads N] [--memory-limit SIZE]"
           " [--follow]\n"
           "     [--live] [--progress TIME] [--quiet] [--check] [--new [NAME]] [--keys [SECTION]]\n"
           "     [--speciate] [--titrate REAGENT] [--version] [--help]\n\n"
           "Runs a corrosion scene in %d dimension%s (pdcorr %s).\n\n"
           "  SCENE          scene file, or a flat file of key = value lines\n"
           "  key=value      replaces a value of the scene; also section.key=value, section.label.key=value\n"
           "  --estimate-error\n"
           "                 after the run also run it with two and four times h, and print the error that follows\n"
           "  --accuracy SHARE\n"
           "                 for example 1%% or 0.01: pick the tolerances and steps that the scene leaves open, and\n"
           "                 estimate whether h reaches it\n"
           "  --out DIR      folder of the output, made when missing\n"
           "  --checkpoint TIME\n"
           "                 wall time between checkpoints, such as 30min or 0 s (every step); 10min unless given;\n"
           "                 off: none\n"
           "  --resume       go on from the checkpoint in the folder of the output, with the same scene and\n"
           "                 overrides; the files become those of a run that was never stopped\n"
           "  --fit KEY=LOW..HIGH\n"
           "                 find the value between the bounds, such as dissolve.rate_scale=0.5..2, whose run comes\n"
           "                 nearest to measured points, and run it; once for each of up to 8 keys\n"
           "  --to FILE      the points: columns of time, value and spread; more as behind 'file =' of [measured];\n"
           "                 without it those of the scene. Without --fit: compare the run with them\n"
           "  --threads N    threads, 0: all\n"
           "  --memory-limit SIZE\n"
           "                 for example 2GB or 500 MB: a run that needs more ends with a message\n"
           "  --sweep \"key=value, value, ... unit\"\n"
           "                 run the scene for each value, side by side on the threads, each into a folder of its own\n"
           "                 (run001, ...); several give all combinations; sweep.csv and sweep.png hold all\n"
           "  --follow       print the figures that the scene watches after each step; with --quiet as CSV, without\n"
           "                 anything else on the standard output\n"
           "  --live         keep the last picture of each field as latest_C.png and so on, for a viewer that reloads\n"
           "  --progress TIME\n"
           "                 wall time between lines of progress where the standard error is no terminal; 1min unless\n"
           "                 given; off: none\n"
           "  --quiet        print the result lines and errors only\n"
           "  --check        read the scene, build it and print the summary; say what the run, its estimate and its\n"
           "                 --resume would be refused for; run and write nothing\n"
           "  --speciate     print the equilibrium of the species of SCENE, or of a file of species and reactions:\n"
           "                 pH, species, saturation of minerals, elements; run and write nothing\n"
           "  --titrate \"REAGENT FROM..TO UNIT ROWS\"\n"
           "                 print a table (CSV) of the same as a reagent is added, such as 'Na+ + OH- 0..1 mM 21'\n"
           "  --new NAME     print a commented scene to begin with; without NAME: which there are\n"
           "  --keys SECTION\n"
           "                 print the keys of a section, with units and defaults; without SECTION: which there are\n"
           "  --version      print the version\n"
           "  --help         print this text\n\n"
           "SIGINT (Ctrl-C) and SIGTERM stop a run within a second, with a checkpoint of the last step that is done;\n"
           "another one, a second or more later, at once.\n"
           "Exit status: 0 done, 1 the run failed or was interrupted, 2 wrong usage or bad input, 3 stopped, --resume\n"
           "goes on.\n",
           program, PD_DIM, PD_DIM > 1 ? "s" : "", PD_VERSION);
}

/* ---- what a scene is made of ---- */

enum { COLUMNS = 100 };

/* The text without its backquotes, in lines that begin with `indent` blanks. */
static void print_text(const char *text, int indent)
{
    int column = 0;
    while (*text) {
        int bytes = (int)strcspn(text, " "), quotes = 0;
        for (int k = 0; k < bytes; k++) quotes += text[k] == '`';
        if (column && column + 1 + bytes - quotes > COLUMNS) {
            printf("\n");
            column = 0;
        }
        column += printf("%*s", column ? 1 : indent, "");
        for (int k = 0; k < bytes; k++)
            if (text[k] != '`') column += printf("%c", text[k]);
        text += bytes;
        text += strspn(text, " ");
    }
    printf("\n");
}

static void print_default(const char *text)
{
    for (; *text; text++)
        if (*text != '`') printf("%c", *text);
    printf("\n");
}

/* What a number, or an expression that is constant, may be. */
static void print_bounds(const pd_key *key)
{
    const char *space = strcmp(key->unit, "-") == 0 ? "" : " ", *unit = space[0] ? key->unit : "";
    int has_low = key->low > -PD_KEY_MAX_NUMBER, has_high = key->high < PD_KEY_MAX_NUMBER;
    if (key->type == PD_KEY_CHOICE || !(key->low < key->high) || (!has_low && !has_high)) return;
    printf("      ");
    if (has_low)
        printf(key->low_is_open ? "above %g%s%s" : has_high ? "from %g%s%s" : "at least %g%s%s", key->low, space, unit);
    if (has_high)
        printf("%s%g%s%s", !has_low ? "at most " : key->low_is_open ? ", at most " : " to ", key->high, space, unit);
    printf("\n");
}

static void print_section(const pd_key_section *s)
{
    printf("[%s%s%s]  %s\n", s->name, s->label[0] ? " " : "", s->label, s->meaning);
    for (int k = 0; k < s->count; k++) {
        const pd_key *key = &s->key[k];
        printf("\n  %-28s unit %-9s %s", key->keys, key->unit,
               strncmp(key->default_text, "required", 8) ? "default " : "");
        print_default(key->default_text);
        print_text(key->meaning, 6);
        print_bounds(key);
    }
}

static int keys(const options *o)
{
    char list[512] = "";
    int count;
    const pd_key_section *s = pd_key_sections(&count);
    for (int k = 0; k < count; k++) {
        char title[64];
        snprintf(title, sizeof title, "[%s%s%s]", s[k].name, s[k].label[0] ? " " : "", s[k].label);
        if (!o->ask) printf("%-18s %s\n", title, s[k].meaning);
        else if (strcmp(s[k].name, o->ask) == 0) {
            print_section(&s[k]);
            return 0;
        }
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", k ? ", " : "", s[k].name);
    }
    if (!o->ask) return 0;
    fprintf(stderr, "%s: --keys: found '%.60s', expected one of %s\n", o->program, o->ask, list);
    return 2;
}

static int begin(const options *o)
{
    char list[512] = "";
    int count;
    const pd_template *t = pd_templates(&count);
    for (int k = 0; k < count; k++) {
        if (!o->begin) printf("%s\n", t[k].name);
        else if (strcmp(t[k].name, o->begin) == 0) {
            for (int line = 0; t[k].line[line]; line++) printf("%s\n", t[k].line[line]);
            return 0;
        }
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", k ? ", " : "", t[k].name);
    }
    if (!o->begin) return 0;
    fprintf(stderr, "%s: --new: found '%.60s', expected one of %s, which there are in %dD\n", o->program, o->begin,
            list, PD_DIM);
    return 2;
}

static int usage(const options *o, const char *what, const char *found)
{
    fprintf(stderr, "%s: %s%s; see %s --help\n", o->program, what, found, o->program);
    return 2;
}

/* The text behind an option that takes one; "" when there is none. */
static const char *value_of(int argc, char **argv, int *k) { return *k + 1 < argc ? argv[++*k] : ""; }

/* The word behind an option that may stand alone, NULL: it does. */
static const char *word_of(int argc, char **argv, int *k)
{
    return *k + 1 < argc && argv[*k + 1][0] != '-' ? argv[++*k] : NULL;
}

/* "1%", "0.1 %" or "0.01" */
static int parse_share(const char *text, double *value)
{
    char number[32];
    size_t length = strlen(text), percent = length && text[length - 1] == '%';
    if (length >= sizeof number) return 0;
    memcpy(number, text, length + 1);
    if (percent) number[--length] = '\0';
    while (percent && length && number[length - 1] == ' ') number[--length] = '\0';
    if (!parse_number(number, 0.0, 100.0, value)) return 0;
    if (percent) *value *= 0.01;
    return *value >= PD_ACCURACY_MIN && *value <= PD_ACCURACY_MAX;
}

/* "10min", "0 s" or "off" */
static int parse_interval(const char *text, int *on, double *every)
{
    pd_ctx quiet;
    pd_dims found, time;
    double scale;
    char *unit;
    pd_ctx_init(&quiet);
    *on = strcmp(text, "off") != 0;
    if (!*on) return 1;
    *every = strtod(text, &unit);
    if (unit == text) return 0;
    while (*unit == ' ') unit++;
    if (pd_units_parse(&quiet, unit, &scale, &found) < 0) return 0;
    pd_units_parse(&quiet, "s", NULL, &time);
    *every *= scale;
    for (int k = 0; k < 6; k++)
        if (fabs(found.exponent[k] - time.exponent[k]) > 1e-9) return 0;
    return *every >= 0.0 && *every < 1e12;
}

/* "2GB", "1.5 GiB", "500 MB"; a number alone counts bytes. */
static int parse_memory(const char *text, double *value)
{
    static const char *const units[] = {"", "kB", "MB", "GB", "TB", "KiB", "MiB", "GiB", "TiB"};
    static const double sizes[] = {1.0, 1e3, 1e6, 1e9, 1e12, 1024.0, 1048576.0, 1073741824.0, 1099511627776.0};
    char number[32];
    size_t length = strspn(text, "0123456789.");
    const char *unit = text + length + strspn(text + length, " ");
    if (length >= sizeof number) return 0;
    memcpy(number, text, length);
    number[length] = '\0';
    if (!parse_number(number, 0.0, 1e18, value)) return 0;
    for (size_t k = 0; k < sizeof units / sizeof units[0]; k++) {
        if (strcmp(unit, units[k]) != 0) continue;
        *value *= sizes[k];
        return *value >= 1.0 && *value < 1e18 && *value <= (double)((size_t)-1 / 2);
    }
    return 0;
}

static int parse(int argc, char **argv, options *o)
{
    memset(o, 0, sizeof *o);
    o->checkpoints = o->progress = 1;
    o->checkpoint_every = CHECKPOINT_EVERY;
    o->progress_every = PROGRESS_EVERY;
    o->program = strrchr(argv[0], '/') ? strrchr(argv[0], '/') + 1 : argv[0];
#if defined(_WIN32)
    if (strrchr(o->program, '\\')) o->program = strrchr(o->program, '\\') + 1;
#endif
    for (int k = 1; k < argc; k++) {
        const char *a = argv[k];
        if (strcmp(a, "--help") == 0 || strcmp(a, "-h") == 0) o->help = 1;
        else if (strcmp(a, "--quiet") == 0) o->quiet = 1;
        else if (strcmp(a, "--check") == 0) o->check = 1;
        else if (strcmp(a, "--estimate-error") == 0) o->estimate = 1;
        else if (strcmp(a, "--resume") == 0) o->resume = 1;
        else if (strcmp(a, "--follow") == 0) o->follow = 1;
        else if (strcmp(a, "--live") == 0) o->live = 1;
        else if (strcmp(a, "--speciate") == 0) o->speciate = 1;
        else if (strcmp(a, "--titrate") == 0) {
            o->titrate = value_of(argc, argv, &k);
            o->speciate = 1;
        } else if (strcmp(a, "--accuracy") == 0) {
            if (!parse_share(value_of(argc, argv, &k), &o->accuracy))
                return usage(o, "--accuracy expects a share from 0.0001% to 50%, such as 1% or 0.01", "");
            o->estimate = 1;
        } else if (strcmp(a, "--out") == 0) {
            o->out = value_of(argc, argv, &k);
            if (!o->out[0]) return usage(o, "--out expects a folder", "");
        } else if (strcmp(a, "--sweep") == 0) {
            if (o->sweep_count == PD_PARAMETER_SWEEP_MAX_AXES) return usage(o, "more than 8 sweeps", "");
            o->sweeps[o->sweep_count++] = value_of(argc, argv, &k);
        } else if (strcmp(a, "--checkpoint") == 0) {
            if (!parse_interval(value_of(argc, argv, &k), &o->checkpoints, &o->checkpoint_every))
                return usage(o, "--checkpoint expects a time such as 10min or 0 s, or off", "");
        } else if (strcmp(a, "--progress") == 0) {
            if (!parse_interval(value_of(argc, argv, &k), &o->progress, &o->progress_every))
                return usage(o, "--progress expects a time such as 10 s or 5min, or off", "");
        } else if (strcmp(a, "--fit") == 0) {
            if (o->range_count == PD_LEAST_SQUARES_PARAMETERS) return usage(o, "more than 8 of --fit", "");
            o->ranges[o->range_count++] = value_of(argc, argv, &k);
        } else if (strcmp(a, "--to") == 0) {
            o->data = value_of(argc, argv, &k);
            if (!o->data[0]) return usage(o, "--to expects a file of measured points", "");
        } else if (strcmp(a, "--threads") == 0) {
            double threads;
            if (!parse_number(value_of(argc, argv, &k), 0.0, 1024.0, &threads) || threads != floor(threads))
                return usage(o, "--threads expects a number from 0 to 1024", "");
            o->threads = (int)threads;
        } else if (strcmp(a, "--memory-limit") == 0) {
            if (!parse_memory(value_of(argc, argv, &k), &o->memory))
                return usage(o, "--memory-limit expects a size such as 2GB, 1.5 GiB or 500 MB", "");
        } else if (strcmp(a, "--new") == 0) {
            o->begins = 1;
            o->begin = word_of(argc, argv, &k);
        } else if (strcmp(a, "--keys") == 0) {
            o->asks = 1;
            o->ask = word_of(argc, argv, &k);
        } else if (strcmp(a, "--version") == 0) {
            o->version = 1;
        } else if (a[0] == '-' && a[1]) return usage(o, "unknown option ", a);
        else if (strchr(a, '=')) {
            if (o->count == MAX_OVERRIDES) return usage(o, "more than 64 key=value arguments", "");
            o->overrides[o->count++] = a;
        } else if (o->scene) return usage(o, "a second scene, expected one and key=value: ", a);
        else o->scene = a;
    }
    if (o->range_count && o->resume) return usage(o, "--resume goes on with one run, --fit begins many", "");
    if (o->sweep_count && o->follow) return usage(o, "--sweep goes without --follow: runs go side by side", "");
    if (o->sweep_count && (o->check || o->resume || o->estimate || o->range_count || o->data))
        return usage(o, "--sweep goes without --check, --resume, --estimate-error, --accuracy, --fit and --to: a run of"
                        " it goes on by itself, with its values and --out", "");
    if (o->speciate && (o->check || o->resume || o->estimate || o->range_count || o->data || o->sweep_count || o->out))
        return usage(o, "--speciate and --titrate run nothing, expected a file and key=value alone", "");
    if ((o->begins || o->asks) && o->scene) return usage(o, "--new and --keys go without a scene, found ", o->scene);
    if (o->begins && o->asks) return usage(o, "--new and --keys together, expected one of them", "");
    return o->scene || o->help || o->version || o->begins || o->asks ? 0 : usage(o, "no scene file given", "");
}

static int fail(const options *o, screen *s, const char *message, int status)
{
    end_progress(s);
    fprintf(stderr, "%s: %s\n", o->program, message);
    return status;
}

/* The same for what was read: memory that is lacking, or a signal, is no fault of the input. */
static int refuse(const options *o, screen *s, const pd_ctx *ctx, pd_status status)
{
    int lacking = status == PD_ERR_MEMORY || status == PD_ERR_LIMIT || status == PD_CANCELLED;
    return fail(o, s, ctx->message, lacking ? 1 : 2);
}

/* Whether the wanted accuracy is reached, and the spacing that the estimate asks for when it is not. */
static void judge(const options *o, const pd_richardson *e, FILE *to)
{
    double h[PD_DIM], worst = e->worst_output < 0 ? NAN : e->list[e->worst_output].error;
    const char *reached = e->worst_output < 0 ? "unknown" : worst <= o->accuracy ? "yes" : "no";
    fprintf(to, "result case=%s accuracy=%.6g reached=%s", e->setup->name, o->accuracy, reached);
    for (int k = 0; k < e->count; k++)
        if (strcmp(e->list[k].figure.key, "volume_loss") == 0)
            fprintf(to, " reached_volume_loss=%s", e->list[k].error <= o->accuracy ? "yes" : "no");
    if (e->worst_output >= 0 && worst < HUGE_VAL) fprintf(to, " err_worst=%.3g", worst);
    if (e->worst_output >= 0) fprintf(to, " h=%.6g", e->setup->h[0]);
    pd_richardson_suggest_spacing(e, o->accuracy, h);
    if (worst > o->accuracy) fprintf(to, " wanted_h=%.12g", h[0]);
    for (int d = 1; d < PD_DIM && worst > o->accuracy; d++)
        if (fabs(h[d] - h[0]) > 1e-9 * h[0]) fprintf(to, " wanted_h%c=%.12g", "xyz"[d], h[d]);
    fprintf(to, "\n");
}

/* What an estimate can do, when it is not run. */
static int checked(pd_richardson *e, pd_ctx *ctx, screen *s)
{
    char line[PD_MESSAGE_SIZE + 64];
    snprintf(line, sizeof line, "the error estimate will assume orders: %s", e->missing_reason);
    if (e->missing_reason[0]) print(s, PD_PRINT_NOTE, line);
    pd_richardson_free(ctx, e);
    return 0;
}

/* The estimate behind a run; without one the run stands, and a check fails. */
static int estimate(const options *o, pd_ctx *ctx, const pd_setup *setup, const pd_run_desc *desc,
                    const pd_scalar_outputs *figures, screen *s)
{
    pd_richardson e;
    if (figures->count == 0) {
        fprintf(stderr, "%s: no error estimate: the scene watches nothing: add a [probe NAME] or another section of "
                        "that sort\n", o->program);
    } else if (pd_richardson_run(ctx, setup, desc, figures, &e) >= 0) {
        if (o->check) return checked(&e, ctx, s);
        pd_richardson_print(&e, print, s);
        if (o->accuracy > 0.0) judge(o, &e, s->results);
        pd_richardson_free(ctx, &e);
        return 0;
    } else if (interrupted) {
        return fail(o, s, "interrupted in the error estimate; the results above are complete", 1);
    } else {
        fprintf(stderr, "%s: no error estimate: %s\n", o->program, ctx->message);
    }
    if (o->check) return 2;
    if (o->accuracy > 0.0)
        fprintf(s->results, "result case=%s accuracy=%.6g reached=unknown\n", setup->name, o->accuracy);
    return 0;
}

static int run_watched(const options *o, pd_ctx *ctx, const pd_setup *setup, pd_scalar_outputs *figures, screen *s)
{
    char line[1024];
    pd_run_desc desc;
    pd_run_result result;
    follow f;
    double wall = wall_seconds();
    memset(&desc, 0, sizeof desc);
    desc.folder = o->out;
    desc.check_only = o->check;
    desc.print = print;
    desc.print_user = s;
    desc.stop = is_interrupted;
    desc.checkpoints = o->checkpoints;
    desc.checkpoint_every = o->checkpoint_every;
    desc.resume = o->resume;
    desc.updates_latest = o->live;
    memset(&f, 0, sizeof f);
    f.s = s;
    if (o->follow) desc.observe = follow_instant;
    desc.observe_user = &f;
    if (o->estimate) desc.figures = figures;
    pd_status status = pd_run(ctx, setup, &desc, &result);
    pd_scalar_outputs_free(ctx, &f.figures);
    if (status == PD_CANCELLED) return fail(o, s, "interrupted before the first step; nothing was written", 1);
    if (status < 0) return fail(o, s, ctx->message, result.bad_input ? 2 : 1);
    end_progress(s);
    if (o->check) return o->estimate ? estimate(o, ctx, setup, &desc, figures, s) : 0;
    pd_run_format_result(&result, line, sizeof line);
    fprintf(s->results, "%s wall_s=%.3f cpu_s=%.3f peak_rss_mb=%.1f threads=%d\n", line, wall_seconds() - wall,
            cpu_seconds(), peak_memory(), result.threads);
    fflush(s->results);
    if (!result.stopped) return o->estimate ? estimate(o, ctx, setup, &desc, figures, s) : 0;
    snprintf(line, sizeof line, "interrupted at t = %g s; %s", result.time,
             o->checkpoints ? "the same command with --resume goes on" : "the output is complete up to there");
    return fail(o, s, line, o->checkpoints ? 3 : 1);
}

static int run(const options *o, pd_ctx *ctx, pd_setup *setup, screen *s)
{
    char line[640];
    pd_scalar_outputs figures;
    memset(&figures, 0, sizeof figures);
    if (o->accuracy > 0.0) {
        pd_status applied = pd_tolerance_presets_apply(ctx, o->accuracy, setup, line, sizeof line);
        if (applied < 0) return refuse(o, s, ctx, applied);
        print(s, PD_PRINT_NOTE, line);
    }
    int status = run_watched(o, ctx, setup, &figures, s);
    pd_scalar_outputs_free(ctx, &figures);
    return status;
}

/* The scene as it is run: at the values of a fit, with the points of the command line. */
static int read_scene(options *o, pd_ctx *ctx, pd_setup *setup, screen *s)
{
    static pd_fit fit; /* the overrides stay */
    static char line[4096];
    pd_fit_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.scene = o->scene;
    desc.overrides = o->overrides;
    desc.count = o->count;
    desc.measured = o->data;
    desc.range = o->ranges;
    desc.ranges = o->range_count;
    desc.print = print;
    desc.print_user = s;
    desc.stop = is_interrupted;
    if (!o->range_count && !o->data) {
        pd_status status = pd_scene_read(ctx, o->scene, o->overrides, o->count, setup);
        return status < 0 ? refuse(o, s, ctx, status) : 0;
    }
    if (o->range_count) {
        if (o->count + o->range_count > MAX_OVERRIDES) return usage(o, "more than 64 key=value arguments", "");
        if (pd_fit_run(ctx, &desc, &fit) < 0) return fail(o, s, ctx->message, fit.bad_input ? 2 : 1);
        pd_fit_format_result(&fit, line, sizeof line);
        print(s, PD_PRINT_RESULT, line);
        for (int k = 0; k < fit.parameters; k++) o->overrides[o->count++] = fit.override[k];
        desc.count = o->count;
    }
    pd_status status = pd_fit_read_setup(ctx, &desc, NULL, 0, setup);
    return status < 0 ? refuse(o, s, ctx, status) : 0;
}

/* Lines of a table; those of results go beside it. */
static void print_row(void *user, pd_print_kind kind, const char *text)
{
    (void)user;
    if (kind == PD_PRINT_SUMMARY) printf("%s\n", text);
    else fprintf(stderr, "%s%s\n", kind == PD_PRINT_NOTE ? "note: " : "", text);
}

static int speciate(const options *o, pd_ctx *ctx, screen *s)
{
    pd_speciation_report_desc desc;
    int bad_input = 0;
    memset(&desc, 0, sizeof desc);
    desc.path = o->scene;
    desc.overrides = o->overrides;
    desc.count = o->count;
    desc.titrate = o->titrate;
    desc.print = o->titrate ? print_row : print;
    desc.user = s;
    return pd_speciation_report_print(ctx, &desc, &bad_input) < 0 ? fail(o, s, ctx->message, bad_input ? 2 : 1) : 0;
}

static int sweep(const options *o, pd_ctx *ctx, screen *s)
{
    pd_parameter_sweep_desc desc;
    pd_parameter_sweep all;
    pd_run_desc run_desc;
    memset(&desc, 0, sizeof desc);
    memset(&run_desc, 0, sizeof run_desc);
    desc.scene = o->scene;
    desc.overrides = o->overrides;
    desc.count = o->count;
    desc.axes = o->sweeps;
    desc.axis_count = o->sweep_count;
    desc.folder = o->out;
    pd_status status = pd_parameter_sweep_build(ctx, &desc, &all);
    if (status < 0) return refuse(o, s, ctx, status);
    run_desc.stop = is_interrupted;
    run_desc.checkpoints = o->checkpoints;
    run_desc.checkpoint_every = o->checkpoint_every;
    run_desc.updates_latest = o->live;
    catch_signals();
    int ended = sweep_runs(ctx, &all, &run_desc, o->threads);
    pd_parameter_sweep_free(ctx, &all);
    return ended;
}

static int act(int argc, char **argv, options *o)
{
    screen s;
    pd_ctx ctx;
    pd_setup setup;
    int status = parse(argc, argv, o);
    if (status) return status;
    if (o->help) {
        help(o->program);
        return 0;
    }
    if (o->version) {
        printf("pdcorr %s\n", PD_VERSION);
        return 0;
    }
    if (o->begins) return begin(o);
    if (o->asks) return keys(o);
    if (o->threads != 1) calm_threads(argv);
    memset(&s, 0, sizeof s);
    s.quiet = o->quiet;
    s.terminal = !o->quiet && is_terminal();
    s.lines = !o->quiet && o->progress;
    s.every = o->progress_every;
    s.said = wall_seconds();
    s.results = o->follow && o->quiet ? stderr : stdout;
    pd_ctx_init(&ctx);
    ctx.threads = o->threads;
    ctx.cancel = is_interrupted_within;
    ctx.alloc.limit = (size_t)o->memory;
    if (o->speciate) return speciate(o, &ctx, &s);
    if (o->sweep_count) return sweep(o, &ctx, &s);
    catch_signals();
    status = read_scene(o, &ctx, &setup, &s);
    if (status) return status;
    status = run(o, &ctx, &setup, &s);
    pd_setup_free(&ctx, &setup);
    return status;
}

/* A program whose lines did not arrive has failed. */
int main(int argc, char **argv)
{
    options o;
#if defined(_WIN32)
    argv = arguments(&argc, argv);
#endif
    int status = act(argc, argv, &o);
    int lost = fflush(stdout) != 0;
    if (!ferror(stdout) && !lost) return status;
    fprintf(stderr, "%s: lines of the standard output are lost: it is closed or full\n", o.program);
    return status ? status : 1;
}
