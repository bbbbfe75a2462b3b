/* scale: the same scene in cells of a nanometre and of a kilometre.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "hard.h"

static hard hard_two;

#define CHANNEL \
    "[grid] h = 10 um  m = 3  box = 0 .. 200 um" ACROSS("0 .. 60 um") "\n[shape pin] box = 80 um .. 110 " \
                                                                      "um" ACROSS("20 um .. 40 um") "  kind = solid\n"
#define METAL "rate = 10 um/h * (1 - C/Csat)  Cs = 2 mol/L  Csat = 500 mol/m3\n"

/* Lengths times `length`, times times `time`; amounts per volume and the density stay. */
static void rescale(pd_setup *u, double length, double time)
{
    double speed = length / time, diffusion = length * speed;
    for (int d = 0; d < PD_DIM; d++) {
        u->h[d] *= length;
        u->lo[d] *= length;
        u->hi[d] *= length;
    }
    for (int k = 0; k < u->shapes; k++) {
        u->shape[k].radius *= length;
        for (int d = 0; d < PD_DIM; d++) {
            u->shape[k].a[d] *= length;
            u->shape[k].b[d] *= length;
        }
    }
    for (int s = 0; s < 2 * PD_DIM; s++) u->side[s].mean_speed *= speed;
    u->mu *= diffusion;
    u->diffusivity *= diffusion;
    u->metal[0].rate_scale *= speed;
    u->end_time *= time;
    u->output_interval *= time;
    u->max_step *= time;
}

/* Reads a scene, rescales and runs it. */
static int play_scaled(hard *h, const char *text, double length, double time)
{
    double end;
    memset(h, 0, sizeof *h);
    h->failures = test_now.failures;
    h->most = 20000;
    h->status = load(&h->ctx, text, NULL, 0, &h->setup);
    if (!CHECK_OK(&h->ctx, h->status)) return 0;
    h->open = 1;
    rescale(&h->setup, length, time);
    end = h->setup.end_time;
    h->status = pd_model_build(&h->ctx, &h->setup, &h->model);
    if (!CHECK_OK(&h->ctx, h->status)) return 0;
    h->built = 1;
    hard_bounds(h);
    if (!CHECK(hard_steps(h, end))) NOTE("%s", h->ctx.message);
    return hard_sound(h);
}

/* Cells of 1e-9 m and 1e3 m, times such that speeds go with the lengths: decimal factors round, powers of two do not.
 * An absolute threshold anywhere, or a square that underflows, would show. */
TEST(cells_of_1e_9_and_1e3_m)
{
    NOT_IN_3D();
    static const struct {
        const char *name;
        double length, time;
        int exact;
    } scales[] = {{"1e-9_m", 1e-4, 1e-8, 0},
                  {"1e3_m", 1e8, 1e12, 0},
                  {"2^-30_m", 9.5367431640625e-7, 1.0 / 65536.0, 1},
                  {"2^10_m", 1073741824.0, 65536.0, 1}};
    static const char *const names[] = {"couple", "corrode", "corrode_activation"};
    hard *h = &hard_one, *base = &hard_two;
    char text[1200], part[64];
    for (int bonds = 0; bonds < 3; bonds++) {
        snprintf(
            text, sizeof text, "%s%s%s%s[run] until = 0.5 h\n", CHANNEL,
            bonds ? "[side x-] flow = open\n"
            : PD_DIM == 1
                ? "[side x-] C = 0\n"
                : "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s  C = 0\n[side x+] flow = outlet\n"
                  "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-10\n", /* below what is compared */
            bonds == 2 ? "[corrode] "
            : bonds    ? "[corrode] D = 1e-9 m2/s  "
                       : "[transport] D = 1e-9 m2/s\n[dissolve] ",
            bonds == 2 ? "control = activation  " METAL : METAL);
        if (!play_scaled(base, text, 1.0, 1.0)) return;
        double size = 500.0;
        CHECK(pd_time_loop_volume_loss(&base->model.time_loop) > 0.01);
        for (int k = 0; k < 4; k++) {
            double off = 1.0;
            if (play_scaled(h, text, scales[k].length, scales[k].time)) {
                off = 0.0;
                if (scales[k].exact) CHECK_INT(h->model.time_loop.steps, base->model.time_loop.steps);
                for (int32_t i = 0; i < h->model.grid.total; i++) {
                    CHECK_INT(h->model.grid.kind[i], base->model.grid.kind[i]);
                    if (h->model.grid.kind[i] != PD_FLUID && h->model.grid.kind[i] != PD_SOLID) continue;
                    off = fmax(off, fabs(hard_field(h)[i] - hard_field(base)[i]) / size);
                }
                if (scales[k].exact) CHECK_NEAR(off, 0.0, 0.0);
                else CHECK_LE(off, bonds ? 1e-6 : LIMITED); /* rounding decides on the number of steps, too */
            }
            snprintf(part, sizeof part, "%s_%s", names[bonds], scales[k].name);
            hard_end(h, part, off, "concentrations_against_h_10_um_over_Csat", 0.0, NULL);
        }
        hard_close(base);
    }
}

TEST_MAIN(ENTRY(cells_of_1e_9_and_1e3_m))
