/* depletion: which metal a run has used up, and which electrodes carry no current any more, in a word when it happens.
 */
#ifndef PD_DEPLETION_H
#define PD_DEPLETION_H
#include "run/summary.h"

typedef struct pd_depletion {
    pd_model *model;                /* borrowed; NULL: nothing dissolves */
    uint8_t *piece;                 /* [total] piece of the setup that a solid node is of; those beyond them: none */
    int32_t left[PD_SETUP_SHAPES];  /* nodes of each piece */
    int idle[PD_SETUP_ELECTRODES];  /* 1: no current passes at all of the electrode */
    double time;                    /* [s] when it last looked */
    int64_t solid;                  /* nodes of metal when it last looked */
} pd_depletion;

#ifdef PDI_INTERNAL
/* Of the metal as it is. */
PDI_FN pd_status pdi_depletion_build(pd_ctx *ctx, pd_model *model, pd_depletion *depletion);
/* After a step: a note for each piece of metal that has gone since, and each electrode at which no current passes any
 * more. print: NULL where none is to be said. */
PDI_FN void pdi_depletion_look(pd_depletion *depletion, pd_print_fn print, void *user);
PDI_FN void pdi_depletion_free(pd_ctx *ctx, pd_depletion *depletion);
#endif

#endif
