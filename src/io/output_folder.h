/* output_folder: the output folder of a run: the list of its files, and a lock against other runs.
 *
 * The list PD_OUTPUT_FOLDER_LIST holds the name of the run and one line for each file, written before the file appears.
 * The next run of that name deletes the listed files, so that frames of two runs are never mixed; other files stay. A
 * folder with the list of another run is refused.
 *
 * The lock file PD_OUTPUT_FOLDER_LOCK is locked by the operating system, which releases it when the process ends. Where
 * files cannot be locked, an existing lock file counts as locked, and the message says which file to remove. WASI alone
 * has no locks: two runs do not see each other there.
 */
#ifndef PD_OUTPUT_FOLDER_H
#define PD_OUTPUT_FOLDER_H
#include "core/archive.h"
#include "io/file.h"

#define PD_OUTPUT_FOLDER_LIST "pdcorr.files"
#define PD_OUTPUT_FOLDER_LOCK "pdcorr.lock"
#define PD_OUTPUT_FOLDER_SCRIPT "open_in_paraview.py" /* see paraview.h */

/* Zero-initialise. */
typedef struct pd_output_folder {
    char path[PD_PATH_SIZE];
    char run_name[PD_PATH_SIZE]; /* name of the run */
    pd_file list;           /* list of output files, open to append */
    int64_t list_length;    /* [byte] length of the list when the checkpoint was written */
    int lock_held;          /* 1: this run holds the lock */
    int lock_descriptor;    /* descriptor of the lock file */
    int removed_count;      /* number of deleted files of the previous run */
} pd_output_folder;

#ifdef PDI_APP_INTERNAL
/* Create and lock the output folder `path` of a run, delete the files that the list of its previous run names, and
 * begin a new list; removed_count: how many there were. On failure the folder is closed. PD_ERR_STATE: another run
 * writes there, or its lock file is none. PD_ERR_ARGUMENT: it holds the files of a run of another name. PD_ERR_FILE,
 * also where the list is none of a run; PD_ERR_SIZE: path or name too long. */
PDI_FN pd_status pdi_output_folder_open(pd_ctx *ctx, const char *path, const char *run_name, pd_output_folder *folder);
/* Check whether the folder, which may be missing, could be opened, and write nothing; a lock file that no run holds is
 * deleted. Same errors as pdi_output_folder_open. */
PDI_FN pd_status pdi_output_folder_check(pd_ctx *ctx, const char *path, const char *run_name);
/* Zero the folder, set path and name, and lock the existing output folder of a run that restarts from a checkpoint;
 * files and list stay. A folder without a list of files, or a missing one, is no error and is not locked. PD_ERR_STATE:
 * another run writes there, or its lock file is none; PD_ERR_FILE; PD_ERR_SIZE. */
PDI_FN pd_status pdi_output_folder_lock_existing(pd_ctx *ctx, const char *path, const char *run_name,
                                                 pd_output_folder *folder);
/* Enter an output file in the list and flush it, before the file is written. name: the ParaView script, or one without
 * folder and with an extension of output files. path[PD_PATH_SIZE]: its path. PD_ERR_SIZE: that is too long;
 * PD_ERR_ARGUMENT: the list is not open; PD_ERR_FILE. */
PDI_FN pd_status pdi_output_folder_add_file(pd_ctx *ctx, pd_output_folder *folder, const char *name, char *path);
/* Write the length [byte] of the list of files to the checkpoint, or read it back; folder->list_length gets it. */
PDI_FN pd_status pdi_output_folder_store(pd_ctx *ctx, pd_output_folder *folder, pd_archive *archive);
/* After a restart: delete the files that were listed after the checkpoint, cut the list to its length then, and open it
 * to append. removed_count becomes 0. PD_ERR_FILE: no list, none of a run, or no line of it ends at that length;
 * PD_ERR_ARGUMENT: that of another run. Nothing is deleted where the list is refused. */
PDI_FN pd_status pdi_output_folder_resume_list(pd_ctx *ctx, pd_output_folder *folder);
/* Close the list, delete the lock file and release the lock, where this run holds it. A zeroed folder is allowed, and
 * closing twice. */
PDI_FN void pdi_output_folder_close(pd_output_folder *folder);
#endif

#endif
