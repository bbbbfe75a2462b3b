/* boundary_faces: bonds that cross the surface of a mesh are none; nodes at one place; pieces of a file.
 * dims: 1 2 3 */
#include "io/file.h"
#include "io/points_file.h"
#include "random.h"
#include "solid/correspondence.h"
#include "solid/equilibrium.h"
#include "test.h"
#include <stdlib.h>

#define TEXT2(x) #x
#define TEXT1(x) TEXT2(x)
#define FOLDER "build/files_of_test_skin_" TEXT1(PD_DIM) "d"
enum { BLOCKS = 4, CORNERS = 1 << PD_DIM, TYPE = PD_DIM == 1 ? 1 : PD_DIM == 2 ? 3 : 5 };

/* Boxes of cells, each with nodes of its own, in one mesh. What is inside is moved by `jitter` cells, and all by a
 * shear, so that no face lies along an axis. */
typedef struct block_mesh {
    int blocks;
    double lo[BLOCKS][3], hi[BLOCKS][3];
    int n[BLOCKS][3];
    double jitter, shear;
} block_mesh;

static void add_block(block_mesh *m, const double *lo, const double *hi, double h)
{
    int k = m->blocks++;
    for (int d = 0; d < 3; d++) {
        m->lo[k][d] = d < PD_DIM ? lo[d] : 0.0;
        m->hi[k][d] = d < PD_DIM ? hi[d] : 0.0;
        m->n[k][d] = d < PD_DIM ? (int)floor((hi[d] - lo[d]) / h + 0.5) : 0;
    }
}

static int nodes_of(const block_mesh *m, int k)
{
    return (m->n[k][0] + 1) * (m->n[k][1] + 1) * (m->n[k][2] + 1);
}

static int cells_of(const block_mesh *m, int k)
{
    int all = 1;
    for (int d = 0; d < PD_DIM; d++) all *= m->n[k][d];
    return all;
}

static void write_nodes(FILE *f, const block_mesh *m, int k, int first, int numbered)
{
    const int *n = m->n[k];
    uint32_t state = 7u + (uint32_t)k;
    for (int i = 0; i < nodes_of(m, k); i++) {
        int at[3] = {i % (n[0] + 1), i / (n[0] + 1) % (n[1] + 1), i / (n[0] + 1) / (n[1] + 1)}, inside = 1;
        double x[3];
        for (int d = 0; d < PD_DIM; d++) inside = inside && at[d] > 0 && at[d] < n[d];
        for (int d = 0; d < 3; d++) {
            double h = n[d] ? (m->hi[k][d] - m->lo[k][d]) / n[d] : 0.0;
            double off = inside ? m->jitter * random_real(&state) : 0.0;
            x[d] = m->lo[k][d] + h * (at[d] + (d < PD_DIM ? off : 0.0));
        }
        if (PD_DIM > 1) x[0] += m->shear * x[1] + 0.6 * m->shear * x[2];
        if (PD_DIM > 2) x[1] += 0.8 * m->shear * x[2];
        if (numbered) fprintf(f, "%d ", first + i);
        fprintf(f, "%.17g %.17g %.17g\n", x[0], x[1], x[2]);
    }
}

/* Corner c of cell i of a block. */
static int corner_of(const int *n, int i, int c)
{
    int at[3] = {i % n[0], n[1] ? i / n[0] % n[1] : 0, n[2] ? i / n[0] / n[1] : 0};
    at[0] += (c & 1) ^ (c >> 1 & 1);
    at[1] += c >> 1 & 1;
    at[2] += c >> 2;
    return at[0] + (n[0] + 1) * (at[1] + (n[1] + 1) * at[2]);
}

static const char *write_msh(const block_mesh *m)
{
    int nodes = 0, cells = 0, first = 1, number = 1;
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, FOLDER));
    FILE *f = fopen(FOLDER "/blocks.msh", "w");
    if (!CHECK(f != NULL)) return "";
    for (int k = 0; k < m->blocks; k++) {
        nodes += nodes_of(m, k);
        cells += cells_of(m, k);
    }
    fprintf(f, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", nodes);
    for (int k = 0; k < m->blocks; first += nodes_of(m, k++)) write_nodes(f, m, k, first, 1);
    fprintf(f, "$EndNodes\n$Elements\n%d\n", cells);
    first = 1;
    for (int k = 0; k < m->blocks; first += nodes_of(m, k++))
        for (int i = 0; i < cells_of(m, k); i++) {
            fprintf(f, "%d %d 2 %d %d", number++, TYPE, k + 1, k + 1);
            for (int c = 0; c < CORNERS; c++) fprintf(f, " %d", first + corner_of(m->n[k], i, c));
            fprintf(f, "\n");
        }
    fprintf(f, "$EndElements\n");
    CHECK(fclose(f) == 0);
    return FOLDER "/blocks.msh";
}

/* Each block is a piece. */
static const char *write_vtu(const block_mesh *m)
{
    static const int types[] = {0, 3, 9, 12};
    FILE *f = fopen(FOLDER "/blocks.vtu", "w");
    if (!CHECK(f != NULL)) return "";
    fprintf(f, "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n");
    for (int k = 0; k < m->blocks; k++) {
        fprintf(f, "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n<Points>\n<DataArray type=\"Float64\" "
                "NumberOfComponents=\"3\" format=\"ascii\">\n", nodes_of(m, k), cells_of(m, k));
        write_nodes(f, m, k, 0, 0);
        fprintf(f, "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" "
                "format=\"ascii\">\n");
        for (int i = 0; i < cells_of(m, k); i++)
            for (int c = 0; c < CORNERS; c++) fprintf(f, "%d ", corner_of(m->n[k], i, c));
        fprintf(f, "\n</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n");
        for (int i = 0; i < cells_of(m, k); i++) fprintf(f, "%d ", CORNERS * (i + 1));
        fprintf(f, "\n</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
        for (int i = 0; i < cells_of(m, k); i++) fprintf(f, "%d ", types[PD_DIM]);
        fprintf(f, "\n</DataArray>\n</Cells>\n</Piece>\n");
    }
    fprintf(f, "</UnstructuredGrid>\n</VTKFile>\n");
    CHECK(fclose(f) == 0);
    return FOLDER "/blocks.vtu";
}

/* A body of what a file has, with the faces of its surface or without. 0: it failed. */
static int read_body(pd_ctx *ctx, const char *path, double horizon, int faces, pd_points *points, pd_body *body)
{
    pd_body_desc desc;
    if (!CHECK_OK(ctx, pd_points_read(ctx, path, 1.0, points))) return 0;
    memset(&desc, 0, sizeof desc);
    desc.count = points->count;
    desc.position = points->position;
    desc.volume = points->volume;
    desc.horizon = horizon;
    desc.faces = faces ? points->face_count : 0;
    desc.face = points->face_corner;
    return CHECK_OK(ctx, pd_body_build(ctx, &desc, body));
}

static int64_t bonds_between(const pd_points *points, const pd_body *body)
{
    int64_t found = 0;
    for (int32_t i = 0; i < body->count; i++)
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            found += points->tag[i] != points->tag[f.neighbour];
    return found;
}

/* Two blocks 0.6 cells apart, with a horizon of three cells. One moves, and the other feels nothing. */
TEST(gap)
{
    const double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0};
    const double from[3] = {1.075, 0.0, 0.0}, to[3] = {2.075, 1.0, 1.0};
    for (int faces = 0; faces < 2; faces++) {
        block_mesh mesh = {0};
        pd_ctx ctx;
        pd_points points;
        pd_body body;
        pd_correspondence_desc material;
        pd_correspondence elastic;
        double most = 0.0;
        mesh.jitter = 0.2;
        mesh.shear = 0.3;
        add_block(&mesh, lo, hi, 0.125);
        add_block(&mesh, from, to, 0.125);
        pd_ctx_init(&ctx);
        if (!read_body(&ctx, write_msh(&mesh), 0.375, faces, &points, &body)) return;
        memset(&material, 0, sizeof material);
        material.young = 1e9;
        material.poisson = PD_DIM > 1 ? 0.3 : 0.0;
        if (!CHECK_OK(&ctx, pd_correspondence_build(&ctx, &body, &material, &elastic))) return;
        double *u = (double *)calloc(2 * (size_t)points.count * PD_DIM, sizeof *u), *force = u + points.count * PD_DIM;
        for (int32_t i = 0; i < points.count * PD_DIM; i++) u[i] = points.tag[i / PD_DIM] == 2 ? 1e-3 : 0.0;
        pd_correspondence_force(&ctx, &elastic, u, force);
        for (int32_t i = 0; i < points.count * PD_DIM; i++)
            if (points.tag[i / PD_DIM] == 1) most = fmax(most, fabs(force[i]));
        if (faces) {
            CHECK_INT(bonds_between(&points, &body), 0);
            CHECK(!(most > 0.0));
        } else CHECK(most > 1e5);
        free(u);
        CHECK_INT(points.coincident_nodes, 0);
        pd_correspondence_free(&ctx, &elastic);
        pd_body_free(&ctx, &body);
        pd_points_free(&ctx, &points);
        CHECK_INT(ctx.in_use, 0);
    }
}

/* A block with flat slanted faces loses no bond. */
TEST(flat)
{
    const double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0};
    for (int k = 0; k < 4; k++) {
        block_mesh mesh = {0};
        pd_ctx ctx;
        pd_points points;
        pd_body whole, body;
        mesh.jitter = 0.1 * k;
        mesh.shear = 0.25 * k;
        add_block(&mesh, lo, hi, PD_DIM == 3 ? 1.0 / 6.0 : 0.0625);
        pd_ctx_init(&ctx);
        const char *path = write_msh(&mesh);
        double horizon = PD_DIM == 3 ? 0.5 : 0.2;
        if (!read_body(&ctx, path, horizon, 0, &points, &whole)) return;
        pd_points_free(&ctx, &points);
        if (!read_body(&ctx, path, horizon, 1, &points, &body)) return;
        CHECK(points.face_count == (PD_DIM == 1 ? 2 : PD_DIM == 2 ? 4 * 16 : 2 * 6 * 36));
        CHECK_INT(body.bonds, whole.bonds);
        pd_body_free(&ctx, &body);
        pd_body_free(&ctx, &whole);
        pd_points_free(&ctx, &points);
        CHECK_INT(ctx.in_use, 0);
    }
}

/* Blocks that touch: with nodes of their own they are two parts, and the nodes at one place are counted; as pieces of a
 * VTU file they are one body, with the bonds and the surface of one block. */
TEST(touching)
{
    const double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0}, from[3] = {1.0, 0.0, 0.0}, to[3] = {2.0, 1.0, 1.0};
    block_mesh two = {0}, one = {0};
    pd_ctx ctx;
    pd_points points, pieces, single;
    pd_body body, joined, whole;
    double h = 0.25;
    int across = PD_DIM == 1 ? 1 : PD_DIM == 2 ? 5 : 25;
    add_block(&two, lo, hi, h);
    add_block(&two, from, to, h);
    add_block(&one, lo, to, h);
    pd_ctx_init(&ctx);
    if (!read_body(&ctx, write_msh(&two), 3.0 * h, 1, &points, &body)) return;
    CHECK_INT(bonds_between(&points, &body), 0);
    CHECK_INT(points.coincident_nodes, across);
    CHECK_INT(points.coincident_faces, 2 * (PD_DIM == 1 ? 1 : PD_DIM == 2 ? 4 : 16));
    if (!read_body(&ctx, write_vtu(&two), 3.0 * h, 1, &pieces, &joined)) return;
    if (!read_body(&ctx, write_msh(&one), 3.0 * h, 1, &single, &whole)) return;
    CHECK_INT(pieces.coincident_nodes, 0);
    CHECK_INT(pieces.face_count, single.face_count);
    CHECK_INT(joined.bonds, whole.bonds);
    double sum = 0.0, all = 0.0;
    for (int32_t i = 0; i < single.count * PD_DIM; i++) {
        sum += fabs(pieces.boundary_area[i]);
        all += fabs(single.boundary_area[i]);
    }
    CHECK_REL(sum, all, 1e-12);
    pd_body_free(&ctx, &body);
    pd_body_free(&ctx, &joined);
    pd_body_free(&ctx, &whole);
    pd_points_free(&ctx, &points);
    pd_points_free(&ctx, &pieces);
    pd_points_free(&ctx, &single);
    CHECK_INT(ctx.in_use, 0);
}

/* Corners that point into the body: lattice points of an L, whose bonds pass just through its corner, keep them; a cut
 * between two columns of points stops all bonds, those through the corners of its faces, too. */
#if PD_DIM > 1
TEST(corners)
{
    enum { side = 6 };
    double position[side * side * side * PD_DIM], volume[side * side * side], face[4 * PD_DIM * PD_DIM];
    int32_t count = 0;
    pd_body_desc desc;
    pd_body body, whole;
    pd_ctx ctx;
    int faces = 0, layers = PD_DIM == 3 ? side : 1;
    for (int k = 0; k < side * side * layers; k++) {
        int at[3] = {k % side, k / side % side, k / side / side};
        if (at[0] >= 3 && at[1] >= 3) continue;
        for (int d = 0; d < PD_DIM; d++) position[count * PD_DIM + d] = at[d] + 0.5;
        volume[count++] = 1.0;
    }
    for (int wall = 0; wall < 2; wall++) /* x = 3 for y > 3, and y = 3 for x > 3 */
        for (int half = 0; half < (PD_DIM == 3 ? 2 : 1); half++) {
            double *to = face + faces++ * PD_DIM * PD_DIM;
            for (int c = 0; c < PD_DIM; c++) {
                int far = PD_DIM == 2 ? c : half ? c < 2 : c == 1, high = half ? c > 0 : c == 2;
                to[c * PD_DIM + wall] = 3.0;
                to[c * PD_DIM + 1 - wall] = far ? 6.0 : 3.0;
                if (PD_DIM == 3) to[c * PD_DIM + PD_DIM - 1] = high ? 6.0 : 0.0;
            }
        }
    memset(&desc, 0, sizeof desc);
    desc.count = count;
    desc.position = position;
    desc.volume = volume;
    desc.horizon = 1.5;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &whole))) return;
    desc.faces = faces;
    desc.face = face;
    if (!CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &body))) return;
    CHECK_INT(body.bonds, whole.bonds); /* the diagonal from (2.5, 3.5) to (3.5, 2.5) passes the corner */
    pd_body_free(&ctx, &body);
    desc.horizon = 2.3; /* now some leave it: from (2.5, 4.5) to (3.5, 2.5) and its like */
    if (!CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &body))) return;
    for (int32_t i = 0; i < body.count; i++)
        for (pd_bond_iterator f = pd_body_bonds_begin(&body, i); pd_body_bonds_next(&f);) {
            double xi[PD_DIM], s;
            const double *x = body.position + i * PD_DIM;
            pdi_body_bond_vector(&body, i, &f, xi);
            s = fabs(xi[0]) > 0.0 ? (3.0 - x[0]) / xi[0] : 2.0; /* it passes x = 3 at or below y = 3 */
            if (s > 0.0 && s < 1.0) CHECK_LE(x[1] + s * xi[1], 3.0 + 1e-12);
        }
    pd_body_free(&ctx, &body);
    pd_body_free(&ctx, &whole);
    CHECK_INT(ctx.in_use, 0);
}
#endif

/* A fork of two clamped legs that are pulled apart. The slot is narrower than a bond. How far it opens is what
 * it is without the other leg, and what Timoshenko's beams give. */
#if PD_DIM == 2
static double opens(int legs, int faces)
{
    const double h = 0.1, high = 1.0, length = 8.0, gap = 0.05, young = 1e9, force = 1e3;
    block_mesh mesh = {0};
    pd_ctx ctx;
    pd_points points;
    pd_body body;
    pd_correspondence_desc material;
    pd_correspondence elastic;
    pd_equilibrium_desc rest;
    pd_equilibrium_result result;
    double lo[2][2] = {{0.0, 0.0}, {0.0, high + gap}}, mean[2] = {0.0, 0.0}, size[2] = {0.0, 0.0};
    double hi[2][2] = {{length, high}, {length, 2.0 * high + gap}};
    pd_ctx_init(&ctx);
    for (int k = 0; k < legs; k++) add_block(&mesh, lo[k], hi[k], h);
    const char *path = write_msh(&mesh);
    if (!read_body(&ctx, path, 3.0 * h, faces, &points, &body)) return 0.0;
    memset(&material, 0, sizeof material);
    material.young = young;
    material.poisson = 0.3;
    material.plane = PD_PLANE_STRESS;
    memset(&rest, 0, sizeof rest);
    double *load = (double *)calloc(4 * (size_t)points.count, sizeof *load), *u = load + 2 * points.count;
    uint8_t *held = (uint8_t *)calloc(2 * (size_t)points.count, sizeof *held);
    for (int32_t i = 0; i < points.count; i++) {
        held[2 * i] = held[2 * i + 1] = points.position[2 * i] < 0.3; /* both legs are clamped over three columns */
        if (points.position[2 * i] > length - h) size[points.tag[i] - 1] += points.volume[i];
    }
    for (int32_t i = 0; i < points.count; i++)
        if (points.position[2 * i] > length - h)
            load[2 * i + 1] = (points.tag[i] == 1 ? -force : force) / size[points.tag[i] - 1];
    rest.prescribed = held;
    if (!CHECK_OK(&ctx, pd_correspondence_build(&ctx, &body, &material, &elastic))) return 0.0;
    pd_material_interface solid = pd_correspondence_material(&elastic);
    if (!CHECK_OK(&ctx, pd_equilibrium_solve(&ctx, &solid, &rest, load, u, &result))) return 0.0;
    for (int32_t i = 0; i < points.count; i++)
        if (points.position[2 * i] > length - h) mean[points.tag[i] - 1] += u[2 * i + 1] * points.volume[i];
    free(load);
    free(held);
    pd_correspondence_free(&ctx, &elastic);
    pd_body_free(&ctx, &body);
    pd_points_free(&ctx, &points);
    return ((legs == 2 ? mean[1] / size[1] : 0.0) - mean[0] / size[0]) * young / (legs * force);
}

TEST(slot)
{
    double length = 8.0 - 0.3 - 0.05; /* from the clamp to where the force is */
    double beam = 4.0 * length * length * length + 1.2 * length * 2.0 * 1.3; /* of height 1, over force/E */
    double alone = opens(1, 1), open = opens(2, 1), glued = opens(2, 0);
    printf("note: slot: a leg bends by %.1f F/E, alone %.1f, glued %.1f, a beam %.1f\n", open, alone, glued, beam);
    CHECK_REL(open, alone, 1e-6);
    CHECK_REL(open, beam, 0.2); /* ten cells with three to a horizon are too soft by 17 % */
    CHECK(glued < 0.5 * open);
}
#endif

/* A half disc of triangles that all have its centre as a corner. Its mirror image is the same mesh, and so are the
 * areas of its cells: the two faces at the centre give theirs to more cells than 96. */
#if PD_DIM == 2
TEST(fan)
{
    enum { cells = 240 };
    pd_ctx ctx;
    pd_points points;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, FOLDER));
    FILE *f = fopen(FOLDER "/fan.msh", "w");
    if (!CHECK(f != NULL)) return;
    fprintf(f, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n1 0 0 0\n", cells + 2);
    for (int k = 0; k <= cells; k++) {
        double angle = acos(-1.0) * k / cells;
        fprintf(f, "%d %.17g %.17g 0\n", k + 2, cos(angle), sin(angle));
    }
    fprintf(f, "$EndNodes\n$Elements\n%d\n", cells);
    for (int k = 0; k < cells; k++) fprintf(f, "%d 2 2 1 1 1 %d %d\n", k + 1, k + 2, k + 3);
    fprintf(f, "$EndElements\n");
    CHECK(fclose(f) == 0);
    if (!CHECK_OK(&ctx, pd_points_read(&ctx, FOLDER "/fan.msh", 1.0, &points))) return;
    CHECK_INT(points.count, cells);
    CHECK_INT(points.face_count, cells + 2);
    for (int k = 0; k < cells; k++) {
        const double *own = points.boundary_area + 2 * k, *image = points.boundary_area + 2 * (cells - 1 - k);
        CHECK_NEAR(own[0], -image[0], 1e-12);
        CHECK_NEAR(own[1], image[1], 1e-12);
    }
    pd_points_free(&ctx, &points);
    CHECK_INT(ctx.in_use, 0);
}
#endif

#if PD_DIM == 2
#define CORNERS_OF ENTRY(corners) ENTRY(slot) ENTRY(fan)
#elif PD_DIM == 3
#define CORNERS_OF ENTRY(corners)
#else
#define CORNERS_OF
#endif
TEST_MAIN(ENTRY(gap) ENTRY(flat) ENTRY(touching) CORNERS_OF)
