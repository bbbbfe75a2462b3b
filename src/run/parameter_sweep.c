/* parameter_sweep: see parameter_sweep.h */
#include "run/parameter_sweep.h"
#include "io/plot.h"
#include "io/csv.h"
#include "io/file.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* What a run leaves in its folder: how it ended, and its result line or message. */
#define PDI_PARAMETER_SWEEP_STATUS_FILE "sweep_run.txt"
#define PDI_PARAMETER_SWEEP_MAX_COLUMNS 64         /* figures of result lines */
#define PDI_PARAMETER_SWEEP_NAME_BYTES 32          /* [byte] of one's name */
#define PDI_PARAMETER_SWEEP_MAX_RESULT_BYTES 65536 /* [byte] of a run's result */

/* ---- axes ---- */

/* Number of blanks at the start of text. */
static size_t pdi_parameter_sweep_count_blanks(const char *text) { return strspn(text, " \t"); }

/* Length of the value at text, up to the first comma outside of round brackets, or the end, without trailing blanks.
 * *next: behind the comma, or the end. */
static size_t pdi_parameter_sweep_find_value_length(const char *text, const char **next)
{
    size_t at = 0, length;
    for (int depth = 0; text[at] && (depth > 0 || text[at] != ','); at++)
        depth += (text[at] == '(') - (text[at] == ')');
    *next = text[at] ? text + at + 1 : text + at;
    for (length = at; length > 0 && pdi_parameter_sweep_count_blanks(text + length - 1) > 0; length--) continue;
    return length;
}

/* Error message for an axis that cannot be read. Returns PD_ERR_ARGUMENT. */
static pd_status pdi_parameter_sweep_reject_axis(pd_ctx *ctx, const char *axis, const char *why)
{
    return pd_fail(ctx, PD_ERR_ARGUMENT, "--sweep", "found '%.200s', expected %s, such as mean=0.01,0.05,0.2 m/s",
                   axis, why);
}

/* Number of values of an axis, at least 1, empty ones included. unit [PD_PARAMETER_SWEEP_VALUE_BYTES]: what stands
 * behind the number of the last value, if every value begins with a number and all before the last are nothing else;
 * otherwise, or if it is too long, "". */
static int pdi_parameter_sweep_count_values(const char *values, char *unit)
{
    int count = 0, plain = 1, more = 1;
    *unit = '\0';
    for (const char *at = values, *next; more; at = next, count++) {
        at += pdi_parameter_sweep_count_blanks(at);
        size_t length = pdi_parameter_sweep_find_value_length(at, &next),
               number = pdi_file_find_number_length(at, length);
        more = next > at && next[-1] == ',';
        plain = plain && number > 0 && (number == length || !more);
        while (number < length && pdi_parameter_sweep_count_blanks(at + number) > 0) number++;
        if (!more && plain && length - number < PD_PARAMETER_SWEEP_VALUE_BYTES)
            snprintf(unit, PD_PARAMETER_SWEEP_VALUE_BYTES, "%.*s", (int)(length - number), at + number);
    }
    return count;
}

/* Append `length` characters of part to text [PD_PARAMETER_SWEEP_VALUE_BYTES], as far as there is room. */
static void pdi_parameter_sweep_append_text(char *text, const char *part, size_t length)
{
    size_t used = strlen(text);
    if (length > PD_PARAMETER_SWEEP_VALUE_BYTES - 1 - used) length = PD_PARAMETER_SWEEP_VALUE_BYTES - 1 - used;
    memcpy(text + used, part, length);
    text[used + length] = '\0';
}

/* Parse "key=value, value, ..." into an axis, whose text is allocated (the caller frees it on failure, too), with the
 * unit of the last value behind all numbers. PD_ERR_ARGUMENT: no key, an empty value, too long a key, unit or value, or
 * more than PD_PARAMETER_SWEEP_MAX_RUNS values. */
static pd_status pdi_parameter_sweep_parse_axis(pd_ctx *ctx, const char *text, pd_parameter_sweep_axis *axis)
{
    char unit[PD_PARAMETER_SWEEP_VALUE_BYTES];
    const char *equal = strchr(text, '='), *at, *next;
    size_t key = equal ? (size_t)(equal - text) : 0, blanks;
    while (key > 0 && pdi_parameter_sweep_count_blanks(text + key - 1) > 0) key--;
    blanks = pdi_parameter_sweep_count_blanks(text);
    if (key <= blanks) return pdi_parameter_sweep_reject_axis(ctx, text, "key = value, value, ...");
    text += blanks;
    key -= blanks;
    axis->count = pdi_parameter_sweep_count_values(equal + 1, unit);
    if (key + strlen(unit) + 4 > sizeof axis->name)
        return pdi_parameter_sweep_reject_axis(ctx, text, "a shorter key and unit");
    pdi_parameter_sweep_append_text(axis->name, text, key);
    if (*unit) {
        pdi_parameter_sweep_append_text(axis->name, " [", 2);
        pdi_parameter_sweep_append_text(axis->name, unit, strlen(unit));
        pdi_parameter_sweep_append_text(axis->name, "]", 1);
    }
    if (axis->count > PD_PARAMETER_SWEEP_MAX_RUNS) return pdi_parameter_sweep_reject_axis(ctx, text, "fewer values");
    axis->unit_bytes = (int)strlen(unit);
    PD_TRY(PD_NEW(ctx, "sweep", axis->count * PD_PARAMETER_SWEEP_VALUE_BYTES, axis->text));
    at = equal + 1;
    for (int k = 0; k < axis->count; k++, at = next) {
        at += pdi_parameter_sweep_count_blanks(at);
        size_t length = pdi_parameter_sweep_find_value_length(at, &next),
               number = pdi_file_find_number_length(at, length);
        char *value = axis->text + (size_t)k * PD_PARAMETER_SWEEP_VALUE_BYTES;
        if (length == 0) return pdi_parameter_sweep_reject_axis(ctx, text, "a value before and behind each comma");
        if (key + length + strlen(unit) + 3 > PD_PARAMETER_SWEEP_VALUE_BYTES)
            return pdi_parameter_sweep_reject_axis(ctx, text, "shorter values");
        pdi_parameter_sweep_append_text(value, text, key);
        pdi_parameter_sweep_append_text(value, "=", 1);
        pdi_parameter_sweep_append_text(value, at, *unit ? number : length);
        if (*unit) pdi_parameter_sweep_append_text(value, " ", 1);
        pdi_parameter_sweep_append_text(value, unit, strlen(unit));
    }
    return PD_OK;
}

/* ---- runs ---- */

/* "key=value" of an axis in run `index`; the last axis changes fastest. */
static const char *pdi_parameter_sweep_get_axis_value(const pd_parameter_sweep *s, int index, int axis)
{
    for (int k = s->axes - 1; k > axis; k--) index /= s->axis[k].count;
    return s->axis[axis].text + (size_t)(index % s->axis[axis].count) * PD_PARAMETER_SWEEP_VALUE_BYTES;
}

/* Read the scene of run `index` with its overrides into setup, which the caller frees. */
static pd_status pdi_parameter_sweep_read_scene(pd_ctx *ctx, const pd_parameter_sweep *s, int index, pd_setup *setup)
{
    const char *overrides[PD_PARAMETER_SWEEP_MAX_OVERRIDES + PD_PARAMETER_SWEEP_MAX_AXES];
    int count = 0;
    for (; count < s->desc.count; count++) overrides[count] = s->desc.overrides[count];
    for (int k = 0; k < s->axes; k++) overrides[count++] = pdi_parameter_sweep_get_axis_value(s, index, k);
    return pd_scene_read(ctx, s->desc.scene, overrides, count, setup);
}

/* Parse all axes and count the runs, the product of their numbers of values. PD_ERR_ARGUMENT: no or too many axes, too
 * many overrides or runs, an axis that cannot be read, a key twice. s->axes counts the one in work, for the caller to
 * free. */
static pd_status pdi_parameter_sweep_parse_axes(pd_ctx *ctx, const pd_parameter_sweep_desc *desc, pd_parameter_sweep *s)
{
    if (desc->axis_count < 1 || desc->axis_count > PD_PARAMETER_SWEEP_MAX_AXES ||
        desc->count > PD_PARAMETER_SWEEP_MAX_OVERRIDES)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "--sweep",
                       "found %d sweeps and %d overrides, expected 1 to %d and at most %d", desc->axis_count,
                       desc->count, PD_PARAMETER_SWEEP_MAX_AXES, PD_PARAMETER_SWEEP_MAX_OVERRIDES);
    s->runs = 1;
    for (int k = 0; k < desc->axis_count; k++) {
        s->axes++;
        PD_TRY(pdi_parameter_sweep_parse_axis(ctx, desc->axes[k], &s->axis[k]));
        for (int before = 0; before < k; before++) {
            size_t length = strcspn(s->axis[k].text, "=") + 1;
            if (strncmp(s->axis[k].text, s->axis[before].text, length) == 0)
                return pdi_parameter_sweep_reject_axis(ctx, desc->axes[k], "each key once");
        }
        s->runs *= s->axis[k].count;
        if (s->runs > PD_PARAMETER_SWEEP_MAX_RUNS)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "--sweep", "found more than %d runs, expected fewer values",
                           PD_PARAMETER_SWEEP_MAX_RUNS);
    }
    return PD_OK;
}

/* Paths of the folder of a run and of its result file into folder[PD_PATH_SIZE] and result[PD_PATH_SIZE]. PD_ERR_FILE:
 * the folder is a link. */
static pd_status pdi_parameter_sweep_format_paths(pd_ctx *ctx, const pd_parameter_sweep *s, int index, char *folder,
                                                  char *result)
{
    char name[32];
    snprintf(name, sizeof name, "run%03d", index + 1);
    PD_TRY(pd_file_join(ctx, s->folder, name, folder));
    if (pdi_file_is_link(folder)) /* runs write below the folder that they were given */
        return pd_fail(ctx, PD_ERR_FILE, "sweep",
                       "'%.300s' is a link, expected the folder of a run or none: remove it", folder);
    return pd_file_join(ctx, folder, PDI_PARAMETER_SWEEP_STATUS_FILE, result);
}

/* Read the scenes of all runs to check them; the first error ends it, and nothing is removed then. Set name and, if the
 * caller gives none, folder from the last one; has_dissolution if metal dissolves in any. Then delete the result files
 * of former sweeps. */
static pd_status pdi_parameter_sweep_check_scenes(pd_ctx *ctx, pd_parameter_sweep *s)
{
    for (int index = 0; index < s->runs; index++) {
        pd_setup setup;
        PD_TRY(pdi_parameter_sweep_read_scene(ctx, s, index, &setup));
        memcpy(s->name, setup.name, sizeof s->name);
        if (!s->desc.folder) memcpy(s->folder, setup.folder, sizeof s->folder);
        s->has_dissolution = s->has_dissolution || setup.has_dissolve;
        pd_setup_free(ctx, &setup);
    }
    for (int index = 0; index < s->runs; index++) {
        char folder[PD_PATH_SIZE], path[PD_PATH_SIZE];
        PD_TRY(pdi_parameter_sweep_format_paths(ctx, s, index, folder, path));
        pdi_file_remove(path);
    }
    return PD_OK;
}

pd_status pd_parameter_sweep_build(pd_ctx *ctx, const pd_parameter_sweep_desc *desc, pd_parameter_sweep *s)
{
    memset(s, 0, sizeof *s);
    s->desc = *desc;
    pd_status status = pdi_parameter_sweep_parse_axes(ctx, desc, s);
    if (status == PD_OK && desc->folder) status = pd_file_join(ctx, "", desc->folder, s->folder);
    if (status == PD_OK) status = pdi_parameter_sweep_check_scenes(ctx, s);
    if (status < 0) pd_parameter_sweep_free(ctx, s);
    return status;
}

void pd_parameter_sweep_label(const pd_parameter_sweep *s, int index, char *text, size_t size)
{
    if (size == 0) return;
    snprintf(text, size, "run%03d", index + 1);
    for (int k = 0; k < s->axes; k++) {
        size_t used = strlen(text);
        snprintf(text + used, size - used, " %s", pdi_parameter_sweep_get_axis_value(s, index, k));
    }
}

/* Write the result file of a run: a line "done", "failed" or "stopped", and its result line or message. */
static pd_status pdi_parameter_sweep_write_status(pd_ctx *ctx, const char *path, const char *ended, const char *text)
{
    pd_file file;
    memset(&file, 0, sizeof file);
    pd_status status = pdi_file_create(ctx, path, &file);
    if (status == PD_OK) status = pdi_file_write_text(ctx, &file, ended);
    if (status == PD_OK) status = pdi_file_write_text(ctx, &file, "\n");
    if (status == PD_OK) status = pdi_file_write_text(ctx, &file, text);
    if (status == PD_OK) status = pdi_file_write_text(ctx, &file, "\n");
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

pd_status pd_parameter_sweep_run(pd_ctx *ctx, const pd_parameter_sweep *s, int index, const pd_run_desc *desc)
{
    char folder[PD_PATH_SIZE], path[PD_PATH_SIZE], text[PD_MESSAGE_SIZE + 1024];
    pd_setup setup;
    pd_run_desc one = *desc;
    pd_run_result result;
    PD_TRY(pdi_parameter_sweep_format_paths(ctx, s, index, folder, path));
    PD_TRY(pd_file_make_directory(ctx, folder));
    /* as long as there is none */
    PD_TRY(pdi_parameter_sweep_write_status(ctx, path, "failed", "ended without a result"));
    PD_TRY(pdi_parameter_sweep_read_scene(ctx, s, index, &setup));
    one.folder = folder;
    pd_status status = pd_run(ctx, &setup, &one, &result);
    pd_setup_free(ctx, &setup);
    int stopped = status == PD_CANCELLED || (status >= 0 && result.stopped); /* before the first step, or after it */
    if (status < 0 && !stopped) {
        pd_ctx copy = *ctx; /* the message is that of the run */
        snprintf(text, sizeof text, "%s", ctx->message);
        pdi_parameter_sweep_write_status(&copy, path, "failed", text);
        return status;
    }
    pd_run_format_result(&result, text, sizeof text);
    if (stopped) snprintf(text, sizeof text, "stopped at t = %g s", result.time);
    PD_TRY(pdi_parameter_sweep_write_status(ctx, path, stopped ? "stopped" : "done", text));
    if (desc->print && !stopped) desc->print(desc->print_user, PD_PRINT_RESULT, text);
    return stopped ? PD_RETRY : status;
}

/* ---- table ---- */

/* Results of all runs, and the columns of the table. */
typedef struct pdi_parameter_sweep_results {
    char **text;      /* [runs] "done\nresult ...\n"; NULL: nothing */
    size_t *size;     /* [runs] */
    char name[PDI_PARAMETER_SWEEP_MAX_COLUMNS][PDI_PARAMETER_SWEEP_NAME_BYTES];
    int columns;
} pdi_parameter_sweep_results;

static const char pdi_parameter_sweep_not_started[] = "stopped\nnot begun\n";

/* Content of the result file of a run; a text for runs that were not started. */
static const char *pdi_parameter_sweep_get_run_text(const pdi_parameter_sweep_results *rows, int index)
{
    return rows->text[index] ? rows->text[index] : pdi_parameter_sweep_not_started;
}

/* Length of the key of the next "key=value" from *at on, to which *at moves; 0: there is none. */
static size_t pdi_parameter_sweep_find_next_pair(const char **at)
{
    for (; **at; *at += strcspn(*at, " \n")) {
        *at += strspn(*at, " \n");
        size_t key = strcspn(*at, "= \n");
        if (key > 0 && (*at)[key] == '=') return key;
    }
    return 0;
}

/* Append the keys of a result line that are not yet columns, in the order of first appearance. The key case, keys of
 * PDI_PARAMETER_SWEEP_NAME_BYTES or more, and those beyond the last column are left out. */
static void pdi_parameter_sweep_find_names(const char *text, pdi_parameter_sweep_results *rows)
{
    const char *at = text;
    for (size_t key = pdi_parameter_sweep_find_next_pair(&at); key > 0;
         at += strcspn(at, " \n"), key = pdi_parameter_sweep_find_next_pair(&at)) {
        int known = key >= PDI_PARAMETER_SWEEP_NAME_BYTES || rows->columns == PDI_PARAMETER_SWEEP_MAX_COLUMNS ||
                    strncmp(at, "case=", 5) == 0;
        for (int k = 0; k < rows->columns && !known; k++)
            known = strlen(rows->name[k]) == key && strncmp(rows->name[k], at, key) == 0;
        if (known) continue;
        memcpy(rows->name[rows->columns], at, key);
        rows->name[rows->columns++][key] = '\0';
    }
}

/* Read the result files of all runs into new memory of rows, which the caller frees, count how they ended, and collect
 * the columns from those that are done. A file that cannot be read counts as stopped; one that begins neither with done
 * nor with stopped as failed. Out of memory is an error. */
static pd_status pdi_parameter_sweep_read_results(pd_ctx *ctx, const pd_parameter_sweep *s,
                                                  pdi_parameter_sweep_results *rows, pd_parameter_sweep_count *count)
{
    PD_TRY(PD_NEW(ctx, "sweep", s->runs, rows->text));
    PD_TRY(PD_NEW(ctx, "sweep", s->runs, rows->size));
    for (int index = 0; index < s->runs; index++) {
        char folder[PD_PATH_SIZE], path[PD_PATH_SIZE];
        PD_TRY(pdi_parameter_sweep_format_paths(ctx, s, index, folder, path));
        pd_ctx quiet = *ctx;
        pd_status status = pdi_file_read_all(&quiet, path, PDI_PARAMETER_SWEEP_MAX_RESULT_BYTES, &rows->text[index],
                                             &rows->size[index]);
        if (pd_is_fatal(status)) return pd_fail(ctx, status, "sweep", "%s", quiet.message);
        ctx->in_use = quiet.in_use;
        const char *text = pdi_parameter_sweep_get_run_text(rows, index);
        int done = strncmp(text, "done\n", 5) == 0, stopped = strncmp(text, "stopped\n", 8) == 0;
        count->done += done;
        count->stopped += stopped;
        count->failed += !done && !stopped;
        if (done) pdi_parameter_sweep_find_names(text + 5, rows);
    }
    return PD_OK;
}

/* Write a CSV field, in double quotes, with those inside doubled, if it has a comma, a double quote or #. */
static pd_status pdi_parameter_sweep_write_csv_field(pd_ctx *ctx, pd_file *file, const char *text, size_t length)
{
    if (!memchr(text, ',', length) && !memchr(text, '"', length) && !memchr(text, '#', length))
        return pdi_file_write(ctx, file, text, length);
    PD_TRY(pdi_file_write_text(ctx, file, "\""));
    for (size_t k = 0; k < length; k++) {
        if (text[k] == '"') PD_TRY(pdi_file_write_text(ctx, file, "\""));
        PD_TRY(pdi_file_write(ctx, file, text + k, 1));
    }
    return pdi_file_write_text(ctx, file, "\"");
}

/* Value of key `name` in the result line of a run that is done, *length bytes at the returned place, not terminated.
 * *length 0: the run is not done, or its line has no such key. */
static const char *pdi_parameter_sweep_find_result_value(const char *text, const char *name, size_t *length)
{
    const char *at = strchr(text, '\n');
    *length = 0;
    if (!at || strncmp(text, "done\n", 5) != 0) return text;
    for (size_t key = pdi_parameter_sweep_find_next_pair(&at); key > 0;
         at += strcspn(at, " \n"), key = pdi_parameter_sweep_find_next_pair(&at)) {
        if (strlen(name) != key || strncmp(at, name, key) != 0) continue;
        *length = strcspn(at + key + 1, " \n");
        return at + key + 1;
    }
    return text;
}

/* Write the row of a run: its number, values without the common unit of their axis, how it ended, results (empty where
 * it has none), and, unless it is done, its message. */
static pd_status pdi_parameter_sweep_write_row(pd_ctx *ctx, const pd_parameter_sweep *s,
                                               const pdi_parameter_sweep_results *rows, int index, pd_file *file)
{
    char run[32];
    const char *text = pdi_parameter_sweep_get_run_text(rows, index), *message = strchr(text, '\n');
    size_t ended = strcspn(text, "\n"), length;
    snprintf(run, sizeof run, "run%03d", index + 1);
    PD_TRY(pdi_file_write_text(ctx, file, run));
    for (int k = 0; k < s->axes; k++) {
        const char *value = strchr(pdi_parameter_sweep_get_axis_value(s, index, k), '=') + 1;
        length = strlen(value) - (size_t)s->axis[k].unit_bytes;
        while (s->axis[k].unit_bytes && length > 0 && value[length - 1] == ' ') length--;
        PD_TRY(pdi_file_write_text(ctx, file, ","));
        PD_TRY(pdi_parameter_sweep_write_csv_field(ctx, file, value, length));
    }
    PD_TRY(pdi_file_write_text(ctx, file, ","));
    PD_TRY(pdi_file_write(ctx, file, text, ended));
    for (int k = 0; k < rows->columns; k++) {
        const char *value = pdi_parameter_sweep_find_result_value(text, rows->name[k], &length);
        PD_TRY(pdi_file_write_text(ctx, file, ","));
        PD_TRY(pdi_parameter_sweep_write_csv_field(ctx, file, value, length));
    }
    PD_TRY(pdi_file_write_text(ctx, file, ","));
    int failed = message && strncmp(text, "done\n", 5) != 0;
    if (failed) PD_TRY(pdi_parameter_sweep_write_csv_field(ctx, file, message + 1, strcspn(message + 1, "\n")));
    return pdi_file_write_text(ctx, file, "\n");
}

/* Write the header and a row for each run. Columns of results have the prefix result_, since a swept key may have the
 * name of a figure. */
static pd_status pdi_parameter_sweep_write_lines(pd_ctx *ctx, const pd_parameter_sweep *s,
                                                 const pdi_parameter_sweep_results *rows, pd_file *file)
{
    PD_TRY(pdi_file_write_text(ctx, file, "run"));
    for (int k = 0; k < s->axes; k++) {
        PD_TRY(pdi_file_write_text(ctx, file, ","));
        PD_TRY(pdi_parameter_sweep_write_csv_field(ctx, file, s->axis[k].name, strlen(s->axis[k].name)));
    }
    PD_TRY(pdi_file_write_text(ctx, file, ",status"));
    for (int k = 0; k < rows->columns; k++) {
        /* a swept key may have the name of a figure */
        PD_TRY(pdi_file_write_text(ctx, file, ",result_"));
        PD_TRY(pdi_file_write_text(ctx, file, rows->name[k]));
    }
    PD_TRY(pdi_file_write_text(ctx, file, ",message\n"));
    for (int index = 0; index < s->runs; index++) PD_TRY(pdi_parameter_sweep_write_row(ctx, s, rows, index, file));
    return PD_OK;
}

/* Write sweep.csv through a temporary file; on failure a former one stays. */
static pd_status pdi_parameter_sweep_write_table(pd_ctx *ctx, const pd_parameter_sweep *s,
                                                 const pdi_parameter_sweep_results *rows)
{
    char path[PD_PATH_SIZE];
    pd_file file;
    memset(&file, 0, sizeof file);
    PD_TRY(pd_file_join(ctx, s->folder, "sweep.csv", path));
    PD_TRY(pdi_file_create(ctx, path, &file));
    pd_status status = pdi_parameter_sweep_write_lines(ctx, s, rows, &file);
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

/* ---- plot ---- */

/* Loss curves of the plot: data[k] holds the times, then the losses. */
typedef struct pdi_parameter_sweep_loss_curves {
    pd_plot plot;
    double *data[PD_PLOT_MAX_SERIES];
    int rows[PD_PLOT_MAX_SERIES];
    char label[PD_PLOT_MAX_SERIES][PD_PARAMETER_SWEEP_MAX_AXES * PD_PARAMETER_SWEEP_VALUE_BYTES];
} pdi_parameter_sweep_loss_curves;

/* Append the volume loss [%] of a run over time [h] to the plot, with its data in new memory of c, which the caller
 * frees. No curve, and PD_OK, where diagnostics.csv cannot be read or has fewer than two rows. Dashed in the second
 * half of the series. */
static pd_status pdi_parameter_sweep_add_curve(pd_ctx *ctx, const pd_parameter_sweep *s, int index,
                                               pdi_parameter_sweep_loss_curves *c)
{
    char folder[PD_PATH_SIZE], path[PD_PATH_SIZE], label[PD_PARAMETER_SWEEP_MAX_AXES * PD_PARAMETER_SWEEP_VALUE_BYTES];
    pd_table table;
    pd_ctx quiet;
    int k = c->plot.count;
    memset(&table, 0, sizeof table);
    PD_TRY(pdi_parameter_sweep_format_paths(ctx, s, index, folder, path));
    PD_TRY(pd_file_join(ctx, folder, "diagnostics.csv", path));
    quiet = *ctx;
    pd_status status = pd_table_read(&quiet, path, &table);
    ctx->in_use = quiet.in_use;
    if (status < 0 || table.rows < 2) {
        pd_table_free(ctx, &table);
        return PD_OK;
    }
    c->rows[k] = table.rows;
    status = PD_NEW(ctx, "sweep", 2 * table.rows, c->data[k]);
    if (status == PD_OK) status = pd_table_parse_column(ctx, &table, "time", c->data[k]);
    if (status == PD_OK) status = pd_table_parse_column(ctx, &table, "volume_loss", c->data[k] + table.rows);
    pd_table_free(ctx, &table);
    PD_TRY(status);
    for (int row = 0; row < c->rows[k]; row++) {
        c->data[k][row] /= 3600.0;
        c->data[k][c->rows[k] + row] *= 100.0;
    }
    pd_parameter_sweep_label(s, index, label, sizeof label);
    snprintf(c->label[k], sizeof c->label[k], "%s", label + strcspn(label, " ") + 1);
    c->plot.series[k].name = c->label[k];
    c->plot.series[k].x = c->data[k];
    c->plot.series[k].y = c->data[k] + c->rows[k];
    c->plot.series[k].count = c->rows[k];
    c->plot.series[k].stroke = k < PD_PLOT_MAX_SERIES / 2 ? PD_SERIES_STYLE_LINE : PD_SERIES_STYLE_DASHED;
    c->plot.count++;
    return PD_OK;
}

/* Draw the loss curves as sweep.png; of more runs than a plot has series, evenly chosen ones with the first and the
 * last. No file where no run has a curve. */
static pd_status pdi_parameter_sweep_draw_curves(pd_ctx *ctx, const pd_parameter_sweep *s,
                                                 pdi_parameter_sweep_loss_curves *c)
{
    char path[PD_PATH_SIZE], title[PD_SETUP_NAME + 64];
    int curves = s->runs < PD_PLOT_MAX_SERIES ? s->runs : PD_PLOT_MAX_SERIES;
    for (int k = 0; k < curves; k++)
        PD_TRY(pdi_parameter_sweep_add_curve(ctx, s, curves > 1 ? k * (s->runs - 1) / (curves - 1) : 0, c));
    if (c->plot.count == 0) return PD_OK;
    snprintf(title, sizeof title, "%s", s->name);
    if (c->plot.count < s->runs) snprintf(title, sizeof title, "%s: %d of %d runs", s->name, c->plot.count, s->runs);
    c->plot.title = title;
    c->plot.x_label = "t [h]";
    c->plot.y_label = "volume loss [%]";
    PD_TRY(pd_file_join(ctx, s->folder, "sweep.png", path));
    return pd_plot_write(ctx, path, &c->plot);
}

/* Write sweep.png; nothing if no metal dissolves in any run. */
static pd_status pdi_parameter_sweep_write_plot(pd_ctx *ctx, const pd_parameter_sweep *s)
{
    pdi_parameter_sweep_loss_curves *c = NULL;
    if (!s->has_dissolution) return PD_OK;
    PD_TRY(PD_NEW(ctx, "sweep", 1, c));
    pd_status status = pdi_parameter_sweep_draw_curves(ctx, s, c);
    for (int k = 0; k < PD_PLOT_MAX_SERIES; k++) PD_DELETE(ctx, 2 * c->rows[k], c->data[k]);
    PD_DELETE(ctx, 1, c);
    return status;
}

pd_status pd_parameter_sweep_write(pd_ctx *ctx, const pd_parameter_sweep *s, pd_parameter_sweep_count *count)
{
    pdi_parameter_sweep_results rows;
    memset(&rows, 0, sizeof rows);
    memset(count, 0, sizeof *count);
    pd_status status = pd_file_make_directory(ctx, s->folder);
    if (status == PD_OK) status = pdi_parameter_sweep_read_results(ctx, s, &rows, count);
    if (status == PD_OK) status = pdi_parameter_sweep_write_table(ctx, s, &rows);
    if (status == PD_OK) status = pdi_parameter_sweep_write_plot(ctx, s);
    for (int k = 0; k < s->runs && rows.text; k++)
        if (rows.text[k]) PD_DELETE(ctx, rows.size[k] + 1, rows.text[k]);
    PD_DELETE(ctx, s->runs, rows.text);
    PD_DELETE(ctx, s->runs, rows.size);
    return status;
}

void pd_parameter_sweep_free(pd_ctx *ctx, pd_parameter_sweep *s)
{
    for (int k = 0; k < s->axes; k++)
        PD_DELETE(ctx, s->axis[k].count * PD_PARAMETER_SWEEP_VALUE_BYTES, s->axis[k].text);
    memset(s, 0, sizeof *s);
}

#undef PDI_PARAMETER_SWEEP_STATUS_FILE
#undef PDI_PARAMETER_SWEEP_MAX_COLUMNS
#undef PDI_PARAMETER_SWEEP_NAME_BYTES
#undef PDI_PARAMETER_SWEEP_MAX_RESULT_BYTES
