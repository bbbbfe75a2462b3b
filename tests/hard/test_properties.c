/* properties: units of the file, turned and mirrored and shifted scenes, threads, and memory in a step.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "hard.h"

static hard hard_two;

#define METAL "Cs = 2 mol/L  Csat = 500 mol/m3\n"

/* Physics of the scenes: 0 dissolution (with a stream beyond 1D), 1 to 3 bond-based: in fluid at rest, with activation
 * control, in a stream (beyond 1D). */
static const char *const kinds[] = {"couple", "corrode", "corrode_activation", "corrode_in_a_stream"};

enum { KINDS = PD_DIM == 1 ? 3 : 4 };

static const char *physics(int kind)
{
    return kind == 0   ? "[transport] D = 1e-9 m2/s\n[dissolve] rate = 10 um/h * (1 - C/Csat)  " METAL
           : kind == 2 ? "[corrode] control = activation  rate = 10 um/h * (1 - C/Csat)  " METAL
                       : "[corrode] D = 1e-9 m2/s  rate = 10 um/h * (1 - C/Csat)  " METAL;
}
static int streams(int kind) { return PD_DIM > 1 && (kind == 0 || kind == 3); }

#define FLOW "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-9\n"

/* Largest difference of the concentrations over Csat, node a of the one against place(a) of the other. */
static double difference(const hard *a, const hard *b, int32_t (*place)(const pd_grid *, const int *))
{
    double off = 0.0;
    const pd_grid *g = &a->model.grid;
    for (int32_t node = 0; node < g->total; node++) {
        int i[PD_DIM];
        pd_grid_index(g, node, i);
        if (!pd_grid_is_inside(g, i) || g->kind[node] == PD_WALL) continue;
        int32_t other = place ? place(&b->model.grid, i) : node;
        if (g->kind[node] != b->model.grid.kind[other]) return HUGE_VAL;
        off = fmax(off, fabs(hard_field(a)[node] - hard_field(b)[other]) / 500.0);
    }
    return off;
}

/* The same scene in um, h and mL and in m and s: literals of both round by themselves. */
TEST(units_of_the_file)
{
    NOT_IN_3D();
    static const char *const grids[2] = {
        "[grid] h = 10 um  m = 3  box = 0 .. 200 um" ACROSS("0 .. 60 um") "\n[shape pin] box = 80 um .. 110 um" ACROSS(
            "20 um .. 40 um") "  kind = solid\n",
        "[grid] h = 1e-5 m  m = 3  box = 0 m .. 2e-4 m" ACROSS(
            "0 m .. 6e-5 m") "\n[shape pin] box = 8e-5 m .. 1.1e-4 m" ACROSS("2e-5 m .. 4e-5 m") "  kind = solid\n"};
    static const char *const inlets[2] = {
        "[side x-] flow = inlet  profile = uniform  mean = 3.6 m/h\n[side x+] flow = outlet\n"
        "[flow] rho = 1 g/cm3  mu = 1 mPa s  steady_tolerance = 1e-9\n",
        "[side x-] flow = inlet  profile = uniform  mean = 1e-3 m/s\n[side x+] flow = outlet\n" FLOW};
    static const char *const laws[2] = {"D = 3600 um2/s  rate = 10 um/h * (1 - C/Csat)  Cs = 2 mol/L  Csat = 0.5 "
                                        "mol/L\n",
                                        "D = 3.6e-9 m2/s  rate = 2.777777777777778e-9 m/s * (1 - C/Csat)  Cs = 2000 "
                                        "mol/m3  "
                                        "Csat = 500 mol/m3\n"};
    hard *h[2] = {&hard_one, &hard_two};
    char text[1600];
    for (int kind = 0; kind < KINDS; kind++) {
        double off = 1.0;
        int good = 1;
        for (int k = 0; k < 2; k++) {
            const char *law = kind % 2 ? laws[k] : strstr(laws[k], "rate");
            snprintf(text, sizeof text, "%s%s%s%s[run] until = %s\n", grids[k], streams(kind) ? inlets[k] : "",
                     kind == 2 ? "[corrode] control = activation  "
                     : kind    ? "[corrode] "
                     : k  ? "[transport] D = 3.6e-9 m2/s\n[dissolve] "
                          : "[transport] D = 3600 um2/s\n[dissolve] ",
                     law, k ? "1080 s" : "0.3 h");
            good = hard_play(h[k], text) && good;
        }
        if (good) off = difference(h[0], h[1], NULL);
        CHECK_LE(off, 1e-6); /* a last digit of the input, through the tolerances of the solvers */
        hard_close(h[1]);
        hard_end(h[0], kinds[kind], off, "concentrations_of_both_over_Csat", 0.0, NULL);
    }
}

/* The box moved by a number of cells that is exact in binary, and by one that is not. */
TEST(translation)
{
    NOT_IN_3D();
    hard *h = &hard_one, *base = &hard_two;
    char text[1600];
    for (int kind = 0; kind < KINDS; kind++)
        for (int shift = 0; shift < 2; shift++) {
            double at[2] = {0.0, shift ? 123.4567 : 1048576.0}, off = 1.0;
            hard *both[2] = {base, h};
            int good = 1;
            for (int k = 0; k < 2; k++) {
                double x = at[k]; /* h = 1/1024 mm keeps every place exact */
                snprintf(
                    text, sizeof text,
                    "[grid] h = %.17g mm  m = 3  box = %.17g mm .. %.17g mm%s\n"
                    "[shape pin] box = %.17g mm .. %.17g mm%s  kind = solid\n%s%s[run] until = 600 s\n",
                    1.0 / 128, x / 128, (x + 20) / 128, ACROSS("0 mm .. 0.046875 mm"), (x + 8) / 128, (x + 11) / 128,
                    ACROSS("0.015625 mm .. 0.03125 mm"),
                    streams(kind)
                        ? "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[side x+] flow = outlet\n" FLOW
                        : "",
                    physics(kind));
                good = hard_play(both[k], text) && good;
            }
            if (good) off = difference(base, h, NULL);
            CHECK_LE(off, kind == 2 ? 1e-10 : LIMITED);
            char part[64];
            snprintf(part, sizeof part, "%s_by_%s_cells", kinds[kind], shift ? "123.4567" : "2^20");
            hard_close(base);
            hard_end(h, part, off, "concentrations_of_both_over_Csat", 0.0, NULL);
        }
}

static int32_t mirrored(const pd_grid *g, const int *i)
{
    int j[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) j[d] = d ? i[d] : g->n[d] - 1 - i[d];
    return pd_grid_node(g, j);
}

/* A pin off the middle, mirrored about x: streams come from the other side. */
TEST(reflection)
{
    NOT_IN_3D();
    hard *h = &hard_one, *base = &hard_two;
    char text[1600];
    for (int kind = 0; kind < KINDS; kind++) {
        hard *both[2] = {base, h};
        double off = 1.0;
        int good = 1;
        for (int k = 0; k < 2; k++) {
            snprintf(text, sizeof text,
                     "[grid] h = 10 um  m = 3  box = 0 .. 200 um%s\n[shape pin] box = %s%s  kind = "
                     "solid\n"
                     "%s%s[run] until = 600 s\n",
                     ACROSS("0 .. 60 um"), k ? "120 um .. 150 um" : "50 um .. 80 um", ACROSS("20 um .. 40 um"),
                     !streams(kind) ? kind ? (k ? "[side x+] flow = open\n" : "[side x-] flow = open\n")
                                           : (k ? "[side x+] C = 0\n" : "[side x-] C = 0\n")
                     : k ? "[side x+] flow = inlet  profile = uniform  mean = 1 mm/s\n[side x-] flow = outlet\n" FLOW
                         : "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[side x+] flow = outlet\n" FLOW,
                     physics(kind));
            good = hard_play(both[k], text) && good;
        }
        if (good) off = difference(base, h, mirrored);
        CHECK_LE(off, kind == 2 ? 1e-11 : kind ? 1e-6 : LIMITED);
        hard_close(base);
        hard_end(h, kinds[kind], off, "concentrations_of_both_over_Csat", 0.0, NULL);
    }
}

#if PD_DIM > 1
static int32_t turned(const pd_grid *g, const int *i)
{
    int j[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) j[(d + 1) % PD_DIM] = i[d];
    return pd_grid_node(g, j);
}

/* A quarter turn (3D: about the diagonal): x becomes y. */
TEST(rotation)
{
    NOT_IN_3D();
    static const char *const boxes[2] = {"0 .. 160 um, 0 .. 60 um" ALONG_Z("0 .. 80 um"),
                                         PD_DIM == 2 ? "0 .. 60 um, 0 .. 160 um"
                                                     : "0 .. 80 um, 0 .. 160 um, 0 .. 60 um"};
    static const char *const pins[2] = {"50 um .. 80 um, 20 um .. 40 um" ALONG_Z("30 um .. 50 um"),
                                        PD_DIM == 2 ? "20 um .. 40 um, 50 um .. 80 um"
                                                    : "30 um .. 50 um, 50 um .. 80 um, 20 um .. 40 um"};
    hard *h = &hard_one, *base = &hard_two;
    char text[1600];
    for (int kind = 0; kind < KINDS; kind++) {
        hard *both[2] = {base, h};
        double off = 1.0;
        int good = 1;
        for (int k = 0; k < 2; k++) {
            snprintf(text, sizeof text,
                     "[grid] h = 10 um  m = 3  box = %s\n[shape pin] box = %s  kind = solid\n"
                     "[side %c-] flow = %s\n[side %c+] flow = %s\n%s%s[run] until = 600 s\n",
                     boxes[k], pins[k], "xy"[k], streams(kind) ? "inlet  profile = uniform  mean = 1 mm/s" : "open",
                     "xy"[k], streams(kind) ? "outlet" : "noslip", streams(kind) ? FLOW : "", physics(kind));
            good = hard_play(both[k], text) && good;
        }
        if (good) off = difference(base, h, turned);
        CHECK_LE(off, kind == 2 ? 1e-11 : 1e-6);
        hard_close(base);
        hard_end(h, kinds[kind], off, "concentrations_of_both_over_Csat", 0.0, NULL);
    }
}
#endif

/* FNV-1a over the bits of the state. */
static uint64_t hash_of(uint64_t hash, const void *bytes, size_t size)
{
    const uint8_t *b = (const uint8_t *)bytes;
    for (size_t k = 0; k < size; k++) hash = (hash ^ b[k]) * 1099511628211u;
    return hash;
}

/* A run of the scene on a number of threads; its hash. */
static uint64_t run_on(hard *h, const char *text, int threads)
{
    uint64_t hash = 14695981039346656037u;
    if (!CHECK(hard_open(h, text))) return 0;
    h->ctx.threads = threads;
    CHECK(hard_steps(h, h->setup.end_time));
    size_t total = (size_t)h->model.grid.total;
    if (h->setup.has_transport) hash = hash_of(hash, hard_field(h), total * sizeof(double));
    if (h->setup.has_flow) {
        hash = hash_of(hash, h->model.flow.u, PD_DIM * total * sizeof(double));
        hash = hash_of(hash, h->model.flow.p, total * sizeof(double));
    }
    hash = hash_of(hash, &h->model.time_loop.ledger, sizeof h->model.time_loop.ledger);
    hard_close(h);
    return hash;
}

/* Large enough that threads are used. The line of each part has the hash, which a build without OpenMP repeats. */
TEST(threads)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    char text[1600];
    for (int kind = 0; kind < KINDS; kind++) {
        const char *box = PD_DIM == 1   ? "0 .. 40 mm"
                          : PD_DIM == 2 ? "0 .. 600 um, 0 .. 400 um"
                                        : "0 .. 200 um, 0 .. 160 um, 0 .. 160 um";
        int failures = test_now.failures;
        snprintf(text, sizeof text,
                 "[grid] h = 10 um  m = 3  box = %s\n[shape pin] box = 80 um .. 110 um%s  kind = "
                 "solid\n"
                 "%s%s[run] until = %s\n",
                 box, ACROSS("20 um .. 40 um"),
                 streams(kind)
                     ? "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[side x+] flow = outlet\n" FLOW
                     : "",
                 physics(kind), "60 s  max_step = 60 s");
        uint64_t one = run_on(h, text, 1);
        for (int threads = 2; threads <= 8; threads *= 2) CHECK(run_on(h, text, threads) == one);
        hard_line(kinds[kind], test_now.failures > failures, NULL, 0.0, "bits_of_1_2_4_and_8_threads");
        printf(" hash=%016llx", (unsigned long long)one);
        hard_naive(0.0, NULL, NULL);
    }
}

/* ---- memory ---- */

#if PD_DIM == 3
#define REST ", 0 m/s2, 0 m/s2"
#else
#define REST ", 0 m/s2"
#endif

static long calls, denied; /* allocations; those of them that are denied because `full` is set */
static int full;

static void *counting(void *user, void *ptr, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    calls++;
    denied += full && new_size;
    if (new_size) return full ? NULL : realloc(ptr, new_size);
    free(ptr);
    return NULL;
}

/* Steps of every integrator after the first one need no memory, as long as no node turns fluid: where there is none
 * they go on. Only linear solvers of transport ask for some: beside a flow to stall less (below), and at rest where a
 * basis outgrows its room, by one vector at a time, which it keeps. */
TEST(steps_need_no_memory)
{
    NOT_IN_3D();
    static const char *const names[] = {"couple",
                                        "corrode",
                                        "corrode_activation",
                                        "corrode_in_a_stream",
                                        "transport_in_time",
                                        "flow_implicit",
                                        "flow_explicit"};
    hard *h = &hard_one;
    char text[1600];
    for (int kind = 0; kind < (PD_DIM == 1 ? 5 : 7); kind++) {
        if (PD_DIM == 1 && kind == 3) continue; /* the stream */
        const char *stream = kind < 5 ? "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[side x+] flow = "
                                        "outlet\n"
                                      : "[side x-] flow = periodic\n[side x+] flow = periodic\n";
        int streaming = kind >= 5 || streams(kind), rests = kind < 4 && !streams(kind), failures = test_now.failures;
        long spent = 0;
        denied = 0;
        snprintf(text, sizeof text,
                 "[grid] h = 10 um  m = 3  box = 0 .. 200 um%s\n[shape pin] box = 80 um .. 110 "
                 "um%s  kind ="
                 " solid\n%s%s%s%s[run] until = 10 s  %s\n",
                 ACROSS("0 .. 60 um"), ACROSS("20 um .. 40 um"), streaming ? stream : "",
                 streaming ? "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  " : "",
                 !streaming  ? ""
                 : kind < 5  ? "\n"
                 : kind == 5 ? "reference_speed = 1 mm/s  reference_length = 60 um  body_force = 1 m/s2" REST
                               "  time = implicit\n"
                             : "reference_speed = 1 mm/s  reference_length = 60 um  body_force = 1 m/s2" REST
                               "  time = explicit  c0 = 20 mm/s\n",
                 kind == 4  ? "[transport] D = 1e-9 m2/s  initial = 1 mol/m3 * (x > 100 um)\n"
                 : kind < 4 ? physics(kind)
                            : "",
                 kind < 5 ? "max_step = 1 s" : "");
        memset(h, 0, sizeof *h);
        if (!CHECK_OK(&h->ctx, load(&h->ctx, text, NULL, 0, &h->setup))) return;
        pd_ctx made = h->ctx;
        made.alloc.fn = counting;
        made.in_use = made.peak = 0;
        if (!CHECK_OK(&made, pd_model_build(&made, &h->setup, &h->model))) return;
        CHECK_OK(&made, pd_time_loop_start(&made, &h->model.time_loop));
        double dt = kind >= 5 ? 1e-4 : 1.0;
        for (int step = 0; step < 8; step++) {
            size_t had = made.in_use;
            calls = 0;
            full = step > 0 && !rests;
            CHECK_OK(&made, pd_time_loop_step(&made, &h->model.time_loop, h->model.time_loop.time + dt));
            if (step > 0) spent += calls;
            if (step > 0) CHECK(rests ? calls <= 3 : made.in_use == had);
            if (step == 7) CHECK(made.in_use == had);
        }
        CHECK_INT(h->model.grid.solid_count, h->model.time_loop.solid_nodes_start);
        full = 0;
        if (kind > 3) CHECK_INT(spent, 0);
        pd_model_free(&made, &h->model);
        CHECK_INT(made.in_use, 0);
        pd_setup_free(&h->ctx, &h->setup);
        hard_line(names[kind], test_now.failures > failures, NULL, (double)spent,
                  "calls_of_the_allocator_in_seven_steps");
        hard_naive(0.0, NULL, NULL);
    }
}

#if PD_DIM == 2
/* A step from an empty channel to its steady field round a bar, of cells ten times as long as wide: linear systems of
 * hundreds of iterations. Where the basis of the solver may not grow the step goes on, and ends within its bounds. */
TEST(a_basis_that_may_not_grow)
{
    hard *h = &hard_one;
    pd_transport_result result;
    long asked = 0;
    int failures = test_now.failures;
    denied = 0;
    memset(h, 0, sizeof *h);
    if (!CHECK_OK(&h->ctx, load(&h->ctx,
                                "[grid] h = 100 um, 10 um  m = 1  box = 0 .. 3200 um, 0 .. 160 um\n"
                                "[shape bar] box = 700 um .. 1100 um, 60 um .. 110 um  kind = wall\n"
                                "[side x-] flow = inlet  profile = parabola  mean = 1 mm/s  C = 1 mol/m3\n"
                                "[side x+] flow = outlet\n"
                                "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
                                "[transport] D = 1e-11 m2/s\n"
                                "[run] until = 10 s\n",
                                NULL, 0, &h->setup)))
        return;
    pd_ctx made = h->ctx;
    made.alloc.fn = counting;
    made.in_use = made.peak = 0;
    if (!CHECK_OK(&made, pd_model_build(&made, &h->setup, &h->model))) return;
    CHECK_OK(&made, pd_time_loop_start(&made, &h->model.time_loop));
    pd_transport *t = &h->model.transport;
    for (int round = 0; round < 3; round++) { /* the first one takes what all steps need */
        full = round == 2;
        for (int32_t i = 0; i < t->grid->total; i++)
            if (t->grid->kind[i] == PD_FLUID) t->c[i] = t->carry[i] = 0.0;
        size_t had = made.in_use;
        calls = 0;
        CHECK_OK(&made, pd_transport_implicit(&made, t, 100.0, &result));
        if (round > 0) CHECK(made.in_use == had);
        CHECK(calls > 0); /* it does ask */
        if (!full) asked = calls;
        for (int32_t i = 0; i < t->grid->total; i++)
            if (t->grid->kind[i] == PD_FLUID) CHECK(t->c[i] >= -1e-9 && t->c[i] <= 1.0 + 1e-9);
    }
    full = 0;
    CHECK(denied > 0);
    pd_model_free(&made, &h->model);
    CHECK_INT(made.in_use, 0);
    pd_setup_free(&h->ctx, &h->setup);
    hard_line("bar", test_now.failures > failures, NULL, (double)asked, "calls_of_the_allocator_in_a_step");
    hard_naive(0.0, NULL, NULL);
}
#define OF_DIM ENTRY(rotation) ENTRY(a_basis_that_may_not_grow)
#elif PD_DIM == 3
#define OF_DIM ENTRY(rotation)
#else
#define OF_DIM
#endif
TEST_MAIN(ENTRY(units_of_the_file) ENTRY(translation) ENTRY(reflection) OF_DIM ENTRY(threads)
              ENTRY(steps_need_no_memory))
