/* Runs scenes and prints, for each, the work of its solvers and what it computes: tools/constants.sh asks for it with
 * one numeric constant of the sources changed.
 *
 *   work SCENE...
 *   work name=pin steps=13 work=2326 loss=0.315126350 u=0.811 c=0.712
 */
#include "run/scalar_outputs.h"
#include "physics/model.h"
#include "scene/scene.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Iterations and evaluations of all solvers of the model. */
static long work_done(const pd_model *m)
{
    pd_model_statistics effort;
    pd_model_get_statistics(m, &effort);
    int64_t work = effort.flow_evaluations + effort.transport_krylov;
    if (m->implicit.flow) work += m->implicit.evaluations;
    return (long)work;
}

/* What the solvers computed: the loss, and the norms of velocity and concentration over fluid nodes; the latter not
 * with bond-based corrosion, where a node more that has turned fluid is a step of it. */
static void work_result(const pd_model *m)
{
    const double *c = m->setup->has_corrode ? NULL : m->transport.c;
    double flow = 0.0, amount = 0.0;
    for (int64_t i = 0; i < m->grid.total; i++) {
        if (m->grid.kind[i] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM && m->flow.u; d++) {
            double u = m->flow.u[(int64_t)d * m->grid.total + i];
            flow += u * u;
        }
        if (c) amount += c[i] * c[i];
    }
    printf(" loss=%.9g u=%.9g c=%.9g", pd_time_loop_volume_loss(&m->time_loop), sqrt(flow), sqrt(amount));
}

static int work_run(pd_ctx *ctx, const char *path)
{
    pd_setup setup;
    pd_model model;
    memset(&model, 0, sizeof model);
    pd_status status = pd_scene_read(ctx, path, NULL, 0, &setup);
    if (status >= 0) status = pd_model_build(ctx, &setup, &model);
    if (status >= 0) status = pd_time_loop_run(ctx, &model.time_loop, setup.end_time, 0.0, NULL, NULL);
    if (status < 0) {
        fprintf(stderr, "%s: %s\n", path, ctx->message);
    } else {
        printf("work name=%s steps=%ld work=%ld", setup.name, (long)model.time_loop.steps, work_done(&model));
        work_result(&model);
        printf("\n");
    }
    pd_model_free(ctx, &model);
    pd_setup_free(ctx, &setup);
    return status < 0;
}

int main(int argc, char **argv)
{
    pd_ctx ctx;
    int failed = 0;
    pd_ctx_init(&ctx);
    for (int k = 1; k < argc; k++) failed += work_run(&ctx, argv[k]);
    return failed != 0;
}
