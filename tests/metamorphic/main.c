/* metamorphic: random scenes and what must be the same of them when they are rotated, mirrored, shifted, rescaled.
 *
 *   metamorphic_2d [--seed N] [--pairs N] [--seconds S] [--class exact|tolerance|lattice] [--only TRANSFORM] [--show]
 *                  [--sanitize] [--limit S] [--through SHARE] [--shrink S] [--jobs N] [--with PHYSICS]...
 *                  [--holding TEXT] [--extreme]
 *
 * --extreme: scenes with numbers far from all scales, which end with an answer or a message (extreme.h); --with,
 * --holding: scenes that have all of these physics, and the text, such as union; --closed: without the seeds of open
 * findings; --through: share of bodies with faces through nodes; --limit: of a run, in seconds of the processor;
 * --shrink: the same for the smallest scene that shows a finding, 0: as it was found; --jobs: processes side by side.
 */
#define _XOPEN_SOURCE 700
#include "generate.h"
#include "record.h"
#include "compare.h"
#include "shrink.h"
#include "invariant.h"
#include "extreme.h"
#include "random.h"
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { TEXT = 65536 };

typedef struct options {
    uint32_t seed;
    int pairs, show, sanitize, extreme, quick, blind, closed, only, jobs;
    double seconds, limit, through, shrink;
    scene_class of;
    uint32_t with;                /* scenes that have all of it */
    const char *holding;          /* scenes with this text; NULL: all */
    int mixed;                    /* a fifth of the pairs by tolerance */
    char folder[256], other[300]; /* scratch; the program in 3D */
} options;

/* Of `make test`: seeds without a finding, in each dimension. Generate others with --show, which says of which pairs
 * agree. */
static const uint32_t quick_seeds[] = {
#if PD_DIM == 1
    60001, 60002, 60003, 60004, 60005, 60006, 60007, 60008, 60009, 60010, 60011, 60012, 60013, 60014, 60015, 60016,
    60017, 60018, 60019, 60020, 60021, 60022, 60023, 60024, 60025, 60027, 60028, 60029, 60030, 60031, 60032, 60033,
    60034, 60036, 60037, 6, 22, 78, 81, /* stresses of bodies that sides hold, by their rtol */
    60691, 60975, 60994, /* a state whose ion is foreseen to run out; what species give back to metal;
                         * two metals and a complex in any order */
#elif PD_DIM == 2
    60001, 60002, 60003, 60004, 60005, 60006, 60008, 60009, 60010, 60012, 60013, 60015, 60016, 60018, 60019, 60020,
    60021, 60022, 60024, 60025, 60029, 60031, 60034, 60035, 60036, 60039, 60040, 60041,
    300122, 300231, /* a ring within a horizon of the outer side; flow in time that comes to rest */
    60411, /* a state whose ion is foreseen to run out */
#else
    60001, 60004, 60006, 60008, 60009, 60010, 60017, 60019, 60021, 60023, 60028, 60031, 60032,
#endif
};

/* Seeds of CI whose findings are open, which --closed leaves out: pairs from 1 on, sanitized scenes from 500001 on. A
 * run without it prints which they are. 0: none. */
static const uint32_t open_seeds[] = {
#if PD_DIM == 1
    0,
#elif PD_DIM == 2
    0,
#else
    7, 15, 25, 43,
#endif
};

enum { FINDINGS = 2000 };

typedef struct found_at {
    uint32_t seed;
    int transform;
    char kind[24], name[48];
} found_at;

/* What all processes add to, one at a time. */
typedef struct tally {
    int next; /* pair that nobody has begun */
    int pairs, ran, changed, several, refused, failed, other_steps, findings;
    int by_transform[TRANSFORM_COUNT], found[TRANSFORM_COUNT];
    double longest;
    found_at at[FINDINGS];
} tally;

/* The tally is a file of the folder for scratch; its lock is that of the tally and of what is printed. */
typedef struct board {
    int file;
    tally *sum;
} board;

static void board_lock(const board *b)
{
    struct flock all;
    memset(&all, 0, sizeof all);
    all.l_type = F_WRLCK;
    all.l_whence = SEEK_SET;
    while (fcntl(b->file, F_SETLKW, &all) != 0) continue;
}

static void board_unlock(const board *b)
{
    struct flock all;
    memset(&all, 0, sizeof all);
    all.l_type = F_UNLCK;
    all.l_whence = SEEK_SET;
    fflush(stdout);
    fcntl(b->file, F_SETLK, &all);
}

static int is_open(uint32_t seed)
{
    for (size_t k = 0; k < sizeof open_seeds / sizeof open_seeds[0]; k++)
        if (open_seeds[k] == seed) return 1;
    return 0;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void write_text(const scene *x, char *text)
{
    if (!scene_write(x, text, TEXT)) {
        fprintf(stderr, "metamorphic: a scene does not fit\n");
        exit(2);
    }
}

/* Where a solver stops earlier than the others, and no key of the scene or of the model makes it go on, pairs agree as
 * far as it goes: a steady flow to 1e-10 of scales of its residuals, which refuse less; a flow in time to a share of
 * its rtol; a steady field in a stream to a balance of 1e-6 (transport/settle). */
static double tolerance_of(const scene *x, const transform *t)
{
    if (transform_bits(t->kind)) return 0.0;
    if ((x->has & HAS_FLOW_IN_TIME) || ((x->has & HAS_STEADY) && (x->has & HAS_TRANSPORT) && (x->has & HAS_FLOW)))
        return 1e-5;
    return x->has & HAS_FLOW ? 1e-7 : 1e-9;
}

#define SHORTER 0.1       /* of the time of a scene */
#define TIGHTER_LIMIT 1.0 /* [s] of the processor, for a run with a tenth of rtol */
#define TIGHTEST_LIMIT 5.0

/* By tolerance: the scene with rtol and a tenth of it differ by 10 rtol, and with a tenth and a hundredth by a tenth of
 * that. Steps of first order are ten times and a hundred times as many: a scene ends earlier where these runs take
 * longer than their limits. The last try has the time that all runs have. */
static void run_steps(const options *o, const scene *x, const transform *t, record *a, record *b, finding *f)
{
    static char text[TEXT];
    static scene shorter, y, z;
    const int most = 3;
    const run_options r = {1, 0, 0, o->of == CLASS_EXACT ? 1 + x->first_order : 0, o->limit, o->folder, NULL};
    shorter = *x;
    for (int tries = 1; tries <= most; tries++) {
        const int last = tries == most;
        run_options limited = r;
        record c;
        if (tries > 1) {
            record_free(a);
            record_free(b);
            scene_shorten(&shorter, SHORTER);
        }
        write_text(&shorter, text);
        record_run(text, &r, a);
        transform_scene(&shorter, t, &y);
        write_text(&y, text);
        if (!last) limited.limit = fmin(TIGHTER_LIMIT, r.limit);
        record_run(text, &limited, b);
        if (a->outcome == OUTCOME_DONE && b->outcome == OUTCOME_HUNG && !last) continue;
        compare_steps(&shorter, t, a, b, 10.0 * x->rtol, f);
        if (f->found || a->outcome != OUTCOME_DONE || b->outcome != OUTCOME_DONE) break;
        transform_scene(&y, t, &z);
        write_text(&z, text);
        if (!last) limited.limit = fmin(TIGHTEST_LIMIT, r.limit);
        record_run(text, &limited, &c);
        const int hung = c.outcome == OUTCOME_HUNG;
        compare_steps(&y, t, b, &c, 10.0 * y.rtol, f); /* nothing of a run that has hung */
        if (f->found) snprintf(f->detail, sizeof f->detail, "at a tenth of rtol and a hundredth");
        record_free(&c);
        if (!hung || last) break;
    }
    if (!f->found && !o->blind) check_record(&shorter, a, f);
}

static void run_pair(const options *o, const scene *x, const transform *t, record *a, record *b, finding *f)
{
    static char text[TEXT];
    static scene y;
    run_options r = {1, t->kind == TRANSFORM_RESUME, 0, o->of == CLASS_EXACT ? 1 + x->first_order : 0,
                     o->limit, o->folder, NULL};
    write_text(x, text);
    record_run(text, &r, a);
    transform_scene(x, t, &y);
    write_text(&y, text);
    if (t->kind == TRANSFORM_THREADS) r.threads = 2;
    if (t->kind == TRANSFORM_RESUME) r.resume = 1 + (int)(t->seed % 4);
    record_run(text, &r, b);
    compare_records(x, t, a, b, tolerance_of(x, t), f);
    int other_steps = f->other_steps;
    if (!f->found && !o->blind) check_record(x, a, f);
    f->other_steps = other_steps;
}

/* Nothing to compare: whether it crashes or hangs. */
static void run_alone(const options *o, const scene *x, record *a, finding *f)
{
    static char text[TEXT];
    run_options r = {1, 0, 0, o->extreme ? 1 : 0, o->limit, o->folder, NULL};
    memset(f, 0, sizeof *f);
    write_text(x, text);
    record_run(text, &r, a);
    if (o->extreme) {
        extreme_check(x, a, f);
        return;
    }
    if (a->outcome != OUTCOME_CRASHED && a->outcome != OUTCOME_HUNG) return;
    f->found = 1;
    f->scale = 1.0;
    f->a = a->outcome;
    snprintf(f->kind, sizeof f->kind, "%s", a->outcome == OUTCOME_HUNG ? "hang" : "crash");
    snprintf(f->detail, sizeof f->detail, "%s", a->message);
}

enum { FINER = 4 };
#define FALLS 2.5 /* a difference of first order falls to a quarter */

/* 1: there are bodies. Which cells are theirs, and how they cut bonds, has no order in h where their faces are not
 * those of cells. The difference of two lattices goes with that, and may be larger with h/4 than by luck with h. */
static int has_bodies(const scene *x)
{
    for (int s = 0; s < x->sections; s++)
        if (strcmp(x->part[s].name, "shape") == 0 && !x->part[s].gone) return 1;
    return 0;
}

/* Records of a scene and of the one that it is compared with, on a lattice. Steps of species are of first order: which
 * steps of second order bounds leave is another question on each lattice. */
typedef struct lattice_pair {
    scene fine;
    record a, b;
    apart apart;
    double worst;
} lattice_pair;

/* 1: there is something to compare. A finer one may take longer than there is time. Where an error in time has made one
 * lattice take other steps, fields differ by that error, which has no order in h. */
static int run_lattices(const scene *x, const transform *t, int by, const run_options *here, const run_options *there,
                        lattice_pair *p, finding *f)
{
    static char text[TEXT];
    static scene y;
    transform_refine(x, by, &p->fine);
    write_text(&p->fine, text);
    record_run(text, here, &p->a);
    transform_scene(&p->fine, t, &y);
    write_text(&y, text);
    record_run(text, there, &p->b);
    memset(f, 0, sizeof *f);
    if (by > 1 && (p->a.outcome == OUTCOME_HUNG || p->b.outcome == OUTCOME_HUNG)) return 0;
    p->worst = compare_layer(&p->fine, &p->a, &p->b, &p->apart, f);
    return !f->found && p->a.outcome == OUTCOME_DONE && p->a.steps == p->b.steps;
}

static void say_falls(const char *of, finding *f)
{
    if (!f->found || strcmp(f->kind, "lattice") != 0) return;
    snprintf(f->detail, sizeof f->detail, "%.3g apart, %.3g with %s", f->a, f->b, of);
}

/* One layer in 3D against 2D, at h and h/4: the same, or nearer to each other. */
static void run_layer(const options *o, const scene *x, const transform *t, record *a, record *b, finding *f)
{
    static lattice_pair pair[2];
    run_options here = {1, 0, 0, 2, 4.0 * o->limit, o->folder, NULL}, there = here;
    int levels = 0;
    there.program = o->other;
    while (levels < 2) {
        int goes = run_lattices(x, t, levels ? FINER : 1, &here, &there, &pair[levels], f);
        levels++;
        if (!goes || pair[levels - 1].worst < 1e-9) break;
        if (levels == 2)
            compare_falls(&pair[0].apart, &pair[1].apart, FALLS, 1e-5, has_bodies(x) ? &pair[0].a : NULL, &pair[1].a,
                          f);
    }
    say_falls("h/4", f);
    *a = pair[0].a;
    *b = pair[0].b;
    if (levels > 1) record_free(&pair[1].a);
    if (levels > 1) record_free(&pair[1].b);
}

#define RADIUS 100.0 /* of a ring, over the height of its section */

/* A ring against the plane: what differs is in proportion to the inverse of its radius. Flows have other coefficients
 * around an axis: they differ by the order of the lattice, too, and are compared with h/4 as well. */
static void run_ring(const options *o, const scene *x, const transform *t, record *a, record *b, finding *f)
{
    static lattice_pair pair[2];
    int flows = (x->has & HAS_FLOW) != 0, levels = 0;
    run_options r = {1, 0, 0, 2, flows ? 4.0 * o->limit : o->limit, o->folder, NULL};
    while (levels < 2) {
        transform far = *t;
        far.offset[1] = (levels ? 10.0 : 1.0) * RADIUS * x->cells[1] * x->h[1];
        int goes = run_lattices(x, &far, levels && flows ? FINER : 1, &r, &r, &pair[levels], f);
        levels++;
        if (!goes || pair[levels - 1].worst < 1e-6) break;
        if (levels == 2)
            compare_falls(&pair[0].apart, &pair[1].apart, FALLS, 1e-6, flows && has_bodies(x) ? &pair[0].a : NULL,
                          &pair[1].a, f);
    }
    say_falls(flows ? "ten times the radius and h/4" : "ten times the radius", f);
    *a = pair[0].a;
    *b = pair[0].b;
    if (levels > 1) record_free(&pair[1].a);
    if (levels > 1) record_free(&pair[1].b);
}

static void run_any(const options *o, const scene *x, const transform *t, record *a, record *b, finding *f)
{
    if (t->kind == TRANSFORM_LAYER) run_layer(o, x, t, a, b, f);
    else if (t->kind == TRANSFORM_RING) run_ring(o, x, t, a, b, f);
    else if (t->kind == TRANSFORM_TIGHTER) run_steps(o, x, t, a, b, f);
    else run_pair(o, x, t, a, b, f);
}

typedef struct pair_compare {
    const options *o;
} pair_compare;

static void compare_again(void *user, const scene *x, const transform *t, finding *f)
{
    record a, b;
    const options *o = ((const pair_compare *)user)->o;
    run_any(o, x, t, &a, &b, f);
    record_free(&a);
    record_free(&b);
}

static void print_finding(const options *o, uint32_t seed, const scene *x, const transform *t, const finding *f)
{
    static char text[TEXT];
    static scene y;
    printf("FINDING seed %u dim %d %s: %s %s: %.17g %.17g (%.3g of %.3g) %s\n", seed, PD_DIM, transform_names[t->kind],
           f->kind, f->name, f->a, f->b, fabs(f->a - f->b) / f->scale, f->scale, f->detail);
    if (f->others[0]) printf("differ:%s\n", f->others);
    write_text(x, text);
    printf("---- scene\n%s", text);
    if (o->sanitize) return;
    transform_scene(x, t, &y);
    write_text(&y, text);
    printf("---- the other one\n%s----\n", text);
    fflush(stdout);
}

static void one(const options *all, uint32_t seed, const board *together)
{
    tally *s = together->sum;
    options own = *all, *o = &own;
    static scene x;
    static char text[TEXT];
    record a, b;
    finding f;
    transform t;
    uint32_t state = seed ^ 0x5bd1e995u;
    if ((o->mixed || o->extreme) && o->only < 0 && seed % 5 == 0) own.of = CLASS_TOLERANCE;
    if (o->mixed && !o->quick && o->only < 0 && o->other[0] && seed % 10 == 7) own.of = CLASS_LATTICE;
    if (o->mixed && PD_DIM == 2 && o->only < 0 && seed % 10 == 3) own.of = CLASS_RING;
    if (o->only == TRANSFORM_LAYER) own.of = CLASS_LATTICE;
    if (o->only == TRANSFORM_RING) own.of = CLASS_RING;
    if (o->only == TRANSFORM_TIGHTER) own.of = CLASS_TOLERANCE;
    generate_scene(seed, o->of, o->through, &x);
    if ((x.has & o->with) != o->with) return;
    if (o->holding) {
        write_text(&x, text);
        if (!strstr(text, o->holding)) return;
    }
    int kind = o->only >= 0 ? o->only : (int)(random_share(&state) * TRANSFORM_TIGHTER);
    if (o->sanitize) kind = TRANSFORM_UNITS;
    if (o->of == CLASS_TOLERANCE && !o->sanitize) kind = TRANSFORM_TIGHTER;
    else if (o->of == CLASS_LATTICE) kind = TRANSFORM_LAYER;
    else if (o->of == CLASS_RING) kind = TRANSFORM_RING;
    for (int k = 0; !transform_draw((transform_kind)kind, &x, &state, &t); k++) {
        if (o->only >= 0 || k > 50) return;
        kind = (int)(random_share(&state) * TRANSFORM_TIGHTER);
        if (o->of == CLASS_TOLERANCE && k == 0) { /* nothing in time */
            own.of = CLASS_EXACT;
            generate_scene(seed, o->of, o->through, &x);
        }
    }
    if (o->extreme) {
        static scene moderate;
        moderate = x;
        extreme_scene(&moderate, seed, &x);
    }
    if (o->sanitize) run_alone(o, &x, &a, &f);
    else run_any(o, &x, &t, &a, &b, &f);
    static scene found;
    found = x;
    if (f.found && o->shrink > 0.0 && !o->sanitize && strcmp(f.kind, "hang") != 0) {
        pair_compare p = {o};
        shrink_scene(compare_again, &p, &t, o->shrink, &found, &f);
    }
    board_lock(together);
    if (o->show) {
        write_text(&x, text);
        printf("# seed %u\n%s", seed, text);
        printf("# seed %u %s: %s, %s, %s, %d physics, %lld steps, %.2f s %s\n", seed, transform_names[kind],
               f.found ? "finding" : "agrees", outcome_names[a.outcome], a.changes ? "changed" : "unchanged",
               scene_physics(&x), (long long)a.steps, a.seconds, a.message);
    }
    s->pairs++;
    s->by_transform[kind]++;
    s->ran += a.outcome == OUTCOME_DONE;
    s->changed += a.outcome == OUTCOME_DONE && a.changes;
    s->several += scene_physics(&x) >= 3;
    s->refused += a.outcome == OUTCOME_REFUSED;
    s->failed += a.outcome == OUTCOME_FAILED;
    s->other_steps += !f.found && f.other_steps;
    if (a.seconds > s->longest) s->longest = a.seconds;
    if (f.found) {
        if (s->findings < FINDINGS) {
            found_at *at = &s->at[s->findings];
            at->seed = seed;
            at->transform = kind;
            snprintf(at->kind, sizeof at->kind, "%s", f.kind);
            snprintf(at->name, sizeof at->name, "%.47s", f.name);
        }
        s->findings++;
        s->found[kind]++;
        print_finding(o, seed, &found, &t, &f);
    }
    board_unlock(together);
    record_free(&a);
    if (!o->sanitize) record_free(&b);
}

/* Pairs that nobody has begun, one after another. */
static void work(const options *o, double begin, const board *b)
{
    for (;;) {
        board_lock(b);
        int k = b->sum->next++;
        board_unlock(b);
        if (k >= o->pairs || (o->seconds > 0.0 && now() - begin > o->seconds)) return;
        if (o->closed && is_open(o->seed + (uint32_t)k)) continue;
        one(o, o->quick ? quick_seeds[k] : o->seed + (uint32_t)k, b);
    }
}

/* Each process has a folder of its own. How many of them did not come to their end. */
static int work_together(const options *o, double begin, const board *b)
{
    for (int k = 0; k < o->jobs; k++) {
        fflush(stdout);
        pid_t child = fork();
        if (child != 0) continue;
        options own = *o;
        snprintf(own.folder, sizeof own.folder, "%.240s/%d", o->folder, k);
        if (mkdir(own.folder, 0777) != 0) _exit(2);
        snprintf(scene_folder, sizeof scene_folder, "%s", own.folder);
        work(&own, begin, b);
        fflush(stdout);
        _exit(0);
    }
    int status, lost = 0;
    while (wait(&status) > 0) lost += !WIFEXITED(status) || WEXITSTATUS(status) != 0;
    return lost;
}

static int open_board(const char *folder, board *b)
{
    char path[300];
    snprintf(path, sizeof path, "%s/tally", folder);
    b->file = open(path, O_RDWR | O_CREAT | O_TRUNC, 0666);
    if (b->file < 0 || ftruncate(b->file, (off_t)sizeof(tally)) != 0) return 0;
    void *p = mmap(NULL, sizeof(tally), PROT_READ | PROT_WRITE, MAP_SHARED, b->file, 0);
    if (p == MAP_FAILED) return 0;
    b->sum = (tally *)p;
    return 1;
}

/* By transform, and within by what differs, with the seeds. */
static void print_summary(const options *o, const tally *s)
{
    printf("%d %s, %d ran, %d (%.0f %%) changed something, %d (%.0f %%) with three physics or more, %d refused, "
           "%d failed, %d of other steps, longest %.2f s\n",
           s->pairs, o->sanitize ? "scenes" : "pairs", s->ran, s->changed, 100.0 * s->changed / fmax(s->pairs, 1),
           s->several, 100.0 * s->several / fmax(s->pairs, 1), s->refused, s->failed, s->other_steps, s->longest);
    int listed = s->findings < FINDINGS ? s->findings : FINDINGS;
    for (int k = 0; k < TRANSFORM_COUNT; k++) {
        if (!s->by_transform[k]) continue;
        printf("%s %d of %d\n", o->sanitize ? "alone" : transform_names[k], s->found[k], s->by_transform[k]);
        for (int i = 0; i < listed; i++) {
            const found_at *p = &s->at[i];
            int first = p->transform == k;
            for (int j = 0; j < i && first; j++)
                first = s->at[j].transform != k || strcmp(s->at[j].kind, p->kind) != 0 ||
                        strcmp(s->at[j].name, p->name) != 0;
            if (!first) continue;
            printf("    %s %s:", p->kind, p->name);
            for (int j = i; j < listed; j++)
                if (s->at[j].transform == k && strcmp(s->at[j].kind, p->kind) == 0 &&
                    strcmp(s->at[j].name, p->name) == 0)
                    printf(" %u", s->at[j].seed);
            printf("\n");
        }
    }
}

static void remove_folder(const char *folder)
{
    char path[600];
    struct dirent *e;
    DIR *d = opendir(folder);
    while (d && (e = readdir(d)) != NULL) {
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0) continue;
        snprintf(path, sizeof path, "%s/%.255s", folder, e->d_name);
        if (unlink(path) != 0) remove_folder(path);
    }
    if (d) closedir(d);
    rmdir(folder);
}

static int usage(const char *what)
{
    fprintf(stderr, "metamorphic: %s: see the head of tests/metamorphic/main.c\n", what);
    return 2;
}

/* A scene for the program of another dimension, as in run_layer. */
static int serve(const char *path)
{
    static char text[TEXT];
    FILE *file = fopen(path, "r");
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    run_options r = {1, 0, 0, 2, 60.0, ".", NULL};
    if (!file || !size) return usage(path);
    fclose(file);
    record_serve(text, &r, 1);
    return 0;
}

/* The program in 3D, beside this one in 2D; "": there is none. */
static void find_other(const char *program, char *path, size_t size)
{
    snprintf(path, size, "%s", program);
    char *end = strstr(path, "_2d");
    if (PD_DIM == 2 && end) end[1] = '3';
    if (PD_DIM != 2 || !end || access(path, X_OK) != 0) path[0] = '\0';
}

int main(int argc, char **argv)
{
    options o;
    board b;
    double begin = now();
    if (!getenv("OMP_WAIT_POLICY")) { /* threads sleep at barriers: runs share the cores with others */
        setenv("OMP_WAIT_POLICY", "passive", 1);
        execv("/proc/self/exe", argv);
    }
    memset(&o, 0, sizeof o);
    o.jobs = 1;
    o.seed = 1;
    o.pairs = 100;
    o.only = -1;
    o.mixed = 1;
    o.limit = 5.0;
    find_other(argv[0], o.other, sizeof o.other);
    o.through = 0.3;
    o.shrink = 20.0;
    for (int k = 1; k < argc; k++) {
        const char *a = argv[k], *v = k + 1 < argc ? argv[k + 1] : "";
        if (strcmp(a, "--show") == 0) o.show = 1;
        else if (strcmp(a, "--sanitize") == 0) o.sanitize = 1;
        else if (strcmp(a, "--extreme") == 0) o.extreme = o.sanitize = 1, o.limit = 10.0, o.mixed = 0;
        else if (strcmp(a, "--blind") == 0) o.blind = 1;
        else if (strcmp(a, "--quick") == 0) o.quick = 1;
        else if (strcmp(a, "--closed") == 0) o.closed = 1;
        else if (k++, strcmp(a, "--seed") == 0) o.seed = (uint32_t)strtoul(v, NULL, 10);
        else if (strcmp(a, "--pairs") == 0) o.pairs = atoi(v);
        else if (strcmp(a, "--jobs") == 0) o.jobs = atoi(v);
        else if (strcmp(a, "--seconds") == 0) o.seconds = atof(v);
        else if (strcmp(a, "--limit") == 0) o.limit = atof(v);
        else if (strcmp(a, "--shrink") == 0) o.shrink = atof(v);
        else if (strcmp(a, "--holding") == 0) o.holding = v;
        else if (strcmp(a, "--with") == 0) {
            static const char *const names[] = {"flow",  "transport", "dissolve",  "corrode", "chemistry", "mineral",
                                                "state", "migration", "potential", "solid",   "gas"};
            for (uint32_t j = 0; j < sizeof names / sizeof names[0]; j++)
                if (strcmp(v, names[j]) == 0) o.with |= (uint32_t)1 << j; /* as HAS_FLOW and its like */
        } else if (strcmp(a, "--through") == 0) o.through = atof(v);
        else if (strcmp(a, "--class") == 0 && strcmp(v, "exact") == 0) o.mixed = 0;
        else if (strcmp(a, "--class") == 0 && strcmp(v, "tolerance") == 0) o.of = CLASS_TOLERANCE, o.mixed = 0;
        else if (strcmp(a, "--class") == 0 && strcmp(v, "lattice") == 0) o.of = CLASS_LATTICE, o.mixed = 0;
        else if (strcmp(a, "--record") == 0) return serve(v);
        else if (strcmp(a, "--only") == 0) {
            for (int j = 0; j < TRANSFORM_COUNT; j++)
                if (strcmp(v, transform_names[j]) == 0) o.only = j;
            if (o.only < 0) return usage(v);
        } else return usage(a);
    }
    const char *scratch = getenv("TMPDIR");
    snprintf(o.folder, sizeof o.folder, "%s/metamorphic.XXXXXX", scratch && scratch[0] ? scratch : P_tmpdir);
    if (!mkdtemp(o.folder) || !open_board(o.folder, &b)) return usage("no folder for scratch files");
    snprintf(scene_folder, sizeof scene_folder, "%s", o.folder);
    if (o.quick) o.pairs = (int)(sizeof quick_seeds / sizeof quick_seeds[0]);
    int lost = 0;
    if (o.jobs > 1) lost = work_together(&o, begin, &b);
    else work(&o, begin, &b);
    print_summary(&o, b.sum);
    int findings = b.sum->findings + lost;
    if (lost) printf("%d processes were lost\n", lost);
    printf("%d passed, %d failed\n", b.sum->pairs - findings, findings);
    remove_folder(o.folder);
    return findings > 0;
}
