/* file: whole-file reading with a limit, writing aside and renaming, appending line by line, directories, numbers.
 *
 * A file under its final name is always complete: a writer fills `<path>.part` and renames it when everything has
 * arrived. A log that must be readable while the run goes on (diagnostics.csv) gets its header that way and is then
 * reopened for appending; every row is one write followed by a flush, so a killed program loses at most the row in
 * flight. (Nothing is forced through the disk cache: power failures are not covered, C99 has no call for it.) A log
 * that a checkpoint has seen goes on from the length it had then.
 *
 * Only plain files are read: pipes and devices have no end. Nothing is written through a link that stands in the place
 * of a file: the file written aside is made anew, a link of its name goes, and renaming replaces one.
 */
#ifndef PD_FILE_H
#define PD_FILE_H
#include "core/base.h"

#define PD_PATH_SIZE 1024 /* longest path with its end, [byte] */

/* An output file. Zero it, or hand it to pdi_file_create. */
typedef struct pd_file {
    void *stream;                    /* FILE, NULL: closed */
    char path[PD_PATH_SIZE];         /* final name */
    char part[PD_PATH_SIZE + 8];     /* name while it is written; empty: the file is appended to in place */
} pd_file;

#define pd_file_make_directory PD_NAME(pd_file_make_directory)
#define pd_file_join PD_NAME(pd_file_join)

/* Make a directory and the missing ones above it; an existing directory is fine. PD_ERR_FILE. */
PD_API pd_status pd_file_make_directory(pd_ctx *ctx, const char *path);
/* path[PD_PATH_SIZE] = "directory/name"; an empty directory gives the name. PD_ERR_SIZE when it does not fit. */
PD_API pd_status pd_file_join(pd_ctx *ctx, const char *directory, const char *name, char *path);
#ifdef PDI_INTERNAL
/* Paths are UTF-8 with '/', on Windows with '\\', too, and with drives. 1: something is there, behind links, too. */
PDI_FN int pdi_file_exists(const char *path);
/* 1: it is a symbolic link, wherever that leads. */
PDI_FN int pdi_file_is_link(const char *path);
PDI_FN int pdi_file_is_separator(char c);
PDI_FN int pdi_file_is_absolute(const char *path);
#if defined(_WIN32)
#define PDI_FILE_WIDE_SIZE (PD_PATH_SIZE + 8)
/* wide[PDI_FILE_WIDE_SIZE], for functions of Windows; empty when the path is no UTF-8. Returns it. */
PDI_FN const wchar_t *pdi_file_wide(const char *path, wchar_t *wide);
#endif
/* name[PD_PATH_SIZE] = "corr_000012_t6.1s.vti" from prefix "corr", frame 12 (0..999999), time 6.1 [s] >= 0 (one to
 * six decimals, as many as it needs) and extension "vti". PD_ERR_ARGUMENT, PD_ERR_SIZE. */
PDI_FN pd_status pdi_file_frame_name(pd_ctx *ctx, const char *prefix, int frame, double time, const char *extension,
                                     char *name);

/* 1: the path stays below the folder it is taken from: not absolute, no drive, no '..' among its parts. */
PDI_FN int pdi_file_below(const char *path);
/* PD_OK, or why the directory or files in it could not be made, as far as that is known without trying. */
PDI_FN pd_status pdi_file_can_make(pd_ctx *ctx, const char *path);
/* Read a whole plain file of at most `limit` bytes. data gets size + 1 bytes, the last one 0, so that text can be
 * parsed in place; free with PDI_DELETE(ctx, size + 1, data). PD_ERR_FILE: missing, unreadable, a folder, pipe or
 * device, larger than the limit. */
PDI_FN pd_status pdi_file_read(pd_ctx *ctx, const char *path, size_t limit, char **data, size_t *size);

/* Make `<path>.part` anew; nothing under the final name changes before the commit. */
PDI_FN pd_status pdi_file_create(pd_ctx *ctx, const char *path, pd_file *file);
/* Open an existing file and write behind its end. PD_ERR_FILE: it is no plain file, or one that a link leads to. */
PDI_FN pd_status pdi_file_append(pd_ctx *ctx, const char *path, pd_file *file);
/* The same with the first `length` bytes of an existing file, which end a line; what stands behind them is cut off.
 * PD_ERR_FILE: it is shorter, or another one. */
PDI_FN pd_status pdi_file_resume(pd_ctx *ctx, const char *path, int64_t length, pd_file *file);
/* Bytes of a file that is appended to. */
PDI_FN pd_status pdi_file_length(pd_ctx *ctx, pd_file *file, int64_t *length);
/* Open a file to read it piece by piece; pdi_file_abandon closes it. */
PDI_FN pd_status pdi_file_open(pd_ctx *ctx, const char *path, pd_file *file);
/* Read `size` bytes; *got is less at the end of the file only. */
PDI_FN pd_status pdi_file_get(pd_ctx *ctx, pd_file *file, void *data, size_t size, size_t *got);
/* Remove a file, and one that was being written aside under that name; either may be missing. */
PDI_FN void pdi_file_remove(const char *path);
/* Short writes are errors. */
PDI_FN pd_status pdi_file_write(pd_ctx *ctx, pd_file *file, const void *data, size_t size);
PDI_FN pd_status pdi_file_text(pd_ctx *ctx, pd_file *file, const char *text);
PDI_FN pd_status pdi_file_flush(pd_ctx *ctx, pd_file *file);
/* Close; a file written aside takes its final name. On failure the aside is removed and the old file stays. */
PDI_FN pd_status pdi_file_commit(pd_ctx *ctx, pd_file *file);
/* Close and remove what was written aside. Allowed on a closed or zeroed file. */
PDI_FN void pdi_file_abandon(pd_file *file);

#define PDI_NUMBER_SIZE 40 /* [byte] of a number as text with its end */
/* The shortest decimal text that reads back as the same bits ("0.1", "1e-09", "nan"), whatever the locale. */
PDI_FN void pdi_file_number(double value, char *text);
/* The reverse: the whole of text[0..length) must be one number. Returns 1 when it is. */
PDI_FN int pdi_file_parse(const char *text, size_t length, double *value);
#endif

#endif
