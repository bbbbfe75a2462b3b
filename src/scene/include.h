/* include: files of species and reactions that a scene names, joined with its text. */
#ifndef PD_INCLUDE_H
#define PD_INCLUDE_H
#include "scene/text.h"

#ifdef PDI_INTERNAL
/* Read the files of the key `include` of [chemistry], relative to the folder of `text`, and those that they include,
 * and add their pairs to text. A pair goes before one of the same name in a file that its own file includes.
 * PD_ERR_PARSE, PD_ERR_ARGUMENT, PD_ERR_FILE with file:line: a file is missing or includes itself, it has other
 * sections than [chemistry], [species] and [reaction], two files beside each other give one value. */
PDI_FN pd_status pdi_include_read(pd_ctx *ctx, pd_text *text);
#endif

#endif
