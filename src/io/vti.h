/* vti: writes fields of the grid as VTK ImageData (XML, raw appended data), and time series as a PVD collection, for
 * ParaView and VTK.
 *
 * Nodes are cell centres, so fields are cell data: the origin is the low corner of the box, the extent 0..n. Missing
 * dimensions are one cell thick. Ghost nodes are not written. The first scalar and the first vector are the active
 * ones. Numbers have the byte order of the machine, which the file states.
 */
#ifndef PD_VTI_H
#define PD_VTI_H
#include "core/base.h"
#include "core/archive.h"
#include "lattice/grid.h"
#include "io/file.h"

/* Number type of a field in the file. In memory both floating types are arrays of double. */
typedef enum pd_vti_type {
    PD_VTI_FLOAT64 = 0,
    PD_VTI_FLOAT32 = 1, /* half the size; magnitudes beyond float become infinite */
    PD_VTI_UINT8 = 2,   /* uint8_t in memory */
    PD_VTI_INT32 = 3    /* int32_t in memory */
} pd_vti_type;

/* A field to write. Zero-initialise. */
typedef struct pd_vti_field {
    const char *name; /* "C" */
    pd_vti_type type;
    int vector;       /* 0: a scalar, data[node]; 1: PD_DIM components, data[d * total + node], padded to 3 by zeros */
    const void *data; /* over the padded lattice: total or PD_DIM * total elements */
    const char *unit; /* "mol/m3", which VTK knows as UNITS_LABEL; NULL: none */
    const char *const *value_names; /* [code_count] names of the values 0, 1, ..., written as the array NAME_names of
                                     * the field data; NULL: none */
    int value_name_count;
} pd_vti_field;

/* A time series of files. Zero-initialise. */
typedef struct pd_pvd {
    char path[PD_PATH_SIZE];
    char *entries;   /* [capacity] XML lines of the files so far */
    size_t size, capacity; /* [byte] length of the lines, and of the buffer */
    double last_time;      /* [s] time of the last file */
    int count;       /* number of files */
} pd_pvd;

#define pd_vti_write PD_NAME(pd_vti_write)

/* Write `count` fields of the box at time [s] to a file, through a temporary one; ghost nodes are left out.
 * PD_ERR_ARGUMENT: a field without name or data, of an unknown type, or with a name that is too long or holds a control
 * character, two of one name, time not finite, an axis without cells; PD_ERR_FILE, PD_CANCELLED: an older file
 * stays. */
PD_API pd_status pd_vti_write(pd_ctx *ctx, const char *path, const pd_grid *grid, double time,
                              const pd_vti_field *fields, int count);

#ifdef PDI_APP_INTERNAL
/* Zero the collection and set its path; its file is written with the first entry. PD_ERR_ARGUMENT: no path, or too
 * long. */
PDI_FN pd_status pdi_pvd_init(pd_ctx *ctx, const char *path, pd_pvd *pvd);
/* Add a file at time [s] and rewrite the collection; on failure it is unchanged. PD_ERR_ARGUMENT: not initialised, a
 * time that is not finite or not greater than the last one, a name that is too long or holds a control character;
 * PD_ERR_FILE. A file below the folder of the collection is listed relative to that, so that the folder can be
 * moved. */
PDI_FN pd_status pdi_pvd_add_file(pd_ctx *ctx, pd_pvd *pvd, double time, const char *file);
/* Free the collection. A zeroed one is allowed. */
PDI_FN void pdi_pvd_free(pd_ctx *ctx, pd_pvd *pvd);
/* Write the entries of the collection to a checkpoint, or read them back into an empty collection that has its path;
 * the collection file is not written. */
PDI_FN pd_status pdi_pvd_store(pd_ctx *ctx, pd_pvd *pvd, pd_archive *archive);
#endif

#endif
