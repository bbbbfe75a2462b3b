/* depletion_notes: notes during a run when the metal of a shape has dissolved, or an electrode carries no current any
 * more.
 */
#ifndef PD_DEPLETION_NOTES_H
#define PD_DEPLETION_NOTES_H
#include "physics/summary.h"

typedef struct pd_depletion_notes {
    pd_model *model;                /* borrowed; NULL: nothing dissolves */
    /* [total] metal shape of the setup that a solid node belongs to; 255: none */
    uint8_t *shape_of_node;
    int32_t nodes_left[PD_SETUP_SHAPES]; /* solid nodes left of each shape */
    int idle[PD_SETUP_ELECTRODES];  /* 1: the electrode carries no current */
    double time;                    /* [s] of the last update */
    int64_t solid_nodes;            /* solid nodes at the last update */
} pd_depletion_notes;

#define pd_depletion_notes_build PD_NAME(pd_depletion_notes_build)
#define pd_depletion_notes_free PD_NAME(pd_depletion_notes_free)
#define pd_depletion_notes_update PD_NAME(pd_depletion_notes_update)

/* Record to which shape each solid node of the box belongs (the last that holds it; 255: none), and count them; resets
 * the object. Where no metal dissolves, model stays NULL and nothing is allocated. */
PD_API pd_status pd_depletion_notes_build(pd_ctx *ctx, pd_model *model, pd_depletion_notes *depletion);
/* Update after a step: print a note for each shape that has dissolved since the last update, and each electrode that
 * has stopped carrying current. print: NULL: update silently. Does nothing where no metal dissolves. */
PD_API void pd_depletion_notes_update(pd_depletion_notes *depletion, pd_print_fn print, void *user);
PD_API void pd_depletion_notes_free(pd_ctx *ctx, pd_depletion_notes *depletion);

#endif
