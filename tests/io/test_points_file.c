/* points_file: points from tables, from Gmsh and from VTK files, against the volumes of what was meshed; and files that
 * are cut off, changed or wrong. dims: 1 2 3 */
#include "io/file.h"
#include "io/points_file.h"
#include "random.h"
#include "solid/correspondence.h"
#include "solid/equilibrium.h"
#include "test.h"

#define TEXT2(x) #x
#define TEXT1(x) TEXT2(x)
#define FOLDER "build/files_of_test_mesh_" TEXT1(PD_DIM) "d"
#define DATA "tests/data/cells_" TEXT1(PD_DIM) "d_"
#ifndef FLIPS
#define FLIPS 500 /* changed files of each kind */
#endif
enum { ROOM = 400000 };

/* A text that grows. */
typedef struct note {
    char text[ROOM];
    size_t size;
} note;

static note page;

TEST_PRINTF_LIKE(1, 2)
static void say(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int more = vsnprintf(page.text + page.size, ROOM - page.size, format, args);
    va_end(args);
    if (CHECK(more >= 0 && (size_t)more < ROOM - page.size)) page.size += (size_t)more;
}

static const char *put(const char *name, const char *text, size_t size)
{
    static char path[200];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, FOLDER));
    snprintf(path, sizeof path, "%s/%s", FOLDER, name);
    FILE *file = fopen(path, "wb");
    CHECK(file != NULL && fwrite(text, 1, size, file) == size && fclose(file) == 0);
    return path;
}

/* ---- meshes of the unit cube ---- */

typedef struct mesh_kind {
    const char *name;
    int type, corners, parts; /* Gmsh's type, and how many cells a cube has */
    int corner[6][8];         /* of the cube (VTK's order), or of a line or a square; 8: the middle */
} mesh_kind;

#if PD_DIM == 1
static const mesh_kind kinds[] = {{"line", 1, 2, 1, {{0, 1}}}};
#elif PD_DIM == 2
static const mesh_kind kinds[] = {{"triangle", 2, 3, 2, {{0, 1, 2}, {0, 2, 3}}}, {"quad", 3, 4, 1, {{0, 1, 2, 3}}}};
#else
static const mesh_kind kinds[] = {
    {"tetrahedron", 4, 4, 6, {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}},
    {"hexahedron", 5, 8, 1, {{0, 1, 2, 3, 4, 5, 6, 7}}},
    {"wedge", 6, 6, 2, {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}}},
    {"pyramid", 7, 5, 6, {{0, 1, 2, 3, 8}, {7, 6, 5, 4, 8}, {0, 4, 5, 1, 8}, {1, 5, 6, 2, 8}, {2, 6, 7, 3, 8},
                          {3, 7, 4, 0, 8}}}};
#endif
enum { KINDS = (int)(sizeof kinds / sizeof kinds[0]), N = PD_DIM == 1 ? 50 : PD_DIM == 2 ? 12 : 4 };

static int64_t nodes_across(void) { return N + 1; }

/* Place of node k: those within the cube are moved, those on its surface stay on it. Middles of cells come behind. */
static void place_of(int64_t k, double *x)
{
    int64_t across = nodes_across(), lattice = 1, cells = 1;
    uint32_t seed = 77 + (uint32_t)k;
    for (int d = 0; d < PD_DIM; d++) lattice *= across, cells *= N;
    int64_t middle = k >= lattice, rest = middle ? k - lattice : k;
    for (int d = 0; d < 3; d++) {
        x[d] = d < PD_DIM ? 0.0 : 0.5;
        if (d >= PD_DIM) continue;
        int64_t at = rest % (middle ? N : across);
        rest /= middle ? N : across;
        x[d] = ((double)at + (middle ? 0.5 : 0.0)) / N;
        double stir = random_real(&seed) * 0.12 / N;
        if (!middle && at > 0 && at < N) x[d] += stir;
    }
    (void)cells;
}

static int64_t node_of(int64_t cell, int corner)
{
    static const int bits[9] = {0, 1, 3, 2, 4, 5, 7, 6, 0};
    int64_t across = nodes_across(), node = 0, stride = 1, rest = cell, lattice = 1;
    for (int d = 0; d < PD_DIM; d++) lattice *= across;
    if (corner == 8) return lattice + cell;
    for (int d = 0; d < PD_DIM; d++, stride *= across, rest /= N) node += (rest % N + (bits[corner] >> d & 1)) * stride;
    return node;
}

static int64_t cells_of(void)
{
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) cells *= N;
    return cells;
}

/* The region of a cell: the half of the cube that it lies in, 7 or 8. */
static int region_of(int64_t cell) { return cell % N < N / 2 ? 7 : 8; }

/* Numbers of nodes with gaps, the last ones first in the file. */
static long number_of(int64_t node) { return (long)(3 * node + 5); }

static void corners_of(const mesh_kind *kind, int64_t cell, int part)
{
    for (int c = 0; c < kind->corners; c++) say(" %ld", number_of(node_of(cell, kind->corner[part][c])));
    say("\n");
}

static int64_t all_nodes(void)
{
    int64_t nodes = 1;
    for (int d = 0; d < PD_DIM; d++) nodes *= nodes_across();
    return nodes + cells_of();
}

static void write_2(const mesh_kind *kind)
{
    int64_t nodes = all_nodes(), cells = cells_of();
    long id = 1;
    page.size = 0;
    say("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n%d 7 \"left half\"\n$EndPhysicalNames\n", PD_DIM);
    say("$Nodes\n%ld\n", (long)nodes);
    for (int64_t k = nodes - 1; k >= 0; k--) {
        double x[3];
        place_of(k, x);
        say("%ld %.17g %.17g %.17g\n", number_of(k), x[0], x[1], x[2]);
    }
    /* as Gmsh does it, cells of two groups come twice */
    say("$EndNodes\n$Elements\n%ld\n", (long)(2 * cells * kind->parts + 1));
    say("%ld 15 2 0 1 %ld\n", id++, number_of(0));
    for (int64_t cell = 0; cell < 2 * cells; cell++)
        for (int part = 0; part < kind->parts; part++) {
            int64_t own = cell < cells ? cell : cell - cells;
            say("%ld %d 2 %d %d", id++, kind->type, cell < cells ? region_of(own) : 12, 100 + region_of(own));
            corners_of(kind, own, part);
        }
    say("$EndElements\n");
}

static void write_4(const mesh_kind *kind)
{
    int64_t nodes = all_nodes(), cells = cells_of();
    long id = 1, halves[2] = {0, 0};
    int counts[4] = {1, 0, 0, 0};
    counts[PD_DIM] = 2;
    page.size = 0;
    say("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n%d %d %d %d\n1 0 0 0 0\n", counts[0], counts[1], counts[2],
        counts[3]);
    for (int half = 0; half < 2; half++)
        say("%d 0 0 0 1 1 1 2 %d 99 %s\n", 21 + half, half ? -8 : 7, half ? "1 5" : "0");
    say("$EndEntities\n$Nodes\n2 %ld 1 99999\n", (long)nodes);
    for (int block = 0; block < 2; block++) { /* the second one with parameters of a surface */
        int64_t from = block ? nodes / 3 : 0, to = block ? nodes : nodes / 3;
        say("%d 21 %d %ld\n", PD_DIM, block, (long)(to - from));
        for (int64_t k = from; k < to; k++) say("%ld\n", number_of(k));
        for (int64_t k = from; k < to; k++) {
            double x[3];
            place_of(k, x);
            say("%.17g %.17g %.17g%s\n", x[0], x[1], x[2], block ? " 0.25 0.5" : "");
        }
    }
    for (int64_t cell = 0; cell < cells; cell++) halves[region_of(cell) - 7] += kind->parts;
    say("$EndNodes\n$Elements\n3 %ld 1 99999\n0 1 15 1\n%ld %ld\n", halves[0] + halves[1] + 1, id++, number_of(0));
    for (int half = 0; half < 2; half++) {
        say("%d %d %d %ld\n", PD_DIM, 21 + half, kind->type, halves[half]);
        for (int64_t cell = 0; cell < cells; cell++)
            for (int part = 0; region_of(cell) == 7 + half && part < kind->parts; part++) {
                say("%ld", id++);
                corners_of(kind, cell, part);
            }
    }
    say("$EndElements\n$NodeData\n1\n\"T\"\n$EndNodeData\n");
}

/* The surface of a cube is closed, and a pressure on it turns nothing. Half of it lies along each axis either way, and
 * no more than where cells at an edge take shares below 0. side: area of one side. */
static void check_surface(const pd_points *points, double side)
{
    double turn[3] = {0.0, 0.0, 0.0}, length = PD_DIM == 3 ? sqrt(side) : side;
    for (int d = 0; d < PD_DIM; d++) {
        double sum = 0.0, size = 0.0;
        for (int32_t i = 0; i < points->count; i++) {
            double area = points->boundary_area[i * PD_DIM + d];
            sum += area;
            size += fabs(area);
            for (int e = 0; e < PD_DIM; e++) {
                if (e == d) continue;
                turn[3 - d - e] += (e == (d + 1) % 3 ? -1.0 : 1.0) * points->position[i * PD_DIM + e] * area;
            }
        }
        CHECK_LE(fabs(sum), 1e-13 * side);
        CHECK(size >= 2.0 * side * (1.0 - 1e-13) && size < 2.03 * side);
    }
    for (int d = 0; d < 3 && PD_DIM > 1; d++) CHECK_LE(fabs(turn[d]), 1e-13 * side * length);
}

/* Meshes of all kinds of cells, with nodes moved about, fill the cube: volumes, centroids and regions, at any scale. */
TEST(cubes)
{
    static const double scales[3] = {1.0, 1e-9, 2e3};
    for (int k = 0; k < KINDS * 2 * 3; k++) {
        const mesh_kind *kind = &kinds[k % KINDS];
        double scale = scales[k / KINDS % 3], volume = 0.0, half = 0.0, moment[3] = {0.0}, size = pow(scale, PD_DIM);
        pd_ctx ctx;
        pd_points points;
        pd_ctx_init(&ctx);
        if (k % 2) write_2(kind);
        else write_4(kind);
        const char *path = put(k % 5 ? "cube.msh" : "cube.mesh", page.text, page.size);
        if (!CHECK_OK(&ctx, pd_points_read(&ctx, path, scale, &points))) continue;
        CHECK_INT(points.count, cells_of() * kind->parts);
        for (int32_t i = 0; i < points.count; i++) {
            volume += points.volume[i];
            half += points.tag[i] == 7 ? points.volume[i] : 0.0;
            CHECK(points.tag[i] == 7 || points.tag[i] == 8);
            for (int d = 0; d < PD_DIM; d++) moment[d] += points.volume[i] * points.position[i * PD_DIM + d];
        }
        CHECK_REL(volume, size, 1e-14);
        for (int d = 0; d < PD_DIM; d++) CHECK_REL(moment[d], 0.5 * size * scale, 1e-14);
        CHECK_REL(half, 0.5 * size, 0.2 / N);
        check_surface(&points, size / scale);
        pd_points_free(&ctx, &points);
        pd_points_free(&ctx, &points);
        CHECK_INT(ctx.in_use, 0);
    }
}

static pd_body_desc family_of(const pd_points *points, double horizon)
{
    pd_body_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.count = points->count;
    desc.position = points->position;
    desc.volume = points->volume;
    desc.horizon = horizon;
    return desc;
}

/* The points of a mesh are a body: a linear field has the stress of Hooke's law at each of them. */
TEST(bodies)
{
    static double u[20000 * PD_DIM], stress[20000 * PD_DIM * PD_DIM];
    for (int k = 0; k < KINDS; k++) {
        pd_ctx ctx;
        pd_points points;
        pd_body_desc desc;
        pd_body body;
        pd_correspondence_desc material;
        pd_correspondence elastic;
        double worst = 0.0, strain = 1e-6, whole = 45e9 * strain;
        pd_ctx_init(&ctx);
        write_2(&kinds[k]);
        if (!CHECK_OK(&ctx, pd_points_read(&ctx, put("body.msh", page.text, page.size), 1e-3, &points))) return;
        desc = family_of(&points, 2.1e-3 / N);
        memset(&material, 0, sizeof material);
        material.young = 45e9;
        material.poisson = PD_DIM == 1 ? 0.0 : 0.3;
        if (!CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &body))) return;
        if (!CHECK_OK(&ctx, pd_correspondence_build(&ctx, &body, &material, &elastic))) return;
        for (int32_t i = 0; i < body.count * PD_DIM; i++) u[i] = i % PD_DIM ? 0.0 : strain * body.position[i];
        if (PD_DIM > 1) whole *= 0.7 / (1.3 * 0.4);
        pd_correspondence_stress(&ctx, &elastic, u, stress);
        for (int32_t i = 0; i < body.count; i++) worst = fmax(worst, fabs(stress[i * PD_DIM * PD_DIM] - whole));
        CHECK_LE(worst, 1e-12 * whole);
        pd_correspondence_free(&ctx, &elastic);
        pd_body_free(&ctx, &body);
        pd_points_free(&ctx, &points);
        CHECK_INT(ctx.in_use, 0);
    }
}

/* A ring under pressure on the faces of its bore opens as Lame's formula says. */
#if PD_DIM == 2
/* Triangles, 48 by 8 squares cut along one diagonal (0), the other (1), or either (2). */
static const char *write_ring(int how)
{
    enum { AROUND = 48, ACROSS = 8 };
    page.size = 0;
    say("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", AROUND * (ACROSS + 1));
    for (int k = 0; k < AROUND * (ACROSS + 1); k++) {
        double r = 5.0 + 5.0 * (k / AROUND) / ACROSS, angle = 6.283185307179586 * (k % AROUND) / AROUND;
        say("%d %.15g %.15g 0\n", k + 1, r * cos(angle), r * sin(angle));
    }
    say("$EndNodes\n$Elements\n%d\n", 2 * AROUND * ACROSS);
    for (int k = 0; k < AROUND * ACROSS; k++) {
        int i = k + 1, j = k / AROUND * AROUND + (k + 1) % AROUND + 1, l = i + AROUND, m = j + AROUND;
        int other = how == 2 ? k * 7 % 5 % 2 : how;
        say("%d 2 2 1 1 %d %d %d\n", 2 * k + 1, i, l, other ? j : m);
        say("%d 2 2 1 1 %d %d %d\n", 2 * k + 2, other ? l : i, m, j);
    }
    say("$EndElements\n");
    return put("ring.msh", page.text, page.size);
}

static void press(const char *path, int count, double horizon, double most)
{
    double inner = 5e-3, outer = 10e-3, young = 45e9, poisson = 0.3, pressure = 1e7, worst = 0.0;
    static double load[2000], u[2000];
    pd_ctx ctx;
    pd_points points;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence_desc material;
    pd_correspondence elastic;
    pd_equilibrium_desc rest;
    pd_equilibrium_result result;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_points_read(&ctx, path, 1e-3, &points))) return;
    desc = family_of(&points, horizon);
    memset(&material, 0, sizeof material);
    material.young = young;
    material.poisson = poisson;
    material.plane = PD_PLANE_STRESS;
    memset(&rest, 0, sizeof rest);
    CHECK_INT(points.count, count);
    memset(u, 0, sizeof u);
    for (int32_t i = 0; i < points.count; i++) {
        const double *x = points.position + 2 * i, *face = points.boundary_area + 2 * i;
        int bore = face[0] * x[0] + face[1] * x[1] < 0.0;
        for (int d = 0; d < 2; d++) load[2 * i + d] = bore ? -pressure * face[d] / points.volume[i] : 0.0;
    }
    if (!CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &body))) return;
    if (!CHECK_OK(&ctx, pd_correspondence_build(&ctx, &body, &material, &elastic))) return;
    pd_material_interface solid = pd_correspondence_material(&elastic);
    if (!CHECK_OK(&ctx, pd_equilibrium_solve(&ctx, &solid, &rest, load, u, &result))) return;
    for (int32_t i = 0; i < points.count; i++) {
        const double *x = points.position + 2 * i;
        double r = hypot(x[0], x[1]), a = pressure * inner * inner / (outer * outer - inner * inner);
        double exact = r / young * ((1.0 - poisson) * a + (1.0 + poisson) * a * outer * outer / (r * r));
        worst = fmax(worst, fabs((u[2 * i] * x[0] + u[2 * i + 1] * x[1]) / r / exact - 1.0));
    }
    CHECK_LE(worst, most);
    pd_correspondence_free(&ctx, &elastic);
    pd_body_free(&ctx, &body);
    pd_points_free(&ctx, &points);
    CHECK_INT(ctx.in_use, 0);
}

TEST(ring)
{
    press("examples/ring.msh", 960, 1.1e-3, 0.015); /* ten cells across */
    for (int how = 0; how < 3; how++) press(write_ring(how), 768, 1.4e-3, 0.07);
}
#endif

/* The middle of a hexahedron whose faces are not plane, against a sum over many small cubes of its map. */
#if PD_DIM == 3
TEST(curved_faces)
{
    static const double corner[8][3] = {{0.0, 0.1, -0.1}, {1.2, 0.0, 0.1}, {1.0, 1.1, 0.3}, {0.1, 0.8, 0.0},
                                        {-0.1, 0.0, 1.0}, {1.0, 0.2, 1.3}, {0.8, 1.0, 0.9}, {0.0, 1.2, 1.1}};
    enum { fine = 40 };
    pd_ctx ctx;
    pd_points points;
    double volume = 0.0, centre[3] = {0.0};
    page.size = 0;
    pd_ctx_init(&ctx);
    say("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n");
    for (int k = 0; k < 8; k++) say("%d %g %g %g\n", k + 1, corner[k][0], corner[k][1], corner[k][2]);
    say("$EndNodes\n$Elements\n1\n1 5 0 1 2 3 4 5 6 7 8\n$EndElements\n");
    if (!CHECK_OK(&ctx, pd_points_read(&ctx, put("hex.msh", page.text, page.size), 1.0, &points))) return;
    for (int k = 0; k < fine * fine * fine; k++) {
        double at[3] = {(k % fine + 0.5) / fine, (k / fine % fine + 0.5) / fine, (k / fine / fine + 0.5) / fine};
        double x[3] = {0.0}, j[3][3] = {{0.0}};
        for (int c = 0; c < 8; c++) {
            int bit[3] = {(c & 1) ^ (c >> 1 & 1), c >> 1 & 1, c >> 2};
            double n[3], s[3];
            for (int d = 0; d < 3; d++) n[d] = bit[d] ? at[d] : 1.0 - at[d], s[d] = bit[d] ? 1.0 : -1.0;
            for (int d = 0; d < 3; d++) {
                x[d] += n[0] * n[1] * n[2] * corner[c][d];
                j[0][d] += s[0] * n[1] * n[2] * corner[c][d];
                j[1][d] += n[0] * s[1] * n[2] * corner[c][d];
                j[2][d] += n[0] * n[1] * s[2] * corner[c][d];
            }
        }
        double part = 0.0;
        for (int d = 0; d < 3; d++)
            part += j[0][d] * (j[1][(d + 1) % 3] * j[2][(d + 2) % 3] - j[1][(d + 2) % 3] * j[2][(d + 1) % 3]);
        volume += part / (fine * fine * fine);
        for (int d = 0; d < 3; d++) centre[d] += part * x[d] / (fine * fine * fine);
    }
    CHECK_REL(points.volume[0], volume, 1e-4); /* the sum is of second order */
    for (int d = 0; d < 3; d++) CHECK_NEAR(points.position[d], centre[d] / volume, 1e-4);
    pd_points_free(&ctx, &points);
}
#endif

/* ---- VTK ---- */

#if PD_DIM > 1
/* What VTK itself wrote in its formats: unit cells of all kinds in a row, cell k of the region k. */
TEST(vtk)
{
    static const char *const files[] = {"ascii", "binary", "zlib", "raw", "base64", "rawzlib"};
    for (int f = 0; f < 6; f++) {
        pd_ctx ctx;
        pd_points points;
        double volume[6] = {0.0}, moment[6] = {0.0};
        char path[100];
        pd_ctx_init(&ctx);
        snprintf(path, sizeof path, DATA "%s.vtu", files[f]);
        if (!CHECK_OK(&ctx, pd_points_read(&ctx, path, 1.0, &points))) continue;
        CHECK_INT(points.count, PD_DIM == 3 ? 16 : 4);
        for (int32_t i = 0; i < points.count; i++) {
            int tag = points.tag[i] < 0 ? -points.tag[i] : points.tag[i];
            if (!CHECK(tag >= 1 && tag <= 5)) break;
            volume[tag] += points.volume[i];
            moment[tag] += points.volume[i] * points.position[i * PD_DIM];
            CHECK((points.tag[i] < 0) == (tag == 3 && points.position[i * PD_DIM + 1] > 0.5));
        }
        for (int tag = 1; tag <= (PD_DIM == 3 ? 5 : 3); tag++) {
            CHECK_NEAR(volume[tag], 1.0, 1e-15);
            CHECK_NEAR(moment[tag], tag - 0.5, 1e-15 * tag);
        }
        pd_points_free(&ctx, &points);
        CHECK_INT(ctx.in_use, 0);
    }
}
#endif

static const char cloud[] =
    "<?xml version=\"1.0\"?>\n<!-- a <comment> -->\n<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n"
    "<Piece NumberOfPoints='2' NumberOfCells='0'>\n<PointData>"
    "<DataArray type='Float64' Name='volume'>2 0.5</DataArray>\n"
    "<DataArray type='Int32' Name='region' format='ascii'> 3 -4 </DataArray></PointData>\n<Points>"
    "<DataArray type='Float32' NumberOfComponents='3'>1 0.25 0.5 2 0.25 0.5</DataArray></Points></Piece>\n"
    "<Piece NumberOfPoints='1' NumberOfCells='1'><Points><DataArray type='Float64' NumberOfComponents='3'>"
    "4 0.25 0.5</DataArray></Points>\n<Cells><DataArray type='Int32' Name='connectivity'>0</DataArray>"
    "<DataArray type='Int32' Name='offsets'>1</DataArray><DataArray type='UInt8' Name='types'>1</DataArray></Cells>"
    "<PointData><DataArray type='Float64' Name='volume'>8</DataArray></PointData></Piece>\n"
    "</UnstructuredGrid></VTKFile>\n";

/* Points with volumes, in two pieces. */
TEST(point_data)
{
    static const double x[3] = {1.0, 2.0, 4.0}, volume[3] = {2.0, 0.5, 8.0};
    static const int32_t tag[3] = {3, -4, 0};
    pd_ctx ctx;
    pd_points points;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_points_read(&ctx, put("cloud.vtu", cloud, strlen(cloud)), 0.5, &points))) return;
    CHECK_INT(points.count, 3);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(points.position[i * PD_DIM], 0.5 * x[i], 0.0);
        CHECK_NEAR(points.volume[i], volume[i] * pow(0.5, PD_DIM), 0.0);
        CHECK_INT(points.tag[i], tag[i]);
    }
    pd_points_free(&ctx, &points);
    CHECK_INT(ctx.in_use, 0);
}

/* The word of appended data in a comment, in a value and at the start of another word is none; the data begin behind
 * the tag. */
TEST(word_of_appended_data)
{
    static const char *const head[] = {"<!-- <AppendedData encoding='raw'>_ -->", "", "", "<!-- <AppendedData> -->"};
    static const char *const field[] = {"", "<FieldData><DataArray Name='<AppendedData>_'/></FieldData>",
                                        "<AppendedDataOfOthers/>", "<X y=\"<AppendedData>_\"/>"};
    static const char *const volume[] = {"format='ascii'>2", "format='appended' offset='0'>"};
    static const char *const tail[] = {"", "<AppendedData encoding='base64'>\n _CAAAAAAAAAAAAABA</AppendedData>"};
    char text[1200];
    pd_ctx ctx;
    pd_points points;
    pd_ctx_init(&ctx);
    for (int k = 0; k < 8; k++) {
        snprintf(text, sizeof text,
                 "<?xml version=\"1.0\"?>%s<VTKFile type='UnstructuredGrid' byte_order='LittleEndian'>"
                 "<UnstructuredGrid>%s<Piece NumberOfPoints='1' NumberOfCells='0'><PointData><DataArray type='Float64' "
                 "Name='volume' %s</DataArray></PointData><Points><DataArray type='Float64' NumberOfComponents='3'>"
                 "1 0.25 0.5</DataArray></Points></Piece></UnstructuredGrid>%s</VTKFile>\n",
                 head[k % 4], field[k % 4], volume[k / 4], tail[k / 4]);
        if (!CHECK_OK(&ctx, pd_points_read(&ctx, put("word.vtu", text, strlen(text)), 1.0, &points))) continue;
        CHECK_INT(points.count, 1);
        CHECK_NEAR(points.position[0], 1.0, 0.0);
        CHECK_NEAR(points.volume[0], 2.0, 0.0);
        pd_points_free(&ctx, &points);
    }
    CHECK_INT(ctx.in_use, 0);
}

/* ---- tables ---- */

static const char sheet[] = "# made by hand\r\n\"Volume [m3]\", name, x [mm],y,z , TAG\r\n"
                            " 2.0,a,1,0.25, 0.5,7\r\n\r\n0.5,\"b, c\",2.5,0.25,0.5,-1\n# end\n";

TEST(tables)
{
    pd_ctx ctx;
    pd_points points;
    pd_ctx_init(&ctx);
    for (int k = 0; k < 2; k++) {
        const char *path = put(k ? "points.txt" : "points.csv", sheet, strlen(sheet));
        if (!CHECK_OK(&ctx, pd_points_read(&ctx, path, 1e-3, &points))) return;
        CHECK_INT(points.count, 2);
        CHECK_NEAR(points.position[PD_DIM], 2.5e-3, 0.0);
        CHECK_REL(points.volume[0], 2.0 * pow(1e-3, PD_DIM), 1e-15);
        CHECK(points.tag[0] == 7 && points.tag[1] == -1);
        pd_points_free(&ctx, &points);
    }
    const char *plain = "x,y,z,volume\n1,2,3,4\n";
    if (!CHECK_OK(&ctx, pd_points_read(&ctx, put("points.csv", plain, strlen(plain)), 1.0, &points))) return;
    CHECK(points.count == 1 && points.tag[0] == 0);
    pd_points_free(&ctx, &points);
    CHECK_INT(ctx.in_use, 0);
}

/* ---- refusals ---- */

/* The text is refused, with a message that has `part`. */
static void refused(const char *name, const char *text, const char *part)
{
    pd_ctx ctx;
    pd_points points;
    pd_ctx_init(&ctx);
    pd_status status = pd_points_read(&ctx, put(name, text, strlen(text)), 1.0, &points);
    if (!CHECK(status < 0) || !CHECK(strstr(ctx.message, part) != NULL)) NOTE("status %d: %s", status, ctx.message);
    CHECK(points.count == 0 && !points.position && !points.volume && !points.tag);
    pd_points_free(&ctx, &points);
    CHECK_INT(ctx.in_use, 0);
}

TEST(bad_tables)
{
    pd_ctx ctx;
    pd_points points;
    pd_ctx_init(&ctx);
    refused("a.csv", "", "no line of column names");
    refused("a.csv", "x,y,z,volume\n", "no point");
    refused("a.csv", "y,z,volume\n1,1,1\n", "no column is named 'x'");
    refused("a.csv", "x,y,z\n1,1,1\n", "no column is named 'volume'");
    refused("a.csv", "x,y,z,volume,X\n1,1,1,1,1\n", "two columns for 'x'");
    refused("a.csv", "x,y,z,volume\n1,1,1,1\n1,1,1\n", "a.csv:3: 3 fields");
    refused("a.csv", "x,y,z,volume\n1,1,1,1\n2,nan,1,1\n", "a.csv:3: column 'y'");
    refused("a.csv", "x,y,z,volume\n1,1,1,1\n2,1,1,0\n", "a.csv:3: the volume 0");
    refused("a.csv", "x,y,z,volume\n1,1,1,-2\n", "a.csv:2: the volume -2");
    refused("a.csv", "x,y,z,volume\n1e300,1,1,1\n", "a.csv:2: column 'x'");
    refused("a.csv", "x,y,z,volume,tag\n1,1,1,1,1.5\n", "a.csv:2: the tag 1.5");
    refused("a.csv", "x,y,z,volume,tag\n1,1,1,1,3e9\n", "a.csv:2: the tag 3e+09");
    if (PD_DIM < 3) refused("a.csv", "x,y,z,volume\n1,1,1,1\n2,1,2,1\n", "a.csv:3: z = 2");
    CHECK_INT(pd_points_read(&ctx, FOLDER "/none.csv", 1.0, &points), PD_ERR_FILE);
    CHECK_INT(pd_points_read(&ctx, FOLDER "/none.msh", 1.0, &points), PD_ERR_FILE);
    CHECK_INT(pd_points_read(&ctx, FOLDER "/none.msh", 0.0, &points), PD_ERR_ARGUMENT);
    CHECK_INT(pd_points_read(&ctx, FOLDER "/none.msh", NAN, &points), PD_ERR_ARGUMENT);
}

/* Four nodes: at 0, and one along each axis; a cell of theirs, and one without volume. */
#define HEAD2 "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define HEAD4 "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
#define NODES2 "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
#define NODES4 "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n"
#if PD_DIM == 1
#define CELL "1 2"
#define FLAT "2 2"
#define TYPE "1"
#elif PD_DIM == 2
#define CELL "1 2 3"
#define FLAT "1 2 2"
#define TYPE "2"
#else
#define CELL "1 2 3 4"
#define FLAT "1 2 3 3"
#define TYPE "4"
#endif

TEST(bad_gmsh)
{
    const char *dim = TEXT1(PD_DIM);
    refused("a.msh", "", "expected $MeshFormat");
    refused("a.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", "a.msh:1: MSH version 4");
    refused("a.msh", "$MeshFormat\n4.1 1 8\n", "a binary file");
    refused("a.msh", HEAD2, "no section $Elements");
    refused("a.msh", HEAD2 "$Elements\n0\n$EndElements\n", "$Elements before $Nodes");
    refused("a.msh", HEAD2 NODES2 "$Elements\n0\n$EndElements\n", "no point, and no cell");
    refused("a.msh", HEAD2 "$Nodes\n999999999\n1 0 0 0\n", "more than the rest of the file can hold");
    refused("a.msh", HEAD2 "$Nodes\n99999999999999999999999\n1 0 0 0\n", "a.msh:5: found '9999");
    refused("a.msh", HEAD2 "$Nodes\n-1\n$EndNodes\n", "found '-1'");
    refused("a.msh", HEAD2 "$Nodes\n2\n1 0 0 0\n1 1 0 0\n$EndNodes\n", "two nodes with the number 1");
    refused("a.msh", HEAD2 "$Nodes\n1\n1 0 nan 0\n$EndNodes\n", "a.msh:6: found 'nan'");
    refused("a.msh", HEAD2 "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n", "a.msh:7: found '2', expected $EndNodes");
    refused("a.msh", HEAD2 NODES2 NODES2, "a second section $Nodes");
    refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 " TYPE " 2 1 1 " CELL "\n", "expected $EndElements");
    refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 " TYPE " 2 1 1 " CELL " 1\n$EndElements\n", "does not end with");
    refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 " TYPE " 2 1 1 9 " CELL "\n$EndElements\n", "unknown node 9");
    refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 " TYPE " 2 1 1 " FLAT "\n$EndElements\n", "a.msh:13: a cell");
    refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 77 2 1 1 " CELL "\n$EndElements\n", "type 77");
    refused("a.msh", HEAD2 NODES2 "$Elements\n2\n1 " TYPE " 2 1 1 " CELL "\n$EndElements\n", "found '$EndElements'");
    refused("a.msh", HEAD2 NODES2 "Text\n", "text outside of sections");
    refused("a.msh", HEAD2 NODES2 "$Periodic\n0\n", "$Periodic has no end");
    if (PD_DIM == 3) {
        refused("a.msh", HEAD2 NODES2 "$Elements\n2\n1 4 0 1 2 3 4\n2 4 0 1 3 2 4\n$EndElements\n",
                "turned inside out");
        refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 11 0 1 3 2 4\n$EndElements\n", "order 1");
    } else {
        refused("a.msh", HEAD2 NODES2 "$Elements\n1\n1 4 0 1 3 2 4\n$EndElements\n", "elements of 3D");
        refused("a.msh", HEAD2 "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 1\n4 1 1 0\n$EndNodes\n$Elements\n2\n1 1 0 1 3\n"
                "1 2 0 1 2 3\n$EndElements\n", PD_DIM == 1 ? "off the line" : "off the plane");
    }
    if (PD_DIM == 2) {
        refused("a.msh", HEAD2 NODES2 "$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 1 1 1 3 2\n$EndElements\n",
                "the other way");
        refused("a.msh", HEAD2 "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n$Elements\n1\n1 3 0 1 2 3 4\n"
                "$EndElements\n", "folded");
    }
    page.size = 0;
    say(HEAD4 "$Entities\n0 0 0 0\n$EndEntities\n" NODES4 "$Elements\n1 1 1 1\n%s 1 " TYPE " 1\n1 " CELL "\n", dim);
    refused("a.msh", page.text, "which $Entities does not have");
    page.size = 0;
    say(HEAD4 NODES4 "$Elements\n1 2 1 1\n%s 1 " TYPE " 1\n1 " CELL "\n$EndElements\n", dim);
    refused("a.msh", page.text, "1 elements too few");
    page.size = 0;
    say(HEAD4 NODES4 "$Elements\n1 1 1 1\n%s 1 " TYPE " 2\n1 " CELL "\n$EndElements\n", dim);
    refused("a.msh", page.text, "more elements than their section");
    refused("a.msh", HEAD4 "$Nodes\n1 2 1 2\n3 1 0 1\n1\n0 0 0\n$EndNodes\n", "1 nodes in blocks, expected 2");
    refused("a.msh", HEAD4 "$Nodes\n1 1 1 2\n3 1 0 2\n1\n0 0 0\n$EndNodes\n", "more than the 1 nodes");
    refused("a.msh", HEAD4 "$PartitionedEntities\n", "a partitioned mesh");
}

/* Cells whose volume is no number of use, by the unit of length. */
TEST(lengths_out_of_range)
{
    static const double unit[] = {1e-170, PD_DIM == 1 ? 9e99 : 1e60};
    for (int k = PD_DIM == 1; k < 2; k++) {
        pd_ctx ctx;
        pd_points points;
        pd_ctx_init(&ctx);
        page.size = 0;
        say(HEAD2 "$Nodes\n4\n1 0 0 0\n2 100 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
            "$Elements\n1\n1 " TYPE " 2 1 1 " CELL "\n$EndElements\n");
        CHECK(pd_points_read(&ctx, put("a.msh", page.text, page.size), unit[k], &points) < 0);
        if (!CHECK(strstr(ctx.message, "a cell whose volume is out of range") != NULL)) NOTE("%s", ctx.message);
        CHECK_INT(ctx.in_use, 0);
    }
}

/* The cloud with `old` replaced. */
static void changed(const char *old, const char *by, const char *part)
{
    const char *at = strstr(cloud, old);
    if (!CHECK(at != NULL)) return;
    page.size = 0;
    say("%.*s%s%s", (int)(at - cloud), cloud, by, at + strlen(old));
    refused("a.vtu", page.text, part);
}

TEST(bad_vtk)
{
    refused("a.vtu", "", "no VTKFile");
    changed("UnstructuredGrid", "ImageData", "UnstructuredGrid");
    changed("NumberOfPoints='2'", "NumberOfPoints='3'", "expected a number of an array");
    changed("NumberOfPoints='2'", "NumberOfPoints='1'", "more than its 3 numbers");
    changed("NumberOfPoints='2'", "NumberOfPoints='4'", "more than it can hold"); /* in the 5 bytes of `2 0.5` */
    changed("NumberOfPoints='2'", "NumberOfPoints='2000000000'", "more than it can hold");
    changed("NumberOfPoints='2'", "NumberOfPoints='-2'", "found '-2'");
    changed("NumberOfPoints='2'", "", "a tag without NumberOfPoints");
    changed("NumberOfCells='0'", "NumberOfCells='1'", "without its array types");
    changed("'volume'>2", "'mass'>2", "without cells of");
    changed(">2 0.5<", ">2 0<", "the volume 0");
    changed(">2 0.5<", ">2 x<", "a.vtu:6: found 'x'");
    changed(" 3 -4 ", " 3 -4.5 ", "the tag -4.5");
    changed("'Float32'", "'String'", "type 'String'");
    changed("NumberOfComponents='3'>1", "NumberOfComponents='2'>1", "2 coordinates");
    changed("format='ascii'", "format='binary'", "more than it can hold");
    changed("format='ascii'", "format='appended' offset='9'", "beyond the appended data");
    changed("</UnstructuredGrid></VTKFile>", "", "ends before");
    changed(">0</DataArray>", ">0 0</DataArray>", "more than its 1 numbers");
    changed("'types'>1", "'types'>99", "VTK's type 99");
    if (PD_DIM == 2) changed("'types'>1", "'types'>5", "has 1 corners");
    if (PD_DIM < 3) changed("2 0.25 0.5<", "2 0.25 0.75<", "off the");
    if (PD_DIM < 3) changed("'types'>1", "'types'>12", "at most");
}

/* ---- files that nobody vouches for ---- */

/* Reads bytes; 1: they were accepted. */
static int attempt(const char *name, const char *bytes, size_t size)
{
    pd_ctx ctx;
    pd_points points;
    double sum = 0.0;
    pd_ctx_init(&ctx);
    ctx.alloc.limit = 50000000;
    pd_status status = pd_points_read(&ctx, put(name, bytes, size), 1.0, &points);
    int32_t count = points.count;
    for (int32_t i = 0; i < count; i++) sum += points.volume[i] + fabs(points.position[i * PD_DIM]);
    CHECK(status == PD_OK ? count > 0 && sum > 0.0 && sum < HUGE_VAL : count == 0 && ctx.message[0]);
    pd_points_free(&ctx, &points);
    CHECK_INT(ctx.in_use, 0);
    return status == PD_OK;
}

/* Cut off behind each byte, and with bytes changed. last: what has to be whole before anything is accepted. */
static void damage_file(const char *name, const char *text, size_t size, const char *last)
{
    static char copy[ROOM];
    uint32_t seed = 3;
    size_t whole = 0;
    int early = 0;
    CHECK(attempt(name, text, size));
    for (size_t k = 0; last && k + strlen(last) <= size; k++)
        if (memcmp(text + k, last, strlen(last)) == 0) whole = k + strlen(last);
    for (size_t k = 0; k < size; k++) early += attempt(name, text, k) && k < whole;
    CHECK_INT(early, 0);
    for (int k = 0; k < FLIPS; k++) {
        memcpy(copy, text, size);
        for (uint32_t n = next_random(&seed) % 3 + 1; n > 0; n--) {
            size_t at = next_random(&seed) % size;
            copy[at] = (char)(k % 2 ? next_random(&seed) : (uint32_t)"0189 -.e\n<>\"="[next_random(&seed) % 13]);
        }
        attempt(name, copy, size);
    }
}

TEST(damaged)
{
    damage_file("a.csv", sheet, strlen(sheet), NULL);
    damage_file("a.vtu", cloud, strlen(cloud), "</UnstructuredGrid>");
    page.size = 0;
    say(HEAD2 NODES2 "$Elements\n2\n1 15 2 0 1 1\n2 " TYPE " 2 1 1 " CELL "\n$EndElements\n");
    damage_file("a.msh", page.text, page.size, "$EndElements");
    page.size = 0;
    say(HEAD4 NODES4 "$Elements\n2 2 1 2\n0 1 15 1\n1 1\n%d 1 " TYPE " 1\n2 " CELL "\n$EndElements\n", PD_DIM);
    damage_file("a.msh", page.text, page.size, "$EndElements");
}

#if PD_DIM > 1
/* The same for what VTK wrote; formats with appended data end with them. */
TEST(damaged_vtk)
{
    static const char *const files[] = {"zlib", "raw", "binary", "rawzlib"};
    for (int f = 0; f < 4; f++) {
        pd_ctx ctx;
        char path[100], *text;
        size_t size;
        pd_ctx_init(&ctx);
        snprintf(path, sizeof path, DATA "%s.vtu", files[f]);
        if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, path, 100000, &text, &size))) continue;
        damage_file("b.vtu", text, size, "</UnstructuredGrid>");
        PD_DELETE(&ctx, size + 1, text);
    }
}
#define VTK ENTRY(vtk) ENTRY(damaged_vtk)
#else
#define VTK
#endif
#if PD_DIM == 3
#define CURVED ENTRY(curved_faces)
#else
#define CURVED
#endif
#if PD_DIM == 2
#define RING ENTRY(ring)
#else
#define RING
#endif
/* Of several arrays that may be tags the first one of tag, region, material and gmsh:physical counts, in any order. */
TEST(names_of_tags)
{
    static const char *const names[] = {"tag", "region", "material", "gmsh:physical"};
    for (int best = 0; best < 4; best++)
        for (int first = 0; first < 2; first++) {
            pd_ctx ctx;
            pd_points points;
            page.size = 0;
            pd_ctx_init(&ctx);
            say("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid>\n"
                "<Piece NumberOfPoints=\"2\" NumberOfCells=\"2\"><PointData>\n");
            for (int n = 0; n < 4 - best; n++) {
                int k = first ? best + n : 3 - n;
                say("<DataArray type=\"Int32\" Name=\"%s\" format=\"ascii\">%d %d</DataArray>\n", names[k], 10 * k + 1,
                    10 * k + 2);
            }
            say("<DataArray type=\"Float64\" Name=\"volume\" format=\"ascii\">1 1</DataArray></PointData>\n"
                "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0</DataArray>"
                "</Points><Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1</DataArray>\n"
                "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">1 2</DataArray>\n"
                "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">1 1</DataArray></Cells></Piece>\n"
                "</UnstructuredGrid></VTKFile>\n");
            if (!CHECK_OK(&ctx, pd_points_read(&ctx, put("tags.vtu", page.text, page.size), 1.0, &points))) return;
            CHECK_INT(points.count, 2);
            CHECK_INT(points.tag[0], 10 * best + 1);
            CHECK_INT(points.tag[1], 10 * best + 2);
            pd_points_free(&ctx, &points);
            CHECK_INT(ctx.in_use, 0);
        }
}

TEST_MAIN(ENTRY(cubes) ENTRY(bodies) RING CURVED VTK ENTRY(point_data) ENTRY(word_of_appended_data) ENTRY(tables)
              ENTRY(bad_tables) ENTRY(bad_gmsh) ENTRY(lengths_out_of_range) ENTRY(bad_vtk) ENTRY(damaged)
                  ENTRY(names_of_tags))
