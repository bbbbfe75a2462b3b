/* svg, canvas, ticks: every sort of thing that a drawing of vectors has, and what stands beside decades.
 * dims: 2 */
#include "io/canvas.h"
#include "io/axis_ticks.h"
#include "test.h"

/* What follows `before` in the drawing; "" where that is not there. */
static const char *drawn_behind(const pdi_svg *svg, size_t before)
{
    static char text[2048];
    size_t size = svg->text.size - before < sizeof text ? svg->text.size - before : sizeof text - 1;
    memcpy(text, (const char *)svg->text.data + before, size);
    text[size] = '\0';
    return text;
}

TEST(vectors)
{
    pd_ctx ctx;
    pdi_svg svg;
    pdi_canvas canvas;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pdi_canvas_build_svg(&ctx, 200, 100, &svg, &canvas))) return;
    const char *head = drawn_behind(&svg, 0);
    CHECK(strstr(head, "version=\"1.1\" width=\"200\" height=\"100\" viewBox=\"0 0 200 100\"") != NULL);
    CHECK(strstr(head, "<rect x=\"0\" y=\"0\" width=\"200\" height=\"100\" fill=\"#ffffff\"/>\n") != NULL);
    size_t at = svg.text.size;
    pdi_canvas_fill_rectangle(&canvas, 10, 20, 30, 50, 0x123456u);
    CHECK_STR(drawn_behind(&svg, at), "<rect x=\"10\" y=\"20\" width=\"20\" height=\"30\" fill=\"#123456\"/>\n");
    at = svg.text.size;
    pdi_canvas_draw_frame(&canvas, 10, 20, 30, 50, 0x00ff7fu); /* a line of one pixel around it */
    CHECK_STR(drawn_behind(&svg, at), "<rect x=\"9.50\" y=\"19.50\" width=\"21.00\" height=\"31.00\" stroke=\"#00ff7f\""
              " fill=\"none\"/>\n");
    at = svg.text.size;
    pdi_canvas_draw_line(&canvas, 1.0, 2.25, 3.5, 4.125, 1.5, 0x000001u);
    CHECK_STR(drawn_behind(&svg, at), "<line x1=\"1.00\" y1=\"2.25\" x2=\"3.50\" y2=\"4.13\" stroke-width=\"1.50\""
              " stroke=\"#000001\" stroke-linecap=\"round\"/>\n");
    at = svg.text.size;
    pdi_svg_begin_path(&svg); /* strokes that meet are one */
    pdi_svg_add_stroke(&svg, 1.0, 2.0, 3.0, 4.0);
    pdi_svg_add_stroke(&svg, 3.0, 4.0, -5.0, 6.0);
    pdi_svg_add_stroke(&svg, 3.0, 6.0, 7.0, 8.0);
    pdi_svg_add_stroke(&svg, 7.0, 9.0, 1.0, 1.0);
    pdi_svg_end_path(&svg, 2.0, 0xabcdefu);
    CHECK_STR(drawn_behind(&svg, at), "<path d=\"M1.00 2.00L3.00 4.00L-5.00 6.00M3.00 6.00L7.00 8.00M7.00 9.00L1.00 "
              "1.00\" fill=\"none\" stroke-width=\"2.00\" stroke=\"#abcdef\" stroke-linecap=\"round\""
              " stroke-linejoin=\"round\"/>\n");
    at = svg.text.size;
    pdi_svg_add_text(&svg, 3.0, 4.0, "middle", 1, 1, 0x102030u, "a<b>&\xC2\xB5\xE2\x82\xAC\xF0\x9D\x84\x9E\x01\xC3");
    CHECK_STR(drawn_behind(&svg, at), "<text x=\"-4.00\" y=\"3.00\" fill=\"#102030\" transform=\"rotate(-90)\""
              " font-weight=\"bold\" text-anchor=\"middle\">a&lt;b&gt;&amp;\xC2\xB5\xE2\x82\xAC\xF0\x9D\x84\x9E?"
              "?</text>\n");
    at = svg.text.size;
    pdi_svg_add_text(&svg, 3.0, 4.0, "start", 0, 0, 0u,
                     "\xE0\x80\x80\xED\xA0\x80\xEF\xBF\xBF\xF0\x80\x80\x80\xF4\x90\x80\x80\x7F");
    CHECK_STR(drawn_behind(&svg, at), "<text x=\"3.00\" y=\"4.00\" fill=\"#000000\" text-anchor=\"start\">"
              "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "?" "</text>\n");
    /* one for each byte that is no letter of XML */
    at = svg.text.size;
    pdi_svg_add_text(&svg, 3.0, 4.0, "start", 0, 0, 0u, "");
    pdi_svg_add_rectangle(&svg, 1, 1, 0, 5, 0u);
    pdi_svg_add_rectangle(&svg, 1, 1, 5, 0, 0u);
    CHECK_STR(drawn_behind(&svg, at), "");
    pdi_svg_add_line(&svg, 1e9, -1e9, 0.004, -0.006, 1.0, 0u); /* no larger than a reader takes */
    CHECK_STR(drawn_behind(&svg, at), "<line x1=\"1000000.00\" y1=\"-1000000.00\" x2=\"0.00\" y2=\"-0.01\""
              " stroke-width=\"1.00\" stroke=\"#000000\" stroke-linecap=\"round\"/>\n");
    CHECK_OK(&ctx, svg.status);
    pdi_svg_free(&svg);
    CHECK_INT(ctx.in_use, 0);
}

/* A group of each clip rectangle; an empty one hides all, as no pixel is drawn in it; the whole canvas has no group. */
TEST(clips)
{
    static const int edge[][4] = {{40, 10, 40, 90}, {40, 10, 60, 10}, {60, 10, 40, 90}, {300, 10, 400, 90}};
    pd_ctx ctx;
    pdi_svg svg;
    pdi_canvas canvas, pixels;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pdi_canvas_build_svg(&ctx, 200, 100, &svg, &canvas))) return;
    size_t at = svg.text.size;
    pdi_canvas_reset_clip(&canvas);
    CHECK_STR(drawn_behind(&svg, at), "");
    pdi_canvas_set_clip(&canvas, 40, 10, 60, 90);
    CHECK_STR(drawn_behind(&svg, at), "<clipPath id=\"clip0\"><rect x=\"40\" y=\"10\" width=\"20\" height=\"80\" "
                                      "fill=\"#000000\"/>\n</clipPath>\n<g clip-path=\"url(#clip0)\">\n");
    for (int k = 0; k < 4; k++) {
        char wanted[160];
        at = svg.text.size;
        pdi_canvas_set_clip(&canvas, edge[k][0], edge[k][1], edge[k][2], edge[k][3]);
        snprintf(wanted, sizeof wanted, "</g>\n<clipPath id=\"clip%d\"></clipPath>\n<g clip-path=\"url(#clip%d)\">\n",
                 k + 1, k + 1);
        CHECK_STR(drawn_behind(&svg, at), wanted);
        if (!CHECK_OK(&ctx, pdi_canvas_build_image(&ctx, 200, 100, &pixels))) continue;
        pdi_canvas_set_clip(&pixels, edge[k][0], edge[k][1], edge[k][2], edge[k][3]);
        pdi_canvas_draw_line(&pixels, 0.0, 50.0, 199.0, 50.0, 30.0, 0u);
        for (int n = 0; n < 3 * 200 * 100; n++)
            if (!CHECK_INT(pixels.image.pixels[n], 0xFF)) break;
        pd_image_free(&ctx, &pixels.image);
    }
    at = svg.text.size;
    pdi_canvas_reset_clip(&canvas);
    pdi_canvas_reset_clip(&canvas);
    CHECK_STR(drawn_behind(&svg, at), "</g>\n");
    pdi_svg_free(&svg);
    CHECK_INT(ctx.in_use, 0);
}

/* Plain numbers from 1e-3 to 1e5, and powers beyond one of them. */
TEST(decades)
{
    pdi_axis_ticks axis;
    memset(&axis, 0, sizeof axis);
    axis.log = 1;
    axis.lo = 1e-3;
    axis.hi = 1e5;
    pdi_axis_ticks_compute(8, &axis);
    CHECK_STR(axis.label[0], "0.001");
    CHECK_STR(axis.label[axis.count - 1], "100000");
    axis.lo = 1e-4;
    axis.hi = 1.0;
    pdi_axis_ticks_compute(8, &axis);
    CHECK_STR(axis.label[axis.count - 1], "10\xE2\x81\xB0");
    axis.lo = 1.0;
    axis.hi = 1e6;
    pdi_axis_ticks_compute(8, &axis);
    CHECK_STR(axis.label[0], "10\xE2\x81\xB0");
    axis.hi = 20.0;
    pdi_axis_ticks_compute(8, &axis); /* two decades: 1, 2, 5 are named, the others are not */
    CHECK_INT(axis.count, 11);
    for (int k = 0; k < axis.count; k++) {
        static const char *const names[] = {"1", "2", "", "", "5", "", "", "", "", "10", "20"};
        CHECK_STR(axis.label[k], names[k]);
        CHECK_REL(axis.value[k], k < 9 ? k + 1.0 : 10.0 * (k - 8), 1e-12);
    }
}

/* A bold text of pixels has the ink of the plain one, and that again one column to the right. */
TEST(bold_text)
{
    enum { WIDE = 120, HIGH = 40 };
    int ink[2] = {0, 0}, first[2] = {WIDE, WIDE}, last[2] = {-1, -1};
    pd_ctx ctx;
    pdi_canvas canvas[2];
    pd_ctx_init(&ctx);
    for (int bold = 0; bold < 2; bold++) {
        if (!CHECK_OK(&ctx, pdi_canvas_build_image(&ctx, WIDE, HIGH, &canvas[bold]))) return;
        if (bold) pdi_canvas_draw_bold_text(&canvas[bold], 10, 12, 0u, "HI1");
        else pdi_canvas_draw_text(&canvas[bold], 10, 12, PDI_ALIGN_START, 0u, "HI1");
        for (int k = 0; k < WIDE * HIGH; k++) {
            if (canvas[bold].image.pixels[3 * k] == 0xFF) continue;
            ink[bold]++;
            first[bold] = k % WIDE < first[bold] ? k % WIDE : first[bold];
            last[bold] = k % WIDE > last[bold] ? k % WIDE : last[bold];
        }
    }
    for (int k = 0; k < WIDE * HIGH - 1; k++) {
        uint8_t plain = canvas[0].image.pixels[3 * k];
        CHECK(canvas[1].image.pixels[3 * k] <= plain && canvas[1].image.pixels[3 * k + 3] <= plain);
    }
    CHECK_INT(first[0], 10);
    CHECK_INT(first[1], 10);
    CHECK_INT(last[1], last[0] + 1);
    CHECK(ink[0] > 60 && ink[1] > ink[0] && ink[1] < 2 * ink[0]);
    for (int bold = 0; bold < 2; bold++) pd_image_free(&ctx, &canvas[bold].image);
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(vectors) ENTRY(clips) ENTRY(bold_text) ENTRY(decades))
