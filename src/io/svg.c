/* svg: see svg.h */
#include "io/svg.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_SVG_FONT_SIZE 19       /* [pixel] font size whose capitals are as high as those of the bitmap font */
#define PDI_SVG_MAX_COORDINATE 1e6 /* [pixel] largest coordinate */

/* Append bytes to the text of the drawing; nothing after a failure. */
static void pdi_svg_add_bytes(pdi_svg *svg, const void *data, size_t size)
{
    if (svg->status == PD_OK) svg->status = pdi_bytes_add(svg->ctx, &svg->text, data, size);
}

/* Append a string. */
static void pdi_svg_add_string(pdi_svg *svg, const char *text) { pdi_svg_add_bytes(svg, text, strlen(text)); }

/* Append a number with two decimals between two strings, in any locale; its magnitude is at most
 * PDI_SVG_MAX_COORDINATE. */
static void pdi_svg_add_number(pdi_svg *svg, const char *before, double value, const char *after)
{
    char text[64];
    long hundredths = lround(100.0 * pd_max(-PDI_SVG_MAX_COORDINATE, pd_min(PDI_SVG_MAX_COORDINATE, value)));
    long size = hundredths < 0 ? -hundredths : hundredths;
    snprintf(text, sizeof text, "%s%s%ld.%02ld%s", before, hundredths < 0 ? "-" : "", size / 100, size % 100, after);
    pdi_svg_add_string(svg, text);
}

/* Append an attribute name="value" with a length [pixel]. */
static void pdi_svg_add_length(pdi_svg *svg, const char *name, double value)
{
    pdi_svg_add_string(svg, " ");
    pdi_svg_add_string(svg, name);
    pdi_svg_add_number(svg, "=\"", value, "\"");
}

/* Append an attribute name="#rrggbb" with a colour. */
static void pdi_svg_add_colour(pdi_svg *svg, const char *name, uint32_t colour)
{
    char text[48];
    snprintf(text, sizeof text, " %s=\"#%06x\"", name, (unsigned)(colour & 0xFFFFFFu));
    pdi_svg_add_string(svg, text);
}

PDI_FN void pdi_svg_begin(pd_ctx *ctx, int width, int height, pdi_svg *svg)
{
    char text[320];
    memset(svg, 0, sizeof *svg);
    svg->ctx = ctx;
    snprintf(text, sizeof text,
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
             "xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\" width=\"%d\" height=\"%d\" "
             "viewBox=\"0 0 %d %d\" font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" font-size=\"%d\">\n",
             width, height, width, height, PDI_SVG_FONT_SIZE);
    pdi_svg_add_string(svg, text);
    pdi_svg_add_rectangle(svg, 0, 0, width, height, 0xFFFFFFu);
}

PDI_FN void pdi_svg_add_rectangle(pdi_svg *svg, int left, int top, int width, int height, uint32_t colour)
{
    char text[128];
    if (width < 1 || height < 1) return;
    snprintf(text, sizeof text, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\"", left, top, width, height);
    pdi_svg_add_string(svg, text);
    pdi_svg_add_colour(svg, "fill", colour);
    pdi_svg_add_string(svg, "/>\n");
}

PDI_FN void pdi_svg_add_frame(pdi_svg *svg, double left, double top, double width, double height, uint32_t colour)
{
    pdi_svg_add_string(svg, "<rect");
    pdi_svg_add_length(svg, "x", left);
    pdi_svg_add_length(svg, "y", top);
    pdi_svg_add_length(svg, "width", width);
    pdi_svg_add_length(svg, "height", height);
    pdi_svg_add_colour(svg, "stroke", colour);
    pdi_svg_add_string(svg, " fill=\"none\"/>\n");
}

PDI_FN void pdi_svg_add_line(pdi_svg *svg, double xa, double ya, double xb, double yb, double width, uint32_t colour)
{
    pdi_svg_add_string(svg, "<line");
    pdi_svg_add_length(svg, "x1", xa);
    pdi_svg_add_length(svg, "y1", ya);
    pdi_svg_add_length(svg, "x2", xb);
    pdi_svg_add_length(svg, "y2", yb);
    pdi_svg_add_length(svg, "stroke-width", width);
    pdi_svg_add_colour(svg, "stroke", colour);
    pdi_svg_add_string(svg, " stroke-linecap=\"round\"/>\n");
}

PDI_FN void pdi_svg_begin_path(pdi_svg *svg)
{
    svg->stroke_count = 0;
    pdi_svg_add_string(svg, "<path d=\"");
}

PDI_FN void pdi_svg_add_stroke(pdi_svg *svg, double xa, double ya, double xb, double yb)
{
    if (!svg->stroke_count || xa != svg->path_end[0] || ya != svg->path_end[1]) {
        pdi_svg_add_number(svg, "M", xa, " ");
        pdi_svg_add_number(svg, "", ya, "");
    }
    pdi_svg_add_number(svg, "L", xb, " ");
    pdi_svg_add_number(svg, "", yb, "");
    svg->path_end[0] = xb;
    svg->path_end[1] = yb;
    svg->stroke_count++;
}

PDI_FN void pdi_svg_end_path(pdi_svg *svg, double width, uint32_t colour)
{
    pdi_svg_add_string(svg, "\" fill=\"none\"");
    pdi_svg_add_length(svg, "stroke-width", width);
    pdi_svg_add_colour(svg, "stroke", colour);
    pdi_svg_add_string(svg, " stroke-linecap=\"round\" stroke-linejoin=\"round\"/>\n");
}

/* Number of bytes of the UTF-8 character at `text`, 1 to 4; 0: invalid (also overlong, a surrogate, cut off), a control
 * character, or not allowed in XML. */
static size_t pdi_svg_count_character_bytes(const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    size_t size = p[0] < 0x80 ? 1 : p[0] >= 0xC2 && p[0] < 0xE0 ? 2 : p[0] >= 0xE0 && p[0] < 0xF0 ? 3 :
                  p[0] >= 0xF0 && p[0] < 0xF5 ? 4 : 0;
    for (size_t k = 1; k < size; k++)
        if ((p[k] & 0xC0) != 0x80) return 0;
    if (p[0] < 32 || p[0] == 127) return 0;
    if (p[0] == 0xE0 && p[1] < 0xA0) return 0; /* overlong encoding */
    if (p[0] == 0xED && p[1] >= 0xA0) return 0; /* surrogates */
    if (p[0] == 0xEF && p[1] == 0xBF && p[2] >= 0xBE) return 0;
    if ((p[0] == 0xF0 && p[1] < 0x90) || (p[0] == 0xF4 && p[1] >= 0x90)) return 0;
    return size;
}

PDI_FN void pdi_svg_add_text(pdi_svg *svg, double x, double y, const char *anchor, int upward, int bold,
                             uint32_t colour, const char *text)
{
    if (!text[0]) return;
    pdi_svg_add_string(svg, "<text");
    pdi_svg_add_length(svg, "x", upward ? -y : x);
    pdi_svg_add_length(svg, "y", upward ? x : y);
    pdi_svg_add_colour(svg, "fill", colour);
    if (upward) pdi_svg_add_string(svg, " transform=\"rotate(-90)\"");
    if (bold) pdi_svg_add_string(svg, " font-weight=\"bold\"");
    pdi_svg_add_string(svg, " text-anchor=\"");
    pdi_svg_add_string(svg, anchor);
    pdi_svg_add_string(svg, "\">");
    while (*text) {
        size_t size = pdi_svg_count_character_bytes(text);
        if (*text == '&') pdi_svg_add_string(svg, "&amp;");
        else if (*text == '<') pdi_svg_add_string(svg, "&lt;");
        else if (*text == '>') pdi_svg_add_string(svg, "&gt;");
        else if (size) pdi_svg_add_bytes(svg, text, size);
        else pdi_svg_add_string(svg, "?");
        text += size ? size : 1;
    }
    pdi_svg_add_string(svg, "</text>\n");
}

/* Append bytes in base64 (RFC 4648), padded with '=', without line breaks. */
static void pdi_svg_add_base64(pdi_svg *svg, const uint8_t *data, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char line[76];
    size_t used = 0;
    for (size_t k = 0; k < size; k += 3) {
        uint32_t three = (uint32_t)data[k] << 16;
        if (k + 1 < size) three |= (uint32_t)data[k + 1] << 8;
        if (k + 2 < size) three |= data[k + 2];
        for (int d = 0; d < 4; d++) line[used++] = digits[three >> (18 - 6 * d) & 63];
        if (k + 1 >= size) line[used - 2] = '=';
        if (k + 2 >= size) line[used - 1] = '=';
        if (used < sizeof line) continue;
        pdi_svg_add_bytes(svg, line, used);
        used = 0;
    }
    pdi_svg_add_bytes(svg, line, used);
}

PDI_FN void pdi_svg_add_image(pdi_svg *svg, int left, int top, const pd_image *image)
{
    char text[160];
    pdi_bytes png = {NULL, 0, 0};
    if (svg->status != PD_OK) return;
    svg->status = pdi_png_encode(svg->ctx, image, &png);
    snprintf(text, sizeof text, "<image x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" ", left, top, image->width,
             image->height);
    pdi_svg_add_string(svg, text);
    pdi_svg_add_string(svg, "xlink:href=\"data:image/png;base64,");
    pdi_svg_add_base64(svg, png.data, png.size);
    pdi_svg_add_string(svg, "\"/>\n");
    pdi_bytes_free(svg->ctx, &png);
}

PDI_FN void pdi_svg_end_clip(pdi_svg *svg)
{
    if (svg->clip_open) pdi_svg_add_string(svg, "</g>\n");
    svg->clip_open = 0;
}

PDI_FN void pdi_svg_set_clip(pdi_svg *svg, int left, int top, int width, int height)
{
    char text[160];
    pdi_svg_end_clip(svg);
    svg->clip_open = 1;
    snprintf(text, sizeof text, "<clipPath id=\"clip%d\">", svg->clip_count);
    pdi_svg_add_string(svg, text);
    pdi_svg_add_rectangle(svg, left, top, width, height, 0);
    pdi_svg_add_string(svg, "</clipPath>\n");
    snprintf(text, sizeof text, "<g clip-path=\"url(#clip%d)\">\n", svg->clip_count++);
    pdi_svg_add_string(svg, text);
}

PDI_FN pd_status pdi_svg_write(pdi_svg *svg, const char *path)
{
    pd_file file;
    pdi_svg_end_clip(svg);
    pdi_svg_add_string(svg, "</svg>\n");
    if (svg->status != PD_OK) return svg->status;
    PD_TRY(pdi_file_create(svg->ctx, path, &file));
    pd_status status = pdi_file_write(svg->ctx, &file, svg->text.data, svg->text.size);
    if (status == PD_OK) return pdi_file_commit(svg->ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

PDI_FN void pdi_svg_free(pdi_svg *svg)
{
    if (svg->ctx) pdi_bytes_free(svg->ctx, &svg->text);
    memset(svg, 0, sizeof *svg);
}

#undef PDI_SVG_FONT_SIZE
#undef PDI_SVG_MAX_COORDINATE
