/* folder: the folder of a run: which files are its own, and that no other run writes there.
 *
 * The list of the files, PD_FOLDER_LIST, holds the name of the run and a line for each file, written before the file
 * appears. The next run of that name removes them, so that frames of two runs never stand side by side; files that no
 * list names stay. A folder with the list of another run is refused.
 *
 * The lock, PD_FOLDER_LOCK, is held by the operating system and goes with the process, whatever ends it. Where there
 * are no such locks, a file that exists is one, and the message says which to remove.
 */
#ifndef PD_FOLDER_H
#define PD_FOLDER_H
#include "core/archive.h"
#include "io/file.h"

#define PD_FOLDER_LIST "pdcorr.files"
#define PD_FOLDER_LOCK "pdcorr.lock"
#define PD_FOLDER_SCRIPT "open_in_paraview.py" /* see paraview.h */

/* Zero-initialise. */
typedef struct pd_folder {
    char path[PD_PATH_SIZE];
    char run[PD_PATH_SIZE]; /* name of the run */
    pd_file list;
    int64_t length;         /* [byte] of the list when the checkpoint was made that a run goes on from */
    int held;               /* the lock is ours: */
    int lock;               /* its descriptor */
    int removed;            /* files of the former run that went */
} pd_folder;

#ifdef PDI_INTERNAL
/* Make the folder, lock it, remove the files of the former run, begin the list. PD_ERR_STATE: another run is at work
 * there, or what stands in the place of its lock is none. PD_ERR_ARGUMENT: it holds the files of a run of another
 * name. */
PDI_FN pd_status pdi_folder_open(pd_ctx *ctx, const char *path, const char *run, pd_folder *folder);
/* What pdi_folder_open would refuse; writes nothing. */
PDI_FN pd_status pdi_folder_check(pd_ctx *ctx, const char *path, const char *run);
/* Lock a folder, if it is there, whose run goes on. */
PDI_FN pd_status pdi_folder_lock(pd_ctx *ctx, const char *path, const char *run, pd_folder *folder);
/* path[PD_PATH_SIZE] of a file that is about to be written, and its line in the list. */
PDI_FN pd_status pdi_folder_add(pd_ctx *ctx, pd_folder *folder, const char *name, char *path);
/* Note the length of the list, or read it back. */
PDI_FN pd_status pdi_folder_store(pd_ctx *ctx, pd_folder *folder, pd_archive *archive);
/* Then go on with the list: files behind that length are removed, since the run writes them again. */
PDI_FN pd_status pdi_folder_resume(pd_ctx *ctx, pd_folder *folder);
/* Give the lock back. Allowed on a zeroed folder, and twice. */
PDI_FN void pdi_folder_close(pd_folder *folder);
#endif

#endif
