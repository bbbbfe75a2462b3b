/* read_electrolyte: reads an electrolyte from the sections [chemistry], [species FORMULA] and [reaction NAME] of a
 * scene, or of a file that has nothing else.
 *
 *   [chemistry]  include = electrolytes/hbss.electrolyte   activity = davies|ideal   temperature = 298.15 K
 *                pH = 7.4   inlet_pH   counter_ion = Cl-   balance_ion = Cl-   minerals = given|all
 *   [species Mg2+]    D = 0.705e-9 m2/s   initial = 0.9 mM   inlet = 0.9 mM   charge   formula
 *   [reaction water]  H+ + OH- = H2O   K = 1e14 L2/mol2 | log10_K = 14   forward = 1.4e11 L/mol/s   backward
 */
#ifndef PD_READ_ELECTROLYTE_H
#define PD_READ_ELECTROLYTE_H
#include "chemistry/electrolyte.h"
#include "scene/read_constants.h"
#include "scene/text.h"

#define pd_electrolyte_read PD_NAME(pd_electrolyte_read)
#define pd_electrolyte_parse PD_NAME(pd_electrolyte_parse)

/* Read an electrolyte from a file, apply overrides ("species.Mg2+.initial=2 mM"), include files, and make its solutions
 * neutral with the given pH (pd_electrolyte_neutralise). Names of other sections and keys are checked, their values
 * ignored. On failure it is zero. PD_ERR_FILE, PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line, what was found and what
 * was expected: also a file without species. */
PD_API pd_status pd_electrolyte_read(pd_ctx *ctx, const char *path, const char *const *overrides, int count,
                                     pd_electrolyte *electrolyte);
/* Read an electrolyte from a text, as pd_electrolyte_read does from a file; `path` is its name in messages, and
 * included files are relative to the folder of `path`. */
PD_API pd_status pd_electrolyte_parse(pd_ctx *ctx, const char *path, const char *text, const char *const *overrides,
                                      int count, pd_electrolyte *electrolyte);
#ifdef PDI_APP_INTERNAL
/* 1: the text has a section [chemistry], [species ...], [reaction ...] or [mineral ...]. All four names count as looked
 * up. */
PDI_FN int pdi_read_electrolyte_has_sections(pd_ctx *ctx, pd_text *text);
/* Read the electrolyte, which is zeroed first, from a text whose constants are declared and whose files are included.
 * Declare the temperature T as a constant. Its solutions become neutral with their pH, NaN where none is given.
 * PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line; what was read so far then stays in it. */
PDI_FN pd_status pdi_read_electrolyte_sections(pd_ctx *ctx, pd_text *text, pdi_read_constants_table *named,
                                               pd_electrolyte *electrolyte);
/* Include the files of [chemistry] into text and apply all overrides[count]. Those that begin with "chemistry.include"
 * are applied before the files are read, all others after, so that they replace pairs of included files. */
PDI_FN pd_status pdi_read_electrolyte_prepare(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count);
#endif

#endif
