/* lattice_notes: see lattice_notes.h */
#include "physics/lattice_notes.h"
#include "core/vec.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Relative difference of volumes above which a note is printed. */
#define PDI_LATTICE_NOTES_VOLUME_TOLERANCE 1e-3
/* Half a cell over the radius of a ring above which a note on its dissolution speed is printed. */
#define PDI_LATTICE_NOTES_RING_TOLERANCE 0.01
/* Largest depth of subdivision of cells that a surface cuts, and largest number of subcells in all. */
#define PDI_LATTICE_NOTES_HALVINGS 4
#define PDI_LATTICE_NOTES_PARTS 2e5
/* Finite-difference step for a normal, over the size of a subcell. */
#define PDI_LATTICE_NOTES_NORMAL_STEP 1e-3
/* J at which a crack of springs runs in balance over E s^2 h, with the critical stretch s, in strips 48 cells high and
 * higher (theory: 15.8). */
#define PDI_LATTICE_NOTES_TOUGHNESS_FACTOR 3.1

/* Signed distance [m], or a bound of the right sign, of x from metal k: its shape less walls and later metals. */
static double pdi_lattice_notes_compute_distance(const pd_setup *u, int k, const double *x)
{
    int shape = u->metal[k].shape < 0 ? u->solid : u->metal[k].shape;
    double level = pd_shape_distance(u->shape, shape, x);
    if (u->wall >= 0) level = pd_max(level, -pd_shape_distance(u->shape, u->wall, x));
    for (int later = k + 1; later < u->metals; later++)
        if (u->metal[later].shape >= 0) level = pd_max(level, -pd_shape_distance(u->shape, u->metal[later].shape, x));
    return level;
}

/* Volume [m^d] of a subcell with edges size [PD_DIM] [m] around x [m]; with axisymmetry [m3] of its ring. */
static double pdi_lattice_notes_compute_cell_volume(const pd_grid *grid, const double *x, const double *size)
{
    double volume = grid->circumference ? 2.0 * PD_PI * fabs(x[PD_DIM - 1]) : 1.0;
    for (int d = 0; d < PD_DIM; d++) volume *= size[d];
    return volume;
}

/* Fraction of a subcell inside metal k, as if its surface were a plane along a face: exact for planes along the
 * lattice, and in the mean over subcells for others. level: signed distance [m] of its centre x from the metal. */
static double pdi_lattice_notes_compute_fraction(const pd_setup *setup, int k, const double *x, const double *size,
                                                 double level)
{
    double at[PD_DIM], normal[PD_DIM], across = 0.0;
    memcpy(at, x, sizeof at);
    for (int d = 0; d < PD_DIM; d++) {
        double step = PDI_LATTICE_NOTES_NORMAL_STEP * size[d];
        at[d] = x[d] + step;
        normal[d] = pdi_lattice_notes_compute_distance(setup, k, at);
        at[d] = x[d] - step;
        normal[d] = (normal[d] - pdi_lattice_notes_compute_distance(setup, k, at)) / (2.0 * step);
        at[d] = x[d];
    }
    for (int d = 0; d < PD_DIM; d++) across += fabs(normal[d]) * size[d];
    if (!(across > 0.0)) return level <= 0.0 ? 1.0 : 0.0;
    return pd_max(0.0, pd_min(1.0, 0.5 - level / across));
}

/* Volume of metal k within a subcell by recursive subdivision (octree), halvings levels deep; subcells farther from the
 * surface than half their diagonal are full or empty. */
static double pdi_lattice_notes_integrate_volume(const pd_model *m, int k, const double *x, const double *size,
                                                 int halvings)
{
    const pd_setup *u = m->setup;
    double level = pdi_lattice_notes_compute_distance(u, k, x), reach = 0.5 * pdi_vec_norm(size), sum = 0.0,
           half[PD_DIM];
    if (level > reach) return 0.0;
    if (level < -reach) return pdi_lattice_notes_compute_cell_volume(&m->grid, x, size);
    if (!halvings)
        return pdi_lattice_notes_compute_fraction(u, k, x, size, level) *
               pdi_lattice_notes_compute_cell_volume(&m->grid, x, size);
    for (int d = 0; d < PD_DIM; d++) half[d] = 0.5 * size[d];
    for (int corner = 0; corner < 1 << PD_DIM; corner++) {
        double at[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) at[d] = x[d] + (corner >> d & 1 ? 0.25 : -0.25) * size[d];
        sum += pdi_lattice_notes_integrate_volume(m, k, at, half, halvings - 1);
    }
    return sum;
}

/* Number of cells of the box that the surface of metal k may cut: it is within half a diagonal of their centres. */
static double pdi_lattice_notes_count_cut_cells(const pd_model *m, int k)
{
    double count = 0.0, reach = 0.5 * pdi_vec_norm(m->grid.h), x[PD_DIM];
    for (int32_t i = 0; i < m->grid.total; i++) {
        int at[PD_DIM];
        pd_grid_index(&m->grid, i, at);
        if (!pd_grid_is_inside(&m->grid, at)) continue;
        pd_grid_position(&m->grid, i, x);
        count += fabs(pdi_lattice_notes_compute_distance(m->setup, k, x)) <= reach;
    }
    return count;
}

PDI_FN void pdi_lattice_notes_compute_volumes(const pd_model *m, int k, double *shape, double *cells, double *error)
{
    pdi_compensated_sum sum[3] = {{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}};
    double cut = pdi_lattice_notes_count_cut_cells(m, k), parts = cut;
    int halvings = 0;
    while (halvings < PDI_LATTICE_NOTES_HALVINGS && parts * (1 << PD_DIM) <= PDI_LATTICE_NOTES_PARTS) {
        parts *= 1 << PD_DIM;
        halvings++;
    }
    for (int32_t i = 0; i < m->grid.total; i++) {
        int at[PD_DIM];
        double x[PD_DIM];
        pd_grid_index(&m->grid, i, at);
        if (!pd_grid_is_inside(&m->grid, at)) continue;
        pd_grid_position(&m->grid, i, x);
        int own = m->grid.kind[i] == PD_SOLID && (m->metal ? m->metal[i] : 0) == k;
        if (own) pdi_compensated_sum_add(&sum[0], pdi_lattice_notes_compute_cell_volume(&m->grid, x, m->grid.h));
        pdi_compensated_sum_add(&sum[1], pdi_lattice_notes_integrate_volume(m, k, x, m->grid.h, halvings));
        if (halvings)
            pdi_compensated_sum_add(&sum[2], pdi_lattice_notes_integrate_volume(m, k, x, m->grid.h, halvings - 1));
    }
    *cells = pdi_compensated_sum_total(&sum[0]);
    *shape = pdi_compensated_sum_total(&sum[1]);
    *error = halvings ? fabs(*shape - pdi_compensated_sum_total(&sum[2])) / *shape : PDI_LATTICE_NOTES_VOLUME_TOLERANCE;
}

/* Print a note where the volume of the cells of metal k differs from that of its shape by more than 1e-3 of it and the
 * error of the latter; nothing where the shape has no volume. */
static void pdi_lattice_notes_print_volume_error(const pd_model *m, int k, pd_print_fn print, void *user)
{
    const char *unit = PD_DIM == 3 || m->grid.circumference ? "m3" : PD_DIM == 2 ? "m2" : "m";
    double shape, cells, error;
    char text[256];
    pdi_lattice_notes_compute_volumes(m, k, &shape, &cells, &error);
    double off = cells / shape - 1.0;
    if (!(fabs(off) > PDI_LATTICE_NOTES_VOLUME_TOLERANCE + error) || !(shape > 0.0)) return;
    snprintf(text, sizeof text, "metal%s%s is whole cells: its shape holds %.6g %s and its cells %.6g %s, %+.3g %%. "
             "What is lost counts against the cells: take a spacing that fits the shape, or a finer one",
             m->setup->metals > 1 ? " " : "", m->setup->metals > 1 ? m->setup->metal[k].material.name : "", shape, unit,
             cells, unit, 100.0 * off);
    print(user, PD_PRINT_NOTE, text);
}

/* Number of nodes of the box that lie on the surface of shape `index`; index < 0: none. */
static int64_t pdi_lattice_notes_count_surface_nodes(const pd_model *m, int index)
{
    int64_t count = 0;
    double x[PD_DIM];
    for (int32_t i = 0; i < m->grid.total && index >= 0; i++) {
        int at[PD_DIM];
        pd_grid_index(&m->grid, i, at);
        if (!pd_grid_is_inside(&m->grid, at)) continue;
        pd_grid_position(&m->grid, i, x);
        count += fabs(pd_shape_distance(m->setup->shape, index, x)) <= pd_shape_surface_tolerance(m->grid.h, x);
    }
    return count;
}

/* Print a note on `count` nodes that lie on a surface of `what`; nothing for 0. */
static void pdi_lattice_notes_print_surface_nodes(const char *what, int64_t count, pd_print_fn print, void *user)
{
    char text[256];
    if (!count) return;
    snprintf(text, sizeof text,
             "a surface of the %s passes through %.0f nodes, within %g of a spacing: they belong to "
             "it, on all its sides. Surfaces along the lattice fit best on faces of cells",
             what, (double)count, PD_SHAPE_TOLERANCE);
    print(user, PD_PRINT_NOTE, text);
}

/* Axisymmetric: print a note where dissolution of a ring is off by more than 1 %, h/(2 r) at the smallest radius r of a
 * radial face between metal and fluid, since it uses the initial face of the ring. */
static void pdi_lattice_notes_print_ring_error(const pd_model *m, pd_print_fn print, void *user)
{
    const pd_grid *grid = &m->grid;
    int radial = PD_DIM - 1, outer = 0;
    double least = HUGE_VAL, h = grid->h[radial];
    char text[256];
    for (int32_t i = 0; i < grid->total && grid->circumference; i++) {
        double x[PD_DIM];
        if (grid->kind[i] != PD_SOLID) continue;
        pd_grid_position(grid, i, x);
        for (int side = 0; side < 2; side++) {
            int32_t beside = side ? i + grid->stride[radial] : i - grid->stride[radial];
            double r = x[radial] + (side ? 0.5 : -0.5) * h;
            if (!(r > 0.0) || r >= least || beside < 0 || beside >= grid->total) continue;
            if (grid->kind[beside] != PD_FLUID) continue;
            least = r;
            outer = side;
        }
    }
    if (!(0.5 * h > PDI_LATTICE_NOTES_RING_TOLERANCE * least)) return;
    snprintf(text, sizeof text, "rings: metal recedes by the face of a ring at its start, at r = %.4g m up to %.2g %% "
             "too %s", least, 50.0 * h / least, outer ? "fast" : "slowly");
    print(user, PD_PRINT_NOTE, text);
}

/* Print a note on cracks of springs in statics, in 2D and 3D and with a toughness: they propagate at more than the
 * toughness. Nothing otherwise. */
static void pdi_lattice_notes_print_toughness_error(const pd_model *m, pd_print_fn print, void *user)
{
    const pd_setup_mechanics *b = &m->setup->metal_body;
    double stretch = m->solid.bond_based.critical;
    char text[256];
    if (PD_DIM == 1 || !m->setup->has_solid || b->material != PD_SOLID_COUPLING_BOND_BASED) return;
    if (!(b->toughness > 0.0) || b->density > 0.0) return;
    double unit = b->young * stretch * stretch * m->grid.h[0] / b->toughness;
    if (PD_DIM == 3)
        snprintf(text, sizeof text,
                 "springs: a crack in balance runs at more than the toughness: in 2D at 1.3 to 3 "
                 "times it, in 3D this is not measured (theory: 15.8). Expected model = correspondence");
    else
        snprintf(text, sizeof text,
                 "springs: a crack in balance begins to run at about %.2g times the toughness, at "
                 "more with fewer than 48 cells between what holds the metal (theory: 15.8). Expected model = "
                 "correspondence",
                 PDI_LATTICE_NOTES_TOUGHNESS_FACTOR * unit);
    print(user, PD_PRINT_NOTE, text);
}

void pd_lattice_notes_print(const pd_model *m, pd_print_fn print, void *user)
{
    const pd_setup *u = m->setup;
    pdi_lattice_notes_print_surface_nodes("metal", m->grid.nodes_on_surface[0], print, user);
    pdi_lattice_notes_print_surface_nodes("wall", m->grid.nodes_on_surface[1], print, user);
    pdi_lattice_notes_print_surface_nodes("medium", pdi_lattice_notes_count_surface_nodes(m, u->medium), print, user);
    pdi_lattice_notes_print_surface_nodes("solution", pdi_lattice_notes_count_surface_nodes(m, u->solution), print,
                                          user);
    pdi_lattice_notes_print_surface_nodes("passive film", pdi_lattice_notes_count_surface_nodes(m, u->passive), print,
                                          user);
    for (int k = 0; k < u->metals && m->grid.solid >= 0; k++) pdi_lattice_notes_print_volume_error(m, k, print, user);
    if (u->has_dissolve && !u->has_corrode) pdi_lattice_notes_print_ring_error(m, print, user);
    pdi_lattice_notes_print_toughness_error(m, print, user);
}

#undef PDI_LATTICE_NOTES_RING_TOLERANCE
#undef PDI_LATTICE_NOTES_VOLUME_TOLERANCE
#undef PDI_LATTICE_NOTES_HALVINGS
#undef PDI_LATTICE_NOTES_PARTS
#undef PDI_LATTICE_NOTES_NORMAL_STEP
#undef PDI_LATTICE_NOTES_TOUGHNESS_FACTOR
