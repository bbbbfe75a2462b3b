/* web: scenes in a browser. worker.js calls the functions of WEB_EXPORT and gives those of WEB_IMPORT.
 *
 * A run goes in slices: each ends with a checkpoint, so that the worker can hear what the page says, and the next one
 * goes on with the same bits. Texts are UTF-8 and end with 0. One scene at a time.
 */
#define PDCORR_IMPLEMENTATION
#define PDI_NO_MEANINGS /* of keys: the page has no list of them */
#include "pdcorr_app.h"

#include <stdio.h>
#include <stdlib.h>

#define WEB_EXPORT(name) __attribute__((export_name(#name)))
#define WEB_IMPORT(name) __attribute__((import_module("page"), import_name(#name)))

#define WEB_FIELDS 1 /* answers of page_instant: it wants the fields, the slice ends here */
#define WEB_ENDS 2
#define WEB_NEVER 1e300 /* [s] between checkpoints: at the ends of slices alone */

/* A line of the run; kind: pd_print_kind. */
WEB_IMPORT(print) void page_print(int kind, const char *text);
/* The lattice: cells[dim], then low and high ends [m] of its box. slice: 3D, the axis across the drawn plane and the
 * index of its cells. */
WEB_IMPORT(box) void page_box(int dim, const int *cells, const double *low, const double *high, int around_axis,
                              int slice_axis, int slice);
/* An instant, in SI; when: pd_snapshot_stage. */
WEB_IMPORT(instant) int page_instant(int when, double time, double dt, double until, double steps, double volume_loss,
                                     double v_max, double c_max, double imbalance);
/* A field [components][cells] of the instant before; map: pd_colour_map; place: pd_field_place. Data stay until the
 * call returns. */
WEB_IMPORT(field) void page_field(const char *name, const char *label, const double *data, int components, int map,
                                  int place);

/* Those were all fields of the instant. */
WEB_IMPORT(shown) void page_shown(void);

static pd_ctx web_ctx;
static uint32_t web_table[PDI_COLOUR_TABLE_SIZE];

/* Room for a text of the page. */
WEB_EXPORT(web_room) char *web_room(int bytes);
char *web_room(int bytes) { return (char *)malloc((size_t)bytes); }

WEB_EXPORT(web_drop) void web_drop(char *text);
void web_drop(char *text) { free(text); }

WEB_EXPORT(web_version) const char *web_version(void);
const char *web_version(void) { return PD_VERSION; }

/* What the last call that failed has to say. */
WEB_EXPORT(web_message) const char *web_message(void);
const char *web_message(void) { return web_ctx.message; }

/* 0xRRGGBB [256] of the pictures of the programs, for the first two maps of pd_colour_map. */
WEB_EXPORT(web_colours) const uint32_t *web_colours(int map);
const uint32_t *web_colours(int map)
{
    pdi_colour_fill_table(map == PD_COLOUR_MAP_DIVERGING ? PD_COLOUR_MAP_DIVERGING : PD_COLOUR_MAP_SEQUENTIAL,
                          web_table);
    return web_table;
}

/* 0xRRGGBB of the numbers 0 to 255, for the third one. */
WEB_EXPORT(web_labels) const uint32_t *web_labels(void);
const uint32_t *web_labels(void)
{
    for (int k = 0; k < PDI_COLOUR_TABLE_SIZE; k++) web_table[k] = pdi_colour_get_label_colour(k);
    return web_table;
}

/* Read a scene, and build nothing. 0: it can be read. */
WEB_EXPORT(web_check) int web_check(const char *name, const char *text);
int web_check(const char *name, const char *text)
{
    pd_setup setup;
    pd_ctx_init(&web_ctx);
    pd_status status = pd_scene_parse(&web_ctx, name, text, NULL, 0, &setup);
    pd_setup_free(&web_ctx, &setup);
    return status < 0 ? status : 0;
}

/* Hands over all fields that the scene has. */
static void web_fields(pd_ctx *ctx, const pd_snapshot *at)
{
    pd_field_info info;
    for (int k = 0; pd_field_info_get(at->model->setup, k, &info); k++) {
        pd_field_view view;
        if (pd_snapshot_get_field(ctx, at, info.name, &view) < 0) continue;
        page_field(info.name, info.label, view.data, info.components,
                   pdi_pictures_get_scale_map(info.scale), info.place);
    }
    page_shown();
}

static void web_box(const pd_model *model)
{
    const pd_grid *g = &model->grid;
    int slice = 0, axis = PD_DIM - 1;
#if PD_DIM == 3
    axis = model->setup->slice_axis;
    slice = (int)((model->setup->slice_at - g->lo[axis]) / g->h[axis]);
    slice = slice < 0 ? 0 : slice < g->n[axis] ? slice : g->n[axis] - 1;
#endif
    page_box(PD_DIM, g->n, g->lo, g->hi, model->setup->axisymmetric, axis, slice);
}

static int web_observe(void *user, pd_ctx *ctx, const pd_snapshot *at)
{
    const pd_step_diagnostics *o = at->diagnostics;
    (void)user;
    if (at->stage == PD_SNAPSHOT_STAGE_START) web_box(at->model);
    int wish = page_instant((int)at->stage, at->time, at->dt, at->end_time, (double)at->steps, o->volume_loss, o->v_max,
                            o->c_max, pd_time_loop_imbalance(&at->model->time_loop));
    if (wish & WEB_FIELDS) web_fields(ctx, at);
    return (wish & WEB_ENDS) != 0;
}

static void web_print(void *user, pd_print_kind kind, const char *text)
{
    (void)user;
    if (kind != PD_PRINT_PROGRESS) page_print((int)kind, text);
}

/* A slice of a run into the folder. goes_on: from the checkpoint of the slice before. keeps: it ends with a checkpoint;
 * else with the files of its last instant. 0: the run is complete, 1: it was ended by page_instant, negative: it has
 * failed. */
WEB_EXPORT(web_run) int web_run(const char *name, const char *text, const char *folder, int goes_on, int keeps);
int web_run(const char *name, const char *text, const char *folder, int goes_on, int keeps)
{
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    char line[1024];
    pd_ctx_init(&web_ctx);
    pd_status status = pd_scene_parse(&web_ctx, name, text, NULL, 0, &setup);
    if (status < 0) return status;
    memset(&desc, 0, sizeof desc);
    desc.folder = folder;
    desc.print = web_print;
    desc.observe = web_observe;
    desc.checkpoints = keeps;
    desc.checkpoint_every = WEB_NEVER;
    desc.resume = goes_on;
    status = pd_run(&web_ctx, &setup, &desc, &result);
    pd_setup_free(&web_ctx, &setup);
    if (status < 0) return status;
    if (result.stopped && keeps) return 1;
    pd_run_format_result(&result, line, sizeof line);
    page_print(PD_PRINT_RESULT, line);
    return result.stopped ? 1 : 0;
}
