/* reader: state shared by the readers of scene sections (text, setup to fill, constants). */
#ifndef PD_READER_H
#define PD_READER_H
#include "setup/setup.h"
#include "scene/key_value.h"
#include "scene/read_constants.h"

#ifdef PDI_APP_INTERNAL
/* Context of a section reader. named: constants that expressions know by name. */
typedef struct pdi_reader {
    pd_ctx *ctx;
    pd_text *text;
    pd_setup *setup;
    pdi_read_constants_table constants;
} pdi_reader;

/* 1: a and b differ by at most 1e-12 of the larger magnitude, the rounding of unit conversions. */
PDI_FN int pdi_reader_is_equal(double a, double b);
/* Read the key `initial` of a section, a concentration [mol/m3] as an expression in x, y, z (default 0), into
 * setup->initial_c, for pd_setup_free. PD_ERR_ARGUMENT: it is constant and out of the bounds of the key. An expression
 * is not checked here. */
PDI_FN pd_status pdi_reader_read_initial(pdi_reader *reader, int section);
/* Name of the section of dissolution: "corrode" or "dissolve". */
PDI_FN const char *pdi_reader_get_dissolution_name(const pd_setup *setup);
/* Its section of metal m in the text: the one with its label if that has the key (NULL: if it is present), else the one
 * without label, which is created empty where it is missing. */
PDI_FN int pdi_reader_find_dissolution(pdi_reader *reader, int m, const char *key);
/* Key of the rate law in such a section: "current" or "law" where it has one of them, else "rate". */
PDI_FN const char *pdi_reader_get_rate_key(pdi_reader *reader, int section);
#endif

#endif
