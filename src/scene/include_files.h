/* include_files: merges the files of species, reactions and minerals that a scene includes into its text. */
#ifndef PD_INCLUDE_FILES_H
#define PD_INCLUDE_FILES_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
/* Read the files listed under `include` of [chemistry], relative to the folder of `text`, and those that they include,
 * each once, and add their pairs to text; without that key do nothing. A pair of a file at a smaller nesting depth has
 * priority. PD_ERR_PARSE with file:line: a file is missing, includes itself or cannot be parsed, it has other sections
 * than [chemistry], [species], [reaction] and [mineral], or two files at the same depth give a pair. */
PDI_FN pd_status pdi_include_files_read(pd_ctx *ctx, pd_text *text);
#endif

#endif
