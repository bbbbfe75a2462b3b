/* include_files: merges the files of species, reactions and minerals that a scene includes into its text. */
#ifndef PD_INCLUDE_FILES_H
#define PD_INCLUDE_FILES_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
/* Read the files listed under `include` of [chemistry], relative to the folder of `text`, and those that they include,
 * and add their pairs to text. A pair of the including file has priority over the same pair of the included file.
 * PD_ERR_PARSE, PD_ERR_ARGUMENT, PD_ERR_FILE with file:line: a file is missing or includes itself, it has other
 * sections than [chemistry], [species], [reaction] and [mineral], or two files of one list give the same pair. */
PDI_FN pd_status pdi_include_files_read(pd_ctx *ctx, pd_text *text);
#endif

#endif
