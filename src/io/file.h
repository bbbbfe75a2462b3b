/* file: reads whole files up to a size limit, writes files through a temporary one, appends lines, makes directories,
 * formats and parses numbers.
 *
 * A file under its final name is always complete: a writer fills the temporary file `<path>.part` and renames it at
 * the end. A log that must be readable during the run (diagnostics.csv) gets its header that way and is then reopened
 * for appending. Every row is one write followed by a flush, so a killed program loses at most one row. (C99 cannot
 * flush the disk cache: power failures are not covered.) After a restart a log goes on from the length that the
 * checkpoint stored.
 *
 * Only regular files are read: pipes and devices have no end. Nothing is written through a symbolic link: the
 * temporary file is created anew, a link of its name is removed, and renaming replaces a link.
 */
#ifndef PD_FILE_H
#define PD_FILE_H
#include "core/base.h"

/* An open file, for writing or reading. Zero it, or let a function that opens a file fill it. */
typedef struct pd_file {
    void *stream;                    /* FILE, NULL: closed */
    char path[PD_PATH_SIZE];         /* final name */
    /* name of the temporary file; empty: the file itself is read or appended to */
    char temporary_path[PD_PATH_SIZE + 8];
} pd_file;

#define pd_file_make_directory PD_NAME(pd_file_make_directory)
#define pd_file_join PD_NAME(pd_file_join)

/* Create a directory and its missing parents; an existing directory is no error. PD_ERR_FILE: it cannot be made (a
 * failure at a parent shows only so); PD_ERR_ARGUMENT: no path; PD_ERR_SIZE: a path too long. */
PD_API pd_status pd_file_make_directory(pd_ctx *ctx, const char *path);
/* Join a directory and a file name: path[PD_PATH_SIZE] = "directory/name", without a second separator where the
 * directory ends in one. An empty directory gives the name. PD_ERR_SIZE when it does not fit; path is empty then. */
PD_API pd_status pd_file_join(pd_ctx *ctx, const char *directory, const char *name, char *path);
#ifdef PDI_APP_INTERNAL
/* Paths are UTF-8, separated by '/' and on Windows also by '\\', there also with drive letters. */
/* Returns 1 when the path exists; links are followed. */
PDI_FN int pdi_file_exists(const char *path);
/* Returns 1 when the path is a symbolic link, valid or dangling; on Windows always 0. */
PDI_FN int pdi_file_is_link(const char *path);
/* Returns 1 for a character that separates the parts of a path. */
PDI_FN int pdi_file_is_separator(char c);
/* Returns 1 for an absolute path; on Windows also for one with a drive letter. */
PDI_FN int pdi_file_is_absolute(const char *path);
#if defined(_WIN32)
#define PDI_FILE_UTF16_SIZE (PD_PATH_SIZE + 8)
/* Convert a UTF-8 path to UTF-16, wide[PDI_FILE_UTF16_SIZE], for the functions of Windows. Returns wide; it is empty
 * when the path is no UTF-8. */
PDI_FN const wchar_t *pdi_file_to_utf16(const char *path, wchar_t *wide);
#endif
/* Name of output frame `frame` (0..999999) at time [s] in 0..1e18, into name[PD_PATH_SIZE]: prefix "corr", frame 12,
 * time 6.1 and extension "vti" give "corr_000012_t6.1s.vti". The time has as few decimals, one to six, as give it to
 * 1e-9 of itself. PD_ERR_ARGUMENT: frame or time out of range; PD_ERR_SIZE: the name is too long. The name is empty on
 * failure. */
PDI_FN pd_status pdi_file_format_frame_name(pd_ctx *ctx, const char *prefix, int frame, double time,
                                            const char *extension, char *name);

/* Returns 1 for a relative path that stays inside its folder: not absolute, no ':', no part '..'. '\\' separates
 * everywhere. An empty path counts as one. */
PDI_FN int pdi_file_is_subpath(const char *path);
/* Check, without writing, whether a directory and files in it could be created: whether access rights allow to write
 * into it, or into the nearest parent that exists. PD_ERR_FILE with the reason: they do not, or a part of the path is
 * no directory; PD_ERR_ARGUMENT: no path; PD_ERR_SIZE: a path too long. */
PDI_FN pd_status pdi_file_check_writable(pd_ctx *ctx, const char *path);
/* Read a whole regular file of at most `limit` bytes into new memory. data gets size + 1 bytes, the last one 0, so that
 * text can be parsed in place; free with PD_DELETE(ctx, size + 1, data). On failure it is NULL and size 0. PD_ERR_FILE:
 * missing, unreadable, a folder, pipe or device, larger than the limit. PD_ERR_ARGUMENT: no path; PD_ERR_SIZE: a path
 * too long. */
PDI_FN pd_status pdi_file_read_all(pd_ctx *ctx, const char *path, size_t limit, char **data, size_t *size);

/* Open a new temporary file `<path>.part` for writing; an old one, or a link of that name, is removed. The final name
 * stays unchanged until the file is committed. PD_ERR_FILE: it cannot be created; PD_ERR_ARGUMENT: no path;
 * PD_ERR_SIZE: a path too long. On failure there is nothing to close. */
PDI_FN pd_status pdi_file_create(pd_ctx *ctx, const char *path, pd_file *file);
/* Open an existing regular file itself to append to it. PD_ERR_FILE: it is missing, no regular file, or reached through
 * a symbolic or hard link (Windows checks none of these, and creates a missing file); PD_ERR_ARGUMENT, PD_ERR_SIZE as
 * of pdi_file_create. On failure there is nothing to close. */
PDI_FN pd_status pdi_file_open_append(pd_ctx *ctx, const char *path, pd_file *file);
/* Truncate an existing file to its first `length` bytes, which must end a line (0 is allowed), by a copy that replaces
 * it, and open it to append. PD_ERR_FILE: it is shorter, or no line ends there; it stays as it is then. */
PDI_FN pd_status pdi_file_resume(pd_ctx *ctx, const char *path, int64_t length, pd_file *file);
/* The same in two parts. The first one writes the copy, with all these errors but those of the last step; the file
 * stays as it is, and abandoning deletes the copy. The second one puts the copy in its place and opens it to append. */
PDI_FN pd_status pdi_file_begin_resume(pd_ctx *ctx, const char *path, int64_t length, pd_file *file);
PDI_FN pd_status pdi_file_finish_resume(pd_ctx *ctx, pd_file *file);
/* Flush a file that is open to append and move to its end; *length: its current length [byte]. PD_ERR_ARGUMENT: it is
 * not open; PD_ERR_FILE, also where the length does not fit a long. */
PDI_FN pd_status pdi_file_get_length(pd_ctx *ctx, pd_file *file, int64_t *length);
/* Open a regular file to read it in parts; abandoning it closes it. PD_ERR_FILE: missing, unreadable, a folder, pipe or
 * device; there is nothing to close then. PD_ERR_ARGUMENT, PD_ERR_SIZE as of pdi_file_create. */
PDI_FN pd_status pdi_file_open_read(pd_ctx *ctx, const char *path, pd_file *file);
/* Read up to `size` bytes of an open file and advance; *got is the number read, less than `size` at the end of the file
 * only, which is no error. PD_ERR_FILE: a read error. */
PDI_FN pd_status pdi_file_read_bytes(pd_ctx *ctx, pd_file *file, void *data, size_t size, size_t *got);
/* Delete a file and its temporary file `<path>.part`; either may be missing. */
PDI_FN void pdi_file_remove(const char *path);
/* Write `size` bytes; a short write is PD_ERR_FILE. PD_ERR_ARGUMENT: the file is not open. */
PDI_FN pd_status pdi_file_write(pd_ctx *ctx, pd_file *file, const void *data, size_t size);
/* Write a string without its terminating 0. */
PDI_FN pd_status pdi_file_write_text(pd_ctx *ctx, pd_file *file, const char *text);
/* Flush the buffer of the C library. PD_ERR_ARGUMENT: the file is not open; PD_ERR_FILE. */
PDI_FN pd_status pdi_file_flush(pd_ctx *ctx, pd_file *file);
/* Close a file that was written or appended to, and rename a temporary one to its final name. PD_ERR_FILE, also where
 * an earlier write failed: the temporary file is removed and the old file stays. PD_ERR_ARGUMENT: it is not open. It is
 * closed in any case. */
PDI_FN pd_status pdi_file_commit(pd_ctx *ctx, pd_file *file);
/* Close a file and delete its temporary file. A closed or zeroed file is allowed. */
PDI_FN void pdi_file_abandon(pd_file *file);

#define PDI_FILE_NUMBER_SIZE 40 /* [byte] of a number as text with its end */
/* Format a number as decimal text, text[PDI_FILE_NUMBER_SIZE], with the fewest of 15 to 17 digits that read back as the
 * same value, without zeros at its end ("0.1", "1e-09"), in any locale; else "nan", "inf", "-inf". */
PDI_FN void pdi_file_format_number(double value, char *text);
/* Length of the decimal number that text[0..length) begins with, in any locale: a sign, digits with a point, an
 * exponent. 0: there is none, as before blanks, inf and nan. */
PDI_FN size_t pdi_file_find_number_length(const char *text, size_t length);
/* Parse text[0..length) as one number, in any locale; inf and nan are numbers, a number beyond the range of double is
 * inf. Returns 1 when the whole text, of 1 to 63 bytes, is one number; else 0, and *value may have changed: for white
 * space at either end, hexadecimal digits, a comma, nan(...). */
PDI_FN int pdi_file_parse_number(const char *text, size_t length, double *value);
#endif

#endif
