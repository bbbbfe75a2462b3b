/* random: blobs of metal and wall in boxes of any size, sides, families and laws: every run ends, balances and keeps
 * the maximum principle, or is refused with a reason. PD_HARD=1: 10,000 geometries over the three dimensions.
 * dims: 1 2 3   slow: 2 3 */
#define _XOPEN_SOURCE 700
#include "hard.h"
#include "core/rng.h"

enum { MOST = 16 * 16 * 16 };

typedef struct dice {
    uint64_t seed, at;
} dice;

static double roll(dice *d, double low, double high)
{
    return low + (high - low) * pdi_rng_uniform(7, d->seed, d->at++);
}
static int choose(dice *d, int count) { return (int)roll(d, 0.0, count); }

/* Cells of a smoothed random field above a level: blobs, threads, debris. Two cells at either end of x stay free when
 * `margin` is 2. */
static int blobs(dice *d, const int *n, double share, int margin, const uint8_t *taken, uint8_t *mask)
{
    static double noise[MOST];
    int cells = 1, found = 0;
    for (int a = 0; a < PD_DIM; a++) cells *= n[a];
    for (int i = 0; i < cells; i++) noise[i] = roll(d, 0.0, 1.0);
    for (int i = 0; i < cells; i++) {
        double sum = 2.0 * noise[i], weight = 2.0;
        int stride = 1, rest = i, free_end = 0;
        for (int a = 0; a < PD_DIM; a++) {
            int x = rest % n[a];
            rest /= n[a];
            if (x > 0) sum += noise[i - stride], weight += 1.0;
            if (x < n[a] - 1) sum += noise[i + stride], weight += 1.0;
            if (a == 0) free_end = x < margin || x >= n[a] - margin;
            stride *= n[a];
        }
        mask[i] = !free_end && !(taken && taken[i]) && sum / weight < share;
        found += mask[i];
    }
    return found;
}

static int add(char *text, size_t size, const char *format, ...) TEST_PRINTF_LIKE(3, 4);
static int add(char *text, size_t size, const char *format, ...)
{
    va_list args;
    size_t used = strlen(text);
    va_start(args, format);
    int written = vsnprintf(text + used, size - used, format, args);
    va_end(args);
    return written;
}

static uint8_t solid[MOST]; /* of the last scene */
static int cells;

/* kind 0: dissolution in fluid at rest, 1: in a stream, 2: bond-based, 3: with activation control, 4: in a stream.
 * Returns 0 when there is no metal. */
static int random_scene(dice *d, int kind, char *text, size_t size)
{
    int streams = kind == 1 || kind == 4;
    static uint8_t wall[MOST];
    static const char *const sides[] = {"noslip", "mirror", "periodic", "noslip"};
    int n[3] = {1, 1, 1}, least = streams ? 9 : 1, most = PD_DIM == 3 ? streams ? 9 : 7 : 16, walled;
    int m = 1 + choose(d, PD_DIM == 3 ? 2 : 4);
    cells = 1;
    for (int a = 0; a < PD_DIM; a++) cells *= n[a] = least + choose(d, most - least + 1);
    walled = choose(d, 3) == 0 && (kind < 2 || streams);
    int walls = walled ? blobs(d, n, roll(d, 0.3, 0.45), streams ? 2 : 0, NULL, wall) : 0;
    int metal = blobs(d, n, roll(d, 0.35, streams ? 0.42 : 0.6), streams ? 2 : 0, walls ? wall : NULL, solid);
    if (!metal || metal + walls == cells) return 0;
    text[0] = 0;
    add(text, size, "[grid] h = 10 um  m = %d  box = ", m);
    for (int a = 0; a < PD_DIM; a++) add(text, size, "%s0 .. %d um", a ? ", " : "", 10 * n[a]);
    for (int w = 0; w <= (walls > 0); w++) {
        put(w ? "wall.raw" : "solid.raw", w ? wall : solid, (size_t)cells);
        add(text, size, "\n[shape %s] raw = %s.raw  size = %d", w ? "wall" : "solid", w ? "wall" : "solid", n[0]);
        for (int a = 1; a < PD_DIM; a++) add(text, size, ", %d", n[a]);
        add(text, size, "  corner = 0 um%s  cell = 10 um  kind = %s", ACROSS("0 um"),
            w ? "wall" : "solid  material = mg4ag");
    }
    for (int a = 0; a < PD_DIM; a++) {
        const char *flow = sides[choose(d, 4)];
        int open = (kind == 2 || kind == 3) && n[a] > m && choose(d, 2) && strcmp(flow, "periodic") != 0;
        if (streams && a == 0)
            add(text, size,
                "\n[side x-] flow = inlet  profile = uniform  mean = %.3g m/s  C = %.3g mol/m3\n"
                "[side x+] flow = outlet",
                pow(10.0, roll(d, -6.0, -1.5)), choose(d, 2) ? 0.0 : roll(d, 0.0, 400.0));
        else
            add(text, size, "\n[side %c-] flow = %s\n[side %c+] flow = %s", "xyz"[a], open ? "open" : flow, "xyz"[a],
                flow);
    }
    const char *initial[] = {"0 mol/m3", "0.5*Csat", "1.5*Csat", "Csat"};
    double csat = pow(10.0, roll(d, 1.0, 2.9)), diffusivity = pow(10.0, roll(d, -13.0, -8.0));
    if (streams) add(text, size, "\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8");
    const char *start = initial[choose(d, 4)];
    if (kind == 3) add(text, size, "\n[corrode] control = activation  bulk = %.3g mol/m3", roll(d, 0.0, 0.99) * csat);
    else
        add(text, size, "\n[%s] D = %.3g m2/s  initial = %s", kind < 2 ? "transport" : "corrode", diffusivity, start);
    if (kind < 2)
        add(text, size, "\n[dissolve] threshold = %.3g", choose(d, 3) ? 0.0 : roll(d, 0.0, 0.9) * csat / 1000.0);
    if (kind >= 2) add(text, size, "  driving_force = %s", choose(d, 2) ? "difference" : "constant");
    add(text, size, "\nrate = %.3g um/h * (1 - C/Csat)  Cs = 1 mol/L  Csat = %.3g mol/m3\n[run] until = 1 h%s\n",
        pow(10.0, roll(d, 0.0, 2.0)), csat, kind < 2 ? "" : "  max_step = 30 min");
    return 1;
}

/* A second metal takes some of the nodes of the first one, with a law of its own. The dice stay as they are. */
static void second_metal(dice d, int kind, char *text, size_t size)
{
    static uint8_t second[MOST];
    const char *as = strstr(text, "size = "), *metal = kind < 2 ? "dissolve" : "corrode";
    char box[64] = "";
    int found = 0;
    for (int i = 0; i < cells; i++) found += second[i] = (uint8_t)(solid[i] && choose(&d, 3) == 0);
    if (!found) return;
    put("second.raw", second, (size_t)cells);
    snprintf(box, sizeof box, "%.*s", (int)strcspn(as, "c"), as);
    add(text, size, "[shape second] raw = second.raw  %s  corner = 0 um%s  cell = 10 um  kind = solid  material = "
        "copper\n[%s copper] rate = %.3g um/h * (1 - C/Csat)%s  Cs = %.3g mol/L\n", box, ACROSS("0 um"), metal,
        pow(10.0, roll(&d, 0.0, 2.0)), choose(&d, 2) ? "" : " * (0.2 + 0.8*(C < 0.4*Csat))",
        roll(&d, 1.0, 8.0));
}

static void sweep(int kind, const char *part, int rounds)
{
    hard *h = &hard_one;
    static char text[4096];
    double ledger = 0.0, excess = 0.0, flux = 0.0;
    int refused = 0, done = 0, gone = 0, failures = test_now.failures;
    long steps = 0;
    for (int round = 0; done + refused < rounds; round++) {
        dice d;
        d.seed = (uint64_t)round * 8 + (uint64_t)kind;
        d.at = 0;
        if (!random_scene(&d, kind, text, sizeof text)) continue;
        if (round % 3 == 0) second_metal(d, kind, text, sizeof text);
        int before = test_now.failures;
        if (hard_open(h, text) && hard_steps(h, h->setup.end_time)) {
            hard_sound(h);
            ledger = fmax(ledger, h->ledger);
            excess = fmax(excess, h->excess);
            flux = fmax(flux, h->flux);
            steps += h->model.time_loop.steps;
            gone += h->model.grid.solid_count == 0;
            done++;
        } else {
            /* a channel that is closed, a stream that is too fast for its lattice */
            CHECK(h->status < 0 && strlen(h->ctx.message) > 20 && h->setup.has_flow);
            CHECK_INT(strncmp(h->ctx.message, "steady: ", 8), 0);
            refused++;
        }
        if (test_now.failures > before) NOTE("round %d: %s\n%s", round, h->ctx.message, text);
        hard_close(h);
        if (test_now.failures > failures + 12) break;
    }
    NOTE("%s: %d done, %d refused, %d without metal in the end", part, done, refused, gone);
    hard_line(part, test_now.failures > failures, NULL, excess, "excess_over_the_bounds");
    printf(" ledger=%.1e bounds=%.1e residual=%.1e steps=%ld geometries=%d refused=%d", ledger, excess, flux, steps,
           done, refused);
    hard_naive(0.0, NULL, NULL);
}

TEST(random_geometries)
{
    static const char *const parts[] = {"dissolve_at_rest", "couple_in_a_stream", "corrode", "corrode_activation",
                                        "corrode_in_a_stream"};
    static const int quick[3][5] = {{60, 0, 60, 10, 0}, {80, 8, 80, 10, 8}, {10, 2, 10, 2, 2}};
    static const int whole[3][5] = {{1600, 0, 1000, 100, 0}, {2800, 500, 2300, 100, 200}, {550, 100, 650, 50, 50}};
    for (int kind = 0; kind < 5; kind++) {
        int rounds = hard_long() ? whole[PD_DIM - 1][kind] : quick[PD_DIM - 1][kind];
        if (rounds) sweep(kind, parts[kind], rounds); /* in 1D metal stops the stream */
    }
}

TEST_MAIN(ENTRY(random_geometries))
