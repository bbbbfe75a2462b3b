/* vti: fields on the lattice as VTK ImageData (XML, raw appended data) and time series as a PVD collection, for
 * ParaView and VTK.
 *
 * Nodes are cell centres, so fields are cell data: the origin is the low corner of the box, the extent 0..n. Missing
 * dimensions are one cell thick. Ghosts are not written. The first scalar and the first vector are the active ones.
 * Numbers have the byte order of the machine, and the file says which.
 */
#ifndef PD_VTI_H
#define PD_VTI_H
#include "core/base.h"
#include "core/archive.h"
#include "lattice/grid.h"
#include "io/file.h"

/* How a field is stored in the file. In memory both floating types are arrays of double. */
typedef enum pd_vti_type {
    PD_VTI_FLOAT64 = 0,
    PD_VTI_FLOAT32 = 1, /* half the size; magnitudes beyond float become infinite */
    PD_VTI_UINT8 = 2,   /* uint8_t in memory */
    PD_VTI_INT32 = 3    /* int32_t in memory */
} pd_vti_type;

/* Zero-initialise. */
typedef struct pd_vti_field {
    const char *name; /* "C" */
    pd_vti_type type;
    int vector;       /* 0: a scalar, data[node]; 1: PD_DIM components, data[d * total + node], padded to 3 by zeros */
    const void *data; /* over the padded lattice: total or PD_DIM * total elements */
    const char *unit; /* "mol/m3", which VTK knows as UNITS_LABEL; NULL: none */
    const char *const *codes; /* [code_count] what the values 0, 1, ... mean: the list NAME_names of the field data;
                               * NULL: none */
    int code_count;
} pd_vti_field;

/* A time series of files. Zero-initialise. */
typedef struct pd_pvd {
    char path[PD_PATH_SIZE];
    char *entries;   /* the lines so far */
    size_t size, capacity;
    double last;     /* [s] time of the last entry */
    int count;
} pd_pvd;

#define pd_vti_write PD_NAME(pd_vti_write)

/* Write `count` fields of the box at time [s], aside and renamed. PD_ERR_ARGUMENT: a field without name or data, two
 * of one name, time not finite; PD_ERR_FILE. */
PD_API pd_status pd_vti_write(pd_ctx *ctx, const char *path, const pd_grid *grid, double time,
                              const pd_vti_field *fields, int count);

#ifdef PDI_INTERNAL
/* Start an empty collection; the file appears with the first entry. */
PDI_FN pd_status pdi_pvd_init(pd_ctx *ctx, const char *path, pd_pvd *pvd);
/* Add a file at time [s] and rewrite the collection aside. Times must increase: PD_ERR_ARGUMENT. A file in the
 * directory of the collection is listed by its name alone, so that the directory can be moved. */
PDI_FN pd_status pdi_pvd_add(pd_ctx *ctx, pd_pvd *pvd, double time, const char *file);
PDI_FN void pdi_pvd_free(pd_ctx *ctx, pd_pvd *pvd);
/* The entries of a collection, into an empty one. */
PDI_FN pd_status pdi_pvd_store(pd_ctx *ctx, pd_pvd *pvd, pd_archive *archive);
#endif

#endif
