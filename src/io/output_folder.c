/* output_folder: see output_folder.h */
#include "io/output_folder.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#include <process.h>
#include <wchar.h>
#else
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#endif

#define PDI_OUTPUT_FOLDER_LIST_HEADER "# pdcorr: files of the run that is named below; its next start removes them\n"
#define PDI_OUTPUT_FOLDER_LOCK_ATTEMPTS 8 /* attempts when the lock file is deleted by another run meanwhile */
#define PDI_OUTPUT_FOLDER_LOCK_SIZE 21    /* [byte] of a lock file: a process id and a newline */

/* Result of an attempt to lock a folder. */
typedef enum pdi_output_folder_lock_state {
    PDI_OUTPUT_FOLDER_LOCK_OURS = 0, /* this run holds the lock */
    PDI_OUTPUT_FOLDER_LOCK_BUSY,     /* another run holds it */
    PDI_OUTPUT_FOLDER_LOCK_MISSING,  /* there is no lock file, or it was deleted meanwhile */
    PDI_OUTPUT_FOLDER_LOCK_FOREIGN,  /* the file is no lock file of a run */
    PDI_OUTPUT_FOLDER_LOCK_ERROR
} pdi_output_folder_lock_state;

/* ---- the lock ---- */

#if defined(_WIN32)
/* Try to lock the folder by creating the lock file at `path`. create 0: only look whether it is there (busy) or
 * missing. *lock: its descriptor, when the lock is ours. */
static pdi_output_folder_lock_state pdi_output_folder_try_lock(const char *path, int create, int *lock)
{
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    struct _stat info;
    pdi_file_to_utf16(path, wide);
    if (!create) return _wstat(wide, &info) == 0 ? PDI_OUTPUT_FOLDER_LOCK_BUSY : PDI_OUTPUT_FOLDER_LOCK_MISSING;
    *lock = _wopen(wide, _O_CREAT | _O_EXCL | _O_RDWR | _O_TEMPORARY, _S_IREAD | _S_IWRITE);
    if (*lock >= 0) return PDI_OUTPUT_FOLDER_LOCK_OURS;
    return _wstat(wide, &info) == 0 ? PDI_OUTPUT_FOLDER_LOCK_BUSY : PDI_OUTPUT_FOLDER_LOCK_ERROR;
}

/* Process id for the lock file. */
static long pdi_output_folder_process_id(void) { return (long)_getpid(); }

/* Write a text into the lock file; failures do not matter. */
static void pdi_output_folder_write_lock(int lock, const char *text)
{
    (void)_write(lock, text, (unsigned)strlen(text));
}

/* Delete the lock file while its lock is held, then release it, so that no other run loses its lock. */
static void pdi_output_folder_release_lock(const char *path, int lock)
{
    (void)path; /* deleted with its last descriptor */
    _close(lock);
}
#else
/* Lock an open lock file without waiting. Returns 1 when this run holds the lock, 0 when another run does, and -1 where
 * files cannot be locked: the system or the file system has no locks. Always 1 under WASI. */
static int pdi_output_folder_lock_file(int lock)
{
#if defined(__wasi__)
    (void)lock;
    return 1;
#elif defined(LOCK_EX)
    /* the lock belongs to the descriptor, so two runs of one process exclude each other */
    errno = 0;
    if (flock(lock, LOCK_EX | LOCK_NB) == 0) return 1;
    return errno == EWOULDBLOCK || errno == EAGAIN ? 0 : -1;
#else
    (void)lock; /* locks of fcntl belong to the process, and go when it closes the file anywhere */
    return -1;
#endif
}

/* Returns 1 when an open file is a lock file: regular, without other links, nothing in it but a process id; else 0.
 * lock: its descriptor, rewound; ours: its attributes. */
static int pdi_output_folder_is_lock(const char *path, int lock, const struct stat *ours)
{
    char text[PDI_OUTPUT_FOLDER_LOCK_SIZE + 1];
    if (!S_ISREG(ours->st_mode) || ours->st_nlink > 1 || pdi_file_is_link(path)) return 0;
    ssize_t size = read(lock, text, sizeof text);
    if (size < 0 || size > PDI_OUTPUT_FOLDER_LOCK_SIZE || (lseek)(lock, 0, SEEK_SET) != 0) return 0;
    for (ssize_t k = 0; k < size; k++)
        if (!strchr("0123456789 \n", text[k]) || !text[k]) return 0;
    return 1;
}

/* Try once to lock the lock file at `path`. create 1: create it when it is missing; 0: one that cannot be opened counts
 * as missing. Also missing: it was deleted or replaced meanwhile. Foreign: a link, or a file with anything but a
 * process id. Where files cannot be locked, one that was there is busy. *lock: its descriptor, open only when the lock
 * is ours. */
static pdi_output_folder_lock_state pdi_output_folder_try_lock(const char *path, int create, int *lock)
{
    struct stat ours, there;
    pdi_output_folder_lock_state state = PDI_OUTPUT_FOLDER_LOCK_MISSING;
    errno = 0;
    if (pdi_file_is_link(path)) return PDI_OUTPUT_FOLDER_LOCK_FOREIGN;
    *lock = open(path, O_RDWR | O_NONBLOCK);
    int created = *lock < 0;
    if (*lock < 0 && errno != ENOENT) return create ? PDI_OUTPUT_FOLDER_LOCK_ERROR : PDI_OUTPUT_FOLDER_LOCK_MISSING;
    if (*lock < 0 && !create) return PDI_OUTPUT_FOLDER_LOCK_MISSING;
    if (*lock < 0) *lock = open(path, O_RDWR | O_CREAT | O_EXCL, 0666); /* which follows no link */
    if (*lock < 0) return errno == EEXIST ? PDI_OUTPUT_FOLDER_LOCK_MISSING : PDI_OUTPUT_FOLDER_LOCK_ERROR;
    int locked = pdi_output_folder_lock_file(*lock);
    if (locked == 0) state = PDI_OUTPUT_FOLDER_LOCK_BUSY;
    else if (fstat(*lock, &ours) == 0 && stat(path, &there) == 0 && ours.st_ino == there.st_ino &&
             ours.st_dev == there.st_dev) {
        if (!pdi_output_folder_is_lock(path, *lock, &ours)) state = PDI_OUTPUT_FOLDER_LOCK_FOREIGN;
        else state = locked > 0 || created ? PDI_OUTPUT_FOLDER_LOCK_OURS : PDI_OUTPUT_FOLDER_LOCK_BUSY;
    }
    if (state != PDI_OUTPUT_FOLDER_LOCK_OURS) close(*lock);
    return state;
}

#if defined(__wasi__)
/* Process id for the lock file. */
static long pdi_output_folder_process_id(void) { return 0; } /* processes have no numbers there */
#else
/* Process id for the lock file. */
static long pdi_output_folder_process_id(void) { return (long)getpid(); }
#endif

/* Write a text into the lock file; failures do not matter. */
static void pdi_output_folder_write_lock(int lock, const char *text)
{
    ssize_t written = write(lock, text, strlen(text));
    (void)written; /* the process id serves messages only */
}

/* Delete the lock file while its lock is held, then release it, so that no other run loses its lock. */
static void pdi_output_folder_release_lock(const char *path, int lock)
{
    remove(path);
    close(lock);
}
#endif

/* Report that another run holds the lock, with the process id from the lock file `lock` (0: none), as PD_ERR_STATE. */
static pd_status pdi_output_folder_fail_in_use(pd_ctx *ctx, const char *folder, const char *lock)
{
    char number[24] = "";
    pd_file file;
    if (pdi_file_open_read(ctx, lock, &file) == PD_OK && !fgets(number, sizeof number, (FILE *)file.stream))
        number[0] = '\0';
    pdi_file_abandon(&file);
    return pd_fail(ctx, PD_ERR_STATE, "folder",
                   "another run (process %.0f) writes into '%.200s', expected a folder of its own: wait for it or "
                   "choose another folder; if none runs, remove '%.200s'", strtod(number, NULL), folder, lock);
}

/* Report that the file in place of the lock is none, as PD_ERR_STATE. */
static pd_status pdi_output_folder_fail_not_lock(pd_ctx *ctx, const char *lock)
{
    return pd_fail(ctx, PD_ERR_STATE, "folder",
                   "'%.300s' is a link or holds something else, expected the lock of a run or none: remove it", lock);
}

/* Lock the folder, note that in it, and write the process id into the lock file. PD_ERR_STATE: another run holds the
 * lock, the lock file is none, or it keeps vanishing (8 attempts). PD_ERR_FILE: it cannot be created; PD_ERR_SIZE. */
static pd_status pdi_output_folder_acquire_lock(pd_ctx *ctx, pd_output_folder *f)
{
    char path[PD_PATH_SIZE], number[32];
    pdi_output_folder_lock_state state = PDI_OUTPUT_FOLDER_LOCK_MISSING;
    PD_TRY(pd_file_join(ctx, f->path, PD_OUTPUT_FOLDER_LOCK, path));
    for (int k = 0; k < PDI_OUTPUT_FOLDER_LOCK_ATTEMPTS && state == PDI_OUTPUT_FOLDER_LOCK_MISSING; k++)
        state = pdi_output_folder_try_lock(path, 1, &f->lock_descriptor);
    if (state == PDI_OUTPUT_FOLDER_LOCK_ERROR)
        return pd_fail(ctx, PD_ERR_FILE, "folder", "cannot create '%.300s': %s", path, strerror(errno));
    if (state == PDI_OUTPUT_FOLDER_LOCK_FOREIGN) return pdi_output_folder_fail_not_lock(ctx, path);
    if (state != PDI_OUTPUT_FOLDER_LOCK_OURS) return pdi_output_folder_fail_in_use(ctx, f->path, path);
    f->lock_held = 1;
    /* over that of a run that was killed */
    snprintf(number, sizeof number, "%-20ld\n", pdi_output_folder_process_id());
    pdi_output_folder_write_lock(f->lock_descriptor, number);
    return PD_OK;
}

/* ---- the list ---- */

/* Returns 1 for a name that a run may write: the ParaView script, or a name without '/', '\\' and ':' that ends in
 * .csv, .png, .svg, .vti, .pvd or .bin (lower case) behind at least one character; else 0. */
static int pdi_output_folder_is_output_name(const char *name)
{
    static const char *const ends[] = {".csv", ".png", ".svg", ".vti", ".pvd", ".bin"};
    size_t length = strlen(name);
    if (strcmp(name, PD_OUTPUT_FOLDER_SCRIPT) == 0) return 1;
    if (length < 5 || length >= PD_PATH_SIZE - 8 || strpbrk(name, "/\\:")) return 0;
    for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++)
        if (strcmp(name + length - 4, ends[k]) == 0) return 1;
    return 0;
}

/* Read one line without its newline, line[PD_PATH_SIZE]. Returns 0 at the end of the file. A line that is too long or
 * cut off is empty. */
static int pdi_output_folder_read_line(pd_file *file, char *line)
{
    if (!fgets(line, PD_PATH_SIZE, (FILE *)file->stream)) return 0;
    size_t length = strlen(line);
    line[length && line[length - 1] == '\n' ? length - 1 : 0] = '\0';
    return 1;
}

/* Open the list of files and read the name of its run, run_name[PD_PATH_SIZE]; the file stays open behind that line.
 * *found 0: there is no list, and no open file. PD_ERR_FILE: it is not a list of a run. */
static pd_status pdi_output_folder_open_list(pd_ctx *ctx, const char *folder, pd_file *file, char *run_name, int *found)
{
    char path[PD_PATH_SIZE], line[PD_PATH_SIZE];
    PD_TRY(pd_file_join(ctx, folder, PD_OUTPUT_FOLDER_LIST, path));
    *found = pdi_file_exists(path);
    memset(file, 0, sizeof *file);
    if (!*found) return PD_OK;
    PD_TRY(pdi_file_open_read(ctx, path, file));
    int head = pdi_output_folder_read_line(file, line) &&
               strncmp(line, PDI_OUTPUT_FOLDER_LIST_HEADER, strlen(PDI_OUTPUT_FOLDER_LIST_HEADER) - 1) == 0;
    if (head && pdi_output_folder_read_line(file, line) && strncmp(line, "run ", 4) == 0) {
        memcpy(run_name, line + 4, strlen(line + 4) + 1);
        return PD_OK;
    }
    pdi_file_abandon(file);
    return pd_fail(ctx, PD_ERR_FILE, "folder", "'%.300s' is not the list of files that a run keeps: remove it", path);
}

/* Delete the files that the rest of the list names, with their temporary files, and count them in removed_count. Names
 * that a run may not write are skipped. */
static void pdi_output_folder_remove_listed(pd_ctx *ctx, pd_output_folder *f, pd_file *file)
{
    char name[PD_PATH_SIZE], path[PD_PATH_SIZE];
    while (pdi_output_folder_read_line(file, name)) {
        if (!pdi_output_folder_is_output_name(name) || pd_file_join(ctx, f->path, name, path) < 0) continue;
        f->removed_count += pdi_file_exists(path);
        pdi_file_remove(path);
    }
}

/* Check that the list belongs to this run: PD_ERR_ARGUMENT when its run has another name than run_name. */
static pd_status pdi_output_folder_check_run_name(pd_ctx *ctx, const char *folder, const char *run_name,
                                                  const char *found_name)
{
    if (strcmp(run_name, found_name) == 0) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "folder",
                   "'%.200s' holds the files of the run '%.80s', expected those of '%.80s' or none: choose another "
                   "folder, or remove '%.200s'", folder, found_name, run_name, folder);
}

/* Delete the files of the previous run, write a new list and leave it open to append; without an old list nothing is
 * deleted. PD_ERR_ARGUMENT: that of a run of another name, and nothing is deleted; PD_ERR_FILE. */
static pd_status pdi_output_folder_begin_list(pd_ctx *ctx, pd_output_folder *f)
{
    char path[PD_PATH_SIZE], found[PD_PATH_SIZE];
    pd_file former;
    int listed;
    PD_TRY(pdi_output_folder_open_list(ctx, f->path, &former, found, &listed));
    pd_status status = listed ? pdi_output_folder_check_run_name(ctx, f->path, f->run_name, found) : PD_OK;
    if (listed && status == PD_OK) pdi_output_folder_remove_listed(ctx, f, &former);
    pdi_file_abandon(&former);
    PD_TRY(status);
    PD_TRY(pd_file_join(ctx, f->path, PD_OUTPUT_FOLDER_LIST, path));
    PD_TRY(pdi_file_create(ctx, path, &f->list));
    status = pdi_file_write_text(ctx, &f->list, PDI_OUTPUT_FOLDER_LIST_HEADER "run ");
    if (status == PD_OK) status = pdi_file_write_text(ctx, &f->list, f->run_name);
    if (status == PD_OK) status = pdi_file_write_text(ctx, &f->list, "\n");
    if (status == PD_OK) status = pdi_file_commit(ctx, &f->list);
    else pdi_file_abandon(&f->list);
    return status == PD_OK ? pdi_file_open_append(ctx, path, &f->list) : status;
}

/* ---- open, add, close ---- */

/* Zero the folder and set path and name; newlines in the name become underscores. PD_ERR_SIZE. */
static pd_status pdi_output_folder_init(pd_ctx *ctx, const char *path, const char *run_name, pd_output_folder *f)
{
    memset(f, 0, sizeof *f);
    if (strlen(path) >= PD_PATH_SIZE || strlen(run_name) >= PD_PATH_SIZE - 8)
        return pd_fail(ctx, PD_ERR_SIZE, "folder", "the path '%.60s...' is too long", path);
    memcpy(f->path, path, strlen(path) + 1);
    memcpy(f->run_name, run_name, strlen(run_name) + 1);
    for (char *c = f->run_name; *c; c++)
        if (*c == '\n' || *c == '\r') *c = '_';
    return PD_OK;
}

PDI_FN pd_status pdi_output_folder_open(pd_ctx *ctx, const char *path, const char *run_name, pd_output_folder *f)
{
    PD_TRY(pdi_output_folder_init(ctx, path, run_name, f));
    PD_TRY(pd_file_make_directory(ctx, path));
    pd_status status = pdi_output_folder_acquire_lock(ctx, f);
    if (status == PD_OK) status = pdi_output_folder_begin_list(ctx, f);
    if (status < 0) pdi_output_folder_close(f);
    return status;
}

PDI_FN pd_status pdi_output_folder_check(pd_ctx *ctx, const char *path, const char *run_name)
{
    char found[PD_PATH_SIZE], lock[PD_PATH_SIZE];
    pd_output_folder f;
    pd_file list;
    int listed;
    PD_TRY(pdi_output_folder_init(ctx, path, run_name, &f));
    PD_TRY(pdi_file_check_writable(ctx, path));
    PD_TRY(pd_file_join(ctx, path, PD_OUTPUT_FOLDER_LOCK, lock));
    pdi_output_folder_lock_state state = pdi_output_folder_try_lock(lock, 0, &f.lock_descriptor);
    if (state == PDI_OUTPUT_FOLDER_LOCK_BUSY) return pdi_output_folder_fail_in_use(ctx, path, lock);
    if (state == PDI_OUTPUT_FOLDER_LOCK_FOREIGN) return pdi_output_folder_fail_not_lock(ctx, lock);
    /* of a run that was killed */
    if (state == PDI_OUTPUT_FOLDER_LOCK_OURS) pdi_output_folder_release_lock(lock, f.lock_descriptor);
    PD_TRY(pdi_output_folder_open_list(ctx, path, &list, found, &listed));
    pdi_file_abandon(&list);
    return listed ? pdi_output_folder_check_run_name(ctx, path, f.run_name, found) : PD_OK;
}

PDI_FN pd_status pdi_output_folder_lock_existing(pd_ctx *ctx, const char *path, const char *run_name,
                                                 pd_output_folder *f)
{
    char list[PD_PATH_SIZE];
    PD_TRY(pdi_output_folder_init(ctx, path, run_name, f));
    PD_TRY(pd_file_join(ctx, path, PD_OUTPUT_FOLDER_LIST, list));
    /* nothing to go on with: reading the checkpoint fails later, with a message */
    if (!pdi_file_exists(list)) return PD_OK;
    return pdi_output_folder_acquire_lock(ctx, f);
}

PDI_FN pd_status pdi_output_folder_add_file(pd_ctx *ctx, pd_output_folder *f, const char *name, char *path)
{
    PD_ASSERT(pdi_output_folder_is_output_name(name));
    PD_TRY(pd_file_join(ctx, f->path, name, path));
    PD_TRY(pdi_file_write_text(ctx, &f->list, name));
    PD_TRY(pdi_file_write_text(ctx, &f->list, "\n"));
    return pdi_file_flush(ctx, &f->list);
}

PDI_FN pd_status pdi_output_folder_store(pd_ctx *ctx, pd_output_folder *f, pd_archive *archive)
{
    if (!archive->is_reading) PD_TRY(pdi_file_get_length(ctx, &f->list, &f->list_length));
    return PD_ARCHIVE_ARRAY(ctx, archive, "length of the list", &f->list_length, 1);
}

PDI_FN pd_status pdi_output_folder_resume_list(pd_ctx *ctx, pd_output_folder *f)
{
    char path[PD_PATH_SIZE], found[PD_PATH_SIZE];
    pd_file former;
    int listed;
    PD_TRY(pd_file_join(ctx, f->path, PD_OUTPUT_FOLDER_LIST, path));
    PD_TRY(pdi_output_folder_open_list(ctx, f->path, &former, found, &listed));
    pd_status status = listed ? pdi_output_folder_check_run_name(ctx, f->path, f->run_name, found)
                              : pd_fail(ctx, PD_ERR_FILE, "folder",
                                        "'%.300s' is missing, expected the list of the run that goes on", path);
    /* a list that is not the one of the checkpoint is refused here, before anything is deleted */
    if (status == PD_OK) status = pdi_file_begin_resume(ctx, path, f->list_length, &f->list);
    if (status == PD_OK && fseek((FILE *)former.stream, (long)f->list_length, SEEK_SET) == 0)
        pdi_output_folder_remove_listed(ctx, f, &former);
    pdi_file_abandon(&former);
    f->removed_count = 0;
    return status == PD_OK ? pdi_file_finish_resume(ctx, &f->list) : status;
}

PDI_FN void pdi_output_folder_close(pd_output_folder *f)
{
    char path[PD_PATH_SIZE];
    pd_ctx quiet;
    pd_ctx_init(&quiet);
    pdi_file_abandon(&f->list);
    if (f->lock_held && pd_file_join(&quiet, f->path, PD_OUTPUT_FOLDER_LOCK, path) == PD_OK)
        pdi_output_folder_release_lock(path, f->lock_descriptor);
    f->lock_held = 0;
}

#undef PDI_OUTPUT_FOLDER_LIST_HEADER
#undef PDI_OUTPUT_FOLDER_LOCK_ATTEMPTS
#undef PDI_OUTPUT_FOLDER_LOCK_SIZE
