/* input_files: paths of input files that a scene names (tables, masks, surfaces), errors while reading them, and the
 * output folder. */
#ifndef PD_INPUT_FILES_H
#define PD_INPUT_FILES_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Path of the input file under `key` into path[PD_PATH_SIZE]: absolute, or relative to `folder`, the folder of the
 * scene with a '/' at its end. PD_ERR_PARSE: no such key; PD_ERR_ARGUMENT: too long. */
PDI_FN pd_status pdi_input_files_get_path(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *folder,
                                          char *path);
/* Prefix the message of a failed call with "file:line: key", since the value of that key caused it. Returns
 * PD_ERR_ARGUMENT, or the status of the call where that is fatal (out of memory, cancelled). */
PDI_FN pd_status pdi_input_files_fail(pd_ctx *ctx, const pd_text *text, int section, const char *key);
/* Read the output folder from a key into setup->folder, by default output/NAME of the setup, or output where NAME gives
 * no path below it. PD_ERR_ARGUMENT with file:line: it is absolute, has a part '..' or a ':', or is too long. */
PDI_FN pd_status pdi_input_files_read_output_folder(pd_ctx *ctx, pd_text *text, int section, const char *key,
                                                    pd_setup *setup);
/* Split a path at its last / or \: file name without its last ending into name[PD_SETUP_NAME], cut to fit, with _ for
 * blanks, tabs and =; and its folder with that separator at the end, when `folder` is not NULL, into
 * folder[PD_PATH_SIZE] ("": none, or too long). A dot that begins the file name begins no ending. */
PDI_FN void pdi_input_files_split_path(const char *path, char *name, char *folder);
#endif

#endif
