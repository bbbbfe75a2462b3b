/* run: runs a setup from its first flow solve to its end: output files, diagnostics, pictures, summary, result.
 *
 *   pd_setup setup; pd_run_result result;
 *   pd_scene_read(&ctx, "pin.scene", NULL, 0, &setup);
 *   pd_run(&ctx, &setup, &desc, &result);
 *   pd_setup_free(&ctx, &setup);
 *
 * Nothing is printed: all text goes to the caller's print function.
 */
#ifndef PD_RUN_H
#define PD_RUN_H
#include "scene/scene.h"
#include "physics/summary.h"
#include "run/snapshot.h"

/* Zero-initialise. */
typedef struct pd_run_desc {
    const char *folder;      /* of the output; NULL: that of the setup */
    int check_only;          /* 1: build and summarise, run nothing, write nothing; what the run would be refused for is
                              * refused, with `resume` also for its checkpoint */
    int no_files;            /* 1: run, write nothing */
    pd_scalar_outputs *figures; /* zeroed; gets the last figures of the run (check_only: those before it), for
                                 * pd_scalar_outputs_free. NULL: not wanted */
    double *computed_at_points; /* [points] [unit of the columns in SI] of all measured sections: gets what the run
                                 * computes there, NaN where it does not come. NULL: not wanted */
    /* [-] of each monitor in the figures of its section, see coarsen_setup.h; NULL: 1 */
    const double *monitor_weight;
    pd_print_fn print;       /* NULL: silent */
    void *print_user;
    int (*stop)(void *user); /* asked after every step before the end; not 0: the run ends there. NULL: never. The poll
                              * function of the context is asked within steps, a few times a second: then the run ends
                              * with a checkpoint of the last step that is done. PD_CANCELLED: before the first began */
    void *stop_user;
    pd_snapshot_fn observe; /* called at the start, after every step and at the end, see snapshot.h; may stop the run.
                             * NULL: none */
    void *observe_user;
    int updates_latest;      /* 1: the last picture of each field is also there as latest_C.png and so on, and the curve
                              * of the volume loss goes as far; both whole at any moment */
    int checkpoints;         /* 1: keep the state in the folder, in PD_RUN_CHECKPOINT, now and then and when stopped */
    double checkpoint_every; /* [s] of wall time, 0: after every step */
    double stall_note_after; /* [s] of wall time without a step after which a note says what is being computed, and
                              * again whenever that has doubled; 0: 10 */
    int resume;              /* 1: go on from the checkpoint in the folder; the files become, byte for byte, those of a
                              * run that was never stopped */
} pd_run_desc;

#define PD_RUN_CHECKPOINT "checkpoint.bin"

/* How a run ended, and its scalar results. */
typedef struct pd_run_result {
    char name[PD_SETUP_NAME];
    int bad_input;        /* the failure lies in the setup or checkpoint, nothing was computed */
    int stopped;          /* by desc.stop, desc.observe or the poll function of the context */
    double time;          /* [s] reached */
    double h;             /* [m] along x */
    double m;             /* [-] */
    double volume_loss;   /* [-] */
    double mass_balance_error; /* [-] relative error of the mass balance */
    int has_front;        /* 1: bond-based corrosion, with: */
    double corrosion_depth; /* [m] corrosion depth, see pd_step_diagnostics */
    int has_flux;
    int evolves_gas;      /* 1: dissolution evolves a gas: */
    double gas;           /* [mol] per m in planar 2D, per m2 in 1D */
    double gas_volume;    /* [m3] the same as a volume at the temperature of the electrolyte and 1 atm */
    double flux_error, layer_flux_error; /* [-] see pd_step_diagnostics */
    double peclet;        /* [-] largest cell Peclet number v h/D of species in a flow; 0: none are in one */
    double residual;      /* [-] larger one of the last flow solve */
    int is_steady;        /* the transport was solved for its steady field */
    double steady_change; /* [-] of that field in the last step of its solver, over the largest value */
    double steady_imbalance; /* [-] largest imbalance of that field, over the fluxes */
    int has_potential;
    double current_balance; /* [-] sum of all currents, over the sum of their sizes and of what 0.1 mV drives */
    double current;       /* [A] per m in planar 2D, per m2 in 1D: what leaves metal, and enters it elsewhere */
    int64_t evaluations, steps, unknowns;
    int64_t unconverged_steps; /* steps, and the start, in which a process missed its tolerance */
    int threads;          /* at most in use */
    double bytes_per_node; /* [byte] peak memory over fluid and solid nodes */
} pd_run_result;

#define pd_run PD_NAME(pd_run)
#define pd_run_format_result PD_NAME(pd_run_format_result)

/* Build the model, print the summary, run, write the files; *result is zeroed first. PD_OK also for a run that is
 * stopped. result->bad_input: 1: setup, folder or checkpoint is refused before the first step. On failure the files
 * hold all steps before it. The checkpoint goes when the run is complete, and when another run begins in its folder.
 * With checkpoints a stopped run writes no fields of that instant. Where ctx->threads is 0 the run has those of the
 * setup. */
PD_API pd_status pd_run(pd_ctx *ctx, const pd_setup *setup, const pd_run_desc *desc, pd_run_result *result);
/* Write "result case=... dim=2 h=5e-06 m=3 volume_loss=..." into text[size], cut off there; the caller appends its
 * times. Results that the run does not have, and those that are NaN or infinite, are left out. Bond-based corrosion has
 * front= in place of residual= and evals=. */
PD_API void pd_run_format_result(const pd_run_result *result, char *text, size_t size);

#ifdef PDI_APP_INTERNAL
/* Put file and line (0 or less: the file alone) of the scene before the message in ctx, whose status stays; nothing
 * where the setup has no file. */
PDI_FN void pdi_run_prefix_message(pd_ctx *ctx, const pd_setup *setup, int line);
#endif

#endif
