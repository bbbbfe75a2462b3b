/* read_tables: reads the [table NAME] sections of a scene: functions through the points of CSV files, for all
 * expressions behind them.
 *
 *   [table iC]  file = crevice.csv  x = C_mol_per_L in mol/L  y = i_A_per_m2 in A/m2  outside = hold|error
 *
 * declares iC(C). A column goes by its name in the heading or, where a scene cannot write that, by its number from 1.
 */
#ifndef PD_READ_TABLES_H
#define PD_READ_TABLES_H
#include "io/csv.h"
#include "scene/text.h"
#include "scene/setup.h"

#ifdef PDI_INTERNAL
/* A section that names a file, and the table in it. */
typedef struct pdi_read_tables {
    pd_ctx *ctx;
    pd_text *text;
    int section; /* in work */
    const char *folder;
    pd_table table; /* the file of that section */
} pdi_read_tables;

/* The column that stands under `key` as "heading" or "heading in unit": values [rows], as they stand, the text of their
 * unit [PD_UNITS_TEXT], its size and dimension. A number is a column counted from 1. fallback: NULL, or what a missing
 * key means. bracket: without "in" the unit stands in the heading, "loss [%]". */
PDI_FN pd_status pdi_read_tables_column(const pdi_read_tables *tables, const char *key, const char *fallback,
                                        int bracket, double *values, char *unit, double *scale, pd_dims *dims);
/* The tables go to `setup`, and `text` knows them from then on. folder: of the scene. Errors name the line of the scene
 * and that of the table: PD_ERR_PARSE, PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_read_tables_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup);
#endif

#endif
