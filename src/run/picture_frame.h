/* picture_frame: what a picture shows at one output time: values and paint of the cells of the drawn plane, or the
 * rendered surface; displacements, bonds and velocities; the range of all frames of a field so far. Frames are written
 * to a file and read back.
 */
#ifndef PD_PICTURE_FRAME_H
#define PD_PICTURE_FRAME_H
#include "io/deformed_plot.h"
#include "io/output_folder.h"
#include "run/surface_view.h"
#include "setup/fields.h"

#define PD_PICTURES_SURFACE PD_FIELD_COUNT /* in place of a field: the surface of the metal */
#define PD_PICTURES_COUNT (PD_FIELD_COUNT + 1)

/* Colour range and extent of all frames of a field so far. */
typedef struct pd_picture_range {
    double min, max;                     /* [unit of the field] smallest and largest value; lo > hi: none */
    double extent_min[2], extent_max[2]; /* [m] extent of deformed metal; low > high: none */
    double max_speed;                    /* [m/s] largest speed in the plane */
} pd_picture_range;

typedef struct pd_output_pictures {
    const pd_model *model;
    pd_output_folder *folder;
    int right, up, mirrored_rows; /* axes of the drawn plane; rows below the axis of an axisymmetric scene */
    int nx, ny;
    int64_t cells;
    double *cell;   /* [cells] [unit of the field] */
    uint8_t *paint; /* [cells] pd_paint */
    /* [2][cells] [m] displacements as they are drawn, NaN: none; NULL: nothing is moved */
    double *displacement;
    uint8_t *bonded;           /* [cells] bit k: the cell and its neighbour k hold together */
    double *velocity;          /* [2][cells] [m/s] along right and up, NaN: nothing flows; NULL: none is drawn */
    double *sorted;            /* [unit of the field] values of a frame, for percentiles; NULL: all of them count */
    pd_rendering surface_view; /* the surface of the metal, in 3D */
    pd_picture_range view[PD_PICTURES_COUNT];
    int64_t frames;     /* so far */
    int64_t last;       /* number of the last frame */
    int updates_latest; /* 1: the last picture of each field is there under a name of its own, too */
    pd_fields latest;   /* those of which a picture stands in the list of the folder */
    int stores_frames;  /* 1: frames are kept, in: */
    pd_file frame_file;
    int64_t frame_file_bytes; /* [byte] of it when the checkpoint was made */
} pd_output_pictures;

#ifdef PDI_APP_INTERNAL
/* 1: the metal is drawn at its displaced place in pictures of this field: the field has values in the metal, and
 * displacements are drawn. */
PDI_FN int pdi_picture_frame_is_deformed(const pd_output_pictures *im, pd_field field);
/* 1: the scene asks for pictures of this field, or of the surface. */
PDI_FN int pdi_picture_frame_is_drawn(const pd_output_pictures *im, pd_field field);
/* The field that gives the colours; PD_FIELD_COUNT: none does. */
PDI_FN pd_field pdi_picture_frame_get_colour_field(const pd_output_pictures *im, pd_field field);
/* Name of the field in file names, such as "C". */
PDI_FN const char *pdi_picture_frame_get_field_name(const pd_output_pictures *im, pd_field field);
/* 1: streamlines or velocity vectors are drawn over the field. */
PDI_FN int pdi_picture_frame_has_flow_overlay(const pd_output_pictures *im, pd_field field);
/* 1: its colour scale is logarithmic. */
PDI_FN int pdi_picture_frame_is_log_scale(const pd_output_pictures *im, pd_field field);
/* Fill displacement [2][cells] [m] with the displacements of the metal along right and up times the scale of the setup,
 * NaN elsewhere, and bonded. */
PDI_FN void pdi_picture_frame_compute_displacements(pd_output_pictures *im);
/* 1: a cell and its neighbour are bonded and drawn as one piece. Callback of pdi_deformed_plot. */
PDI_FN int pdi_picture_frame_are_bonded(const void *user, int cell, int other);
/* Fill velocity[2][cells] [m/s] with the components along right and up in the drawn plane, the latter reversed in
 * mirrored rows; NaN outside the fluid. */
PDI_FN void pdi_picture_frame_compute_velocities(pd_output_pictures *im);
/* Fill cell[cells] with the values of a field, rounded to float, and paint[cells]. */
PDI_FN void pdi_picture_frame_compute_cells(pd_output_pictures *im, pd_field field);
/* 1: the colour range is known from the start: given (low < high), 0 to 1 of a fraction that is not drawn
 * logarithmically, that of kind or phase, or no field gives colours. */
PDI_FN int pdi_picture_frame_is_range_fixed(const pd_setup *setup, pd_field field);
/* Extend im->view of the field by this frame: the extent of deformed metal (described by warp) if it is drawn deformed,
 * the largest speed with streamlines or vectors, and the colour range unless it is fixed. */
PDI_FN pd_status pdi_picture_frame_update_range(pd_ctx *ctx, pd_output_pictures *im, pd_field field,
                                                const pdi_deformed_plot *warp);
/* Largest number of values that are sorted for percentiles. */
PDI_FN int64_t pdi_picture_frame_count_max_values(const pd_output_pictures *im);
/* Write or read the data of a frame that follow its header: values and paint, or the rendered surface; displacements
 * and bonds if it is deformed; velocities with streamlines or vectors; a newline at the end. */
PDI_FN pd_status pdi_picture_frame_store(pd_ctx *ctx, pd_output_pictures *im, pd_field field, pd_file *file,
                                         int reading);
/* [byte] Length of the data of a frame, without header. */
PDI_FN int64_t pdi_picture_frame_count_bytes(const pd_output_pictures *im, pd_field field);
#endif

#endif
