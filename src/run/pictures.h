/* pictures: pictures of fields and of the metal surface at output times, with one colour range and one size for
 * all frames of a field.
 *
 * A frame is drawn at once, with the range of the frames so far. Its data are stored in a file, PD_FRAMES_FILE. At the
 * end frames whose range has grown since are drawn again, and films are made. That file is not needed where all ranges
 * are given and there is no film.
 */
#ifndef PD_PICTURES_H
#define PD_PICTURES_H
#include "run/picture_frame.h"

#define PD_FRAMES_FILE "pictures.bin"

#ifdef PDI_APP_INTERNAL
/* Colour map by how the values of a field lie: labels for categories, diverging where they have both signs, else
 * sequential. */
PDI_FN pd_colour_map pdi_pictures_get_scale_map(pd_field_scale scale);
/* Zero images, prepare the pictures that the setup requests and allocate their work; model and folder are borrowed.
 * Without pictures only these are set. No file is written. On failure pdi_pictures_free. */
PDI_FN pd_status pdi_pictures_build(pd_ctx *ctx, const pd_model *model, pd_output_folder *folder,
                                    pd_output_pictures *images);
/* Create an empty file of frames for a new run, in place of an older one, enter it in the list of the folder and open
 * it to append; nothing where no frames are stored. */
PDI_FN pd_status pdi_pictures_begin_frame_file(pd_ctx *ctx, pd_output_pictures *images);
/* Store the state of the pictures in a checkpoint, or load it, cut the file of frames to its length then and open it to
 * append. PD_ERR_FILE: it is missing or shorter. */
PDI_FN pd_status pdi_pictures_store(pd_ctx *ctx, pd_output_pictures *images, pd_archive *archive);
/* Draw the pictures of all requested fields now, with the range of the frames so far and this one, and write their
 * files; call pd_sample_prepare before. frame: number of the output time. The frames are appended to their file where
 * they are stored. PD_CANCELLED: some fields are drawn, and the frame is not counted. */
PDI_FN pd_status pdi_pictures_draw_frames(pd_ctx *ctx, pd_output_pictures *images, int frame);
/* After the last frame: close the file of frames, redraw those whose colour range or extent has changed since, and make
 * films. Nothing where no frames are stored. PD_CANCELLED. */
PDI_FN pd_status pdi_pictures_finish(pd_ctx *ctx, pd_output_pictures *images);
/* Remove the file of frames, once the run is complete; nothing where none are stored, and afterwards none are. A file
 * that cannot be removed stays. PD_ERR_SIZE: its path is too long. */
PDI_FN pd_status pdi_pictures_remove_frame_file(pd_ctx *ctx, pd_output_pictures *images);
/* Close the file of frames, which stays, free all memory and zero images. Zeroed ones are allowed. */
PDI_FN void pdi_pictures_free(pd_ctx *ctx, pd_output_pictures *images);
#endif

#endif
