/* run: see run.h */
#include "run/result_line.h"
#include "run/run.h"
#include "core/par.h"
#include "core/vec.h"
#include "io/archive_file.h"
#include "io/output_folder.h"
#include "io/progress.h"
#include "physics/memory_estimate.h"
#include "run/checkpoint.h"
#include "run/output.h"
#include "physics/lattice_notes.h"
#include "run/monitor_report.h"
#include "run/stall_note.h"
#include "physics/depletion_notes.h"
#include "run/compare_measured.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_RUN_MAX_FLUX_ERROR 0.5    /* flux_max above which velocities are not those of the flow */
#define PDI_RUN_PROGRESS_INTERVAL 0.2 /* [s] between progress lines */
#define PDI_RUN_STALL_TIME 10.0       /* [s] without a step before a note says what is computed */

/* A run at work. */
typedef struct pdi_run {
    pd_ctx *ctx;
    const pd_run_desc *desc;
    const pd_setup *setup;
    pd_model model;
    pd_output output;
    pd_step_diagnostics observables;
    pd_depletion_notes depletion;
    pd_monitors monitors;
    pd_measured_comparison compare;
    pd_field_views views; /* of the observer */
    pd_status status;     /* of the step that was observed last */
    int stopped;
    double start_clock, progress_clock; /* [s] clock */
    double checkpoint_clock;            /* [s] clock of the last checkpoint */
    const char *folder_path;            /* of the folder */
    pd_output_folder folder;
    /* checkpoint of the last step in memory, for a run that is stopped within a step */
    pd_archive_file kept_checkpoint;
    double kept_clock;        /* [s] clock of it */
    int kept_is_complete;     /* 1: it is complete */
    double poll_clock;        /* [s] clock of the last poll */
    double step_clock;        /* [s] clock of the last step */
    double stall_time;        /* [s] wall time without a step before the next note */
    int writing;          /* 1: stopped, but the files of this step are still written */
    pd_cancel_fn poll;    /* of the caller */
    void *poll_user;
    char checkpoint_path[PD_PATH_SIZE];
} pdi_run;

/* Print the progress line now and set progress_clock; doing, count: what is being computed, or NULL. Nothing without a
 * print function or with an end time of 0. */
static void pdi_run_print_progress_line(pdi_run *r, const char *doing, int64_t count)
{
    char line[360], time[PD_UNITS_TEXT], dt[PD_UNITS_TEXT];
    double now = pd_par_clock(), until = r->setup->end_time;
    const pd_time_loop *c = &r->model.time_loop;
    if (!r->desc->print || !(until > 0.0)) return;
    r->progress_clock = now;
    pdi_progress_format_line(c->time / until, now - r->start_clock, r->setup->name, line, sizeof line);
    pd_setup_format_value(c->time, "s", time);
    pd_setup_format_value(c->dt, "s", dt);
    size_t used = strlen(line);
    snprintf(line + used, sizeof line - used, "  step %.0f, t = %s", (double)c->steps, time);
    used = strlen(line);
    if (c->dt > 0.0) snprintf(line + used, sizeof line - used, ", dt = %s", dt);
    used = strlen(line);
    if (r->setup->has_dissolve)
        snprintf(line + used, sizeof line - used, ", %.3g %% lost", 100.0 * r->observables.volume_loss);
    used = strlen(line);
    if (doing) snprintf(line + used, sizeof line - used, "  (%.40s %.0f)", doing, (double)count);
    r->desc->print(r->desc->print_user, PD_PRINT_PROGRESS, line);
}

/* Print the progress line if 0.2 s have passed since the last one, or at the end time. */
static void pdi_run_print_progress(pdi_run *r)
{
    if (pd_par_clock() - r->progress_clock >= PDI_RUN_PROGRESS_INTERVAL ||
        !(r->model.time_loop.time < r->setup->end_time))
        pdi_run_print_progress_line(r, NULL, 0);
}

/* Print a note on a run without a step for `waited` [s] of wall time, and set stall_time to twice the larger of it and
 * `waited`. The print function must be set. */
static void pdi_run_print_stall(pdi_run *r, const char *doing, int64_t count, double waited)
{
    char line[480];
    r->stall_time = 2.0 * pd_max(waited, r->stall_time);
    pdi_stall_note_format(&r->model.time_loop, waited, doing, count, line, sizeof line);
    r->desc->print(r->desc->print_user, PD_PRINT_NOTE, line);
}

/* Poll function of the context within steps. Returns 1 to stop: once r->stopped is set, always 1, but 0 while the files
 * of the last step are written. Prints a note after stall_time without a step. At most every 0.2 s asks the poll
 * function of the caller, whose non-zero answer sets r->stopped; prints progress at most every 0.4 s. */
static int pdi_run_poll(void *user, const char *doing, int64_t count)
{
    pdi_run *r = (pdi_run *)user;
    double now = pd_par_clock();
    if (r->stopped) return !r->writing;
    if (r->desc->print && now - r->step_clock > r->stall_time)
        pdi_run_print_stall(r, doing, count, now - r->step_clock);
    if (now - r->poll_clock < PDI_RUN_PROGRESS_INTERVAL) return 0;
    r->poll_clock = now;
    if (now - r->progress_clock >= 2.0 * PDI_RUN_PROGRESS_INTERVAL) pdi_run_print_progress_line(r, doing, count);
    if (r->poll && r->poll(r->poll_user, doing, count)) r->stopped = 1;
    return r->stopped;
}

/* 1: fields are written now: if none are yet, at the end time, if a run without checkpoints is stopped, and at a
 * multiple of the output interval (within 1e-9 of the interval) that lies at least half of it behind the last
 * fields. */
static int pdi_run_is_frame_due(const pdi_run *r)
{
    double time = r->model.time_loop.time, every = r->setup->output_interval,
           next = r->output.last_frame_time + 0.5 * every;
    int over = (r->stopped && !r->desc->checkpoints) || !(time < r->setup->end_time);
    if (r->output.last_frame_time < 0.0 || over) return 1;
    double multiple = floor(time / every + 0.5) * every;
    return time >= next && fabs(time - multiple) <= 1e-9 * every;
}

/* Write fields, pictures and profiles of this time and count the frame; nothing if those of this time, or of a later
 * one, are written. */
static pd_status pdi_run_write_frame(pdi_run *r)
{
    int frame = r->output.frame;
    PD_TRY(pdi_output_write_frame(r->ctx, &r->output));
    return r->output.frame > frame ? pdi_monitors_write_frame(r->ctx, &r->monitors, frame) : PD_OK;
}

/* Write the rows of this step. With no_files the monitors are computed only for an observer or where the comparison
 * needs outputs; else they keep those of an earlier step. The comparison is stepped only where it needs outputs. */
static pd_status pdi_run_write_rows(pdi_run *r)
{
    int asked = r->desc->observe || pdi_compare_measured_needs_output(&r->compare, r->model.time_loop.time);
    if (!r->desc->no_files) PD_TRY(pdi_output_write_rows(r->ctx, &r->output, &r->observables));
    if (!r->desc->no_files || asked) PD_TRY(pdi_monitors_step(r->ctx, &r->monitors));
    return pdi_compare_measured_needs_output(&r->compare, r->model.time_loop.time)
               ? pdi_compare_measured_step(r->ctx, &r->compare)
               : PD_OK;
}

/* Call the observer of the caller with the present state; nothing without one. Its non-zero answer sets r->stopped, but
 * not at the stage END, nor when the end time is reached. */
static void pdi_run_call_observer(pdi_run *r, pd_snapshot_stage when)
{
    pd_snapshot at;
    int before_end = r->model.time_loop.time < r->setup->end_time;
    if (!r->desc->observe) return;
    memset(&at, 0, sizeof at);
    at.stage = when;
    at.name = r->setup->name;
    at.folder = r->desc->no_files ? NULL : r->folder_path;
    at.time = r->model.time_loop.time;
    at.steps = r->model.time_loop.steps;
    at.dt = r->model.time_loop.dt;
    at.end_time = r->setup->end_time;
    at.diagnostics = &r->observables;
    at.model = at.writable_model = &r->model;
    at.monitors = &r->monitors;
    at.views = &r->views;
    int ends = r->desc->observe(r->desc->observe_user, r->ctx, &at);
    if (ends && before_end && when != PD_SNAPSHOT_STAGE_END) r->stopped = 1;
}

/* ---- checkpoints ---- */

/* Store or load model, diagnostics, computed points and wall time. On loading, start_clock moves so that wall time goes
 * on. PD_ERR_ARGUMENT: the checkpoint is of another scene; after a failure the model may only be freed. */
static pd_status pdi_run_store_state(pdi_run *r, pd_archive *archive)
{
    double now = pd_par_clock(), spent = now - r->start_clock;
    PD_TRY(pdi_checkpoint_store_model(r->ctx, &r->model, archive));
    PD_TRY(pd_step_diagnostics_store(r->ctx, &r->observables, archive));
    PD_TRY(pdi_compare_measured_store(r->ctx, &r->compare, archive));
    PD_TRY(PD_ARCHIVE_ARRAY(r->ctx, archive, "wall time [s]", &spent, 1));
    r->start_clock = now - spent;
    return PD_OK;
}

/* Store all that a run continues from, lengths of files included. */
static pd_status pdi_run_store_all(pdi_run *r, pd_archive *archive)
{
    PD_TRY(pdi_run_store_state(r, archive));
    PD_TRY(pdi_output_save(r->ctx, &r->output, archive));
    PD_TRY(pdi_monitors_save(r->ctx, &r->monitors, archive));
    return pdi_output_folder_store(r->ctx, &r->folder, archive);
}

/* Write the checkpoint file under a temporary name and rename it. On failure the former file stays. PD_ERR_FILE. */
static pd_status pdi_run_write_checkpoint(pdi_run *r)
{
    pd_archive_file store;
    PD_TRY(pd_archive_file_create(r->ctx, r->checkpoint_path, &store));
    pd_status status = pdi_run_store_all(r, &store.archive);
    if (status == PD_OK) return pd_archive_file_close(r->ctx, &store);
    pdi_archive_file_abandon(&store);
    return status;
}

/* Store a checkpoint in memory, at most every 0.2 s; nothing with no_files or without checkpoints. A failure is no
 * error but clears kept_is_complete: a run stopped within a step then continues from the file. */
static void pdi_run_keep_checkpoint(pdi_run *r)
{
    double now = pd_par_clock();
    if (r->desc->no_files || !r->desc->checkpoints ||
        (r->kept_is_complete && now - r->kept_clock < PDI_RUN_PROGRESS_INTERVAL))
        return;
    r->kept_clock = now;
    pd_status status = pdi_archive_file_begin_in_memory(r->ctx, &r->kept_checkpoint);
    if (status == PD_OK) status = pdi_run_store_all(r, &r->kept_checkpoint.archive);
    if (status == PD_OK) status = pd_archive_file_close(r->ctx, &r->kept_checkpoint);
    r->kept_is_complete = status == PD_OK;
}

/* Write the checkpoint file if the run is stopped, or checkpoint_every [s] of wall time have passed since the last;
 * nothing without checkpoints. A failure is returned only if the run is stopped; else it is printed as a note, the
 * former file stays, and the status is PD_OK. */
static pd_status pdi_run_write_due_checkpoint(pdi_run *r)
{
    char line[PD_MESSAGE_SIZE + 80];
    double now = pd_par_clock();
    if (!r->desc->checkpoints || (!r->stopped && now - r->checkpoint_clock < r->desc->checkpoint_every)) return PD_OK;
    r->checkpoint_clock = now;
    pd_status status = pdi_run_write_checkpoint(r);
    if (status == PD_OK || r->stopped) return status;
    snprintf(line, sizeof line, "no checkpoint at t = %g s, the one before stays: %s", r->model.time_loop.time,
             r->ctx->message);
    if (r->desc->print) r->desc->print(r->desc->print_user, PD_PRINT_NOTE, line);
    return PD_OK;
}

/* Compute diagnostics and outputs of the time that a run continues from; their rows are in the tables already. */
static pd_status pdi_run_update_outputs(pdi_run *r)
{
    pd_step_diagnostics_update(r->ctx, &r->model, &r->observables);
    return pdi_monitors_step(r->ctx, &r->monitors);
}

/* Load the checkpoint and open all files to append at the lengths it holds; files listed later are deleted. With an
 * observer the outputs are computed, too. Notes on what was depleted before are not repeated. On failure the archive is
 * closed, and the state may only be freed. */
static pd_status pdi_run_read_checkpoint(pdi_run *r)
{
    pd_archive_file store;
    PD_TRY(pd_archive_file_open(r->ctx, r->checkpoint_path, &store));
    pd_status status = pdi_run_store_state(r, &store.archive);
    if (status == PD_OK) pd_depletion_notes_update(&r->depletion, NULL, NULL); /* what has gone before has been said */
    if (status == PD_OK && r->desc->observe) status = pdi_run_update_outputs(r);
    if (status == PD_OK) status = pdi_output_resume(r->ctx, &r->model, &r->folder, &store.archive, &r->output);
    if (status == PD_OK) status = pdi_monitors_resume(r->ctx, &r->monitors, &r->folder, &store.archive);
    if (status == PD_OK) status = pdi_output_folder_store(r->ctx, &r->folder, &store.archive);
    if (status == PD_OK) {
        PD_TRY(pd_archive_file_close(r->ctx, &store));
        return pdi_output_folder_resume_list(r->ctx, &r->folder);
    }
    pdi_archive_file_abandon(&store);
    return status;
}

/* Lock the folder, continue its run from the checkpoint and say so. result->bad_input: 1: a failure that is not fatal
 * (memory, limit, cancelled). */
static pd_status pdi_run_resume(pdi_run *r, pd_run_result *result)
{
    char line[80];
    pd_status status = pdi_output_folder_lock_existing(r->ctx, r->folder_path, r->setup->name, &r->folder);
    if (status == PD_OK) status = pdi_run_read_checkpoint(r);
    result->bad_input = status < 0 && !pd_is_fatal(status);
    if (status < 0) return status;
    r->output.images.updates_latest = r->desc->updates_latest;
    snprintf(line, sizeof line, "goes on from t = %g s", r->model.time_loop.time);
    if (r->desc->print) r->desc->print(r->desc->print_user, PD_PRINT_SUMMARY, line);
    return PD_OK;
}

/* Open the output folder, delete the files of the former run, with a note if there were any, and its checkpoint. Enter
 * the checkpoint in the new list of files. result->bad_input: 1: the folder is in use (PD_ERR_STATE) or of another run
 * (PD_ERR_ARGUMENT). */
static pd_status pdi_run_clear_folder(pdi_run *r, pd_run_result *result)
{
    char line[PD_PATH_SIZE + 80];
    pd_status status = pdi_output_folder_open(r->ctx, r->folder_path, r->setup->name, &r->folder);
    result->bad_input = status == PD_ERR_STATE || status == PD_ERR_ARGUMENT;
    PD_TRY(status);
    snprintf(line, sizeof line, "removed %d files of the former run from '%s'", r->folder.removed_count,
             r->folder_path);
    if (r->folder.removed_count && r->desc->print) r->desc->print(r->desc->print_user, PD_PRINT_NOTE, line);
    pdi_file_remove(r->checkpoint_path);
    return pdi_output_folder_add_file(r->ctx, &r->folder, PD_RUN_CHECKPOINT, r->checkpoint_path);
}

/* Open the files of a run: those of a checkpoint with desc->resume, else new ones. Nothing with no_files. */
static pd_status pdi_run_open_files(pdi_run *r, pd_run_result *result)
{
    if (r->desc->no_files) return PD_OK;
    PD_TRY(pd_file_join(r->ctx, r->folder_path, PD_RUN_CHECKPOINT, r->checkpoint_path));
    if (r->desc->resume) return pdi_run_resume(r, result);
    PD_TRY(pdi_run_clear_folder(r, result));
    PD_TRY(pdi_output_open(r->ctx, &r->model, &r->folder, &r->output));
    r->output.images.updates_latest = r->desc->updates_latest;
    return pdi_monitors_open(r->ctx, &r->monitors, &r->folder);
}

/* ---- steps ---- */

/* Callback of the time loop after the start and each step: diagnostics, tables, observer, fields when due, checkpoints,
 * progress. desc->stop is asked only before the end time. Returns 1 to end the run: it is stopped, or r->status, the
 * first failure, is negative; what follows a failure is skipped. */
static int pdi_run_observe_step(void *user, const pd_time_loop *couple)
{
    pdi_run *r = (pdi_run *)user;
    (void)couple;
    pd_step_diagnostics_update(r->ctx, &r->model, &r->observables);
    pd_depletion_notes_update(&r->depletion, r->desc->print, r->desc->print_user);
    int before_end = r->model.time_loop.time < r->setup->end_time;
    if (before_end && r->desc->stop && r->desc->stop(r->desc->stop_user)) r->stopped = 1;
    r->writing = r->stopped; /* what a step that is done has to show */
    r->status = pdi_run_write_rows(r);
    if (r->status >= 0)
        pdi_run_call_observer(r, r->model.time_loop.steps ? PD_SNAPSHOT_STAGE_STEP : PD_SNAPSHOT_STAGE_START);
    r->writing = r->stopped;
    if (!r->desc->no_files && r->status >= 0 && pdi_run_is_frame_due(r)) r->status = pdi_run_write_frame(r);
    if (!r->desc->no_files && before_end && r->status >= 0) r->status = pdi_run_write_due_checkpoint(r);
    if (before_end && !r->stopped && r->status >= 0) pdi_run_keep_checkpoint(r);
    pdi_run_print_progress(r);
    r->poll_clock = r->step_clock = pd_par_clock();
    return r->stopped || r->status < 0;
}

/* Step to the end time, or until r->stopped; steps also end on the times of measured points. Returns the failure of the
 * time loop or of what follows a step. */
static pd_status pdi_run_step_to_end(pdi_run *r)
{
    double until = r->setup->end_time, reached;
    do {
        reached = pdi_compare_measured_find_next_time(&r->compare, r->model.time_loop.time, until);
        PD_TRY(
            pd_time_loop_run(r->ctx, &r->model.time_loop, reached, r->setup->output_interval, pdi_run_observe_step, r));
        PD_TRY(r->status);
    } while (!r->stopped && reached < until);
    return PD_OK;
}

/* Print a note if layer_flux_error is above 0.5: node velocities and conserved fluxes disagree, as the lattice is too
 * coarse for the flow. */
static void pdi_run_print_flux_error(const pdi_run *r)
{
    char text[256];
    if (!(r->observables.layer_flux_error > PDI_RUN_MAX_FLUX_ERROR) || !r->desc->print) return;
    snprintf(text, sizeof text,
             "flow: velocities of a layer of nodes carry %.3g times the flow more or less than its "
             "fluxes (flux_max): they are not those of the flow; expected a smaller m or h",
             r->observables.layer_flux_error);
    r->desc->print(r->desc->print_user, PD_PRINT_NOTE, text);
}

/* Print a note if crack faces overlapped at any time of the run: there is no contact model, so stresses are wrong
 * there. */
static void pdi_run_print_overlap(const pdi_run *r)
{
    char line[320];
    double depth = r->model.solid.overlap.max_crack_overlap;
    if (!r->desc->print || !(depth > 0.0)) return;
    snprintf(line, sizeof line, "solid: faces of a crack or of a gap overlapped by up to %.3g m, as if they were not "
             "there: no contact is computed, so displacements, stresses and J are not those of faces that touch",
             depth);
    r->desc->print(r->desc->print_user, PD_PRINT_NOTE, line);
}

/* Copy the values computed at measured points [SI], set behind set, to the array of the caller, if there is one. */
static void pdi_run_copy_measured(const pdi_run *r)
{
    double *to = r->desc->computed_at_points;
    for (int k = 0; to && k < r->setup->measured_count; k++) {
        int points = r->setup->measured[k].points;
        memcpy(to, r->compare.list[k].computed, (size_t)points * sizeof *to);
        to += points;
    }
}

/* Write the checkpoint of the last complete step, kept in memory, to its file, for a run stopped within a step; nothing
 * where none is kept. */
static pd_status pdi_run_write_kept_checkpoint(pdi_run *r)
{
    if (r->desc->no_files || !r->desc->checkpoints || !r->kept_is_complete) return PD_OK;
    return pdi_archive_file_write_memory(r->ctx, &r->kept_checkpoint, r->checkpoint_path);
}

/* Make all steps and write the final files and result lines. With no_files only outputs, computed points and the
 * observer get the end. A cancelled run ends with PD_OK and writes the checkpoint of its last complete step. A stopped
 * run keeps checkpoint and file of frames and redraws no picture; a complete one removes both. After a failed step
 * nothing final is written. */
static pd_status pdi_run_run_steps(pdi_run *r)
{
    pdi_run_keep_checkpoint(r);
    if (r->desc->resume && !r->desc->no_files) pdi_run_call_observer(r, PD_SNAPSHOT_STAGE_START);
    pd_status status = r->stopped ? PD_OK : pdi_run_step_to_end(r);
    if (status == PD_CANCELLED || r->status == PD_CANCELLED) {
        status = r->status = PD_OK;
        PD_TRY(pdi_run_write_kept_checkpoint(r));
    }
    if (status < 0) return status;
    pdi_run_copy_measured(r);
    if (r->desc->no_files) PD_TRY(pdi_monitors_step(r->ctx, &r->monitors));
    if (r->desc->figures) PD_TRY(pdi_scalar_outputs_collect(r->ctx, &r->model, &r->monitors, 0, r->desc->figures));
    if (r->desc->no_files) {
        pdi_run_call_observer(r, PD_SNAPSHOT_STAGE_END);
        return PD_OK;
    }
    PD_TRY(pdi_monitors_close(r->ctx, &r->monitors));
    pdi_monitor_report_print(&r->monitors, r->desc->print, r->desc->print_user);
    pdi_run_print_overlap(r);
    pdi_run_print_flux_error(r);
    pdi_compare_measured_print(&r->compare, r->desc->print, r->desc->print_user);
    PD_TRY(pdi_compare_measured_write(r->ctx, &r->compare, &r->folder));
    status = pdi_output_close(r->ctx, &r->output, !r->stopped);
    if (status == PD_CANCELLED) return pdi_run_write_kept_checkpoint(r);
    if (status < 0) return status;
    if (!r->stopped) {
        pdi_file_remove(r->checkpoint_path);
        PD_TRY(pdi_pictures_remove_frame_file(r->ctx, &r->output.images));
    }
    pdi_run_call_observer(r, PD_SNAPSHOT_STAGE_END);
    return PD_OK;
}

/* [mol] Gas evolved by dissolution so far (per m in planar 2D, per m2 in 1D): lost metal times gas_released, summed
 * over metals where the species keep them apart, else with that of the one metal. 0 without species in time. */
static double pdi_run_compute_evolved_gas(const pdi_run *r)
{
    const pd_setup *u = r->setup;
    const pd_course *course = &r->model.species_integrator;
    int goes = pd_setup_find_species_rate_metal(u);
    double gas = 0.0;
    if (!course->reactive) return 0.0;
    if (!course->each) return u->metal[goes > 0 ? goes : 0].gas_released * pd_course_lost(course, 0);
    for (int m = 0; m < u->metals; m++) gas += u->metal[m].gas_released * pd_course_lost(course, m);
    return gas;
}

/* Fill in the result from model and diagnostics; result->unknowns is added to and must be 0 before. */
static void pdi_run_set_result(const pdi_run *r, pd_run_result *result)
{
    const pd_model *m = &r->model;
    const pd_time_loop *c = &m->time_loop;
    pd_model_statistics effort;
    pd_model_get_statistics(m, &effort);
    int64_t nodes = m->grid.fluid_count + m->grid.solid_count;
    const char *slowest;
    memcpy(result->name, r->setup->name, sizeof result->name);
    result->stopped = r->stopped;
    result->time = c->time;
    result->h = r->setup->h[0];
    result->m = m->stencil.m;
    result->volume_loss = r->observables.volume_loss;
    result->mass_balance_error = pd_time_loop_imbalance(c);
    result->has_front = r->setup->has_corrode;
    result->corrosion_depth = r->observables.corrosion_depth;
    result->evolves_gas = r->setup->has_surface_reaction && r->setup->gas[0];
    result->gas = pdi_run_compute_evolved_gas(r);
    result->gas_volume = result->gas * PD_GAS_CONSTANT * r->setup->electrolyte.temperature / PD_MODEL_ATMOSPHERE;
    result->has_potential = r->setup->has_potential;
    result->current_balance = m->cell.result.imbalance;
    result->current = m->cell.result.anodic;
    if (m->dissolution_laws.species_electrodes.setup)
        result->current = pd_species_electrodes_compute_total_current(&m->dissolution_laws.species_electrodes,
                                                                      &result->current_balance);
    result->has_flux = r->observables.has_flux;
    result->flux_error = r->observables.flux_error;
    result->layer_flux_error = r->observables.layer_flux_error;
    result->peclet = pd_step_diagnostics_compute_peclet(m, &slowest);
    result->residual = pd_max(effort.momentum, effort.continuity);
    result->evaluations = effort.flow_evaluations;
    result->is_steady = r->setup->steady_transport;
    result->steady_change = effort.steady_change;
    result->steady_imbalance = effort.mass_defect;
    result->steps = c->steps;
    result->unconverged_steps = c->unsolved;
    result->threads = pd_par_available_threads(r->ctx, INT64_MAX);
    for (int k = 0; k < PD_PART_COUNT; k++) result->unknowns += m->unknowns[k];
    result->bytes_per_node = nodes ? (double)r->ctx->peak / (double)nodes : 0.0;
}

PDI_FN void pdi_run_prefix_message(pd_ctx *ctx, const pd_setup *setup, int line)
{
    char where[320], message[PD_MESSAGE_SIZE];
    if (!setup->source[0]) return;
    memcpy(message, ctx->message, sizeof message);
    if (line > 0) snprintf(where, sizeof where, "%.280s:%d", setup->source, line);
    else snprintf(where, sizeof where, "%.280s", setup->source);
    pd_fail(ctx, ctx->status, where, "%s", message);
}

/* Build everything that can refuse the setup: memory estimate, model, monitors, measured points. Stops at the first
 * failure; nothing is written. result->bad_input: 1: the failure is not fatal (memory, limit, cancelled), and the
 * message begins with file and line. */
static pd_status pdi_run_build(pdi_run *r, pd_run_result *result)
{
    pd_status status = pd_memory_estimate_check_limit(r->ctx, r->setup, r->desc->no_files);
    int line = r->setup->line[PD_PART_GRID];
    if (status == PD_OK) {
        status = pd_model_build(r->ctx, r->setup, &r->model);
        line = r->model.error_line;
    }
    if (status == PD_OK) {
        status = pdi_monitors_build(r->ctx, &r->model, &r->monitors);
        line = r->monitors.error_line;
    }
    if (status == PD_OK) {
        status = pdi_compare_measured_build(r->ctx, &r->model, &r->monitors, r->desc->monitor_weight,
                                            !r->desc->no_files, &r->compare);
        line = r->compare.error_line;
    }
    result->bad_input = status < 0 && !pd_is_fatal(status);
    if (result->bad_input) pdi_run_prefix_message(r->ctx, r->setup, line);
    return status;
}

/* Dry check: collect the figures for the caller, check that the output folder can be opened, and with `resume` load the
 * checkpoint into the model. Writes nothing. result->bad_input: 1: folder or checkpoint is refused by an error that is
 * not fatal. */
static pd_status pdi_run_check_resume(pdi_run *r, pd_run_result *result)
{
    pd_archive_file store;
    if (r->desc->figures) PD_TRY(pdi_scalar_outputs_collect(r->ctx, &r->model, &r->monitors, 0, r->desc->figures));
    pd_status status = pdi_output_folder_check(r->ctx, r->folder_path, r->setup->name);
    if (status == PD_OK && r->desc->resume) {
        status = pd_file_join(r->ctx, r->folder_path, PD_RUN_CHECKPOINT, r->checkpoint_path);
        if (status == PD_OK) status = pd_archive_file_open(r->ctx, r->checkpoint_path, &store);
        if (status == PD_OK) {
            status = pdi_run_store_state(r, &store.archive);
            pdi_archive_file_abandon(&store);
        }
    }
    result->bad_input = status < 0 && !pd_is_fatal(status);
    return status;
}

/* Print the summary, run all steps, and fill in the result, before the steps and after them. With check_only no step is
 * made: figures are collected, folder and checkpoint checked, or with no_files none of that. */
static pd_status pdi_run_execute(pdi_run *r, pd_run_result *result)
{
    r->folder_path = r->desc->folder ? r->desc->folder : r->setup->folder;
    pd_summary_print(&r->model, r->desc->print, r->desc->print_user);
    if (r->desc->print) pd_lattice_notes_print(&r->model, r->desc->print, r->desc->print_user);
    pdi_run_set_result(r, result);
    PD_TRY(pd_step_diagnostics_build(r->ctx, &r->model, &r->observables));
    PD_TRY(pd_depletion_notes_build(r->ctx, &r->model, &r->depletion));
    if (r->desc->check_only) return r->desc->no_files ? PD_OK : pdi_run_check_resume(r, result);
    PD_TRY(pdi_run_open_files(r, result));
    pd_status status = pdi_run_run_steps(r);
    result->unknowns = 0;
    pdi_run_set_result(r, result);
    return status;
}

pd_status pd_run(pd_ctx *ctx, const pd_setup *setup, const pd_run_desc *desc, pd_run_result *result)
{
    pdi_run *r = NULL;
    int threads = ctx->threads;
    memset(result, 0, sizeof *result);
    PD_TRY(PD_NEW(ctx, "run", 1, r));
    r->ctx = ctx;
    r->desc = desc;
    r->setup = setup;
    r->start_clock = r->progress_clock = r->checkpoint_clock = r->step_clock = pd_par_clock();
    r->stall_time = desc->stall_note_after > 0.0 ? desc->stall_note_after : PDI_RUN_STALL_TIME;
    if (setup->threads > 0 && threads == 0) ctx->threads = setup->threads;
    r->poll = ctx->cancel;
    r->poll_user = ctx->cancel_user;
    if (r->poll || desc->print) {
        ctx->cancel = pdi_run_poll;
        ctx->cancel_user = r;
    }
    pd_status status = pdi_run_build(r, result);
    if (status == PD_OK) status = pdi_run_execute(r, result);
    ctx->cancel = r->poll;
    ctx->cancel_user = r->poll_user;
    result->stopped = r->stopped;
    pdi_archive_file_free_memory(ctx, &r->kept_checkpoint);
    pdi_output_free(ctx, &r->output);
    pd_step_diagnostics_free(ctx, &r->observables);
    pd_depletion_notes_free(ctx, &r->depletion);
    pdi_field_view_free(ctx, &r->views);
    pdi_compare_measured_free(ctx, &r->compare);
    pdi_monitors_free(ctx, &r->monitors);
    pd_model_free(ctx, &r->model);
    pdi_output_folder_close(&r->folder);
    PD_DELETE(ctx, 1, r);
    ctx->threads = threads;
    return status;
}

void pd_run_format_result(const pd_run_result *r, char *text, size_t size)
{
    if (size == 0) return;
    text[0] = '\0';
    pd_append(text, size, "result case=%s", r->name);
    char *figures = text + strlen(text);
    pd_append(text, size, " dim=%d h=%.6g m=%.6g volume_loss=%.9g ledger=%.3g", PD_DIM, r->h, r->m, r->volume_loss,
              r->mass_balance_error);
    if (r->is_steady) pd_append(text, size, " defect=%.3g", r->steady_imbalance);
    if (r->unconverged_steps) pd_append(text, size, " unsolved=%.0f", (double)r->unconverged_steps);
    if (r->evolves_gas) pd_append(text, size, " gas=%.9g gas_mL=%.6g", r->gas, r->gas_volume * 1e6);
    if (r->has_potential)
        pd_append(text, size, " current=%.9g current_balance=%.3g", r->current, r->current_balance);
    if (r->has_flux) pd_append(text, size, " flux=%.3g flux_max=%.3g", r->flux_error, r->layer_flux_error);
    if (r->peclet > 0.0) pd_append(text, size, " peclet=%.3g", r->peclet);
    if (r->has_front) pd_append(text, size, " front=%.6g", r->corrosion_depth);
    else pd_append(text, size, " residual=%.3g evals=%.0f", r->residual, (double)r->evaluations);
    pd_append(text, size, " steps=%.0f unknowns=%.0f bytes_per_node=%.0f", (double)r->steps, (double)r->unknowns,
                   r->bytes_per_node);
    pdi_result_line_remove_nonfinite(figures);
}

#undef PDI_RUN_MAX_FLUX_ERROR
#undef PDI_RUN_PROGRESS_INTERVAL
#undef PDI_RUN_STALL_TIME
