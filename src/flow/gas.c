/* gas: see gas.h
 *
 * Design: sweeps work on up to PDI_CHUNK neighbours along axis 0 at once, bond by bond. Closed lanes see the state of
 * the node at the far end too, so that all numbers stay finite, and count for nothing. The pressure of the node is
 * taken off every flux of its momentum; that changes nothing, since its faces close, and gas at rest stays at rest to
 * the last bit.
 */
#include "flow/gas.h"
#include "flow/gas_open_boundary.h"
#include "flow/gas_wall.h"
#include "core/par.h"
#include "lattice/op.h"
#include <math.h>
#include <string.h>

#define PDI_GAS_VELOCITY 1            /* index of the first velocity or momentum component in a state */
#define PDI_GAS_PRESSURE (PD_DIM + 1) /* index of the pressure or energy in a state */
#define PDI_GAS_MAX_HALVINGS 20       /* most halvings of a step before the run fails */
#define PDI_GAS_MAX_FALLBACK_ROUNDS 8 /* most rounds in which nodes fall back to first order within a stage */
#define PDI_GAS_INFINITE 1e200        /* values beyond this count as infinite */

/* Primitive states on both sides of a face, the middle of a bond, for a block of nodes. */
typedef struct pdi_gas_face_states {
    double left[PD_GAS_FIELDS][PDI_CHUNK], right[PD_GAS_FIELDS][PDI_CHUNK];
    double u_left[PDI_CHUNK], u_right[PDI_CHUNK]; /* [m/s] v.n */
    double s_left[PDI_CHUNK], s_right[PDI_CHUNK]; /* [m/s] speeds of the outer waves */
} pdi_gas_face_states;

/* Kernel over `count` consecutive nodes from i, which are the rows from `row` (-1: full families). */
typedef void (*pdi_gas_kernel_fn)(const pd_gas *gas, int32_t i, int32_t row, int count);

/* Arguments of a sweep. */
typedef struct pdi_gas_sweep_args {
    const pd_gas *gas;
    pdi_gas_kernel_fn kernel;
} pdi_gas_sweep_args;

/* Sweep callback: runs the kernel on a range of nodes. */
static void pdi_gas_apply_kernel_range(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_gas_sweep_args *s = (const pdi_gas_sweep_args *)user;
    s->kernel(s->gas, i, row, count);
}

/* Runs a kernel over all fluid nodes. */
static void pdi_gas_apply_kernel(const pd_ctx *ctx, const pd_gas *gas, pdi_gas_kernel_fn lanes)
{
    pdi_gas_sweep_args s;
    s.gas = gas;
    s.kernel = lanes;
    pdi_node_loop_by_ranges(ctx, gas->bonds, gas->grid->fluid_count * gas->bonds->stencil->count * 16, PDI_CHUNK,
                            pdi_gas_apply_kernel_range, &s);
}

/* ---- states ---- */
/* Primitive state q = (rho, v, p) of the conserved one u = (rho, rho v, rho E). Returns 1; 0: density or pressure is
 * not positive, or one of them or the kinetic energy is not below 1e200; q is set all the same. */
static int pdi_gas_compute_primitive(double gamma, const double *u, double *q)
{
    double kinetic = 0.0;
    q[0] = u[0];
    for (int d = 0; d < PD_DIM; d++) {
        q[PDI_GAS_VELOCITY + d] = u[PDI_GAS_VELOCITY + d] / u[0];
        kinetic += 0.5 * u[PDI_GAS_VELOCITY + d] * q[PDI_GAS_VELOCITY + d];
    }
    double p = q[PDI_GAS_PRESSURE] = (gamma - 1.0) * (u[PDI_GAS_PRESSURE] - kinetic);
    return u[0] > 0.0 && u[0] < PDI_GAS_INFINITE && p > 0.0 && p < PDI_GAS_INFINITE && kinetic < PDI_GAS_INFINITE;
}

/* Sets the primitive state of node i from its state. 1: admissible; 0: not, the values are set all the same. */
static int pdi_gas_update_primitive(const pd_gas *gas, int32_t i)
{
    int64_t total = gas->grid->total;
    double u[PD_GAS_FIELDS], q[PD_GAS_FIELDS];
    for (int c = 0; c < PD_GAS_FIELDS; c++) u[c] = gas->state[c * total + i];
    int good = pdi_gas_compute_primitive(gas->desc.gamma, u, q);
    for (int c = 0; c < PD_GAS_FIELDS; c++) gas->primitive[c * total + i] = q[c];
    return good;
}

/* 1: the kind of node has a state of its own. */
static int pdi_gas_has_state(uint8_t kind) { return kind == PD_FLUID || kind == PD_INLET; }

/* Sets the primitive states of all fluid nodes and inlets. Returns the first node that is not admissible, or -1.
 * Inadmissible ones get a density of -1 in `primitive`. */
static int32_t pdi_gas_update_primitives(const pd_ctx *ctx, const pd_gas *gas)
{
    const uint8_t *kind = gas->grid->kind;
    int32_t total = gas->grid->total, bad = -1;
    int nt = pd_par_threads(ctx, (int64_t)total * 8);
    (void)nt;
    /* the mark of a bad node is a density of -1, which no admissible one has */
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++)
        if (pdi_gas_has_state(kind[i]) && !pdi_gas_update_primitive(gas, i)) gas->primitive[i] = -1.0;
    for (int32_t i = 0; i < total && bad < 0; i++)
        if (pdi_gas_has_state(kind[i]) && !(gas->primitive[i] > 0.0)) bad = i;
    return bad;
}

/* Fills the ghosts of the primitive states, or with_slopes 1 of their gradients: images and outlets. Inlets stay. */
PDI_NOINLINE static void pdi_gas_update_ghosts(const pd_gas *gas, int with_slopes)
{
    const pd_ghosts *g = &gas->bonds->ghosts;
    int64_t total = gas->grid->total;
    for (int32_t k = 0; k < g->outlets_end; k++) {
        int32_t to = g->node[k], from = g->source[k];
        int flip, odd;
        pdi_gas_open_boundary_get_ghost_signs(g, k, &flip, &odd);
        for (int c = 0; c < PD_GAS_FIELDS; c++) {
            int sign = c >= PDI_GAS_VELOCITY && c < PDI_GAS_PRESSURE ? odd >> (c - PDI_GAS_VELOCITY) & 1 : 0;
            double *q = gas->primitive + c * total;
            if (!with_slopes) q[to] = sign ? -q[from] : q[from];
            for (int d = 0; d < PD_DIM && with_slopes; d++) {
                double *slope = gas->gradient + ((int64_t)c * PD_DIM + d) * total;
                slope[to] = sign ^ (flip >> d & 1) ? -slope[from] : slope[from];
            }
        }
    }
}

/* Kernel: factors [-] that limit the gradients of density and pressure (not of velocity), into their fields of
 * time_derivative. Half of any open bond must not change the value by more than the distance to the nearer one of the
 * extremes over the node and its open bonds (eq. 4.6). At an extremum it is 0, else at most 1. */
static void pdi_gas_limit_gradients_kernel(const pd_gas *gas, int32_t i, int32_t row, int count)
{
    const pd_bonds *bonds = gas->bonds;
    int64_t total = gas->grid->total;
    double least[PDI_CHUNK], most[PDI_CHUNK], steep[PDI_CHUNK], along[PDI_CHUNK], open[PDI_CHUNK];
    for (int c = 0; c < PD_GAS_FIELDS; c += PDI_GAS_PRESSURE) {
        const double *q = gas->primitive + c * total + i, *slope = gas->gradient + (int64_t)c * PD_DIM * total + i;
        for (int b = 0; b < count; b++) {
            least[b] = most[b] = q[b];
            steep[b] = 0.0;
        }
        pdi_bond_mask_block gate = {NULL, 0, 0, 0};
        for (int k = 0; k < bonds->stencil->count; k++) {
            pdi_bond_openness lanes = pdi_bond_find_nodes_open(bonds, row, k, count, &gate, open);
            const double *far = q + bonds->paths.shift[k], *xi = bonds->stencil->xi + k * PD_DIM;
            if (lanes == PDI_BOND_OPEN_NONE) continue;
            for (int b = 0; b < count; b++) along[b] = 0.0;
            for (int d = 0; d < PD_DIM; d++)
                for (int b = 0; b < count; b++) along[b] += 0.5 * xi[d] * slope[d * total + b];
            for (int b = 0; b < count; b++) {
                int passes = lanes == PDI_BOND_OPEN_ALL || open[b] > 0.0;
                double value = passes ? far[b] : q[b], size = passes ? fabs(along[b]) : 0.0;
                least[b] = value < least[b] ? value : least[b];
                most[b] = value > most[b] ? value : most[b];
                steep[b] = size > steep[b] ? size : steep[b];
            }
        }
        for (int b = 0; b < count; b++) {
            double room = most[b] - q[b] < q[b] - least[b] ? most[b] - q[b] : q[b] - least[b];
            gas->time_derivative[c * total + i + b] = room < steep[b] ? room / steep[b] : 1.0;
        }
    }
}

/* Fills the ghosts of admissible primitive states; in second order also `gradient` with its ghosts, that of density and
 * pressure limited at fluid nodes. Behind outlets the gradients see states that are extrapolated. time_derivative is
 * work. */
static void pdi_gas_compute_gradients(const pd_ctx *ctx, const pd_gas *gas)
{
    const uint8_t *kind = gas->grid->kind;
    int64_t total = gas->grid->total;
    int nt = pd_par_threads(ctx, total * 8);
    (void)nt;
    pdi_gas_update_ghosts(gas, 0);
    if (!gas->gradient) return;
    pdi_gas_open_boundary_extrapolate_ghosts(gas->bonds, PD_GAS_FIELDS, PDI_GAS_VELOCITY, gas->primitive);
    for (int c = 0; c < PD_GAS_FIELDS; c++)
        pd_op_gradient(ctx, gas->bonds, gas->primitive + c * total, gas->gradient + (int64_t)c * PD_DIM * total);
    pdi_gas_apply_kernel(ctx, gas, pdi_gas_limit_gradients_kernel);
    pdi_gas_update_ghosts(gas, 0);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++)
        for (int c = 0; c < PD_GAS_FIELDS && kind[i] == PD_FLUID; c += PDI_GAS_PRESSURE)
            for (int d = 0; d < PD_DIM; d++)
                gas->gradient[((int64_t)c * PD_DIM + d) * total + i] *= gas->time_derivative[c * total + i];
    pdi_gas_update_ghosts(gas, 1);
}

/* ---- faces ---- */
/* Slope limiter: harmonic mean 2ab/(a + b), 0 for different signs (van Leer 1974; H of eq. 4.5). */
static inline double pdi_gas_limit_van_leer(double a, double b)
{
    double product = a * b, positive = product > 0.0 ? product : 0.0, sum = product > 0.0 ? a + b : 1.0;
    return 2.0 * positive / sum;
}

/* States on both sides of the middle of bond k by limited linear reconstruction (eq. 4.5), between those of its ends;
 * without gradients those of its ends. open: 1.0 or 0.0 for each node, NULL: all open. A closed bond has the state of
 * the node on both sides. */
static void pdi_gas_interpolate_face(const pd_gas *gas, int32_t i, int k, int count, const double *open,
                                     pdi_gas_face_states *f)
{
    const double *xi = gas->bonds->stencil->xi + k * PD_DIM;
    int64_t total = gas->grid->total, shift = gas->bonds->paths.shift[k];
    for (int c = 0; c < PD_GAS_FIELDS; c++) {
        const double *near = gas->primitive + c * total + i;
        const double *slope = gas->gradient ? gas->gradient + (int64_t)c * PD_DIM * total + i : NULL;
        double *left = f->left[c], *right = f->right[c], step[PDI_CHUNK], here[PDI_CHUNK], there[PDI_CHUNK];
        for (int b = 0; b < count; b++) {
            left[b] = near[b];
            step[b] = open && !(open[b] > 0.0) ? 0.0 : near[b + shift] - near[b];
            right[b] = open && !(open[b] > 0.0) ? near[b] : near[b + shift];
            here[b] = there[b] = 0.0;
        }
        if (!slope) continue;
        for (int d = 0; d < PD_DIM; d++)
            for (int b = 0; b < count; b++) {
                here[b] += 2.0 * xi[d] * slope[d * total + b];
                there[b] += 2.0 * xi[d] * slope[d * total + b + shift];
            }
        for (int b = 0; b < count; b++) {
            left[b] += 0.5 * pdi_gas_limit_van_leer(here[b] - step[b], step[b]);
            right[b] -= 0.5 * pdi_gas_limit_van_leer(there[b] - step[b], step[b]);
        }
    }
}

/* Weight eta of the velocity jump in the mean speed of sound (eq. 4.4): at least that of Roe's mean. */
static double pdi_gas_compute_jump_weight(double gamma) { return gamma > 2.0 ? 0.5 * (gamma - 1.0) : 0.5; }

/* Slowest wave of a face [m/s] (eq. 4.4, Einfeldt 1988). u_l, u_r: normal velocities. spread:
 * pdi_gas_compute_jump_weight. The fastest one is that of the mirrored face, negative. */
static inline double pdi_gas_compute_slowest_wave(double gamma, double spread, double rho_l, double u_l, double p_l,
                                                  double rho_r, double u_r, double p_r)
{
    double root = sqrt(rho_r / rho_l), share = 1.0 / (1.0 + root), rest = root * share, jump = u_r - u_l;
    double square_l = gamma * p_l / rho_l, square_r = gamma * p_r / rho_r;
    double mean = share * u_l + rest * u_r;
    double wide = sqrt(share * square_l + rest * square_r + spread * share * rest * jump * jump);
    double own = u_l - sqrt(square_l), roe = mean - wide;
    return own < roe ? own : roe;
}

/* Sets u_left, u_right (velocities along the normal n) and s_left, s_right (slowest and fastest wave, eq. 4.4) of *f
 * for `count` nodes, from the states on both sides. */
static void pdi_gas_compute_wave_speeds(const pd_gas *gas, const double *n, int count, pdi_gas_face_states *f)
{
    double gamma = gas->desc.gamma, spread = pdi_gas_compute_jump_weight(gamma);
    for (int b = 0; b < count; b++) f->u_left[b] = f->u_right[b] = 0.0;
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < count; b++) {
            f->u_left[b] += n[d] * f->left[PDI_GAS_VELOCITY + d][b];
            f->u_right[b] += n[d] * f->right[PDI_GAS_VELOCITY + d][b];
        }
    for (int b = 0; b < count; b++) {
        double rho_l = f->left[0][b], rho_r = f->right[0][b], p_l = f->left[PDI_GAS_PRESSURE][b],
               p_r = f->right[PDI_GAS_PRESSURE][b];
        f->s_left[b] = pdi_gas_compute_slowest_wave(gamma, spread, rho_l, f->u_left[b], p_l, rho_r, f->u_right[b], p_r);
        f->s_right[b] =
            -pdi_gas_compute_slowest_wave(gamma, spread, rho_r, -f->u_right[b], p_r, rho_l, -f->u_left[b], p_l);
    }
}

/* sum [PD_GAS_FIELDS][PDI_CHUNK] += `weight` times the HLLC flux through faces with the normal n, its momentum less the
 * pressure p [count] of the nodes (eq. 4.2, 4.3). open: 1.0 or 0.0 for each node, NULL: all open. */
PDI_NOINLINE static void pdi_gas_add_hllc_flux(const pd_gas *gas, const double *n, double weight, const double *p,
                                               int count, const double *open, const pdi_gas_face_states *f,
                                               double (*sum)[PDI_CHUNK])
{
    double inner = 1.0 / (gas->desc.gamma - 1.0);
    for (int b = 0; b < count; b++) {
        double rho_l = f->left[0][b], rho_r = f->right[0][b], p_l = f->left[PDI_GAS_PRESSURE][b],
               p_r = f->right[PDI_GAS_PRESSURE][b];
        double mass_l = rho_l * (f->s_left[b] - f->u_left[b]), mass_r = rho_r * (f->s_right[b] - f->u_right[b]);
        double contact = (p_r - p_l + mass_l * f->u_left[b] - mass_r * f->u_right[b]) / (mass_l - mass_r);
        int from_left = contact >= 0.0;
        double rho = from_left ? rho_l : rho_r, u = from_left ? f->u_left[b] : f->u_right[b];
        double pressure = from_left ? p_l : p_r, wave = from_left ? f->s_left[b] : f->s_right[b];
        double passing = from_left ? (wave < 0.0 ? wave : 0.0) : (wave > 0.0 ? wave : 0.0);
        double scale = open ? open[b] * weight : weight, kinetic = 0.0;
        double star = rho * ((wave - u) / (wave - contact)), mass = rho * u + passing * (star - rho);
        double push = pressure - p[b] + passing * star * (contact - u);
        for (int d = 0; d < PD_DIM; d++) {
            double v = from_left ? f->left[PDI_GAS_VELOCITY + d][b] : f->right[PDI_GAS_VELOCITY + d][b];
            kinetic += 0.5 * v * v;
            sum[PDI_GAS_VELOCITY + d][b] += scale * (mass * v + push * n[d]);
        }
        double energy = kinetic + inner * pressure / rho; /* per mass */
        double gain = (contact - u) * (contact + pressure / (rho * (wave - u)));
        sum[0][b] += scale * mass;
        sum[PDI_GAS_PRESSURE][b] += scale * (mass * energy + pressure * u + passing * star * gain);
    }
}

/* Outflow velocity *u [m/s] at slip wall w of row r, and its normal n into the wall (eq. 4.7). First order: the normal
 * velocity of node i. Second order: reconstructed at the middle of a bond to the mirror image. Returns the weight 2
 * |wall_face| [1/m]; 0: there is no such wall, *u is 0 and n not set. */
static double pdi_gas_compute_slip_wall(const pd_gas *gas, int32_t i, int32_t r, int w, double *n, double *u)
{
    int64_t total = gas->grid->total, place = (int64_t)r * PD_DIM + w;
    const double *face = gas->wall_face + place * PD_DIM;
    double square = 0.0, slope = 0.0;
    for (int d = 0; d < PD_DIM; d++) square += face[d] * face[d];
    *u = 0.0;
    if (!(square > 0.0)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        n[d] = face[d] / sqrt(square);
        *u += n[d] * gas->primitive[(PDI_GAS_VELOCITY + d) * total + i];
    }
    if (gas->gradient) {
        for (int c = 0; c < PD_DIM; c++)
            for (int d = 0; d < PD_DIM; d++)
                slope += n[c] * n[d] * gas->gradient[((int64_t)(PDI_GAS_VELOCITY + c) * PD_DIM + d) * total + i];
        *u += 0.5 * pdi_gas_limit_van_leer(4.0 * gas->wall_distance[place] * slope + 2.0 * *u, -2.0 * *u);
    }
    return 2.0 * sqrt(square);
}

/* Slowest wave [m/s], negative, between node i and its mirror image, for the velocity u towards the wall. */
static double pdi_gas_compute_slip_wall_wave(const pd_gas *gas, int32_t i, double u)
{
    double gamma = gas->desc.gamma, rho = gas->primitive[i];
    double p = gas->primitive[(int64_t)PDI_GAS_PRESSURE * gas->grid->total + i];
    return pdi_gas_compute_slowest_wave(gamma, pdi_gas_compute_jump_weight(gamma), rho, u, p, rho, -u, p);
}

/* ---- sums over bonds ---- */
/* Kernel: sets time_derivative to the rates of the state by all open bonds, those through open sides included, and slip
 * walls (eq. 4.2, 4.7). A slip wall adds to the momentum alone. Gradients and ghosts must be set. */
static void pdi_gas_compute_rates_kernel(const pd_gas *gas, int32_t i, int32_t row, int count)
{
    const pd_bonds *bonds = gas->bonds;
    int64_t total = gas->grid->total;
    const double *p = gas->primitive + PDI_GAS_PRESSURE * total + i;
    double sum[PD_GAS_FIELDS][PDI_CHUNK], open[PDI_CHUNK], n[PD_DIM];
    pdi_gas_face_states face;
    memset(sum, 0, sizeof sum);
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_bond_openness lanes = pdi_bond_find_nodes_open(bonds, row, k, count, &gate, open);
        const double *some = lanes == PDI_BOND_OPEN_SOME ? open : NULL;
        if (lanes == PDI_BOND_OPEN_NONE) continue;
        double weight = pdi_gas_wall_get_bond_face(bonds->stencil, k, n);
        pdi_gas_interpolate_face(gas, i, k, count, some, &face);
        pdi_gas_compute_wave_speeds(gas, n, count, &face);
        pdi_gas_add_hllc_flux(gas, n, weight, p, count, some, &face, sum);
    }
    for (int b = 0; b < count * PD_DIM && row >= 0; b++) {
        int lane = b / PD_DIM;
        double u, weight = pdi_gas_compute_slip_wall(gas, i + lane, row + lane, b % PD_DIM, n, &u);
        if (!(weight > 0.0)) continue;
        double push = gas->primitive[i + lane] * u * (u - pdi_gas_compute_slip_wall_wave(gas, i + lane, u));
        for (int d = 0; d < PD_DIM; d++) sum[PDI_GAS_VELOCITY + d][lane] += weight * push * n[d];
    }
    for (int c = 0; c < PD_GAS_FIELDS; c++)
        for (int b = 0; b < count; b++) gas->time_derivative[c * total + i + b] = -sum[c][b];
}

/* ---- open sides ---- */
/* sum [PD_GAS_FIELDS][lane 0] += twice the sum of g times the fluxes of the bonds of node i through open sides. */
static void pdi_gas_add_open_side_bonds(const pd_gas *gas, int32_t i, double (*sum)[PDI_CHUNK])
{
    const double *p = gas->primitive + PDI_GAS_PRESSURE * (int64_t)gas->grid->total + i;
    pdi_gas_face_states face;
    for (int k = 0; k < gas->bonds->stencil->count; k++) {
        double n[PD_DIM];
        if (!pdi_gas_open_boundary_is_crossed_by_bond(gas->bonds, i, k)) continue;
        double weight = pdi_gas_wall_get_bond_face(gas->bonds->stencil, k, n);
        pdi_gas_interpolate_face(gas, i, k, 1, NULL, &face);
        pdi_gas_compute_wave_speeds(gas, n, 1, &face);
        pdi_gas_add_hllc_flux(gas, n, weight, p, 1, NULL, &face, sum);
    }
}

/* sum [PD_GAS_FIELDS][lane 0] += twice the flux through the faces of node i on open sides, between its state there and
 * the one beyond (eq. 4.8). */
static void pdi_gas_add_open_side_faces(const pd_gas *gas, int32_t i, const pdi_gas_open_boundary_faces *t,
                                        double (*sum)[PDI_CHUNK])
{
    int64_t total = gas->grid->total;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        double size = pdi_vec_norm(t->area[side]), n[PD_DIM];
        int32_t beyond = t->outer_ghost[side] < 0 ? i : t->outer_ghost[side];
        pdi_gas_face_states face;
        if (!(size > 0.0)) continue;
        for (int d = 0; d < PD_DIM; d++) n[d] = t->area[side][d] / size;
        for (int c = 0; c < PD_GAS_FIELDS; c++) {
            face.left[c][0] = gas->primitive[c * total + i];
            face.right[c][0] = gas->primitive[c * total + beyond];
            for (int d = 0; d < PD_DIM && gas->gradient && (PD_DIM > 1 || beyond != i); d++)
                face.left[c][0] +=
                    t->half_length[side] / size * n[d] * gas->gradient[((int64_t)c * PD_DIM + d) * total + i];
        }
        pdi_gas_compute_wave_speeds(gas, n, 1, &face);
        pdi_gas_add_hllc_flux(gas, n, 2.0 * size, gas->primitive + PDI_GAS_PRESSURE * total + i, 1, NULL, &face, sum);
    }
}

/* Replaces the bonds through open sides by faces in time_derivative of open_side_nodes. passes [4]: sums of mass and
 * energy rates [kg/s], [J/s] (1D: per m2; 2D: per m) over nodes where they go out, then over nodes where they come in,
 * all positive. */
static void pdi_gas_update_open_side_rates(const pd_gas *gas, double *passes)
{
    int64_t total = gas->grid->total;
    for (int k = 0; k < 4; k++) passes[k] = 0.0;
    for (int32_t o = 0; o < gas->open_side_node_count; o++) {
        double sum[PD_GAS_FIELDS][PDI_CHUNK] = {{0.0}}, bonds[PD_GAS_FIELDS][PDI_CHUNK] = {{0.0}};
        int32_t i = gas->open_side_nodes[o];
        pdi_gas_open_boundary_faces t;
        pdi_gas_open_boundary_compute_faces(gas->bonds, i, &t);
        pdi_gas_add_open_side_bonds(gas, i, bonds);
        pdi_gas_add_open_side_faces(gas, i, &t, sum);
        for (int c = 0; c < PD_GAS_FIELDS; c++) gas->time_derivative[c * total + i] += bonds[c][0] - sum[c][0];
        for (int k = 0; k < 2; k++) {
            double passing = sum[k ? PDI_GAS_PRESSURE : 0][0] * gas->bonds->stencil->volume;
            passes[passing > 0.0 ? k : 2 + k] += fabs(passing);
        }
    }
}

/* Kernel: sum over the faces of a node of weight times size of the slowest wave where that is negative [1/s], with the
 * states of the nodes as they are, and over its slip walls (eq. 4.10), into the first field of time_derivative. One
 * over it is the step limit of the node. */
static void pdi_gas_compute_limit_kernel(const pd_gas *gas, int32_t i, int32_t row, int count)
{
    const pd_bonds *bonds = gas->bonds;
    double sum[PDI_CHUNK], open[PDI_CHUNK], n[PD_DIM];
    pd_gas nodes = *gas;
    pdi_gas_face_states face;
    nodes.gradient = NULL;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_bond_openness lanes = pdi_bond_find_nodes_open(bonds, row, k, count, &gate, open);
        if (lanes == PDI_BOND_OPEN_NONE) continue;
        double weight = pdi_gas_wall_get_bond_face(bonds->stencil, k, n);
        pdi_gas_interpolate_face(&nodes, i, k, count, lanes == PDI_BOND_OPEN_SOME ? open : NULL, &face);
        pdi_gas_compute_wave_speeds(gas, n, count, &face);
        for (int b = 0; b < count; b++) {
            double back = face.s_left[b] < 0.0 ? -weight * face.s_left[b] : 0.0;
            sum[b] += lanes == PDI_BOND_OPEN_SOME ? open[b] * back : back;
        }
    }
    for (int b = 0; b < count * PD_DIM && row >= 0; b++) {
        int lane = b / PD_DIM;
        double u, weight = pdi_gas_compute_slip_wall(&nodes, i + lane, row + lane, b % PD_DIM, n, &u);
        if (weight > 0.0) sum[lane] -= weight * pdi_gas_compute_slip_wall_wave(gas, i + lane, u);
    }
    memcpy(gas->time_derivative + i, sum, (size_t)count * sizeof(double));
}

/* ---- steps ---- */
/* Fails with PD_ERR_STATE and a message about the inadmissible state of a node. */
static pd_status pdi_gas_fail_inadmissible(pd_ctx *ctx, const pd_gas *gas, int32_t node)
{
    int64_t total = gas->grid->total;
    char place[PDI_GRID_POSITION_LENGTH];
    return pd_fail(ctx, PD_ERR_STATE, "gas",
                   "node %d at %s m has rho = %g kg/m3 and rho E = %g J/m3 at t = %g s: density and pressure "
                   "must be positive and finite",
                   (int)node, pdi_grid_format_position(gas->grid, node, place), gas->state[node],
                   gas->state[PDI_GAS_PRESSURE * total + node], gas->time);
}

pd_status pd_gas_limit(pd_ctx *ctx, pd_gas *gas, double *limit)
{
    double fastest = 0.0;
    int32_t bad = pdi_gas_update_primitives(ctx, gas);
    *limit = 0.0;
    if (bad >= 0) return pdi_gas_fail_inadmissible(ctx, gas, bad);
    pdi_gas_update_ghosts(gas, 0);
    pdi_gas_apply_kernel(ctx, gas, pdi_gas_compute_limit_kernel);
    for (int32_t i = 0; i < gas->grid->total; i++)
        if (gas->grid->kind[i] == PD_FLUID) fastest = pd_max(fastest, gas->time_derivative[i]);
    *limit = fastest > 0.0 ? 1.0 / fastest : HUGE_VAL;
    return PD_OK;
}

/* A Runge-Kutta stage (Shu and Osher 1988): state = start_weight start_state + (1 - start_weight) (state + dt
 * time_derivative). */
typedef struct pdi_gas_rk_stage {
    double start_weight, dt;
} pdi_gas_rk_stage;

/* State u of node i after the stage. A state without rate keeps its bits. */
static void pdi_gas_compute_stage_state(const pd_gas *gas, const pdi_gas_rk_stage *g, int32_t i, double *u)
{
    int64_t total = gas->grid->total;
    for (int c = 0; c < PD_GAS_FIELDS; c++) {
        double start = gas->start_state[c * total + i];
        double change = (gas->state[c * total + i] - start) + g->dt * gas->time_derivative[c * total + i];
        u[c] = start + (1.0 - g->start_weight) * change;
    }
}

/* Updates first_order_flag at fluid nodes: 1: the stage would leave the node inadmissible, 2: flagged in an earlier
 * round, 3: both, 0: neither. *last: the last one of the inadmissible nodes. Returns their number, or -1 when one of
 * them was flagged before, so that first order has not helped. The state stays. */
static int64_t pdi_gas_mark_inadmissible(const pd_ctx *ctx, pd_gas *gas, const pdi_gas_rk_stage *g, int32_t *last)
{
    const uint8_t *kind = gas->grid->kind;
    int32_t total = gas->grid->total;
    int64_t found = 0;
    int again = 0, nt = pd_par_threads(ctx, (int64_t)total * 16);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++) {
        double u[PD_GAS_FIELDS], q[PD_GAS_FIELDS];
        if (kind[i] != PD_FLUID) continue;
        pdi_gas_compute_stage_state(gas, g, i, u);
        int good = pdi_gas_compute_primitive(gas->desc.gamma, u, q);
        gas->first_order_flag[i] = (uint8_t)(gas->first_order_flag[i] ? 2 + !good : !good);
    }
    for (int32_t i = 0; i < total; i++) {
        if (!(gas->first_order_flag[i] & 1)) continue;
        again = again || gas->first_order_flag[i] == 3;
        found++;
        *last = i;
    }
    return again ? -1 : found;
}

/* First order at nodes of flag 1, which are added to first_order_count: zero gradients there and at the far ends of
 * their bonds; images and outlet ghosts count for their sources. Ghosts of the gradients are filled. Gradients must be
 * allocated. */
static void pdi_gas_set_first_order(pd_gas *gas)
{
    const pd_bonds *bonds = gas->bonds;
    const pd_grid *grid = gas->grid;
    int64_t total = grid->total;
    for (int32_t i = 0; i < grid->total; i++) {
        if (gas->first_order_flag[i] != 1) continue;
        gas->first_order_count++;
        for (int k = -1; k < bonds->stencil->count; k++) {
            int32_t j = k < 0 ? i : i + bonds->paths.shift[k];
            if (grid->kind[j] == PD_IMAGE || grid->kind[j] == PD_OUTLET) j = pd_grid_find_source(grid, j, NULL);
            for (int c = 0; c < PD_GAS_FIELDS * PD_DIM; c++) gas->gradient[c * total + j] = 0.0;
        }
    }
    pdi_gas_update_ghosts(gas, 1);
}

/* Does a stage. Nodes that would become inadmissible fall back to first order, and the rates are computed again. 1:
 * done; passes [4]: flow rates through open sides (pdi_gas_update_open_side_rates). 0: *lost is an inadmissible node,
 * the state is that before the stage: it fell back in vain, there are no gradients, or 8 such rounds were not
 * enough. */
static int pdi_gas_try_stage(const pd_ctx *ctx, pd_gas *gas, const pdi_gas_rk_stage *g, int32_t *lost, double *passes)
{
    const uint8_t *kind = gas->grid->kind;
    int32_t total = gas->grid->total;
    int64_t found;
    int nt = pd_par_threads(ctx, (int64_t)total * 8);
    (void)nt;
    memset(gas->first_order_flag, 0, (size_t)total);
    pdi_gas_compute_gradients(ctx, gas);
    for (int round = 0;; round++) {
        pdi_gas_apply_kernel(ctx, gas, pdi_gas_compute_rates_kernel);
        pdi_gas_update_open_side_rates(gas, passes);
        found = pdi_gas_mark_inadmissible(ctx, gas, g, lost);
        if (found <= 0 || !gas->gradient || round == PDI_GAS_MAX_FALLBACK_ROUNDS) break;
        pdi_gas_set_first_order(gas);
    }
    if (found != 0) return 0;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++) {
        double u[PD_GAS_FIELDS];
        if (kind[i] != PD_FLUID) continue;
        pdi_gas_compute_stage_state(gas, g, i, u);
        for (int c = 0; c < PD_GAS_FIELDS; c++) gas->state[(int64_t)c * total + i] = u[c];
    }
    return 1;
}

pd_status pd_gas_step(pd_ctx *ctx, pd_gas *gas, double dt)
{
    static const double old_share[3] = {0.0, 0.75, 1.0 / 3.0};
    static const double weight[3] = {1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0}; /* of the rates of the stages in the step */
    double passes[3][4];
    int64_t size = (int64_t)PD_GAS_FIELDS * gas->grid->total;
    if (!(dt > 0.0) || !(dt < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "gas", "the step is %g s, expected a positive one", dt);
    int32_t bad = pdi_gas_update_primitives(ctx, gas);
    if (bad >= 0) return pdi_gas_fail_inadmissible(ctx, gas, bad);
    pdi_par_copy(ctx, size, gas->state, gas->start_state);
    for (int stage = 0; stage < 3; stage++) {
        pdi_gas_rk_stage g;
        g.start_weight = old_share[stage];
        g.dt = dt;
        int done = pdi_gas_try_stage(ctx, gas, &g, &bad, passes[stage]);
        if (!done) pdi_par_copy(ctx, size, gas->start_state, gas->state);
        pdi_gas_update_primitives(ctx, gas);
        if (done) continue;
        return pd_fail(ctx, PD_RETRY, "gas", "density or pressure of node %d turns non-positive in a step of %g s at "
                       "t = %g s", (int)bad, dt, gas->time);
    }
    for (int stage = 0; stage < 3; stage++)
        for (int k = 0; k < 2; k++) {
            gas->outflow[k] += dt * weight[stage] * passes[stage][k];
            gas->inflow[k] += dt * weight[stage] * passes[stage][2 + k];
        }
    gas->time += dt;
    gas->steps++;
    return PD_OK;
}

/* ---- the process ---- */

PDI_COLD_BEGIN
/* Process callback: s->dt is cfl times the step limit. */
static pd_status pdi_gas_limit_step(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_gas *gas = (pd_gas *)self;
    PD_TRY(pd_gas_limit(ctx, gas, &s->dt));
    s->dt *= gas->desc.cfl;
    return PD_OK;
}

/* Process callback: tries one step. */
static pd_status pdi_gas_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    return pd_gas_step(ctx, (pd_gas *)self, s->dt);
}

/* Process callback: sets the time. */
static pd_status pdi_gas_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    ((pd_gas *)self)->time = s->end;
    return PD_OK;
}

/* Process callback: halves a rejected step and counts it. PD_ERR_STATE: it was rejected after 20 halvings. */
static pd_status pdi_gas_reject_step(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_gas *gas = (pd_gas *)self;
    if (s->rejected == PDI_GAS_MAX_HALVINGS)
        return pd_fail(ctx, PD_ERR_STATE, "gas", "steps down to %g s at t = %g s leave the admissible range", s->dt,
                       s->time);
    s->dt *= 0.5;
    gas->rejected++;
    return PD_OK;
}

/* Process callback: fails, since steps have become too short for the time to advance. */
static pd_status pdi_gas_fail_step_underflow(pd_ctx *ctx, void *self, const pd_step *s)
{
    (void)self;
    return pd_fail(ctx, PD_ERR_STATE, "gas",
                   "steps of %g s do not lead on from t = %g s to %g s: the gas is too fast for this lattice", s->dt,
                   s->time, s->latest_end);
}

/* Process callback: writes or reads the checkpoint; primitive states follow. PD_ERR_STATE: a state read is not
 * admissible. */
static pd_status pdi_gas_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_gas *gas = (pd_gas *)self;
    PD_TRY(pdi_array_registry_store(ctx, pdi_gas_list, gas, archive));
    int32_t bad = archive->is_reading ? pdi_gas_update_primitives(ctx, gas) : -1;
    return bad < 0 ? PD_OK : pdi_gas_fail_inadmissible(ctx, gas, bad);
}

static const pd_element pdi_gas_element[2] = {{"mass", "kg"}, {"energy", "J"}};

/* Process callback: adds mass (k = 0) or energy (k = 1) to the balance. */
static void pdi_gas_add_balance(pd_ctx *ctx, void *self, int k, pd_amounts *a)
{
    const pd_gas *gas = (const pd_gas *)self;
    double stock[PD_GAS_FIELDS];
    pdi_gas_integrate_state(ctx, gas, stock);
    a->dissolved += stock[k ? PDI_GAS_PRESSURE : 0];
    a->out += gas->outflow[k];
    a->in += gas->inflow[k];
}

pd_physics pd_gas_process(pd_gas *gas)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "gas";
    p.self = gas;
    p.time = &gas->time;
    p.element = pdi_gas_element;
    p.elements = 2;
    p.has_substeps = 1;
    p.steps = &gas->steps;
    p.max_run_step = pdi_physics_limit_max_step;
    p.limit = pdi_gas_limit_step;
    p.attempt = pdi_gas_attempt;
    p.accept = pdi_gas_accept;
    p.reject = pdi_gas_reject_step;
    p.report_underflow = pdi_gas_fail_step_underflow;
    p.checkpoint = pdi_gas_store;
    p.add_amounts = pdi_gas_add_balance;
    return p;
}

PDI_FN void pdi_gas_integrate_state(pd_ctx *ctx, const pd_gas *gas, double *stock)
{
    const pd_grid *grid = gas->grid;
    (void)ctx;
    for (int c = 0; c < PD_GAS_FIELDS; c++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        for (int32_t i = 0; i < grid->total; i++)
            if (grid->kind[i] == PD_FLUID) pdi_compensated_sum_add(&sum, gas->state[(int64_t)c * grid->total + i]);
        stock[c] = pdi_compensated_sum_total(&sum) * gas->bonds->stencil->volume;
    }
}

/* ---- build ---- */
/* Allocates and fills the list of fluid nodes with bonds, open or closed, to ghosts of inlets and outlets. */
static pd_status pdi_gas_find_open_side_nodes(pd_ctx *ctx, pd_gas *gas)
{
    const pd_bonds *bonds = gas->bonds;
    int32_t total = gas->grid->total;
    for (int fill = 0; fill < 2; fill++) {
        int32_t found = 0;
        for (int32_t i = 0; i < total; i++) {
            int open = 0;
            if (gas->grid->kind[i] != PD_FLUID) continue;
            for (int k = 0; k < bonds->stencil->count && !open; k++)
                open = pdi_gas_open_boundary_is_open_kind(gas->grid->kind[i + bonds->paths.shift[k]]);
            if (open && fill) gas->open_side_nodes[found] = i;
            found += open;
        }
        gas->open_side_node_count = found;
        if (!fill) PD_TRY(PD_NEW(ctx, "gas", found, gas->open_side_nodes));
    }
    return PD_OK;
}

/* Sets the initial state of a node by the callback, and its primitive state. A ghost takes the point inside the box
 * that it stands for, with velocity components reversed across mirror sides. PD_ERR_ARGUMENT: it is not admissible. */
static pd_status pdi_gas_init_node(pd_ctx *ctx, const pd_gas *gas, int32_t node)
{
    const pd_grid *grid = gas->grid;
    int64_t total = grid->total;
    double x[PD_DIM], v[PD_DIM], rho = 0.0, p = 0.0, kinetic = 0.0;
    int i[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) v[d] = 0.0;
    pd_grid_index(grid, node, i);
    int odd = pdi_grid_fold_index(grid, i);
    pd_grid_position(grid, pd_grid_node(grid, i), x);
    gas->desc.initial(gas->desc.initial_user, x, &rho, v, &p);
    gas->state[node] = rho;
    for (int d = 0; d < PD_DIM; d++) {
        kinetic += 0.5 * rho * v[d] * v[d];
        gas->state[(PDI_GAS_VELOCITY + d) * total + node] = odd >> d & 1 ? -rho * v[d] : rho * v[d];
    }
    gas->state[PDI_GAS_PRESSURE * total + node] = p / (gas->desc.gamma - 1.0) + kinetic;
    if (pdi_gas_update_primitive(gas, node)) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "gas",
                   "the initial state at (%g, ...) m has rho = %g kg/m3, v = (%g, ...) m/s and p = %g Pa: density and "
                   "pressure must be positive and finite",
                   x[0], rho, v[0], p);
}

PDI_FN void pdi_gas_list(pdi_array_visitor *owner, void *object)
{
    pd_gas *gas = (pd_gas *)object;
    int64_t total = gas->grid ? gas->grid->total : 0;
    PDI_ARRAY_STATE(owner, gas, state, PD_GAS_FIELDS * total, "");
    PDI_ARRAY(owner, gas, primitive, PD_GAS_FIELDS * total, "");
    PDI_ARRAY(owner, gas, start_state, PD_GAS_FIELDS * total, "");
    PDI_ARRAY(owner, gas, time_derivative, PD_GAS_FIELDS * total, "");
    PDI_ARRAY(owner, gas, wall_face, (int64_t)gas->rows * PD_DIM * PD_DIM, "1/m");
    PDI_ARRAY(owner, gas, wall_distance, (int64_t)gas->rows * PD_DIM, "m");
    PDI_ARRAY(owner, gas, first_order_flag, total, "1");
    if (gas->desc.spatial_order == PD_GAS_SECOND) PDI_ARRAY(owner, gas, gradient, PD_GAS_FIELDS * PD_DIM * total, "");
    PDI_ARRAY_GROWING(owner, gas, open_side_nodes, gas->open_side_node_count, "1");
    PDI_SCALAR_STATE(owner, gas, outflow, "");
    PDI_SCALAR_STATE(owner, gas, inflow, "");
    PDI_SCALAR_STATE(owner, gas, time, "s");
    PDI_SCALAR_STATE(owner, gas, steps, "1");
    PDI_SCALAR_STATE(owner, gas, rejected, "1");
    PDI_SCALAR_STATE(owner, gas, first_order_count, "1");
}

/* Inner part of the build: checks desc, sets cfl (0: 0.8), allocates, finds open sides and slip walls, and sets the
 * initial states of fluid nodes and inlets if there is a callback. The caller frees after an error. */
static pd_status pdi_gas_try_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_gas_desc *desc,
                                   pd_gas *gas)
{
    int64_t total = grid->total;
    memset(gas, 0, sizeof *gas);
    gas->desc = *desc;
    if (!(gas->desc.cfl > 0.0)) gas->desc.cfl = 0.8;
    if (!(desc->gamma > 1.0) || !(desc->gamma < 100.0) || !(desc->cfl >= 0.0) || !(desc->cfl < 100.0) ||
        (desc->spatial_order != PD_GAS_SECOND && desc->spatial_order != PD_GAS_FIRST))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "gas",
                       "gamma = %g must be above 1, cfl = %g not negative, both finite, order %d one of pd_gas_order",
                       desc->gamma, desc->cfl, (int)desc->spatial_order);
    if (grid->circumference)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "gas", "found an axisymmetric grid, expected a planar one");
    gas->grid = grid;
    gas->bonds = bonds;
    gas->rows = bonds->rows;
    PD_TRY(pdi_array_registry_build(ctx, pdi_gas_list, gas));
    PD_TRY(pdi_gas_find_open_side_nodes(ctx, gas));
    PD_TRY(pdi_gas_wall_build(ctx, bonds, gas->rows, gas->wall_face, gas->wall_distance));
    for (int32_t node = 0; node < total && desc->initial; node++)
        if (pdi_gas_has_state(grid->kind[node])) PD_TRY(pdi_gas_init_node(ctx, gas, node));
    return PD_OK;
}

pd_status pd_gas_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_gas_desc *desc, pd_gas *gas)
{
    pd_status status = pdi_gas_try_build(ctx, grid, bonds, desc, gas);
    if (status < 0) pd_gas_free(ctx, gas);
    return status;
}

void pd_gas_free(pd_ctx *ctx, pd_gas *gas)
{
    pdi_array_registry_free(ctx, pdi_gas_list, gas);
    memset(gas, 0, sizeof *gas);
}
PDI_COLD_END
