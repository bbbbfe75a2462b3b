/* pictures: see pictures.h */
#include "run/pictures.h"
#include "setup/fields.h"
#include "io/apng.h"
#include "io/canvas.h"
#include "io/unit_label.h"
#include "io/plot.h"
#include "io/axis_ticks.h"
#include "io/deformed_plot.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_PICTURES_MAX_FILE_BYTES 1073741824u /* [byte] largest picture file that is copied */
#define PDI_PICTURES_FRAME_MS 100               /* [ms] between frames of a film */

/* Header of a frame in the file of frames. */
typedef struct pdi_pictures_frame_header {
    double field, frame, time; /* [-], [-], [s] */
    pd_picture_range view;     /* with which it was drawn */
} pdi_pictures_frame_header;

/* Buffers of labels. */
typedef struct pdi_pictures_labels {
    char title[PD_SETUP_NAME + PD_UNITS_TEXT + 72], time[PDI_UNIT_LABEL_SIZE];
} pdi_pictures_labels;

/* Write "t = 3 h" into the buffers; returns it. */
static const char *pdi_pictures_format_time(double time, pdi_pictures_labels *text)
{
    char value[PD_UNITS_TEXT], label[PDI_UNIT_LABEL_SIZE];
    pd_setup_format_value(time, "s", value);
    snprintf(text->time, sizeof text->time, "t = %s", pdi_unit_label_format_value(value, label));
    return text->time;
}

/* Write the title of a picture into the buffers: case and field, in 3D the place of the slice, and the magnification of
 * displacements if it is drawn deformed. Returns it. */
static const char *pdi_pictures_format_title(const pd_output_pictures *im, pd_field field, pdi_pictures_labels *text)
{
    const pd_setup *u = im->model->setup;
    char value[PD_UNITS_TEXT], place[PDI_UNIT_LABEL_SIZE];
    const char *name = pd_fields_get_name(u, field);
    if (PD_DIM < 3) snprintf(text->title, sizeof text->title, "%s: %s", u->name, name);
    else {
        pd_setup_format_value(u->slice_at, "m", value);
        snprintf(text->title, sizeof text->title, "%s: %s at %c = %.*s", u->name, name, "xyz"[u->slice_axis],
                 PD_UNITS_TEXT, pdi_unit_label_format_value(value, place));
    }
    size_t used = strlen(text->title);
    if (pdi_picture_frame_is_deformed(im, field))
        snprintf(text->title + used, sizeof text->title - used, ", displacements \xC3\x97 %g", u->displacement_scale);
    return text->title;
}

PDI_FN pd_colour_map pdi_pictures_get_scale_map(pd_field_scale scale)
{
    if (scale == PD_FIELD_SCALE_CATEGORY) return PD_COLOUR_MAP_LABELS;
    return scale == PD_FIELD_SCALE_SIGNED ? PD_COLOUR_MAP_DIVERGING : PD_COLOUR_MAP_SEQUENTIAL;
}

/* Colour map of a field: labels for categories, else the given one, else sequential on a logarithmic scale, else
 * diverging for signed fields and sequential for others. */
static pd_colour_map pdi_pictures_get_colour_map(const pd_setup *setup, pd_field field)
{
    pd_colour_map map = pdi_pictures_get_scale_map(pd_fields_get_scale(field));
    if (map == PD_COLOUR_MAP_LABELS) return map;
    if (setup->drawing.map[field]) return (pd_colour_map)(setup->drawing.map[field] - 1);
    return setup->drawing.log >> field & 1u ? PD_COLOUR_MAP_SEQUENTIAL : map;
}

/* Colour range *lo, *hi: as given if low < high; otherwise 0 to 1 where it is fixed, else that of all frames so far,
 * and either is adjusted for the map and the logarithm, with a default if there is no value. */
static void pdi_pictures_get_range(const pd_output_pictures *im, pd_field field, pd_colour_map map, double *lo,
                                   double *hi)
{
    const pd_setup *u = im->model->setup;
    pd_field of = pdi_picture_frame_get_colour_field(im, field);
    *lo = of < PD_FIELD_COUNT ? u->drawing.range[of][0] : 0.0;
    *hi = of < PD_FIELD_COUNT ? u->drawing.range[of][1] : 0.0;
    if (*lo < *hi) return;
    *lo = pdi_picture_frame_is_range_fixed(u, of) ? 0.0 : im->view[field].min;
    *hi = pdi_picture_frame_is_range_fixed(u, of) ? 1.0 : im->view[field].max;
    pdi_field_plot_adjust_range(map, pdi_picture_frame_is_log_scale(im, field), lo, hi);
}

/* Add streamlines or vectors to the picture; nothing where the field has none. side_closed: left, right, lower, upper
 * side of the picture is a wall or a mirror; with mirrored rows the lower one is as the upper one. */
static void pdi_pictures_set_flow_overlay(const pd_output_pictures *im, pd_field field, pd_field_plot *picture)
{
    const pd_grid *grid = &im->model->grid;
    if (!pdi_picture_frame_has_flow_overlay(im, field)) return;
    picture->streamlines = im->model->setup->drawing.streamlines[field];
    picture->arrows = im->model->setup->drawing.vectors[field];
    picture->velocity = im->velocity;
    picture->max_speed = im->view[field].max_speed;
    for (int k = 0; k < 4; k++) {
        pd_side side = grid->side[2 * (k < 2 ? im->right : im->up) + (k == 2 && im->mirrored_rows ? 1 : k % 2)];
        picture->side_closed[k] = side == PD_SIDE_WALL || side == PD_SIDE_MIRROR;
    }
}

/* Set legend names and colours of the fields kind and phase; for other fields none (NULL, 0). */
static void pdi_pictures_set_legend(pd_field field, pd_field_plot *picture)
{
    static const char *const kinds[] = {"outside", "fluid", "solid", "wall"};
    static const char *const phases[] = {"fluid", "solid"};
    static const uint32_t colours[] = {0xE8EAEDu, 0xC9DEF2u, 0x9A9DA1u, 0x3C4043u};
    picture->names = field == PD_FIELD_KIND ? kinds : field == PD_FIELD_PHASE ? phases : NULL;
    picture->colours = field == PD_FIELD_KIND ? colours : field == PD_FIELD_PHASE ? colours + 1 : NULL;
    picture->name_count = field == PD_FIELD_KIND ? 4 : field == PD_FIELD_PHASE ? 2 : 0;
}

/* Describe the picture of the frame in memory at `time` [s]. Arrays are those of im, texts those of `text`. Axes are x,
 * y, z, or x and r with axisymmetry. Categories have no label beside the scale, as the title names them. */
static void pdi_pictures_build_picture(const pd_output_pictures *im, pd_field field, double time,
                                       pdi_pictures_labels *text, pd_field_plot *picture)
{
    static const char *const axes[3] = {"x", "y", "z"};
    const pd_model *m = im->model;
    const pd_setup_image_options *drawing = &m->setup->drawing;
    memset(picture, 0, sizeof *picture);
    picture->nx = im->nx;
    picture->ny = im->ny;
    picture->values = im->cell;
    picture->cell_paint = im->paint;
    picture->lo[0] = m->grid.lo[im->right];
    picture->lo[1] = im->mirrored_rows ? -m->grid.hi[im->up] : m->grid.lo[im->up];
    picture->hi[0] = m->grid.hi[im->right];
    picture->hi[1] = m->grid.hi[im->up];
    picture->axes[0] = axes[im->right];
    picture->axes[1] = m->setup->axisymmetric ? "r" : axes[im->up];
    picture->mirrored = im->mirrored_rows > 0;
    picture->map = pdi_pictures_get_colour_map(m->setup, field);
    picture->log = pdi_picture_frame_is_log_scale(im, field);
    picture->smooth = drawing->smooth;
    picture->width = drawing->width;
    picture->contour_count = drawing->contours[field];
    picture->contours = drawing->has_contour_values[field] ? drawing->contour_value[field] : NULL;
    pdi_pictures_get_range(im, field, picture->map, &picture->range_lo, &picture->range_hi);
    pdi_pictures_set_flow_overlay(im, field, picture);
    pdi_pictures_set_legend(field, picture);
    picture->title = pdi_pictures_format_title(im, field, text);
    picture->stamp = pdi_pictures_format_time(time, text);
    picture->widest_stamp = "t = 000.000 min";
    /* the title names it */
    picture->label =
        pd_fields_get_scale(field) == PD_FIELD_SCALE_CATEGORY ? NULL : pd_fields_get_label(m->setup, field);
}

/* Describe the deformed picture: displacements, bonds, and the extent of all frames so far, 0 while none is known.
 * `picture` is borrowed. */
static void pdi_pictures_build_deformed(const pd_output_pictures *im, pd_field field, const pd_field_plot *picture,
                                        pdi_deformed_plot *warp)
{
    memset(warp, 0, sizeof *warp);
    warp->undeformed = picture;
    warp->displacement = im->displacement;
    warp->is_connected = pdi_picture_frame_are_bonded;
    warp->user = im;
    for (int d = 0; d < 2 && im->view[field].extent_min[0] < im->view[field].extent_max[0]; d++) {
        warp->lo[d] = im->view[field].extent_min[d];
        warp->hi[d] = im->view[field].extent_max[d];
    }
}

/* 1D: describe the plot of the field over x. x[cells] [um]: output. Values of cells that the field does not paint
 * become NaN. The range of the value axis is that of colours; unless it is given, it is widened by a margin. */
static void pdi_pictures_build_plot(pd_output_pictures *im, pd_field field, double time, pdi_pictures_labels *text,
                                    double *x, pd_plot *plot)
{
    const pd_model *m = im->model;
    pdi_axis_ticks axis;
    memset(plot, 0, sizeof *plot);
    memset(&axis, 0, sizeof axis);
    for (int k = 0; k < im->nx; k++) {
        x[k] = (m->grid.lo[0] + (k + 0.5) * m->grid.h[0]) * 1e6;
        if (im->paint[k] != PD_PAINT_FIELD) im->cell[k] = (double)NAN;
    }
    snprintf(text->title, sizeof text->title, "%s, %.60s", m->setup->name, pdi_pictures_format_time(time, text));
    plot->title = text->title;
    plot->x_label = "x [um]";
    plot->y_label = pd_fields_get_label(m->setup, field);
    plot->x_lo = m->grid.lo[0] * 1e6;
    plot->x_hi = m->grid.hi[0] * 1e6;
    plot->y_log = axis.log = pdi_picture_frame_is_log_scale(im, field);
    pdi_pictures_get_range(im, field, PD_COLOUR_MAP_SEQUENTIAL, &axis.lo, &axis.hi);
    if (!(m->setup->drawing.range[field][0] < m->setup->drawing.range[field][1]))
        pdi_axis_ticks_widen_range(0.03, &axis);
    plot->y_lo = axis.lo;
    plot->y_hi = axis.hi;
    plot->count = 1;
    plot->series[0].x = x;
    plot->series[0].y = im->cell;
    plot->series[0].count = im->nx;
}

/* 3D: draw the rendered metal surface into the image, or, where image is NULL, into the file `path`. Without a colour
 * field it has shades alone and no scale. */
static pd_status pdi_pictures_draw_surface(pd_ctx *ctx, const pd_output_pictures *im, double time, const char *path,
                                           pd_image *image)
{
    const pd_setup *u = im->model->setup;
    pd_field of = pdi_surface_view_get_colour_field(u);
    pdi_pictures_labels text;
    pdi_surface_plot relief;
    pd_field_plot labels;
    memset(&relief, 0, sizeof relief);
    relief.rendering = &im->surface_view;
    relief.use_values = of < PD_FIELD_COUNT;
    snprintf(text.title, sizeof text.title, "%s: surface%s%s", u->name, relief.use_values ? ", " : "",
             relief.use_values ? pd_fields_get_name(im->model->setup, of) : "");
    relief.title = text.title;
    relief.stamp = pdi_pictures_format_time(time, &text);
    relief.widest_stamp = "t = 000.000 min";
    if (relief.use_values) {
        relief.map = pdi_pictures_get_colour_map(u, of);
        relief.log = pdi_picture_frame_is_log_scale(im, of);
        relief.label = pd_fields_get_label(im->model->setup, of);
        pdi_pictures_set_legend(of, &labels);
        relief.names = labels.names;
        relief.colours = labels.colours;
        relief.name_count = labels.name_count;
        pdi_pictures_get_range(im, PD_PICTURES_SURFACE, relief.map, &relief.lo, &relief.hi);
    }
    return image || !path ? pdi_surface_plot_draw_image(ctx, &relief, image)
                          : pdi_surface_plot_write(ctx, path, &relief);
}

/* Draw the frame in memory into the image, which the caller frees, or, where image is NULL, into a file: the surface, a
 * plot in 1D, a deformed or a plain picture. */
static pd_status pdi_pictures_draw_frame(pd_ctx *ctx, pd_output_pictures *im, pd_field field, double time,
                                         const char *path, pd_image *image)
{
    pdi_pictures_labels text;
    pd_field_plot picture;
    pdi_deformed_plot warp;
    pd_plot plot;
    double *x = NULL;
    if (field == PD_PICTURES_SURFACE) return pdi_pictures_draw_surface(ctx, im, time, path, image);
    if (PD_DIM > 1) {
        pdi_pictures_build_picture(im, field, time, &text, &picture);
        if (!pdi_picture_frame_is_deformed(im, field))
            return image ? pd_field_plot_draw_image(ctx, &picture, image) : pd_field_plot_write(ctx, path, &picture);
        pdi_pictures_build_deformed(im, field, &picture, &warp);
        return image ? pdi_deformed_plot_draw_image(ctx, &warp, image) : pdi_deformed_plot_write(ctx, path, &warp);
    }
    PD_TRY(PD_NEW(ctx, "images", im->cells, x));
    pdi_pictures_build_plot(im, field, time, &text, x, &plot);
    pd_status status = image ? pd_plot_draw_image(ctx, &plot, image) : pd_plot_write(ctx, path, &plot);
    PD_DELETE(ctx, im->cells, x);
    return status;
}

/* Copy the file `picture` to latest_C.png through a temporary file, end: "png" or "svg"; it joins the list of the
 * folder unless im->latest has the field already. PD_ERR_FILE. */
static pd_status pdi_pictures_copy_latest(pd_ctx *ctx, pd_output_pictures *im, pd_field field, const char *end,
                                          const char *picture)
{
    char name[PD_SETUP_NAME], path[PD_PATH_SIZE], *data = NULL;
    size_t size = 0;
    pd_file file;
    snprintf(name, sizeof name, "latest_%.40s.%s", pdi_picture_frame_get_field_name(im, field), end);
    PD_TRY(im->latest >> field & 1u ? pd_file_join(ctx, im->folder->path, name, path)
                                     : pdi_output_folder_add_file(ctx, im->folder, name, path));
    PD_TRY(pdi_file_read_all(ctx, picture, PDI_PICTURES_MAX_FILE_BYTES, &data, &size));
    pd_status status = pdi_file_create(ctx, path, &file);
    if (status == PD_OK) {
        status = pdi_file_write(ctx, &file, data, size);
        if (status == PD_OK) status = pdi_file_commit(ctx, &file);
        else pdi_file_abandon(&file);
    }
    PD_DELETE(ctx, size + 1, data);
    return status;
}

/* Write the picture files of a frame in the formats asked for (PNG by default), and with updates_latest copies as the
 * latest ones if it is frame im->last. fresh: 1: add them to the list of the folder. image: the drawn frame for the
 * PNG, or NULL: it is drawn. */
static pd_status pdi_pictures_write_files(pd_ctx *ctx, pd_output_pictures *im, pd_field field, int frame, double time,
                                          int fresh, const pd_image *image)
{
    static const char *const ends[2] = {"png", "svg"};
    unsigned formats = im->model->setup->drawing.formats ? im->model->setup->drawing.formats : 1u;
    char name[PD_PATH_SIZE], path[PD_PATH_SIZE];
    for (int k = 0; k < 2; k++) {
        if (!(formats >> k & 1u)) continue;
        PD_TRY(
            pdi_file_format_frame_name(ctx, pdi_picture_frame_get_field_name(im, field), frame, time, ends[k], name));
        PD_TRY(fresh ? pdi_output_folder_add_file(ctx, im->folder, name, path)
                      : pd_file_join(ctx, im->folder->path, name, path));
        PD_TRY(image && k == 0 ? pd_png_write(ctx, path, image)
                               : pdi_pictures_draw_frame(ctx, im, field, time, path, NULL));
        if (im->updates_latest && frame == im->last) PD_TRY(pdi_pictures_copy_latest(ctx, im, field, ends[k], path));
    }
    if (im->updates_latest) im->latest |= pd_fields_bit(field);
    return PD_OK;
}

/* ---- frames in a file ---- */

/* Append a frame, with the range of the frames so far, to the file of frames and flush it. */
static pd_status pdi_pictures_append_frame(pd_ctx *ctx, pd_output_pictures *im, pd_field field, int frame)
{
    pdi_pictures_frame_header head;
    memset(&head, 0, sizeof head);
    head.field = (double)field;
    head.frame = frame;
    head.time = im->model->time_loop.time;
    head.view = im->view[field];
    PD_TRY(pdi_file_write(ctx, &im->frame_file, &head, sizeof head));
    PD_TRY(pdi_picture_frame_store(ctx, im, field, &im->frame_file, 0));
    return pdi_file_flush(ctx, &im->frame_file);
}

PDI_FN pd_status pdi_pictures_draw_frames(pd_ctx *ctx, pd_output_pictures *im, int frame)
{
    double time = im->model->time_loop.time;
    pdi_pictures_labels text;
    pd_field_plot picture;
    pdi_deformed_plot warp;
    memset(&warp, 0, sizeof warp);
    im->last = frame;
    if (im->displacement) pdi_picture_frame_compute_displacements(im);
    if (im->velocity) pdi_picture_frame_compute_velocities(im);
    for (int k = 0; k < PD_PICTURES_COUNT; k++) {
        pd_field field = (pd_field)k;
        if (!pdi_picture_frame_is_drawn(im, field)) continue;
        PD_TRY(pd_check_cancel(ctx, "pictures", k));
        if (field == PD_PICTURES_SURFACE) PD_TRY(pdi_surface_view_draw(ctx, im->model, &im->surface_view));
        else pdi_picture_frame_compute_cells(im, field);
        if (pdi_picture_frame_is_deformed(im, field)) {
            pdi_pictures_build_picture(im, field, time, &text, &picture);
            pdi_pictures_build_deformed(im, field, &picture, &warp);
        }
        PD_TRY(pdi_picture_frame_update_range(ctx, im, field, &warp));
        if (im->stores_frames) PD_TRY(pdi_pictures_append_frame(ctx, im, field, frame));
        PD_TRY(pdi_pictures_write_files(ctx, im, field, frame, time, 1, NULL));
    }
    im->frames++;
    return PD_OK;
}

/* 1: two frames have the same range and extent. */
static int pdi_pictures_is_same_view(const pd_picture_range *a, const pd_picture_range *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

/* Read the frames of a field from the file into memory. Rewrite the picture files of those whose range or extent was
 * another when they were drawn, under their names; add all to the film, if it is not NULL. A header that ends early
 * ends the frames. PD_ERR_FILE: data end early. PD_CANCELLED. */
static pd_status pdi_pictures_redraw_frames(pd_ctx *ctx, pd_output_pictures *im, pd_file *file, pd_field field,
                                            pdi_apng *film)
{
    pdi_pictures_frame_header head;
    pd_image image;
    size_t got;
    memset(&image, 0, sizeof image);
    for (;;) {
        PD_TRY(pdi_file_read_bytes(ctx, file, &head, sizeof head, &got));
        if (got < sizeof head) return PD_OK;
        pd_field of = (pd_field)(int)head.field;
        if (of != field || (!film && pdi_pictures_is_same_view(&head.view, &im->view[field]))) {
            if (fseek((FILE *)file->stream, (long)pdi_picture_frame_count_bytes(im, of), SEEK_CUR) == 0) continue;
            return pd_fail(ctx, PD_ERR_FILE, "images", "'%s' ends early", file->path);
        }
        PD_TRY(pd_check_cancel(ctx, "pictures", (int64_t)head.frame));
        PD_TRY(pdi_picture_frame_store(ctx, im, field, file, 1));
        pd_status status = film ? pdi_pictures_draw_frame(ctx, im, field, head.time, NULL, &image) : PD_OK;
        if (status == PD_OK && !pdi_pictures_is_same_view(&head.view, &im->view[field]))
            status = pdi_pictures_write_files(ctx, im, field, (int)head.frame, head.time, 0, film ? &image : NULL);
        if (status == PD_OK && film) status = pdi_apng_add_frame(ctx, film, &image);
        pd_image_free(ctx, &image);
        PD_TRY(status);
    }
}

/* Begin the animated picture C_film.png with im->frames frames; it joins the list of the folder. */
static pd_status pdi_pictures_begin_film(pd_ctx *ctx, pd_output_pictures *im, pd_field field, pdi_apng *film)
{
    char name[PD_PATH_SIZE], path[PD_PATH_SIZE];
    snprintf(name, sizeof name, "%s_film.png", pdi_picture_frame_get_field_name(im, field));
    PD_TRY(pdi_output_folder_add_file(ctx, im->folder, name, path));
    return pdi_apng_create(ctx, path, (int)im->frames, PDI_PICTURES_FRAME_MS, film);
}

/* Finish the pictures of one field from the file of frames `path`: redraw frames and, with drawing.animate, make the
 * film. On failure there is no film. */
static pd_status pdi_pictures_redraw_field(pd_ctx *ctx, pd_output_pictures *im, pd_field field, const char *path)
{
    int filmed = im->model->setup->drawing.animate;
    pd_file file;
    pdi_apng film;
    memset(&film, 0, sizeof film);
    PD_TRY(pdi_file_open_read(ctx, path, &file));
    pd_status status = filmed ? pdi_pictures_begin_film(ctx, im, field, &film) : PD_OK;
    if (status == PD_OK) status = pdi_pictures_redraw_frames(ctx, im, &file, field, filmed ? &film : NULL);
    if (status == PD_OK && filmed) status = pdi_apng_commit(ctx, &film);
    pdi_apng_abandon(&film);
    pdi_file_abandon(&file);
    return status;
}

PDI_FN pd_status pdi_pictures_finish(pd_ctx *ctx, pd_output_pictures *im)
{
    char path[PD_PATH_SIZE];
    if (!im->stores_frames) return PD_OK;
    PD_TRY(pdi_file_commit(ctx, &im->frame_file));
    PD_TRY(pd_file_join(ctx, im->folder->path, PD_FRAMES_FILE, path));
    for (int k = 0; k < PD_PICTURES_COUNT; k++)
        if (pdi_picture_frame_is_drawn(im, (pd_field)k)) PD_TRY(pdi_pictures_redraw_field(ctx, im, (pd_field)k, path));
    return PD_OK;
}

PDI_FN pd_status pdi_pictures_remove_frame_file(pd_ctx *ctx, pd_output_pictures *im)
{
    char path[PD_PATH_SIZE];
    if (!im->stores_frames) return PD_OK;
    PD_TRY(pd_file_join(ctx, im->folder->path, PD_FRAMES_FILE, path));
    im->stores_frames = 0;
    pdi_file_remove(path);
    return PD_OK;
}

/* 1: frames have to be stored: in a drawn field the colour range is not fixed, metal is drawn deformed, or vectors are
 * scaled by the largest speed. */
static int pdi_pictures_has_growing_range(const pd_output_pictures *im)
{
    for (int k = 0; k < PD_PICTURES_COUNT; k++) {
        pd_field field = (pd_field)k;
        int known = pdi_picture_frame_is_range_fixed(im->model->setup, pdi_picture_frame_get_colour_field(im, field)) &&
                    !pdi_picture_frame_is_deformed(im, field) &&
                    !(field < PD_FIELD_COUNT && im->model->setup->drawing.vectors[field]);
        if (pdi_picture_frame_is_drawn(im, field) && !known) return 1;
    }
    return 0;
}

/* Allocate the arrays that the requested pictures need: pixels of the surface; values to sort for a percentile between
 * 0 and 1; with images cell and paint, velocity for streamlines or vectors, displacement and bonds with a
 * displacement_scale > 0. On failure the caller frees. */
static pd_status pdi_pictures_allocate(pd_ctx *ctx, pd_output_pictures *im)
{
    const pd_setup *u = im->model->setup;
    if (pdi_surface_view_is_requested(u)) PD_TRY(pdi_surface_view_build(ctx, u, &im->surface_view));
    if (u->drawing.percentile > 0.0 && u->drawing.percentile < 1.0 && (u->images || pdi_surface_view_is_requested(u)))
        PD_TRY(PD_NEW(ctx, "images", pdi_picture_frame_count_max_values(im), im->sorted));
    if (!u->images) return PD_OK;
    PD_TRY(PD_NEW(ctx, "images", im->cells, im->cell));
    PD_TRY(PD_NEW(ctx, "images", im->cells, im->paint));
    for (int k = 0; k < PD_FIELD_COUNT && !im->velocity; k++)
        if (pdi_picture_frame_has_flow_overlay(im, (pd_field)k))
            PD_TRY(PD_NEW(ctx, "images", 2 * im->cells, im->velocity));
    if (!(u->displacement_scale > 0.0)) return PD_OK;
    PD_TRY(PD_NEW(ctx, "images", 2 * im->cells, im->displacement));
    return PD_NEW(ctx, "images", im->cells, im->bonded);
}

PDI_FN pd_status pdi_pictures_build(pd_ctx *ctx, const pd_model *model, pd_output_folder *folder,
                                    pd_output_pictures *im)
{
    const pd_setup *u = model->setup;
    memset(im, 0, sizeof *im);
    im->model = model;
    im->folder = folder;
    if (!u->images && !pdi_surface_view_is_requested(u)) return PD_OK;
    im->right = PD_DIM == 3 && u->slice_axis == 0 ? 1 : 0;
    im->up = PD_DIM == 3 && u->slice_axis == 2 ? 1 : PD_DIM - 1;
    /* drawn whole */
    im->mirrored_rows = u->axisymmetric && !(model->grid.lo[im->up] > 0.0) ? model->grid.n[im->up] : 0;
    im->nx = model->grid.n[im->right];
    im->ny = im->right == im->up ? 1 : model->grid.n[im->up] + im->mirrored_rows;
    im->cells = (int64_t)im->nx * im->ny;
    for (int k = 0; k < PD_PICTURES_COUNT; k++) {
        pd_picture_range *view = &im->view[k];
        view->min = view->extent_min[0] = view->extent_min[1] = HUGE_VAL;
        view->max = view->extent_max[0] = view->extent_max[1] = -HUGE_VAL;
    }
    PD_TRY(pdi_pictures_allocate(ctx, im));
    im->stores_frames = u->drawing.animate || pdi_pictures_has_growing_range(im);
    return PD_OK;
}

PDI_FN pd_status pdi_pictures_begin_frame_file(pd_ctx *ctx, pd_output_pictures *im)
{
    char path[PD_PATH_SIZE];
    if (!im->stores_frames) return PD_OK;
    PD_TRY(pdi_output_folder_add_file(ctx, im->folder, PD_FRAMES_FILE, path));
    PD_TRY(pdi_file_create(ctx, path, &im->frame_file)); /* empty, also where a file of this name stands */
    PD_TRY(pdi_file_commit(ctx, &im->frame_file));
    return pdi_file_open_append(ctx, path, &im->frame_file);
}

PDI_FN pd_status pdi_pictures_store(pd_ctx *ctx, pd_output_pictures *im, pd_archive *archive)
{
    char path[PD_PATH_SIZE];
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "views of pictures", im->view, PD_PICTURES_COUNT));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "frames of pictures", &im->frames, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "last picture", &im->last, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "listed last pictures", &im->latest, 1));
    if (im->stores_frames && !archive->is_reading)
        PD_TRY(pdi_file_get_length(ctx, &im->frame_file, &im->frame_file_bytes));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "length of pictures", &im->frame_file_bytes, 1));
    if (!im->stores_frames || !archive->is_reading) return PD_OK;
    PD_TRY(pd_file_join(ctx, im->folder->path, PD_FRAMES_FILE, path));
    return pdi_file_resume(ctx, path, im->frame_file_bytes, &im->frame_file);
}

PDI_FN void pdi_pictures_free(pd_ctx *ctx, pd_output_pictures *im)
{
    pdi_file_abandon(&im->frame_file); /* every frame has been flushed */
    PD_DELETE(ctx, im->cells, im->cell);
    PD_DELETE(ctx, im->cells, im->paint);
    PD_DELETE(ctx, 2 * im->cells, im->displacement);
    PD_DELETE(ctx, 2 * im->cells, im->velocity);
    PD_DELETE(ctx, im->cells, im->bonded);
    PD_DELETE(ctx, pdi_picture_frame_count_max_values(im), im->sorted);
    pdi_renderer_free(ctx, &im->surface_view);
    memset(im, 0, sizeof *im);
}

#undef PDI_PICTURES_MAX_FILE_BYTES
#undef PDI_PICTURES_FRAME_MS
