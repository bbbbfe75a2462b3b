/* read_shapes: see read_shapes.h */
#include "scene/read_shapes.h"
#include "scene/reader.h"
#include "io/png.h"
#include "io/stl.h"
#include "scene/input_files.h"
#include "scene/read_mechanics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_READ_SHAPES_RAW_LIMIT ((size_t)1 << 31)
/* Grey level, 0 to 255, from which on a pixel is inside the shape. */
#define PDI_READ_SHAPES_INSIDE_GREY 128

/* What a shape is, the values of the key `kind`. */
typedef enum pdi_read_shapes_kind {
    PDI_READ_SHAPES_PART = 0, /* only an operand of set operations */
    PDI_READ_SHAPES_SOLID,
    PDI_READ_SHAPES_WALL,
    PDI_READ_SHAPES_MEDIUM, /* fluid with a diffusivity of its own */
    PDI_READ_SHAPES_PASSIVE, /* fluid there does not dissolve metal */
    PDI_READ_SHAPES_GRIP,    /* metal there has prescribed displacements */
    PDI_READ_SHAPES_SOLUTION /* fluid there starts with the composition `inside` */
} pdi_read_shapes_kind;

/* State of the reader: the section in work and the shapes read so far, which later ones may use. */
typedef struct pdi_read_shapes_state {
    pd_ctx *ctx;
    pd_text *text;
    const char *folder;
    pd_setup *setup;
    int section; /* in work */
    int count;
    const char *name[PD_SETUP_SHAPES]; /* labels of the sections so far */
    int index[PD_SETUP_SHAPES];        /* their shapes */
    int used[PD_SETUP_SHAPES];
    int materials, grains; /* sections with these keys so far */
} pdi_read_shapes_state;

/* Keys of primitives and set operations, in the order of the enum below. */
static const char *const pdi_read_shapes_form_keys[] = {"box", "ball",  "cylinder",  "half_space", "mask", "raw",
                                                        "stl", "union", "intersect", "difference", NULL};
typedef enum pdi_read_shapes_form {
    PDI_READ_SHAPES_BOX = 0,
    PDI_READ_SHAPES_BALL,
    PDI_READ_SHAPES_CYLINDER,
    PDI_READ_SHAPES_HALF_SPACE,
    PDI_READ_SHAPES_MASK,
    PDI_READ_SHAPES_RAW,
    PDI_READ_SHAPES_STL,
    PDI_READ_SHAPES_UNION,
    PDI_READ_SHAPES_INTERSECT,
    PDI_READ_SHAPES_DIFFERENCE
} pdi_read_shapes_form;

/* Read PD_DIM numbers of dimension `unit` into x[PD_DIM], in SI. PD_ERR_ARGUMENT: fewer numbers; PD_ERR_PARSE: more. */
static pd_status pdi_read_shapes_point(pdi_read_shapes_state *s, const char *key, const char *unit, double *x)
{
    int count;
    PD_TRY(pdi_text_get_numbers(s->ctx, s->text, s->section, key, unit, NULL, PD_DIM, x, &count));
    if (count == PD_DIM) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, s->section, key,
                             "found %d number%s, expected %d, one for each axis:"
                             " pd%dd runs scenes in %dD",
                             count, count > 1 ? "s" : "", PD_DIM, count, count);
}

/* Read a box from its ranges along the axes into shape->a and shape->b [m]. PD_ERR_ARGUMENT: fewer than PD_DIM
 * ranges. */
static pd_status pdi_read_shapes_box(pdi_read_shapes_state *s, pd_shape *shape)
{
    int count;
    shape->type = PD_SHAPE_BOX;
    PD_TRY(pdi_text_get_ranges(s->ctx, s->text, s->section, "box", "m", NULL, PD_DIM, shape->a, shape->b, &count));
    if (count == PD_DIM) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, s->section, "box",
                             "found %d range%s, expected %d, one for each axis:"
                             " pd%dd runs scenes in %dD",
                             count, count > 1 ? "s" : "", PD_DIM, count, count);
}

/* Read an unbounded cylinder: axis, centre (the origin by default), radius. */
static pd_status pdi_read_shapes_cylinder(pdi_read_shapes_state *s, pd_shape *shape)
{
    static const char *const axes[] = {"x", "y", "z", NULL};
    shape->type = PD_SHAPE_CYLINDER;
    PD_TRY(pdi_text_get_choice(s->ctx, s->text, s->section, "cylinder", axes, NULL, &shape->axis));
    if (pdi_text_has_key(s->ctx, s->text, s->section, "centre"))
        PD_TRY(pdi_read_shapes_point(s, "centre", "m", shape->a));
    return pdi_key_value_get_number(s->ctx, s->text, s->section, "radius", &shape->radius);
}

/* Read a half space: a point of its plane and the outward normal, of any length. PD_ERR_ARGUMENT: half_space = no, or a
 * normal of zeros. */
static pd_status pdi_read_shapes_half_space(pdi_read_shapes_state *s, pd_shape *shape)
{
    int yes;
    double size = 0.0;
    shape->type = PD_SHAPE_HALF_SPACE;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, s->section, "half_space", &yes));
    if (!yes) return pdi_text_fail_key(s->ctx, s->text, s->section, "half_space", "found 'no', expected 'yes'");
    PD_TRY(pdi_read_shapes_point(s, "point", "m", shape->a));
    PD_TRY(pdi_read_shapes_point(s, "normal", "", shape->b));
    for (int d = 0; d < PD_DIM; d++) size += fabs(shape->b[d]);
    if (size > 0.0) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, s->section, "normal", "found a zero vector, expected the outward normal");
}

/* Convert a picture to mask[width height]: 1, inside, where the luminance is PDI_READ_SHAPES_INSIDE_GREY or more, else
 * 0, as for transparent pixels. The lowest row of the picture becomes the first row of the mask. *least, *most: range
 * of the luminance, 0 to 255. */
static void pdi_read_shapes_threshold_pixels(const pd_image *image, uint8_t *mask, int *least, int *most)
{
    *least = 255;
    *most = 0;
    for (int row = 0; row < image->height; row++)
        for (int column = 0; column < image->width; column++) {
            int light = pdi_image_get_luminance(image, column, row);
            mask[(size_t)(image->height - 1 - row) * (size_t)image->width + (size_t)column] =
                light >= PDI_READ_SHAPES_INSIDE_GREY;
            *least = light < *least ? light : *least;
            *most = light > *most ? light : *most;
        }
}

/* Read the mask of a shape from a PNG picture; the setup owns it. PD_ERR_ARGUMENT: not in 2D, a file that cannot be
 * read, or no pixel is inside. */
static pd_status pdi_read_shapes_png(pdi_read_shapes_state *s, pd_shape *shape)
{
    char path[PD_PATH_SIZE];
    pd_image image;
    uint8_t *mask = NULL;
    memset(&image, 0, sizeof image);
    if (PD_DIM != 2)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "mask",
                                 "found a picture in %dD, expected raw = FILE with"
                                 " size = %s",
                                 PD_DIM, PD_DIM == 3 ? "NX, NY, NZ" : "NX");
    PD_TRY(pdi_input_files_get_path(s->ctx, s->text, s->section, "mask", s->folder, path));
    if (pd_png_read(s->ctx, path, &image) < 0) return pdi_input_files_fail(s->ctx, s->text, s->section, "mask");
    pd_status status = pd_setup_add_mask(s->ctx, s->setup, (size_t)image.width * (size_t)image.height, &mask);
    int least = 0, most = 255;
    if (status == PD_OK) pdi_read_shapes_threshold_pixels(&image, mask, &least, &most);
    if (most < PDI_READ_SHAPES_INSIDE_GREY)
        status = pdi_text_fail_key(s->ctx, s->text, s->section, "mask",
                                   "found lightness from %d to %d in '%.200s', "
                                   "expected %d and more of 255 where the shape is: %s",
                                   least, most, path, PDI_READ_SHAPES_INSIDE_GREY,
                                   !most       ? "it is black or transparent everywhere"
                                   : most < 16 ? "numbers of labels are no lightness; make theirs 255"
                                               : "white is inside");
    shape->mask_size[0] = image.width;
    shape->mask_size[PD_DIM - 1] = image.height;
    shape->mask = mask;
    pd_image_free(s->ctx, &image);
    return status;
}

/* Read the mask of a shape from a raw file: one byte a voxel, nonzero inside, x fastest; the setup owns it.
 * PD_ERR_ARGUMENT: a size that is not whole, below 1 or 1e6 and more, a file that cannot be read, another number of
 * bytes than voxels, or all are 0. */
static pd_status pdi_read_shapes_raw(pdi_read_shapes_state *s, pd_shape *shape)
{
    char path[PD_PATH_SIZE], *bytes = NULL;
    double number[PD_DIM], voxels = 1.0;
    size_t size = 0;
    uint8_t *mask = NULL;
    PD_TRY(pdi_input_files_get_path(s->ctx, s->text, s->section, "raw", s->folder, path));
    PD_TRY(pdi_read_shapes_point(s, "size", "", number));
    for (int d = 0; d < PD_DIM; d++) {
        if (!(number[d] >= 1.0) || !(number[d] < 1e6) || number[d] > floor(number[d]))
            return pdi_text_fail_key(s->ctx, s->text, s->section, "size", "found %.6g, expected whole numbers from 1",
                                     number[d]);
        shape->mask_size[d] = (int)number[d];
        voxels *= number[d];
    }
    /* a longer file need not be read to its end to see that it is too long */
    double most = pd_min(2.0 * voxels + 4096.0, (double)PDI_READ_SHAPES_RAW_LIMIT);
    if (pdi_file_read_all(s->ctx, path, (size_t)most, &bytes, &size) < 0)
        return pdi_input_files_fail(s->ctx, s->text, s->section, "raw");
    pd_status status;
    if ((double)size < voxels || (double)size > voxels)
        status = pdi_text_fail_key(s->ctx, s->text, s->section, "raw",
                                   "found a file of %.0f bytes, expected %.0f, one for each"
                                   " voxel",
                                   (double)size, voxels);
    else status = pd_setup_add_mask(s->ctx, s->setup, size, &mask);
    if (status == PD_OK && mask) {
        size_t zeros = 0;
        memcpy(mask, bytes, size);
        shape->mask = mask;
        while (zeros < size && !mask[zeros]) zeros++;
        if (zeros == size)
            status = pdi_text_fail_key(s->ctx, s->text, s->section, "raw",
                                       "found bytes that are all 0, expected others "
                                       "where the shape is");
    }
    PD_DELETE(s->ctx, size + 1, bytes);
    return status;
}

/* Read a shape of voxels: first corner [m] into shape->a, cell size [m], one for all axes or one each, into shape->b,
 * and the mask. PD_ERR_ARGUMENT: another number of cell sizes, or one that is not positive. */
static pd_status pdi_read_shapes_mask(pdi_read_shapes_state *s, pdi_read_shapes_form form, pd_shape *shape)
{
    int count;
    shape->type = PD_SHAPE_VOXELS;
    PD_TRY(pdi_read_shapes_point(s, "corner", "m", shape->a));
    PD_TRY(pdi_text_get_numbers(s->ctx, s->text, s->section, "cell", "m", NULL, PD_DIM, shape->b, &count));
    for (int d = 0; d < PD_DIM; d++) {
        if (count == 1) shape->b[d] = shape->b[0];
        if ((count != 1 && count != PD_DIM) || !(shape->b[d] > 0.0))
            return pdi_text_fail_key(s->ctx, s->text, s->section, "cell",
                                     "expected one positive length or one for each axis");
    }
    return form == PDI_READ_SHAPES_MASK ? pdi_read_shapes_png(s, shape) : pdi_read_shapes_raw(s, shape);
}

/* Read a closed triangle surface from an STL file; the setup owns it. Key `scale`: length of one unit of the file;
 * `shift` [m]: where its origin lies. Add notes where triangles were turned or corners merged. PD_ERR_ARGUMENT: not in
 * 3D, or a file that is refused. */
static pd_status pdi_read_shapes_stl(pdi_read_shapes_state *s, pd_shape *shape)
{
    char path[PD_PATH_SIZE];
    double scale, shift[PD_DIM] = {0.0};
    pd_facets *surface = NULL;
    shape->type = PD_SHAPE_FACETS;
    if (PD_DIM != 3)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "stl", "found a surface in %dD, expected 3D", PD_DIM);
    PD_TRY(pdi_input_files_get_path(s->ctx, s->text, s->section, "stl", s->folder, path));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "scale", &scale));
    if (pdi_text_has_key(s->ctx, s->text, s->section, "shift")) PD_TRY(pdi_read_shapes_point(s, "shift", "m", shift));
    PD_TRY(pd_setup_add_facets(s->ctx, s->setup, &surface));
    shape->facets = surface;
    if (pd_facets_read(s->ctx, path, scale, shift, surface) < 0)
        return pdi_input_files_fail(s->ctx, s->text, s->section, "stl");
    if (surface->flipped)
        pd_setup_add_note(s->setup, "%.200s is inside out, its normals point inward: all its triangles are turned",
                          path);
    if (surface->merged)
        pd_setup_add_note(s->setup, "%.200s is closed where corners within 3e-6 of its extent are one: %d have moved",
                          path, (int)surface->merged);
    return PD_OK;
}

/* Index of the shape of an earlier section of that name, which is marked as used. PD_ERR_ARGUMENT: none. */
static pd_status pdi_read_shapes_find_shape(pdi_read_shapes_state *s, const char *key, const char *name, int *index)
{
    for (int k = 0; k < s->count; k++)
        if (strcmp(s->name[k], name) == 0) {
            s->used[k] = 1;
            *index = s->index[k];
            return PD_OK;
        }
    return pdi_text_fail_key(s->ctx, s->text, s->section, key, "found '%s', expected the name of a [shape] above",
                             name);
}

/* Read a union, intersection or difference of earlier shapes. PD_ERR_ARGUMENT: fewer than 2 names, more than a shape
 * has room for, or a name of no shape above. */
static pd_status pdi_read_shapes_set_operation(pdi_read_shapes_state *s, pdi_read_shapes_form form, pd_shape *shape)
{
    pd_word_list list;
    const char *key = pdi_read_shapes_form_keys[form];
    const int room = (int)(sizeof shape->child / sizeof shape->child[0]);
    shape->type = form == PDI_READ_SHAPES_UNION       ? PD_SHAPE_UNION
                  : form == PDI_READ_SHAPES_INTERSECT ? PD_SHAPE_INTERSECT
                                                 : PD_SHAPE_DIFFERENCE;
    PD_TRY(pdi_text_get_words(s->ctx, s->text, s->section, key, NULL, &list));
    if (list.count < 2 || list.count > room)
        return pdi_text_fail_key(s->ctx, s->text, s->section, key, "found %d name%s, expected 2 to %d", list.count,
                                 list.count > 1 ? "s" : "", room);
    for (int k = 0; k < list.count; k++) PD_TRY(pdi_read_shapes_find_shape(s, key, list.word[k], &shape->child[k]));
    shape->child_count = list.count;
    return PD_OK;
}

/* Find the one primitive or set operation of the section. PD_ERR_ARGUMENT: none or several. */
static pd_status pdi_read_shapes_find_form(pdi_read_shapes_state *s, pdi_read_shapes_form *form)
{
    int found = -1;
    for (int k = 0; pdi_read_shapes_form_keys[k]; k++) {
        if (!pdi_text_has_key(s->ctx, s->text, s->section, pdi_read_shapes_form_keys[k])) continue;
        if (found >= 0)
            return pdi_text_fail_key(s->ctx, s->text, s->section, pdi_read_shapes_form_keys[k],
                                     "found beside '%s', expected one"
                                     " primitive or operation in a [shape] section",
                                     pdi_read_shapes_form_keys[found]);
        found = k;
    }
    if (found < 0)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "shape",
                                 "found no geometry, expected one of box, ball, cylinder,"
                                 " half_space, mask, raw, stl, union, intersect, difference");
    *form = (pdi_read_shapes_form)found;
    return PD_OK;
}

/* Read the geometry of the section, with its complement if outside = yes, and append it; *index: its shape. */
static pd_status pdi_read_shapes_geometry(pdi_read_shapes_state *s, int *index)
{
    pd_shape shape;
    pdi_read_shapes_form form = PDI_READ_SHAPES_BOX;
    int outside;
    memset(&shape, 0, sizeof shape);
    PD_TRY(pdi_read_shapes_find_form(s, &form));
    switch (form) {
    case PDI_READ_SHAPES_BOX: PD_TRY(pdi_read_shapes_box(s, &shape)); break;
    case PDI_READ_SHAPES_BALL:
        shape.type = PD_SHAPE_BALL;
        PD_TRY(pdi_read_shapes_point(s, "ball", "m", shape.a));
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "radius", &shape.radius));
        break;
    case PDI_READ_SHAPES_CYLINDER: PD_TRY(pdi_read_shapes_cylinder(s, &shape)); break;
    case PDI_READ_SHAPES_HALF_SPACE: PD_TRY(pdi_read_shapes_half_space(s, &shape)); break;
    case PDI_READ_SHAPES_MASK:
    case PDI_READ_SHAPES_RAW: PD_TRY(pdi_read_shapes_mask(s, form, &shape)); break;
    case PDI_READ_SHAPES_STL: PD_TRY(pdi_read_shapes_stl(s, &shape)); break;
    case PDI_READ_SHAPES_UNION:
    case PDI_READ_SHAPES_INTERSECT:
    case PDI_READ_SHAPES_DIFFERENCE: PD_TRY(pdi_read_shapes_set_operation(s, form, &shape)); break;
    }
    PD_TRY(pd_setup_add_shape(s->ctx, s->setup, &shape, index));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, s->section, "outside", &outside));
    return outside ? pd_setup_add_complement(s->ctx, s->setup, index) : PD_OK;
}

/* Append a solid shape to setup->solid_shape and read its material, if it names one; a material that no metal has is
 * appended to setup->metal. The first named material becomes metal 0, which is also that of shapes without one. A shape
 * of another metal joins metal->shape. PD_ERR_ARGUMENT: an unknown material, or too many metals. */
static pd_status pdi_read_shapes_material(pdi_read_shapes_state *s, int index)
{
    pd_setup *u = s->setup;
    int found = 0;
    const char *name;
    pd_material material;
    pd_setup_solid_shape *piece = &u->solid_shape[u->solid_shapes++];
    snprintf(piece->name, sizeof piece->name, "%.*s", PD_SETUP_NAME - 1, s->text->section[s->section].label);
    piece->shape = index;
    piece->metal = 0;
    if (!pdi_text_has_key(s->ctx, s->text, s->section, "material")) return PD_OK;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, s->section, "material", NULL, &name));
    if (!pd_material_find(name, &material))
        return pdi_text_fail_key(s->ctx, s->text, s->section, "material", "found '%.40s', expected %s", name,
                                 PD_MATERIAL_NAMES);
    if (!s->materials++) u->metal[0].material = material;
    while (found < u->metals && strcmp(material.name, u->metal[found].material.name) != 0) found++;
    if (found == PD_SETUP_METALS)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "material", "found more than %d metals", PD_SETUP_METALS);
    pd_setup_metal *metal = &u->metal[found];
    piece->metal = found;
    if (found == u->metals) {
        metal->material = material;
        metal->shape = -1;
        metal->rate_scale = 1.0;
        u->metals++;
    }
    metal->solid_c = pd_material_concentration(&material);
    return found ? pd_setup_add_union(s->ctx, u, index, &metal->shape) : PD_OK;
}

/* Read the grain structure of a solid into setup->grain, if grain_size is given: size, deviation, seed, boundary width,
 * and set has_grains. PD_ERR_ARGUMENT: a structure other than that of a solid above, or a boundary wider than the grain
 * size. */
static pd_status pdi_read_shapes_grains(pdi_read_shapes_state *s)
{
    pd_grain_desc grain;
    int seed;
    memset(&grain, 0, sizeof grain);
    if (!pdi_text_has_key(s->ctx, s->text, s->section, "grain_size")) return PD_OK;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "grain_size", &grain.size));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "grain_size_deviation", &grain.spread));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, s->section, "grain_seed", &seed));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "grain_boundary_width", &grain.boundary_width));
    if (grain.boundary_width > grain.size && !pdi_reader_is_equal(grain.boundary_width, grain.size))
        return pdi_text_fail_key(s->ctx, s->text, s->section, "grain_boundary_width",
                                 "found %.6g m, expected 0 to the grain size %.6g m", grain.boundary_width, grain.size);
    grain.seed = (uint64_t)seed;
    const pd_grain_desc *first = &s->setup->grain;
    int same = pdi_reader_is_equal(grain.size, first->size) && pdi_reader_is_equal(grain.spread, first->spread) &&
               pdi_reader_is_equal(grain.boundary_width, first->boundary_width) && grain.seed == first->seed;
    if (s->grains++ && !same)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "grain_size",
                                 "found other grains than in a shape above, expected the same for all solids");
    s->setup->grain = grain;
    s->setup->line[PD_PART_GRAIN] = s->text->section[s->section].line;
    s->setup->has_grains = 1;
    return PD_OK;
}

/* Add the shape to setup->wall and setup->wall_shape, with a Dirichlet concentration if key C is given and there is
 * transport. PD_ERR_ARGUMENT: too many walls, or a constant C below 0; an expression is not checked. */
static pd_status pdi_read_shapes_wall(pdi_read_shapes_state *s, int index)
{
    pd_setup *u = s->setup;
    if (u->wall_count >= PD_SETUP_WALLS)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "kind", "found more than %d walls", PD_SETUP_WALLS);
    pd_setup_wall *w = &u->wall_shape[u->wall_count++];
    w->shape = index;
    w->section = s->section;
    if (u->has_transport && pdi_text_has_key(s->ctx, s->text, s->section, "C")) {
        PD_TRY(pdi_text_get_expr(s->ctx, s->text, s->section, "C", "mol/m3", pd_setup_get_position_symbols(),
                                 PD_SETUP_POSITION_VARS, NULL, &w->fixed_c));
        if (!w->fixed_c.variables_used && !(pd_expr_eval(&w->fixed_c, NULL) >= 0.0))
            return pdi_text_fail_key(s->ctx, s->text, s->section, "C", "found %.6g mol/m3, expected at least 0",
                                     pd_expr_eval(&w->fixed_c, NULL));
        w->has_fixed_c = 1;
    }
    return pd_setup_add_union(s->ctx, u, index, &u->wall);
}

/* Add the shape to the medium, fluid with a diffusivity of its own. PD_ERR_ARGUMENT: no [transport], or a medium above
 * has another diffusivity. */
static pd_status pdi_read_shapes_medium(pdi_read_shapes_state *s, int index)
{
    pd_setup *u = s->setup;
    double value;
    if (!u->has_transport)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "kind", "found 'medium' without a [transport] section");
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "D", &value));
    if (u->medium >= 0 && !pdi_reader_is_equal(value, u->medium_diffusivity))
        return pdi_text_fail_key(s->ctx, s->text, s->section, "D",
                                 "found another diffusivity than in a medium above,"
                                 " expected the same for all");
    u->medium_diffusivity = value;
    return pd_setup_add_union(s->ctx, u, index, &u->medium);
}

/* Add the shape to the region of passive film, where fluid does not dissolve metal. PD_ERR_ARGUMENT: no [corrode]. */
static pd_status pdi_read_shapes_passive(pdi_read_shapes_state *s, int index)
{
    if (!s->setup->has_corrode)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "kind", "found 'passive' without a [corrode] section");
    return pd_setup_add_union(s->ctx, s->setup, index, &s->setup->passive);
}

/* Add the shape to the region of fluid that starts with the composition `inside`. PD_ERR_ARGUMENT: no chemistry. */
static pd_status pdi_read_shapes_solution(pdi_read_shapes_state *s, int index)
{
    if (!s->setup->has_chemistry)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "kind",
                                 "found 'solution' without species, expected "
                                 "[species Na+] and others");
    return pd_setup_add_union(s->ctx, s->setup, index, &s->setup->solution);
}

/* Read one [shape NAME] section: geometry, kind, and the keys of that kind. The shape joins the region of its kind in
 * the setup; a part joins none. setup->section_shape has its index for solids and walls, else -1. setup->shape_line is
 * the line of the first solid, or, while there is none, of the first shape. PD_ERR_ARGUMENT: no name, too many
 * shapes. */
static pd_status pdi_read_shapes_section(pdi_read_shapes_state *s)
{
    static const char *const kinds[] = {"part", "solid", "wall", "medium", "passive", "grip", "solution", NULL};
    const char *label = s->text->section[s->section].label;
    int kind = 0, index = 0;
    if (label[0] == '\0')
        return pdi_text_fail_key(s->ctx, s->text, s->section, "shape", "expected a name: [shape NAME]");
    if (s->count >= PD_SETUP_SHAPES)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "shape", "more than %d shapes", PD_SETUP_SHAPES);
    PD_TRY(pdi_text_get_choice(s->ctx, s->text, s->section, "kind", kinds, "part", &kind));
    PD_TRY(pdi_read_shapes_geometry(s, &index));
    s->name[s->count] = label;
    s->index[s->count] = index;
    s->setup->section_shape[s->count] = kind == PDI_READ_SHAPES_SOLID || kind == PDI_READ_SHAPES_WALL ? index : -1;
    s->used[s->count++] = kind != PDI_READ_SHAPES_PART;
    int line = s->text->section[s->section].line;
    if (s->count == 1 || (kind == PDI_READ_SHAPES_SOLID && s->setup->solid < 0)) s->setup->shape_line = line;
    if (kind == PDI_READ_SHAPES_MEDIUM) return pdi_read_shapes_medium(s, index);
    if (kind == PDI_READ_SHAPES_WALL) return pdi_read_shapes_wall(s, index);
    if (kind == PDI_READ_SHAPES_PASSIVE) return pdi_read_shapes_passive(s, index);
    if (kind == PDI_READ_SHAPES_GRIP) return pdi_read_mechanics_shape_bc(s->ctx, s->text, s->section, index, s->setup);
    if (kind == PDI_READ_SHAPES_SOLUTION) return pdi_read_shapes_solution(s, index);
    if (kind != PDI_READ_SHAPES_SOLID) return PD_OK;
    PD_TRY(pdi_read_shapes_material(s, index));
    PD_TRY(pdi_read_shapes_grains(s));
    return pd_setup_add_union(s->ctx, s->setup, index, &s->setup->solid);
}

PDI_FN pd_status pdi_read_shapes_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup)
{
    pdi_read_shapes_state s;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.text = text;
    s.folder = folder;
    s.setup = setup;
    for (s.section = pdi_text_next_section(ctx, text, "shape", -1); s.section >= 0;
         s.section = pdi_text_next_section(ctx, text, "shape", s.section))
        PD_TRY(pdi_read_shapes_section(&s));
    for (int k = 0; k < s.count; k++) {
        if (s.used[k]) continue;
        return pdi_text_fail_key(ctx, text, pdi_text_get_section(ctx, text, "shape", s.name[k]), "shape",
                                 "'%.40s' has no kind and is part of no other shape, expected kind = solid, wall,"
                                 " medium, passive, grip or solution",
                                 s.name[k]);
    }
    return setup->shapes ? pd_shape_validate(ctx, setup->shape, setup->shapes) : PD_OK;
}

#undef PDI_READ_SHAPES_RAW_LIMIT
#undef PDI_READ_SHAPES_INSIDE_GREY
