/* physics_row: one physics as a row of callbacks. Models, estimates of memory, summaries and samples go through the
 * rows of a list and know no physics by name.
 */
#ifndef PD_PHYSICS_ROW_H
#define PD_PHYSICS_ROW_H
#include "physics/memory_plan.h"
#include "physics/summary_text.h"

#ifdef PDI_INTERNAL
#define PDI_PHYSICS_MAX 16         /* rows of a list */
#define PDI_PHYSICS_ROW_SAMPLERS 4 /* groups of fields of a row */

/* Order of the processes in a step of the run; within a stage, that of the list. */
typedef enum pdi_physics_stage {
    PDI_PHYSICS_STAGE_MOTION = 0, /* flow, gas, mechanics */
    PDI_PHYSICS_STAGE_SURFACE,    /* species that the laws of the metal read */
    PDI_PHYSICS_STAGE_METAL,      /* dissolution, with what transport carries */
    PDI_PHYSICS_STAGE_SPECIES,    /* species that read what dissolution released */
    PDI_PHYSICS_STAGE_CURRENTS,
    PDI_PHYSICS_STAGE_COUNT
} pdi_physics_stage;

/* Fields first .. last of a physics, in the order of pd_field. */
typedef struct pdi_physics_sampler {
    pd_field first, last;
    int (*has)(const pd_setup *setup, pd_field field); /* 1: it has this one of them; NULL: all */
    /* value at a node as of pd_sample_get_node */
    double (*sample)(const pd_model *m, pd_field field, int32_t node);
    /* array [total] of a component, which values at points are interpolated from; NULL: from `sample` */
    const double *(*get_values)(const pd_model *m, pd_field field, int component);
} pdi_physics_sampler;

/* Callbacks of one physics. Each may be NULL unless noted. */
typedef struct pdi_physics_row {
    const char *name; /* as summaries list what is not modelled; NULL: its absence is not told */
    pd_part part;                                 /* whose line, memory and unknowns it counts */
    int (*is_present)(const pd_setup *setup);     /* never NULL */
    const char *(*absent)(const pd_setup *setup); /* what is not modelled, NULL: nothing; default: the name */
    pdi_physics_stage stage;                      /* of its processes, unless get_stage gives it */
    pdi_physics_stage (*get_stage)(const pd_model *m);
    pd_status (*build)(pd_ctx *ctx, pd_model *m);   /* its solvers; the rows before it are built */
    pd_status (*connect)(pd_ctx *ctx, pd_model *m); /* what needs all rows to be built */
    pd_status (*add_processes)(pd_ctx *ctx, pd_model *m);
    void (*free)(pd_ctx *ctx, pd_model *m);       /* also after a build that failed, or none */
    int (*reads_bonds)(const pd_setup *setup);    /* 1: it reads the bonds after metal has dissolved */
    const double *(*velocity)(const pd_model *m); /* [PD_DIM][total] [m/s] what moves */
    void (*add_statistics)(const pd_model *m, pd_model_statistics *effort);
    void (*prepare_samples)(pd_ctx *ctx, pd_model *m, pd_fields fields); /* as of pd_sample_prepare */
    pdi_physics_sampler sampler[PDI_PHYSICS_ROW_SAMPLERS];
    int samplers;
    void (*estimate)(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b); /* add its memory */
    void (*print_summary)(const pdi_summary_text *s);
    void (*print_notes)(const pdi_summary_text *s);
} pdi_physics_row;

typedef struct pdi_physics_list {
    pdi_physics_row row[PDI_PHYSICS_MAX];
    int count;
} pdi_physics_list;

/* Append a row with what every physics has; the caller fills in the rest of the returned row, which is 0. The list has
 * room for it. */
PDI_FN pdi_physics_row *pdi_physics_row_add(pdi_physics_list *list, const char *name, pd_part part,
                                            int (*is_present)(const pd_setup *setup));
/* Append a sampler of the fields first .. last, which has all of them; get_values may be NULL. */
PDI_FN void pdi_physics_row_add_fields(pdi_physics_row *row, pd_field first, pd_field last,
                                       double (*sample)(const pd_model *m, pd_field field, int32_t node),
                                       const double *(*get_values)(const pd_model *m, pd_field field, int component));
/* A `reads_bonds` callback: 1. */
PDI_FN int pdi_physics_row_always(const pd_setup *setup);
#endif

#endif
