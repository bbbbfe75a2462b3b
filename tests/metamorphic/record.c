/* record: see record.h */
#define _XOPEN_SOURCE 700
#include "setup/fields.h"
#include "record.h"
#include "run/run.h"
#include "scene/scene.h"
#include <dirent.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define ASLEEP 60.0 /* [s] a process that takes no processor time for so long is stuck */

const char *const outcome_names[] = {"done", "failed", "refused", "crashed", "hung"};

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- the process that runs ---- */

typedef struct collector {
    record *r;
    record start; /* fields of the first instant */
    int stop_at;
    int tight;
} collector;

static void *need(size_t bytes)
{
    void *p = calloc(1, bytes ? bytes : 1);
    if (!p) {
        fprintf(stderr, "metamorphic: out of memory\n");
        exit(9);
    }
    return p;
}

static void collect_field(pd_ctx *ctx, const pd_snapshot *at, const char *name, record *r)
{
    pd_field_view v;
    if (pd_snapshot_get_field(ctx, at, name, &v) < 0) return;
    run_field *f = &r->field[r->fields++];
    snprintf(f->name, sizeof f->name, "%s", name);
    snprintf(f->label, sizeof f->label, "%s", v.label);
    f->components = v.components;
    r->cells = 1;
    for (int d = 0; d < 3; d++) {
        r->n[d] = d < PD_DIM ? v.n[d] : 1;
        r->cells *= r->n[d];
    }
    f->data = (double *)need((size_t)(f->components * r->cells) * sizeof(double));
    for (int c = 0; c < f->components; c++)
        for (int64_t k = 0; k < r->cells; k++) {
            int64_t rest = k, from = c * v.component_stride;
            for (int d = 0; d < PD_DIM; d++) {
                from += rest % v.n[d] * v.stride[d];
                rest /= v.n[d];
            }
            f->data[c * r->cells + k] = v.data[from];
        }
}

/* Vectors of which the fields are the lengths. */
static void collect_vector(const pd_snapshot *at, const char *name, const char *label, int of_current, record *r)
{
    const pd_model *m = at->model;
    run_field *f = &r->field[r->fields++];
    int x[PD_DIM];
    double v[PD_DIM];
    memset(x, 0, sizeof x);
    snprintf(f->name, sizeof f->name, "%s", name);
    snprintf(f->label, sizeof f->label, "%s", label);
    f->components = PD_DIM;
    f->data = (double *)need((size_t)(PD_DIM * r->cells) * sizeof(double));
    for (int64_t k = 0; k < r->cells; k++) {
        int32_t i = pd_grid_node(&m->grid, x);
        memset(v, 0, sizeof v);
        if (of_current && m->grid.kind[i] == PD_FLUID) pdi_cell_current(&m->cell, i, v);
        if (!of_current && m->grid.kind[i] == PD_SOLID && m->solid.point[i] >= 0)
            memcpy(v, pd_solid_coupling_displacements(&m->solid) + (int64_t)m->solid.point[i] * PD_DIM, sizeof v);
        for (int d = 0; d < PD_DIM; d++) f->data[d * r->cells + k] = v[d];
        for (int d = 0; d < PD_DIM && ++x[d] == m->grid.n[d]; d++) x[d] = 0;
    }
}

static void collect_fields(pd_ctx *ctx, const pd_snapshot *at, record *r)
{
    r->field = (run_field *)need((PD_FIELD_COUNT + 3) * sizeof(run_field));
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        const pd_setup *u = at->model->setup;
        const char *name = pd_fields_get_name(u, (pd_field)k);
        if (name && name[0] && !pd_fields_lacks(u, (pd_field)k)) collect_field(ctx, at, name, r);
    }
    if (at->model->setup->has_solid) collect_vector(at, "u(vector)", "u [m]", 0, r);
    if (at->model->setup->has_potential && !at->model->setup->has_migration)
        collect_vector(at, "j(vector)", "j [A/m2]", 1, r);
}

static void collect_first(const record *start, record *r)
{
    for (int k = 0; k < start->fields; k++) {
        if (strcmp(start->field[k].name, "kind") != 0) continue;
        run_field *f = &r->field[r->fields++];
        *f = start->field[k];
        snprintf(f->name, sizeof f->name, "%s", FIRST_KIND);
        f->data = (double *)need((size_t)r->cells * sizeof(double));
        memcpy(f->data, start->field[k].data, (size_t)r->cells * sizeof(double));
    }
}

static int differs(const record *a, const record *b)
{
    for (int k = 0; k < a->fields && k < b->fields; k++)
        for (int64_t i = 0; i < a->field[k].components * a->cells; i++) {
            double p = a->field[k].data[i], q = b->field[k].data[i];
            if (fabs(p - q) > 1e-12 * (fabs(p) + fabs(q))) return 1;
        }
    return 0;
}

/* A field that is not the same everywhere. */
static int varies(const record *a)
{
    for (int k = 0; k < a->fields; k++) {
        if (strncmp(a->field[k].name, "kind", 4) == 0 || strcmp(a->field[k].name, "phase") == 0) continue;
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int64_t i = 0; i < a->cells; i++) {
            double p = a->field[k].data[i];
            if (p == 0.0 || !isfinite(p)) continue;
            low = p < low ? p : low;
            high = p > high ? p : high;
        }
        if (high > low + 1e-9 * fabs(low)) return 1;
    }
    return 0;
}

/* Tolerances of the solvers, which no key of a scene sets: what pairs compare is not to be what a solver left undone.
 */
static void tighten(pd_model *model, int first_order)
{
    model->transport.desc.tolerance = 1e-13;
    model->transport.desc.limiter_tolerance = 1e-13;
    model->reactive.desc.tolerance = 1e-13;
    model->implicit.desc.stage_tolerance = 1e-12;
    if (model->surface_states) model->surface_states->state_solver.desc.tolerance = 1e-12;
    /* steps as prescribed: estimates of errors are solved to a tenth of their residual */
    model->transport_integrator.desc.rtol = model->species_integrator.desc.rtol = 1e300;
    if (model->surface_states) model->surface_states->state_solver.desc.rtol = 1e300;
    if (first_order) model->reactive.desc.order = 1;
}

static void forget(record *r)
{
    for (int k = 0; k < r->fields; k++) free(r->field[k].data);
    free(r->field);
    free(r->figure);
    r->field = NULL;
    r->figure = NULL;
    r->fields = r->figures = 0;
}

static int observe(void *user, pd_ctx *ctx, const pd_snapshot *at)
{
    collector *c = (collector *)user;
    if (at->stage == PD_SNAPSHOT_STAGE_START) {
        if (c->tight) tighten(at->writable_model, c->tight > 1);
        if (!c->start.fields) collect_fields(ctx, at, &c->start); /* a run that goes on starts once more */
        return 0;
    }
    if (at->stage == PD_SNAPSHOT_STAGE_STEP) {
        if (c->stop_at && at->steps >= c->stop_at) {
            c->stop_at = 0;
            return 1;
        }
        return 0;
    }
    pd_scalar_outputs figures;
    memset(&figures, 0, sizeof figures);
    c->r->residual = at->writable_model->species_integrator.residual;
    c->r->species_steps = at->writable_model->species_integrator.steps;
    c->r->species_euler = at->writable_model->species_integrator.euler;
    forget(c->r); /* of the run that was stopped */
    collect_fields(ctx, at, c->r);
    collect_first(&c->start, c->r);
    if (pd_snapshot_get_outputs(ctx, at, &figures) >= 0) {
        c->r->figure = (run_figure *)need((size_t)(figures.count + 40) * sizeof(run_figure));
        for (int k = 0; k < figures.count; k++) {
            run_figure *f = &c->r->figure[c->r->figures++];
            snprintf(f->section, sizeof f->section, "%s", figures.list[k].section);
            snprintf(f->name, sizeof f->name, "%s", figures.list[k].name);
            snprintf(f->key, sizeof f->key, "%s", figures.list[k].key);
            snprintf(f->unit, sizeof f->unit, "%s", figures.list[k].unit);
            f->value = figures.list[k].value;
        }
    }
    pd_scalar_outputs_free(ctx, &figures);
    c->r->changes = c->start.fields && at->steps > 0 ? differs(&c->start, c->r) : varies(c->r);
    return 0;
}

static void result_figure(record *r, const char *key, const char *unit, double value)
{
    run_figure *f = &r->figure[r->figures++];
    memset(f, 0, sizeof *f);
    snprintf(f->section, sizeof f->section, "result");
    snprintf(f->key, sizeof f->key, "%s", key);
    snprintf(f->unit, sizeof f->unit, "%s", unit);
    f->value = value;
}

static void collect_result(const pd_run_result *result, int axisymmetric, record *r)
{
    static const char *const currents[] = {"A/m2", "A/m", "A"}, *const amounts[] = {"mol/m2", "mol/m", "mol"};
    int depth = axisymmetric ? 2 : PD_DIM - 1;
    r->steps = result->steps;
    r->time = result->time;
    if (!r->figure) return;
    result_figure(r, "volume_loss", "-", result->volume_loss);
    result_figure(r, "ledger", "-", result->mass_balance_error);
    if (result->has_front) result_figure(r, "front", "m", result->corrosion_depth);
    if (result->has_flux) {
        result_figure(r, "flux", "-", result->flux_error);
        result_figure(r, "flux_max", "-", result->layer_flux_error);
    }
    if (result->evolves_gas) result_figure(r, "gas", amounts[depth], result->gas);
    if (result->has_potential) {
        result_figure(r, "current", currents[depth], result->current);
        result_figure(r, "current_balance", "-", result->current_balance);
    }
    result_figure(r, "steps", "-", (double)result->steps);
}

static void clear_folder(const char *folder)
{
    char path[600];
    struct dirent *e;
    DIR *d = opendir(folder);
    while (d && (e = readdir(d)) != NULL) {
        snprintf(path, sizeof path, "%s/%.250s", folder, e->d_name);
        unlink(path);
    }
    if (d) closedir(d);
    rmdir(folder);
}

enum { FILES = 400 };

static void sum_bytes(run_file *f, const unsigned char *bytes, size_t count)
{
    for (size_t k = 0; k < count; k++) f->sum = (f->sum ^ bytes[k]) * 1099511628211u;
    f->size += (int64_t)count;
}

/* Sums of what a run has written, and its result line, in which no time of the processor stands. */
static void collect_files(const char *folder, const pd_run_result *result, record *r)
{
    static unsigned char bytes[65536];
    char path[600];
    struct dirent *e;
    DIR *d = opendir(folder);
    r->file = (run_file *)need(FILES * sizeof(run_file));
    pd_run_format_result(result, r->line, sizeof r->line);
    char *memory = strstr(r->line, " bytes_per_node="); /* the largest of a process: of two parts it is another one */
    if (memory) *memory = '\0';
    while (d && (e = readdir(d)) != NULL && r->files < FILES) {
        if (e->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%.250s", folder, e->d_name);
        FILE *file = fopen(path, "rb");
        if (!file) continue;
        run_file *f = &r->file[r->files++];
        snprintf(f->name, sizeof f->name, "%.79s", e->d_name);
        for (size_t n; (n = fread(bytes, 1, sizeof bytes, file)) > 0;) sum_bytes(f, bytes, n);
        fclose(file);
    }
    if (d) closedir(d);
}

static void run_here(const char *text, const run_options *o, record *r)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    collector c;
    char folder[320];
    memset(&c, 0, sizeof c);
    memset(&desc, 0, sizeof desc);
    c.r = r;
    c.tight = o->tight;
    pd_ctx_init(&ctx);
    ctx.threads = o->threads;
    pd_status status = pd_scene_parse(&ctx, "scene", text, NULL, 0, &setup);
    if (status < 0) {
        r->outcome = OUTCOME_REFUSED;
        snprintf(r->message, sizeof r->message, "%s", ctx.message);
        return;
    }
    snprintf(folder, sizeof folder, "%s/files", o->folder);
    if (o->files) clear_folder(folder);
    desc.no_files = !o->files;
    desc.folder = o->files ? folder : o->folder;
    desc.observe = observe;
    desc.observe_user = &c;
    desc.checkpoints = o->files;
    desc.checkpoint_every = 1e9;
    c.stop_at = o->resume;
    status = pd_run(&ctx, &setup, &desc, &result);
    if (status >= 0 && result.stopped) {
        desc.resume = 1;
        pd_setup_free(&ctx, &setup);
        status = pd_scene_parse(&ctx, "scene", text, NULL, 0, &setup);
        if (status >= 0) status = pd_run(&ctx, &setup, &desc, &result);
    }
    r->outcome = status >= 0 ? OUTCOME_DONE : result.bad_input ? OUTCOME_REFUSED : OUTCOME_FAILED;
    if (status < 0) snprintf(r->message, sizeof r->message, "%s", ctx.message);
    if (status >= 0) collect_result(&result, setup.axisymmetric != 0, r);
    if (status >= 0 && o->files) collect_files(folder, &result, r);
    if (o->files) clear_folder(folder);
    pd_setup_free(&ctx, &setup);
}

/* ---- from process to process ---- */

static void send(int to, const void *data, size_t bytes)
{
    const char *p = (const char *)data;
    while (bytes) {
        ssize_t n = write(to, p, bytes);
        if (n <= 0) _exit(8);
        p += n;
        bytes -= (size_t)n;
    }
}

static void record_send(int to, const record *r)
{
    send(to, r, sizeof *r);
    if (r->figures) send(to, r->figure, (size_t)r->figures * sizeof *r->figure);
    if (r->files) send(to, r->file, (size_t)r->files * sizeof *r->file);
    for (int k = 0; k < r->fields; k++) {
        send(to, &r->field[k], sizeof r->field[k]);
        send(to, r->field[k].data, (size_t)(r->field[k].components * r->cells) * sizeof(double));
    }
}

/* [s] of the processor that a process has had. */
static double processor_time(pid_t process)
{
    clockid_t clock;
    struct timespec t;
    if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &t) != 0) return 0.0;
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* All that comes until the other side closes; 0: the process is stuck. Its processor time is limited elsewhere, so that
 * a machine with much other work ends none. */
static int receive_all(int from, pid_t process, char **data, size_t *size)
{
    size_t room = 1 << 16;
    double had = 0.0, since = seconds_now();
    *data = (char *)need(room);
    *size = 0;
    for (;;) {
        struct pollfd p = {from, POLLIN, 0};
        if (poll(&p, 1, 1000) <= 0) {
            double has = processor_time(process);
            if (has > had) since = seconds_now();
            had = has;
            if (seconds_now() - since > ASLEEP) return 0;
            continue;
        }
        since = seconds_now();
        if (*size == room) {
            room *= 2;
            *data = (char *)realloc(*data, room);
            if (!*data) exit(9);
        }
        ssize_t n = read(from, *data + *size, room - *size);
        if (n <= 0) return 1;
        *size += (size_t)n;
    }
}

double processor_seconds(void)
{
    struct rusage own, others;
    getrusage(RUSAGE_SELF, &own);
    getrusage(RUSAGE_CHILDREN, &others);
    return (double)(own.ru_utime.tv_sec + own.ru_stime.tv_sec + others.ru_utime.tv_sec + others.ru_stime.tv_sec) +
           1e-6 * (double)(own.ru_utime.tv_usec + own.ru_stime.tv_usec + others.ru_utime.tv_usec +
                           others.ru_stime.tv_usec);
}

static int take(const char **from, const char *end, void *to, size_t bytes)
{
    if ((size_t)(end - *from) < bytes) return 0;
    memcpy(to, *from, bytes);
    *from += bytes;
    return 1;
}

/* 0: what came is not whole. */
static int record_unpack(const char *data, size_t size, record *r)
{
    const char *end = data + size;
    record head;
    if (!take(&data, end, &head, sizeof head)) return 0;
    *r = head;
    r->fields = 0;
    r->figure = (run_figure *)need((size_t)head.figures * sizeof(run_figure));
    r->file = (run_file *)need((size_t)head.files * sizeof(run_file));
    r->field = (run_field *)need((size_t)head.fields * sizeof(run_field));
    if (!take(&data, end, r->figure, (size_t)head.figures * sizeof(run_figure))) return 0;
    if (!take(&data, end, r->file, (size_t)head.files * sizeof(run_file))) return 0;
    for (int k = 0; k < head.fields; k++) {
        run_field *f = &r->field[k];
        if (!take(&data, end, f, sizeof *f)) return 0;
        size_t bytes = (size_t)(f->components * r->cells) * sizeof(double);
        f->data = (double *)need(bytes);
        r->fields = k + 1;
        if (!take(&data, end, f->data, bytes)) return 0;
    }
    return 1;
}

/* The last lines of what a process that died has said. */
static void last_words(const char *path, char *message, size_t size)
{
    char line[512];
    FILE *file = fopen(path, "r");
    size_t used = strlen(message);
    while (file && fgets(line, sizeof line, file)) {
        int says = strstr(line, "rror") || strstr(line, "ssert") || strstr(line, "    #");
        if (says && used + 1 < size) used += (size_t)snprintf(message + used, size - used, "%s", line);
        if (used >= size) used = size - 1;
    }
    if (file) fclose(file);
}

void record_serve(const char *text, const run_options *o, int to)
{
    static record r;
    run_here(text, o, &r);
    record_send(to, &r);
}

/* The program of another dimension takes the place of this process. */
static void run_elsewhere(const char *text, const run_options *o, int to)
{
    char path[600];
    snprintf(path, sizeof path, "%s/scene", o->folder);
    FILE *file = fopen(path, "w");
    if (!file || fputs(text, file) == EOF || fclose(file) != 0 || dup2(to, 1) < 0) _exit(8);
    execl(o->program, o->program, "--record", path, (char *)NULL);
    _exit(8);
}

void record_run(const char *text, const run_options *o, record *r)
{
    int ends[2], status = 0;
    char *data, said[600];
    size_t size;
    memset(r, 0, sizeof *r);
    snprintf(said, sizeof said, "%s/said", o->folder);
    fflush(stdout);
    fflush(stderr);
    if (pipe(ends) != 0) exit(9);
    double begin = processor_seconds();
    pid_t child = fork();
    if (child < 0) exit(9);
    if (child == 0) {
        close(ends[0]);
        if (!freopen(said, "w", stderr)) _exit(8);
        struct rlimit time_limit = {(rlim_t)ceil(o->limit), (rlim_t)ceil(o->limit) + 1};
        setrlimit(RLIMIT_CPU, &time_limit);
        if (o->program) run_elsewhere(text, o, ends[1]);
        run_here(text, o, r);
        record_send(ends[1], r);
        fflush(stderr);
        _exit(0);
    }
    close(ends[1]);
    int came = receive_all(ends[0], child, &data, &size);
    if (!came) kill(child, SIGKILL);
    close(ends[0]);
    waitpid(child, &status, 0);
    int whole = came && record_unpack(data, size, r);
    free(data);
    if (!came || (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
        r->outcome = OUTCOME_HUNG;
    else if (!whole || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        r->outcome = OUTCOME_CRASHED;
        snprintf(r->message, sizeof r->message, "%s %d\n", WIFSIGNALED(status) ? "signal" : "exit",
                 WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
        last_words(said, r->message, sizeof r->message);
    }
    r->seconds = processor_seconds() - begin;
}

void record_free(record *r)
{
    forget(r);
    free(r->file);
    memset(r, 0, sizeof *r);
}

const run_figure *record_figure(const record *r, const char *section, const char *name, const char *key)
{
    for (int k = 0; k < r->figures; k++)
        if (strcmp(r->figure[k].section, section) == 0 && strcmp(r->figure[k].name, name) == 0 &&
            strcmp(r->figure[k].key, key) == 0)
            return &r->figure[k];
    return NULL;
}
