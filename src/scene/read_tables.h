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
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* State of the reader: the section in work and the CSV file that it names. */
typedef struct pdi_read_tables_state {
    pd_ctx *ctx;
    pd_text *text;
    int section; /* in work */
    const char *folder;
    pd_table table; /* the file of that section */
} pdi_read_tables_state;

/* Read the column that the key selects as "heading", "heading in unit" or column number from 1. values [rows]: not yet
 * converted; unit [PD_UNITS_TEXT], *scale its size in SI, *dims its dimension. fallback: default column, NULL:
 * required. bracket 1: without "in" the unit is taken from the heading, "loss [%]". PD_ERR_ARGUMENT: no such column, no
 * unit, or a field that is no number. */
PDI_FN pd_status pdi_read_tables_column(const pdi_read_tables_state *tables, const char *key, const char *fallback,
                                        int bracket, double *values, char *unit, double *scale, pd_dims *dims);
/* Read all [table NAME] sections into setup->table and setup->function, which are allocated for pd_setup_free; the
 * expressions of `text` know the functions after the last. Without such sections do nothing. folder: of the scene.
 * PD_ERR_PARSE, PD_ERR_ARGUMENT with the lines of the scene and of the table: x that does not rise, a name that is
 * taken. */
PDI_FN pd_status pdi_read_tables_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup);
#endif

#endif
