/* geometry: solids and fluids that are as thin, as closed or as torn as a lattice allows.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "hard.h"
#include "transport/amount.h"

static hard hard_two;

#define FLUID "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8\n[transport] D = 1e-9 m2/s\n"
#define STREAM "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s  C = 0\n[side x+] flow = outlet\n" FLUID
#define METAL "Cs = 2 mol/L  Csat = 500 mol/m3\n"
#define LAW "[dissolve] rate = 10 um/h * (1 - C/Csat)  " METAL
/* Metal of a bond-based scene; open sides hold 0. */
#define BONDS "[corrode] rate = 10 um/h * (1 - C/Csat)  D = 1e-9 m2/s  " METAL
#define BONDS_IN_FLOW "[corrode] rate = 10 um/h * (1 - C/Csat)  " METAL
/* Diffusion limits. */
#define STILL "[transport] D = 1e-9 m2/s\n[dissolve] rate = 10 mm/h * (1 - C/Csat)  " METAL
#define OPEN "[side x-] flow = open\n[side x+] flow = open\n"
#define CHANNEL "[grid] h = 10 um  m = 3  box = 0 .. 200 um" ACROSS("0 .. 80 um") "\n"

/* All metal is gone, and what left the box and what is in it make up for it. */
static void check_gone(const hard *h)
{
    CHECK_INT(h->model.grid.solid_count, 0);
    CHECK_NEAR(pd_time_loop_volume_loss(&h->model.time_loop), 1.0, 0.0);
}

/* Share of the exchange of a node beside a plate one node thick that a family cut by nothing but the kinds of its far
 * ends would send through the plate. */
static double leak_of_plain_bonds(const pd_stencil *s)
{
    double through = 0.0;
    for (int k = 0; k < s->count; k++)
        if (s->offset[k * PD_DIM] > 1) through += s->laplacian_weight[k];
    return through / s->lap_sum;
}

/* A plate one node thick across a box: bonds are longer than it is thick. Metal that does not dissolve keeps a
 * concentration on one side for good; metal that does goes from both sides, and the sides become one. */
TEST(wall_of_one_node)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    double across = 0.0;
    const char *apart = CHANNEL "[shape plate] box = 100 um .. 110 um" ACROSS(
        "0 .. 80 um") "  kind = solid\n"
                      "[transport] D = 1e-9 m2/s  initial = 100 mol/m3 * (1 + tanh((x - 105 um)/(1 nm)))\n"
                      "[dissolve] rate = 0 um/h  " METAL "[run] until = 10 h\n";
    if (hard_play(h, apart)) {
        const double *c = hard_field(h);
        for (int32_t i = 0; i < h->model.grid.total; i++) {
            double x[PD_DIM];
            if (h->model.grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&h->model.grid, i, x);
            across = fmax(across, fabs(c[i] - (x[0] > 105e-6 ? 200.0 : 0.0)) / 200.0);
        }
        CHECK_LE(across, 1e-14);
    }
    double leak = h->built ? leak_of_plain_bonds(&h->model.stencil) : 0.0;
    hard_end(h, "kept_apart", across, "change_of_either_side", leak, "share_of_exchange_that_bonds_carry_through_it");

    const char *plate = CHANNEL
        "[shape plate] box = 100 um .. 110 um" ACROSS("0 .. 40 um") "  kind = solid\n" STREAM LAW "[run] until = 4 h\n";
    if (hard_play(h, plate)) check_gone(h);
    hard_end(h, "couple", h->ledger, "imbalance", 0.0, NULL);

    /* A node between two fluids loses v sum c(n) h over both of them. */
    const char *both = CHANNEL "[shape plate] box = 100 um .. 110 um" ACROSS(
        "0 .. 80 um") "  kind = solid\n"
                      "[side x-] flow = open\n[side x+] flow = open\n"
                      "[corrode] control = activation  rate = 10 um/h  Cs = 2 mol/L  Csat = 1e-3 mol/m3\n"
                      "[run] until = 10 h  max_step = 0.5 min  max_dissolved_fraction = 0.01\n";
    double error = 1.0;
    if (CHECK(hard_open(h, both))) {
        const pd_stencil *s = &h->model.stencil;
        double sum = 0.0, end = 0.0;
        for (int k = 0; k < s->count; k++)
            if (s->offset[k * PD_DIM] != 0) sum += h->model.dissolve.weight[k];
        double due = 1.0 / (sum * 10e-6 / 3600.0);
        h->status = pd_time_loop_start(&h->ctx, &h->model.time_loop);
        while (h->status >= 0 && h->model.grid.solid_count && end < 2.0 * due) {
            h->status = pd_time_loop_step(&h->ctx, &h->model.time_loop, h->setup.end_time);
            hard_watch(h);
            end = h->model.time_loop.time;
        }
        CHECK_OK(&h->ctx, h->status);
        check_gone(h);
        error = fabs(end - due) / due;
        CHECK_LE(error, 0.02); /* the last step */
        CHECK_LE(h->ledger, LEDGER);
        CHECK_LE(h->excess, BOUNDS);
    }
    hard_end(h, "corrode", error, "time_until_it_is_gone", 0.0, NULL);
}

/* Metal that reaches through a side of the box has no ghost of its own there: on a wall, in an inlet, in an outlet, on
 * a mirror. What stands on a mirror is half of what stands in a box of twice the width. */
TEST(solid_at_sides)
{
    NOT_IN_3D();
    static const char *const names[] = {"couple_wall", "couple_inlet", "couple_outlet"};
    static const char *const bonds[] = {"corrode_wall", "corrode_open_side", "corrode_far_open_side"};
    static const char *const places[] = {"60 um .. 100 um" ACROSS("0 .. 30 um"), "0 .. 40 um" ACROSS("0 .. 30 um"),
                                         "160 um .. 200 um" ACROSS("0 .. 30 um")};
    hard *h = &hard_one;
    char text[1200];
    for (int k = 0; k < 3; k++) {
        snprintf(text, sizeof text, "%s[shape pin] box = %s  kind = solid\n%s", CHANNEL, places[k],
                 STREAM LAW "[run] until = 8 h\n");
        if (hard_play(h, text)) check_gone(h);
        hard_end(h, names[k], h->flux, "flow_far_down_against_far_up", 0.0, NULL);
        snprintf(text, sizeof text, "%s[shape pin] box = %s  kind = solid\n%s", CHANNEL, places[k],
                 OPEN BONDS "[run] until = 8 h\n");
        if (hard_play(h, text)) check_gone(h);
        hard_end(h, bonds[k], h->ledger, "imbalance", 0.0, NULL);
    }
}

TEST(solid_on_a_mirror)
{
    NOT_IN_3D();
    static const char *const scenes[2] = {
        "[grid] h = 10 um  m = 3  box = 0 .. 160 um, 0 .. 60 um" ALONG_Z(
            "0 .. 60 um") "\n[side y-] flow = mirror\n"
                          "[shape pin] box = 60 um .. 100 um, 0 .. 20 um" ALONG_Z("20 um .. 50 um") "  kind = solid\n",
        "[grid] h = 10 um  m = 3  box = 0 .. 160 um, -60 um .. 60 um" ALONG_Z(
            "0 .. 60 um") "\n"
                          "[shape pin] box = 60 um .. 100 um, -20 um .. 20 um" ALONG_Z(
                              "20 um .. 50 um") "  kind = solid\n"};
    hard *h[2] = {&hard_one, &hard_two};
    char text[1200];
    static const char *const worlds[4] = {STREAM LAW "[run] until = 0.5 h\n", OPEN BONDS "[run] until = 0.5 h\n",
                                          STILL "[run] until = 0.02 s\n",
                                          STREAM BONDS_IN_FLOW "[run] until = 0.5 h\n"};
    static const char *const names[4] = {"couple", "corrode", "couple_still", "corrode_in_a_stream"};
    for (int world = 0; world < 4; world++) {
        double loss[2] = {0.0, 1.0};
        for (int k = 0; k < 2; k++) {
            snprintf(text, sizeof text, "%s%s", scenes[k], worlds[world]);
            if (hard_play(h[k], text)) loss[k] = pd_time_loop_volume_loss(&h[k]->model.time_loop);
            CHECK(loss[k] > (world == 2 ? 1e-3 : 0.1) && loss[k] < 0.99);
        }
        double error = fabs(loss[0] - loss[1]) / loss[1];
        /* steps by the same law from the same surface: rounding; where what has dissolved stays, law and transport are
         * solved together to 1e-10 */
        CHECK_LE(error, world == 2 ? 1e-10 : 1e-12);
        hard_close(h[1]);
        hard_end(h[0], names[world], error, "volume_loss_of_half_against_whole", 0.0, NULL);
    }
}

/* Fluid shut in by metal: its pressure has no level, and its mass no way out, until the shell opens. A box without any
 * outlet is the same as a whole. */
TEST(closed_pocket)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    const char *shell = CHANNEL "[shape out] box = 60 um .. 130 um" ACROSS(
        "0 .. 60 um") "\n"
                      "[shape in] box = 80 um .. 110 um" ACROSS(
                          "20 um .. 40 um") "\n"
                                            "[shape shell] difference = out, in  kind = solid\n" STREAM LAW
                                            "[run] until = 10 min\n";
    if (hard_play(h, shell)) {
        double inside = 0.0, fastest = 0.0;
        const pd_grid *g = &h->model.grid;
        for (int32_t i = 0; i < g->total; i++) {
            double x[PD_DIM], speed = 0.0;
            int in = 1;
            if (g->kind[i] != PD_FLUID) continue;
            pd_grid_position(g, i, x);
            in = x[0] > 80e-6 && x[0] < 110e-6;
            for (int d = 1; d < PD_DIM; d++) in = in && x[d] > 20e-6 && x[d] < 40e-6;
            for (int d = 0; d < PD_DIM; d++) speed = fmax(speed, fabs(h->model.flow.u[(int64_t)d * g->total + i]));
            if (in) inside = fmax(inside, speed);
            else fastest = fmax(fastest, speed);
            CHECK(fabs(h->model.flow.p[i]) < 1e3);
        }
        CHECK_LE(inside, 1e-8 * fastest);
        /* through the opening to the end; in 3D the last node has taken over what a dozen others held */
        CHECK(hard_steps(h, (PD_DIM == 3 ? 16.0 : 8.0) * 3600.0));
        hard_sound(h);
        check_gone(h);
    }
    hard_end(h, "couple", h->flux, "flow_far_down_against_far_up", 0.0, NULL);

    const char *lid = "[grid] h = 10 um  m = 3  box = 0 .. 120 um" ACROSS(
        "0 .. 120 um") "\n"
                       "[shape pin] box = 40 um .. 60 um" ACROSS(
                           "40 um .. 60 um") "  kind = solid\n"
                                             "[side y+] flow = noslip  velocity = 1 mm/s, 0 m/s" ALONG_Z(
                                                 "0 m/s") "\n"
                                                          "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = "
                                                          "1e-8  "
                                                          "reference_speed = 1 mm/s  reference_length = 120 um\n"
                                                          "[transport] D = 1e-9 m2/s\n" LAW "[run] until = 6 h\n";
    if (hard_play(h, lid)) check_gone(h);
    hard_end(h, "couple_without_outlet", h->ledger, "imbalance", 0.0, NULL);

    const char *bonds = CHANNEL "[shape out] box = 60 um .. 130 um" ACROSS(
        "0 .. 60 um") "\n"
                      "[shape in] box = 80 um .. 110 um" ACROSS(
                          "20 um .. 40 um") "\n"
                                            "[shape shell] difference = out, in  kind = solid\n" OPEN BONDS
                                            "[run] until = 10 h\n";
    if (hard_play(h, bonds)) check_gone(h);
    hard_end(h, "corrode", h->ledger, "imbalance", 0.0, NULL);
}

/* A scheme that subtracts rate times step and sets what has become negative to zero has given the fluid more than there
 * was: with steps of a share of a node each, this much. */
static double made_by_a_clamp(double share)
{
    double content = 1.0, given = 0.0;
    while (content > 0.0) {
        given += share;
        content = fmax(content - share, 0.0);
    }
    return given - 1.0;
}

/* A plate from wall to wall: what enters cannot leave. Behind mirrors it is as closed. */
TEST(closed_channel)
{
    NOT_IN_3D();
    static const char *const names[] = {"couple_between_walls", "couple_between_mirrors"};
    static const char *const sides[] = {"", "[side y-] flow = mirror\n[side y+] flow = mirror\n"};
    char text[1200];
    for (int k = 0; k < 2; k++) {
        snprintf(text, sizeof text, "%s[shape plate] box = 100 um .. 110 um%s  kind = solid\n%s%s", CHANNEL,
                 ACROSS("0 .. 80 um"), sides[k], STREAM LAW "[run] until = 1 h\n");
        hard_refused(&hard_one, text, names[k], "the flow at t = 0 s has no way from the inlet beside (5e-06, ",
                     PD_ERR_GEOMETRY);
    }
}

/* A head on a neck one node wide: when the neck is gone the head is debris, with nothing solid behind it to take up
 * what its nodes are off by. */
TEST(debris)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    const char *shapes = "[shape foot] box = 40 um .. 120 um" ACROSS(
        "0 .. 20 um") "\n"
                      "[shape neck] box = 70 um .. 80 um, 0 .. 40 um" ALONG_Z(
                          "10 um .. 20 um") "\n"
                                            "[shape head] box = 50 um .. 100 um, 40 um .. 70 um" ALONG_Z(
                                                "0 .. 40 um") "\n"
                                                              "[shape pin] union = foot, neck, head  kind = solid\n";
    char text[1600];
    static const char *const names[] = {"couple", "corrode", "corrode_in_a_stream"};
    static const char *const worlds[] = {STREAM LAW, OPEN BONDS, STREAM BONDS_IN_FLOW};
    for (int bonds = 0; bonds < 3; bonds++) {
        snprintf(text, sizeof text, "%s%s%s[run] until = 10 h\n", CHANNEL, shapes, worlds[bonds]);
        if (hard_play(h, text)) check_gone(h);
        double worst = h->ledger;
        hard_end(h, names[bonds], worst, "imbalance", made_by_a_clamp(bonds ? 0.2 : 0.1 / 0.35),
                 "metal_that_a_clamp_at_zero_makes");
    }
}

/* After the last node there is nothing to choose a step by, and the flow has no body left: it is that of the empty
 * channel, and the fluid that of the inlet. */
TEST(everything_dissolved)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    const char *pin = "[grid] h = 10 um  m = 3  box = 0 .. 200 um, 0 .. 80 um" ALONG_Z(
        "0 .. 20 um") "\n"
#if PD_DIM == 3
                      "[side z-] flow = mirror\n[side z+] flow = mirror\n"
#endif
                      "[shape pin] box = 80 um .. 110 um, 30 um .. 50 um" ALONG_Z(
                          "0 .. 20 um") "  kind = solid\n"
                                        "[side x-] flow = inlet  profile = expression  vx = 6 mm/s * y/(80 um) * (1 - "
                                        "y/(80 um))\n"
                                        "[side x+] flow = outlet\n" FLUID LAW "[run] until = 30 h\n";
    double off = 1.0;
    if (hard_play(h, pin)) {
        const pd_grid *g = &h->model.grid;
        off = 0.0;
        check_gone(h);
        for (int32_t i = 0; i < g->total; i++) {
            double x[PD_DIM];
            if (g->kind[i] != PD_FLUID) continue;
            pd_grid_position(g, i, x);
            double s = x[1] / 80e-6;
            off = fmax(off, fabs(h->model.flow.u[i] - 6e-3 * s * (1.0 - s)) / 1.5e-3);
            CHECK_LE(hard_field(h)[i], 1e-6);
        }
        CHECK_LE(off, 1e-6);
    }
    hard_end(h, "couple", off, "flow_against_the_parabola", 0.0, NULL);
    if (hard_play(h, CHANNEL "[shape pin] box = 80 um .. 110 um" ACROSS("30 um .. 50 um") "  kind = solid\n" OPEN BONDS
                                                                                          "[run] until = 30 h\n"))
        check_gone(h);
    double low = 0.0, high = 1e3;
    if (h->built) hard_extremes(h, &low, &high);
    CHECK_LE(high, 1e-6 * 500.0);
    hard_end(h, "corrode", high / 500.0, "concentration_left_over_Csat", 0.0, NULL);
}

TEST(nothing_to_dissolve)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    const char *pin = "[shape pin] box = 80 um .. 110 um" ACROSS("30 um .. 50 um") "  kind = solid\n";
    char text[1200];
    for (int bonds = 0; bonds < 2; bonds++) {
        snprintf(text, sizeof text, "%s%s%s%s[run] until = 1 h\n", CHANNEL, pin,
                 bonds ? OPEN "[corrode] D = 1e-9 m2/s  " METAL : STREAM "[dissolve] " METAL, "rate = 0 um/h\n");
        if (hard_play(h, text)) {
            CHECK_INT(h->model.grid.solid_count, h->model.time_loop.solid_nodes_start);
            CHECK_NEAR(pd_time_loop_volume_loss(&h->model.time_loop), 0.0, 0.0);
        }
        hard_end(h, bonds ? "corrode_rate_0" : "couple_rate_0", h->ledger, "imbalance", 0.0, NULL);
    }
    hard_refused(h, CHANNEL STREAM LAW "[run] until = 1 h\n", "couple_no_solid",
                 "a.scene:6: dissolve: found no solid, expected a [shape ...] with kind = solid", PD_ERR_ARGUMENT);
    hard_refused(h, CHANNEL OPEN BONDS "[run] until = 1 h\n", "corrode_no_solid",
                 "a.scene:4: corrode: found no solid, expected a [shape ...] with kind = solid", PD_ERR_ARGUMENT);
}

/* A slit one node wide, as a grain boundary leaves it: its nodes have neighbours along one axis only. Between values
 * held at its ends diffusion through it is that of a rod; with longer bonds the ends, where held and closed walls meet
 * within one horizon, shift it by a fraction of a node, however long it is. */
TEST(channel_of_one_node)
{
    NOT_IN_3D();
    static const struct {
        const char *name, *m;
        int cells;
    } rods[] = {{"transport_m_1", "1", 20}, {"transport_m_3", "3", 20}, {"transport_m_3_long", "3", 40}};
    hard *h = &hard_one;
    char text[1600];
    double shift[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        double length = 1e-5 * rods[k].cells, across = 1e-5 * (PD_DIM == 3 ? 1e-5 : 1.0), off = 1.0;
        snprintf(text, sizeof text,
                 "[grid] h = 10 um  m = %s  box = 0 .. %d um%s\n[side x-] C = 0\n"
                 "[side x+] C = 100 mol/m3\n[transport] D = 1e-9 m2/s  time = steady\n",
                 rods[k].m, 10 * rods[k].cells, ACROSS("0 .. 10 um"));
        if (hard_play(h, text)) {
            double flux = pdi_amount_section(&h->ctx, &h->model.transport, 0, 10);
            off = fabs(flux / (-1e-9 * 100.0 / length * across) - 1.0);
            shift[k] = 0.5 * (1e-9 * 100.0 * across / fabs(flux) - length) / 1e-5;
        }
        if (k == 0) CHECK_LE(off, 1e-6);
        hard_end(h, rods[k].name, off, "flux_against_that_of_a_rod", 0.0, NULL);
    }
    NOTE("m = 3: each end shifted by %.4f cells, in a rod twice as long by %.4f", shift[1], shift[2]);
    CHECK_LE(fabs(shift[1]), 1.0);
    CHECK_NEAR(shift[2], shift[1], 1e-4);

    const char *blocks = "[shape one] box = 60 um .. 140 um, 0 .. 30 um" ALONG_Z(
        "0 .. 80 um") "\n"
                      "[shape two] box = 60 um .. 140 um, 40 um .. 80 um" ALONG_Z(
                          "0 .. 80 um") "\n"
                                        "[shape grains] union = one, two  kind = solid\n";
    for (int bonds = 0; bonds < 2; bonds++) {
        snprintf(text, sizeof text, "%s%s%s[run] until = 20 h\n", CHANNEL, blocks, bonds ? OPEN BONDS : STREAM LAW);
        if (hard_play(h, text)) check_gone(h);
        hard_end(h, bonds ? "corrode" : "couple", bonds ? h->ledger : h->flux,
                 bonds ? "imbalance" : "flow_far_down_against_far_up", 0.0, NULL);
    }

    /* boundaries that dissolve a thousand times faster leave such slits behind, and debris in the end */
    const char *metal = "[shape pin] box = 50 um .. 150 um" ACROSS(
        "0 .. 50 um") "  kind = solid  grain_size = 40 um  grain_boundary_width = 2 um\n";
    for (int bonds = 0; bonds < 2; bonds++) {
        const char *law = bonds ? OPEN "[corrode] D = 1e-9 m2/s  " : STREAM "[dissolve] ";
        snprintf(text, sizeof text,
                 "%s%s%srate = 0.2 um/h * (1 - C/Csat)  grain_boundary_factor = 1000\n%s[run] until = %s\n", CHANNEL,
                 metal, law, METAL, PD_DIM == 3 ? "0.5 h" : "1 h");
        if (hard_play(h, text)) CHECK(pd_time_loop_volume_loss(&h->model.time_loop) > 0.05);
        double loss = h->built ? pd_time_loop_volume_loss(&h->model.time_loop) : 0.0;
        CHECK(loss < 0.999);
        hard_end(h, bonds ? "corrode_grains" : "couple_grains", h->ledger, "imbalance", 0.0, NULL);
    }
}

#if PD_DIM == 2
#define AROUND "[grid] geometry = axisymmetric  h = 10 um  m = 3  box = 0 .. 200 um, 0 .. 300 um\n"
#define TUBE AROUND "[side y+] flow = noslip\n"

/* A wire of 160 um that should lose half of its radius, of `cells` cells: how far it is ahead of that, in cells, and
 * how far nodes lead metal that is flat. */
static double wire_ahead(hard *h, int cells, double *lead)
{
    double size = 160.0 / cells;
    char text[1200];
    snprintf(text, sizeof text,
             "[grid] geometry = axisymmetric  h = %.17g um  m = 3  box = 0 .. %.17g um, 0 .. 320 um\n"
             "[shape wire] box = 0 .. %.17g um, 0 .. 160 um  kind = solid\n"
             "[corrode] control = activation  rate = 10 um/h  Cs = 2 mol/L  Csat = 1 mol/m3\n[run] until = 8 h\n",
             size, 10.0 * size, 10.0 * size);
    if (!hard_play(h, text)) return HUGE_VAL;
    const pd_stencil *s = &h->model.stencil;
    *lead = 0.0;
    for (int k = 0; k < s->count; k++) {
        double n = s->offset[k * PD_DIM + 1];
        *lead += 0.5 * s->area_weight[k] * s->h[1] * (n > 0.0 ? n * n : 0.0);
    }
    return (0.5 - sqrt(1.0 - pd_time_loop_volume_loss(&h->model.time_loop))) * cells;
}

/* Bond-based metal of rings: a wire on the axis that recedes at a given speed, and a pin that dissolves to the last
 * node in fluid at rest and in the stream of a tube. The nodes on the axis have no neighbours across it. */
TEST(around_an_axis)
{
    hard *h = &hard_one;
    const char *pin = "[shape pin] box = 60 um .. 120 um, 0 .. 60 um  kind = solid\n";
    char text[1600];
    double lead = 0.0, coarse = wire_ahead(h, 16, &lead);
    hard_close(h);
    double fine = wire_ahead(h, 32, &lead);
    /* the nodes lead the metal by a distance in cells; a front that halves its radius gains ln 2 of it */
    CHECK_REL(coarse, log(2.0) * lead, 0.05);
    CHECK_REL(fine, log(2.0) * lead, 0.05);
    hard_end(h, "corrode_wire", fine / 16.0, "depth_of_a_shrinking_wire", 0.0, NULL);
    snprintf(text, sizeof text, "%s%s%s[run] until = 60 h\n", AROUND, pin, OPEN BONDS);
    if (hard_play(h, text)) check_gone(h);
    hard_end(h, "corrode_around_an_axis", h->ledger, "imbalance", 0.0, NULL);
    snprintf(text, sizeof text, "%s%s%s[run] until = 60 h\n", TUBE, pin, STREAM BONDS_IN_FLOW);
    if (hard_play(h, text)) check_gone(h);
    hard_end(h, "corrode_in_a_tube", h->flux, "flow_far_down_against_far_up", 0.0, NULL);
}
#define OF_AXIS ENTRY(around_an_axis)
#else
#define OF_AXIS
#endif

TEST_MAIN(ENTRY(wall_of_one_node) ENTRY(solid_at_sides) ENTRY(solid_on_a_mirror) ENTRY(closed_pocket)
              ENTRY(closed_channel) ENTRY(debris) ENTRY(everything_dissolved) ENTRY(nothing_to_dissolve)
              ENTRY(channel_of_one_node) OF_AXIS)
