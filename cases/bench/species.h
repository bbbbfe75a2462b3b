/* species: the Mg pin with species that react, against one that does not. */
#ifndef BENCH_SPECIES_H
#define BENCH_SPECIES_H
#if PD_DIM == 2

/* mg_pin_2d without what it watches; its law is the mean speed. */
#define SPECIES_PIN \
    "[grid] h = %g um  box = -500 um .. 900 um, -150 um .. 150 um\n" \
    "[shape pin] box = 0 .. 400 um, -40 um .. 40 um  kind = solid  material = mg4ag  grain_size = 40 um\n" \
    "            grain_size_deviation = 5 um  grain_seed = 1  grain_boundary_width = 0.5 um\n" \
    "[side x-] flow = inlet  profile = parabola  mean = 0.236 m/s\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-6\n[transport] D = 1e-9 m2/s\n" \
    "[run] until = %g h  rtol = 4e-3\n[dissolve] rate = 1.21 um/h  grain_boundary_factor = 3"
#define SPECIES_BUFFER \
    "  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)\n[chemistry] activity = ideal\n" \
    "[species H+] D = 9.31e-9 m2/s\n[species OH-] D = 5.27e-9 m2/s\n" \
    "[species HCO3-] D = 1.18e-9 m2/s  initial = 4.2 mM\n[species CO2] D = 1.92e-9 m2/s  initial = 0.4 mM\n" \
    "[species Mg2+] D = 0.705e-9 m2/s  initial = 2.1 mM\n" \
    "[reaction water] H2O = H+ + OH-  log10_K = -14\n[reaction acid] CO2 + H2O = HCO3- + H+  log10_K = -6.352\n"

typedef struct species_found {
    double cpu, nodes, bytes, loss, ledger; /* [s], [1], [byte] at once, [-] */
    double steps;
    int species;
} species_found;

/* On one thread, by the processor's time. */
static pd_status species_once(bench *b, int buffer, species_found *f)
{
    char text[2048];
    pd_ctx ctx;
    pd_setup setup;
    pd_model model;
    memset(&setup, 0, sizeof setup);
    memset(&model, 0, sizeof model);
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    snprintf(text, sizeof text, SPECIES_PIN "%s", b->quick ? 10.0 : 5.0, b->quick ? 0.5 : 9.0,
             buffer ? SPECIES_BUFFER : "\n");
    f->cpu = cpu_seconds();
    pd_status status = pd_scene_parse(&ctx, "pin", text, NULL, 0, &setup);
    if (status >= 0) status = pd_model_build(&ctx, &setup, &model);
    if (status >= 0)
        status = pd_time_loop_run(&ctx, &model.time_loop, setup.end_time, setup.output_interval, NULL, NULL);
    f->cpu = cpu_seconds() - f->cpu;
    f->species = buffer ? model.reactive.components.solutes : 1;
    f->nodes = (double)(model.grid.fluid_count + model.grid.solid_count);
    f->bytes = (double)ctx.peak;
    f->steps = (double)model.time_loop.steps;
    if (status >= 0) f->loss = pd_time_loop_volume_loss(&model.time_loop);
    if (status >= 0) f->ledger = pd_time_loop_imbalance(&model.time_loop);
    runs_close(b, &setup, &model);
    return status < 0 ? pd_fail(b->ctx, status, "species", "%s", ctx.message) : PD_OK;
}

static pd_status species_run(bench *b)
{
    static const char *const words[] = {"species", "nodes", "steps", "volume loss", "cpu [s]", "bytes a node",
                                        "bytes a node and species"};
    species_found f[2];
    table_row *row = bench_row(b);
    for (int k = 0; k < (int)(sizeof words / sizeof words[0]); k++) table_cell(row, "%s", words[k]);
    memset(f, 0, sizeof f);
    for (int k = 0; k < 2; k++) {
        PD_TRY(species_once(b, k, &f[k]));
        double own = k ? (f[1].bytes - f[0].bytes) / f[1].nodes / (f[1].species - 1) : 0.0;
        row = bench_row(b);
        table_cell(row, "%d", f[k].species);
        table_cell(row, "%.0f", f[k].nodes);
        table_cell(row, "%.0f", f[k].steps);
        table_cell(row, "%.5f", f[k].loss);
        table_cell(row, "%.2f", f[k].cpu);
        table_cell(row, "%.0f", f[k].bytes / f[k].nodes);
        table_cell(row, k ? "%.0f" : "-", own);
        bench_result(b,
                     "name=pin species=%d nodes=%.0f steps=%.0f volume_loss=%.6g ledger=%.3g ratio=%.3g "
                     "bytes_per_node=%.0f bytes_per_node_and_species=%.0f cpu_s=%.3f threads=1",
                     f[k].species, f[k].nodes, f[k].steps, f[k].loss, f[k].ledger, f[k].cpu / f[0].cpu,
                     f[k].bytes / f[k].nodes, own, f[k].cpu);
    }
    bench_table(b, "Nine hours of the pin in a stream");
    if (!b->quick) bench_judge(b, "pin: time of five species with a buffer over that of one", 0, 5.0,
                               f[1].cpu / f[0].cpu);
    bench_note(b, "Bytes a node and species: what five species need more than one, for each of the four.");
    return PD_OK;
}

static const bench_case species_case = {
    "species", "Species with a buffer",
    "The Mg pin of `mg_pin_2d` for nine hours with what it dissolves into as one species that does not react, and as "
    "five: Mg2+, H+, OH-, HCO3- and CO2, with water and carbonic acid in equilibrium at every node. Flow, lattice, law "
    "and tolerances are the same. One thread; processor time from the reading of the scene to its end.",
    species_run};
#endif
#endif
