/* cell: see cell.h */
#include "potential/cell.h"
#include "core/par.h"
#include "potential/circuit.h"
#include <math.h>
#include <string.h>

/* [cells] Contacts are looked for this far from a fluid node. */
#define PDI_CELL_AROUND 2

PDI_FN void pdi_cell_list(pdi_array_visitor *owner, void *object)
{
    pd_cell *cell = (pd_cell *)object;
    if (!cell->grid) return;
    int64_t total = cell->grid->total, electrodes = cell->desc.potential.electrodes;
    PDI_ARRAY(owner, cell, curve, electrodes, "");
    PDI_ARRAY(owner, cell, circuit, cell->desc.potential.circuits, "");
    PDI_ARRAY(owner, cell, kinds, electrodes, "1");
    PDI_ARRAY_STATE(owner, cell, charge, electrodes, "C");
    PDI_ARRAY_STATE(owner, cell, anodic, electrodes, "C");
    PDI_ARRAY_STATE(owner, cell, charge_error, electrodes, "C");
    PDI_ARRAY_STATE(owner, cell, last_current, electrodes, "A");
    PDI_ARRAY(owner, cell, stock, electrodes, "mol");
    PDI_ARRAY_STATE(owner, cell, met, electrodes, "V");
    PDI_ARRAY(owner, cell, factor, electrodes, "1");
    PDI_ARRAY(owner, cell, metal, total, "1");
    if (cell->dissolve) PDI_ARRAY(owner, cell, left, total, "1");
    PDI_ARRAY(owner, cell, first, total, "1");
    if (!cell->desc.conduct) return;
    PDI_ARRAY(owner, cell, field, total, "S/m");
    PDI_ARRAY(owner, cell, last_field, total, "S/m");
    PDI_ARRAY_STATE(owner, cell, change, total, "S/m/s");
}

/* ---- the surface as it is ---- */

/* Metal that stands out of its cell counts as that of a whole one. */
static void pdi_cell_left(pd_cell *cell)
{
    for (int32_t i = 0; i < cell->grid->total && cell->left; i++)
        if (cell->grid->kind[i] == PD_SOLID)
            cell->left[i] = pd_min(pd_max(pdi_metal_left(cell->dissolve, i), 0.0), 1.0);
}

static void pdi_cell_index(pd_cell *cell)
{
    const pd_contacts *c = &cell->potential.contacts;
    for (int32_t i = 0; i < cell->grid->total; i++) cell->first[i] = -1;
    for (int32_t k = pdi_contact_all(c); k-- > 0;) cell->first[c->list[k].node] = k;
}

/* 1: contact k is one of node i. */
static int pdi_cell_at_node(const pd_potential *p, int32_t k, int32_t i)
{
    return k >= 0 && k < pdi_contact_all(&p->contacts) && p->contacts.list[k].node == i;
}

/* Adds the contacts of node i with a metal of `kinds` (bits): sums of area, and of area times the rest. */
static void pdi_cell_add(const pd_cell *cell, int32_t i, uint32_t kinds, double sum[3])
{
    const pd_potential *p = &cell->potential;
    for (int32_t k = cell->first[i]; pdi_cell_at_node(p, k, i); k++) {
        const pd_contact *c = &p->contacts.list[k];
        if (!(cell->kinds[c->electrode] & kinds)) continue;
        sum[0] += c->area;
        sum[1] += c->area * p->current[k] * cell->factor[c->electrode];
        sum[2] += c->area * p->surface[k];
    }
}

/* The nodes around i whose largest distance along an axis is `reach` cells. */
static void pdi_cell_around(const pd_cell *cell, int32_t i, int reach, uint32_t kinds, double sum[3])
{
    for (int k = 0; k < pdi_grid_count_cube(reach); k++) {
        int far;
        int32_t j = pdi_grid_find_cube_node(cell->grid, i, reach, k, &far);
        if (j >= 0 && far == reach) pdi_cell_add(cell, j, kinds, sum);
    }
}

/* The contacts nearest to node i: how far off they are in cells, and their sums. -1: there are none. */
static int pdi_cell_nearest(const pd_cell *cell, int32_t i, uint32_t kinds, double sum[3])
{
    sum[0] = sum[1] = sum[2] = 0.0;
    for (int reach = 0; reach <= PDI_CELL_AROUND; reach++) {
        pdi_cell_around(cell, i, reach, kinds, sum);
        if (sum[0] > 0.0) return reach;
    }
    return -1;
}

PDI_FN int pdi_cell_beside(const pd_cell *cell, int32_t i, int kind, double *current, double *surface)
{
    double sum[3];
    pdi_cell_nearest(cell, i, (uint32_t)1 << kind, sum);
    *current = sum[0] > 0.0 ? sum[1] / sum[0] : 0.0;
    *surface = sum[0] > 0.0 ? sum[2] / sum[0] : 0.0;
    return sum[0] > 0.0;
}

/* What metal `kind` beside node i, of `area` [1/m] over its volume, gets of the currents of electrodes. */
static void pdi_cell_gets(const pd_cell *cell, int32_t i, int kind, double area, double *got)
{
    const pd_potential *p = &cell->potential;
    uint32_t kinds = (uint32_t)1 << kind;
    double sum[3];
    int reach = pdi_cell_nearest(cell, i, kinds, sum);
    if (reach < 0 || !(sum[1] > 0.0)) return;
    for (int n = 0; n < pdi_grid_count_cube(reach); n++) {
        int far;
        int32_t j = pdi_grid_find_cube_node(cell->grid, i, reach, n, &far),
                k = j >= 0 && far == reach ? cell->first[j] : -1;
        for (; pdi_cell_at_node(p, k, j); k++) {
            const pd_contact *c = &p->contacts.list[k];
            if (cell->kinds[c->electrode] & kinds) got[c->electrode] += area * c->area * p->current[k] / sum[0];
        }
    }
}

PDI_FN void pdi_cell_match(pd_cell *cell)
{
    const pd_potential *p = &cell->potential;
    const pd_dissolve *d = cell->dissolve;
    double wanted[PD_ELECTRODES], got[PD_ELECTRODES];
    for (int e = 0; e < p->desc.electrodes; e++) {
        cell->factor[e] = 1.0;
        wanted[e] = got[e] = 0.0;
    }
    for (int32_t k = 0; k < p->contacts.count; k++) {
        const pd_contact *c = &p->contacts.list[k];
        if (pdi_metal_passive(d, c->node)) continue;
        wanted[c->electrode] += pdi_potential_area(p, c) * pd_max(p->current[k], 0.0);
    }
    for (int32_t n = 0; n < d->beside_count; n++) {
        const pdi_beside *beside = &d->beside[n];
        double around = pd_grid_circumference(cell->grid, beside->node);
        for (int m = 0; m < d->kinds; m++) {
            double weight = pdi_metal_portion(d, beside)[m].weight;
            if (weight > 0.0) pdi_cell_gets(cell, beside->node, m, around * weight / d->kind[m].supply, got);
        }
    }
    for (int e = 0; e < p->desc.electrodes; e++)
        if (wanted[e] > 0.0 && got[e] > 0.0) cell->factor[e] = wanted[e] / got[e];
}

PDI_FN double pdi_cell_density(const pd_cell *cell, int32_t i)
{
    const pd_potential *p = &cell->potential;
    double area = 0.0, current = 0.0;
    for (int32_t k = cell->first[i]; pdi_cell_at_node(p, k, i); k++) {
        area += p->contacts.list[k].area;
        current += p->contacts.list[k].area * p->current[k];
    }
    return area > 0.0 ? current / area : (double)NAN;
}

/* What bond k of node i conducts in the electrolyte [S/m3]. */
static double pdi_cell_conduct(const pd_potential *p, int32_t i, int k)
{
    const pd_bonds *bonds = p->bonds;
    int32_t row = bonds->row_of_node[i];
    double bond;
    pdi_diffusion_bond(&p->diffusion, i, k, 1, row >= 0, &bond);
    return row >= 0 && (bonds->has_inlet[row] || bonds->grid->mixed_sides) ? pdi_conductance_beside(bonds, i, k, bond)
                                                                           : bond;
}

/* What bond k of node i carries away through the electrolyte, or to a side that holds a potential [A/m3]. */
static double pdi_cell_carried(const pd_potential *p, int32_t i, int k)
{
    const pd_bonds *bonds = p->bonds;
    const pd_grid *grid = bonds->grid;
    int32_t row = bonds->row_of_node[i], far = i + bonds->paths.shift[k];
    double value = 0.0;
    if (row >= 0 && !pdi_bond_is_open(bonds, row, k)) {
        double conduct = pdi_diffusion_wall(&p->diffusion, row, k, &value);
        return conduct > 0.0 ? conduct * ((p->phi[i] - p->origin) - value) : 0.0;
    }
    if (grid->kind[far] == PD_INLET) {
        int side = pdi_circuit_side(grid, far);
        return p->desc.held[side] ? pdi_cell_conduct(p, i, k) * (p->phi[i] - p->desc.hold[side]) : 0.0;
    }
    int32_t home = pd_grid_find_source(grid, far, NULL);
    return grid->kind[home] == PD_FLUID ? pdi_cell_conduct(p, i, k) * (p->phi[i] - p->phi[home]) : 0.0;
}

PDI_FN void pdi_cell_current(const pd_cell *cell, int32_t i, double *j)
{
    const pd_potential *p = &cell->potential;
    const pd_stencil *s = p->bonds->stencil;
    memset(j, 0, PD_DIM * sizeof *j);
    for (int k = 0; k < s->count; k++) {
        double carried = pdi_cell_carried(p, i, k);
        for (int d = 0; d < PD_DIM; d++) j[d] += 0.5 * carried * s->xi[k * PD_DIM + d];
    }
    for (int32_t n = cell->first[i]; pdi_cell_at_node(p, n, i); n++)
        for (int d = 0; d < PD_DIM; d++) j[d] += p->current[n] * p->contacts.list[n].moment[d];
}

/* [mol] of metal that an electrode has: of each node the share of its supply that is left. */
static double pdi_cell_stock(const pd_cell *cell, int electrode)
{
    const pd_grid *grid = cell->grid;
    const pd_dissolve *d = cell->dissolve;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < grid->total && d; i++)
        if (grid->kind[i] == PD_SOLID && cell->metal[i] == electrode && pd_grid_find_source(grid, i, NULL) == i)
            pdi_compensated_sum_add(&sum,
                                    pdi_metal_solid(d, i) * pdi_metal_left(d, i) * pd_grid_circumference(grid, i));
    return pdi_compensated_sum_total(&sum) * cell->potential.bonds->stencil->volume;
}

/* [V] E of a circuit; NaN: neither it is given nor a current passes. */
static double pdi_cell_known(const pd_potential *p, int circuit)
{
    if (p->desc.circuit[circuit].control == PD_CIRCUIT_POTENTIAL) return p->metal[circuit];
    for (int32_t k = 0; k < p->contacts.count; k++)
        if (pdi_potential_circuit(p, p->contacts.list[k].electrode) == circuit) return p->metal[circuit];
    return (double)NAN;
}

void pd_cell_electrode_of(const pd_cell *cell, int electrode, pd_cell_electrode *now)
{
    const pd_potential *p = &cell->potential;
    double volume = p->bonds->stencil->volume;
    int touched = 0;
    memset(now, 0, sizeof *now);
    now->potential = pdi_cell_known(p, pdi_potential_circuit(p, electrode));
    for (int32_t k = 0; k < pdi_contact_all(&p->contacts); k++) {
        const pd_contact *c = &p->contacts.list[k];
        if (c->electrode != electrode) continue;
        if (now->touches != PD_CELL_WORKS) now->touches = k < p->contacts.count ? PD_CELL_WORKS : PD_CELL_IDLE;
        double area = volume * pdi_potential_area(p, c), i = p->current[k];
        now->area += area;
        now->current += area * i;
        now->anodic += area * pd_max(i, 0.0);
        now->least = touched ? pd_min(now->least, i) : i;
        now->most = touched ? pd_max(now->most, i) : i;
        touched = 1;
    }
    now->charge = cell->charge[electrode];
    now->passed = cell->anodic[electrode];
    now->charge_error = cell->charge_error[electrode];
    now->met = cell->met[electrode];
    now->lost = cell->stock[electrode] - pdi_cell_stock(cell, electrode);
}

/* ---- the process ---- */

const pd_electrode_term *pd_cell_table(const pd_cell *cell, int electrode)
{
    const pd_electrode *e = &cell->curve[electrode];
    return e->count == 1 && e->term->kind == PD_ELECTRODE_TABLE ? e->term : NULL;
}

PDI_FN void pdi_cell_meet(const pd_electrode_term *table, double u, double t, pd_cell_range *met)
{
    met->least = pd_min(met->least, u);
    met->most = pd_max(met->most, u);
    int outside = u < table->potential[0] || u > table->potential[table->points - 1];
    if (outside && t < met->left) met->left = t;
}

/* What surfaces have met by the present solution. */
static void pdi_cell_watch(pd_cell *cell)
{
    const pd_potential *p = &cell->potential;
    for (int e = 0; e < p->desc.electrodes; e++) {
        const pd_electrode_term *table = pd_cell_table(cell, e);
        for (int32_t k = 0; table && k < p->contacts.count; k++)
            if (p->contacts.list[k].electrode == e && p->contacts.list[k].share > 0.0)
                pdi_cell_meet(table, p->surface[k], cell->time, &cell->met[e]);
    }
}

static pd_status pdi_cell_solve(pd_ctx *ctx, pd_cell *cell, double t)
{
    char name[PDI_CIRCUIT_NAME];
    if (cell->desc.apart) return PD_OK;
    for (int n = 0; n < cell->desc.potential.circuits && cell->desc.given; n++)
        cell->circuit[n].value = cell->desc.given(cell->desc.user, n, t);
    if (cell->desc.share)
        PD_TRY(cell->desc.share(ctx, cell->desc.user, cell->potential.contacts.list, cell->potential.contacts.count,
                                t));
    pd_status status = pd_potential_solve(ctx, &cell->potential, &cell->result);
    if (status < 0) return status;
    if (status != PD_OK)
        return pd_fail(ctx, PD_ERR_DIVERGED, "potential", "at t = %g s the balances of currents lack %.3g of them "
                       "after %d steps of Newton's method, most at %s, expected at most %g: a larger tolerance of "
                       "[potential] accepts it", t, cell->result.residual,
                       cell->result.newton, pdi_circuit_electrode(&cell->potential, cell->result.worst, name),
                       cell->potential.desc.tolerance);
    cell->time = t;
    cell->solves++;
    cell->newton += cell->result.newton;
    cell->krylov += cell->result.krylov;
    pdi_cell_watch(cell);
    pdi_cell_index(cell);
    return PD_OK;
}

/* Conductivities as they are now, and how they change since the end of the last step, `span` [s] ago. Nodes that were
 * metal then have no past. */
static void pdi_cell_conduct_now(pd_cell *cell, double span)
{
    cell->desc.conduct(cell->desc.user, cell->field);
    for (int32_t i = 0; i < cell->grid->total; i++) {
        int known = span > 0.0 && cell->last_field[i] > 0.0;
        if (span > 0.0) cell->change[i] = known ? (cell->field[i] - cell->last_field[i]) / span : 0.0;
        cell->last_field[i] = cell->field[i];
    }
}

/* Contacts, and conductances where fluid or conductivity are others. span [s]: that of a step which ends; 0: none. */
static pd_status pdi_cell_renew(pd_ctx *ctx, pd_cell *cell, double span)
{
    int anew = cell->stale || cell->desc.conduct;
    pdi_cell_left(cell);
    if (cell->desc.conduct) pdi_cell_conduct_now(cell, span);
    cell->stale = 0;
    cell->potential.desc.idle = 1; /* what metal leaves behind as it goes */
    if (anew) return pd_potential_update(ctx, &cell->potential);
    return cell->dissolve ? pdi_distribution_contacts(ctx, &cell->potential) : PD_OK;
}

/* What species that move bring to nodes goes on as in the last step; a conductivity that falls comes to rest at 0. */
static void pdi_cell_foresee(pd_cell *cell, double t)
{
    for (int32_t i = 0; i < cell->grid->total; i++) {
        double last = cell->last_field[i], change = (t - cell->reached) * cell->change[i];
        cell->field[i] = change < 0.0 ? last / (1.0 - change / last) : last + change;
    }
}

PDI_FN pd_status pdi_cell_bring(pd_ctx *ctx, pd_cell *cell, double t)
{
    if (cell->desc.apart) return PD_OK;
    if (cell->solves && !cell->stale && !(cell->time < t) && !(cell->time > t)) return PD_OK;
    if (cell->stale) PD_TRY(pdi_cell_renew(ctx, cell, 0.0));
    if (cell->desc.conduct) {
        pdi_cell_foresee(cell, t);
        PD_TRY(pd_potential_update(ctx, &cell->potential));
    }
    return pdi_cell_solve(ctx, cell, t);
}

/* ---- charges ---- */

/* [A] (per m in planar 2D, per m2 in 1D) of each electrode. */
static void pdi_cell_passes(const pd_potential *p, double *passes)
{
    for (int e = 0; e < p->desc.electrodes; e++) passes[e] = 0.0;
    for (int32_t k = 0; k < p->contacts.count; k++)
        passes[p->contacts.list[k].electrode] += pdi_potential_area(p, &p->contacts.list[k]) * p->current[k];
    for (int e = 0; e < p->desc.electrodes; e++) passes[e] *= p->bonds->stencil->volume;
}

/* Charges of `span` [s] by the currents at hand. */
static void pdi_cell_count(pd_cell *cell, double span)
{
    const pd_potential *p = &cell->potential;
    for (int32_t k = 0; k < p->contacts.count; k++) {
        const pd_contact *c = &p->contacts.list[k];
        double passed = span * p->bonds->stencil->volume * pdi_potential_area(p, c) * p->current[k];
        cell->charge[c->electrode] += passed;
        cell->anodic[c->electrode] += pd_max(passed, 0.0);
    }
}

/* What a charge over a span of 1 s misses where the current goes from `first` to `last`, and counts as `held`: the
 * first one, or (middle) that of the middle. Simpson's rule says by how much the middle is off. Where the middle has
 * the current of one end, it has jumped at the other. */
static double pdi_cell_misses(double first, double held, double last, int middle)
{
    double simpson = fabs(first - 2.0 * held + last) / 6.0;
    if (!middle) return 0.5 * fabs(last - first);
    return pd_min(simpson, pd_min(fabs(held - first), fabs(last - held)));
}

/* A solution for the end t of a step, with the errors of its charges. `held` [electrodes] [A]: what they went by. */
static pd_status pdi_cell_end(pd_ctx *ctx, pd_cell *cell, double t, const double *held, int middle)
{
    double now[PD_ELECTRODES];
    PD_TRY(pdi_cell_solve(ctx, cell, t));
    pdi_cell_passes(&cell->potential, now);
    for (int e = 0; e < cell->potential.desc.electrodes; e++) {
        double misses = held ? pdi_cell_misses(cell->last_current[e], held[e], now[e], middle) : 0.0;
        cell->charge_error[e] += (t - cell->reached) * misses;
        cell->last_current[e] = now[e];
    }
    cell->reached = t;
    return PD_OK;
}

/* ---- the process ---- */

static pd_status pdi_cell_start(pd_ctx *ctx, void *self, double t)
{
    pd_cell *cell = (pd_cell *)self;
    cell->reached = t;
    return cell->desc.apart ? PD_OK : pdi_cell_end(ctx, cell, t, NULL, 0);
}

static pd_status pdi_cell_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    double left = s->dt;
    PD_TRY(pdi_physics_limit_max_step(ctx, self, s));
    s->dt = pdi_physics_equal_steps(left, s->dt);
    return PD_OK;
}

/* What changes in time is that of the middle of the step, which those ahead may have asked for. */
static pd_status pdi_cell_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_cell *cell = (pd_cell *)self;
    int moves = cell->desc.timed || cell->desc.conduct;
    if (s->solve_at) PD_TRY(s->solve_at(ctx, s->solve_at_user, s->end));
    return moves && !(cell->time > s->time) ? pdi_cell_bring(ctx, cell, s->time + 0.5 * s->dt) : PD_OK;
}

/* A law that reads a potential has one. */
static pd_status pdi_cell_lawful(pd_ctx *ctx, const pd_cell *cell, double t)
{
    const pd_potential *p = &cell->potential;
    char place[PDI_GRID_POSITION_LENGTH], name[PDI_CIRCUIT_NAME];
    for (int32_t k = p->contacts.count; k < pdi_contact_all(&p->contacts); k++) {
        const pd_contact *c = &p->contacts.list[k];
        if (!isnan(p->surface[k]) || !(cell->kinds[c->electrode] & cell->desc.reads)) continue;
        return pd_fail(ctx, PD_ERR_STATE, "potential",
                       "at t = %g s the law of the metal of %s reads E, which nothing "
                       "tells beside %s m: curves there carry current into the metal only, and nothing else closes "
                       "the circuit; expected an anodic branch of its curve, too",
                       t, pdi_circuit_electrode(p, c->electrode, name),
                       pdi_grid_format_position(cell->grid, c->node, place));
    }
    return PD_OK;
}

static pd_status pdi_cell_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_cell *cell = (pd_cell *)self;
    double held[PD_ELECTRODES], span = s->end - cell->reached;
    int middle = cell->time > cell->reached;
    if (!cell->desc.apart) {
        pdi_cell_passes(&cell->potential, held);
        pdi_cell_count(cell, span);
    }
    PD_TRY(pdi_cell_renew(ctx, cell, span));
    PD_TRY(pdi_cell_lawful(ctx, cell, s->end));
    return cell->desc.apart ? PD_OK : pdi_cell_end(ctx, cell, s->end, held, middle);
}

static pd_status pdi_cell_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    (void)ctx;
    (void)turned;
    (void)count;
    ((pd_cell *)self)->stale = 1;
    return PD_OK;
}

/* Metal and fluid have been read before. */
static pd_status pdi_cell_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_cell *cell = (pd_cell *)self;
    pd_potential *p = &cell->potential;
    if (archive->is_reading) {
        cell->stale = 1;
        PD_TRY(pdi_cell_renew(ctx, cell, 0.0));
    }
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "potential", p->phi, cell->grid->total));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "potentials of metal", p->metal, p->desc.circuits));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "currents of circuits", p->total, p->desc.circuits));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "current densities", p->current, pdi_contact_all(&p->contacts)));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "overpotentials", p->surface, pdi_contact_all(&p->contacts)));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "slopes of currents", p->slope, pdi_contact_all(&p->contacts)));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "imbalance of currents", &cell->result.imbalance, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "anodic current", &cell->result.anodic, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "current through sides", &cell->result.through, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "solves of the potential", &cell->solves, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "time of the potential", &cell->time, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "charges", cell->charge, p->desc.electrodes));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "anodic charges", cell->anodic, p->desc.electrodes));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "errors of charges", cell->charge_error, p->desc.electrodes));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "currents of the last step", cell->last_current, p->desc.electrodes));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "time of the charges", &cell->reached, 1));
    if (cell->change)
        PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "changes of conductivities", cell->change, cell->grid->total));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "potentials met", cell->met, p->desc.electrodes));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "newton of the potential", &cell->newton, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "krylov of the potential", &cell->krylov, 1));
    if (archive->is_reading) pdi_cell_index(cell);
    return PD_OK;
}

pd_physics pd_cell_process(pd_cell *cell)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "potential";
    p.self = cell;
    p.start = pdi_cell_start;
    p.limit = pdi_cell_limit;
    p.attempt = pdi_cell_attempt;
    p.accept = pdi_cell_accept;
    p.nodes_converted = pdi_cell_changed;
    p.checkpoint = pdi_cell_store;
    return p;
}

/* ---- build ---- */

static pd_status pdi_cell_make(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_dissolve *dissolve,
                               const pd_cell_desc *desc, pd_cell *cell)
{
    pd_potential_desc p = desc->potential;
    memset(cell, 0, sizeof *cell);
    cell->desc = *desc;
    cell->grid = grid;
    cell->dissolve = dissolve;
    PD_TRY(pdi_array_registry_build(ctx, pdi_cell_list, cell));
    for (int e = 0; e < p.electrodes; e++) PD_TRY(pd_electrode_build(ctx, &desc->electrode[e], &cell->curve[e]));
    for (int n = 0; n < p.circuits; n++) cell->circuit[n] = desc->circuit[n];
    for (int32_t i = 0; i < grid->total; i++) {
        int32_t home = pd_grid_find_source(grid, i, NULL);
        if (grid->kind[home] != PD_SOLID) continue;
        int e = desc->which(desc->user, home);
        PD_ASSERT(e >= 0 && e < p.electrodes);
        cell->metal[i] = (uint8_t)e;
        cell->kinds[e] |= (uint32_t)1 << (dissolve ? pdi_metal_of(dissolve, home) : 0);
    }
    pdi_cell_left(cell);
    if (desc->conduct) pdi_cell_conduct_now(cell, 0.0);
    p.electrode = cell->curve;
    p.circuit = cell->circuit;
    p.metal = cell->metal;
    p.left = cell->left;
    p.apart = desc->apart;
    p.name = desc->name;
    if (desc->conduct) p.field = cell->field;
    PD_TRY(pd_potential_build(ctx, grid, bonds, &p, &cell->potential));
    for (int e = 0; e < p.electrodes; e++) {
        cell->stock[e] = pdi_cell_stock(cell, e);
        cell->factor[e] = 1.0;
        cell->met[e].least = cell->met[e].left = HUGE_VAL;
        cell->met[e].most = -HUGE_VAL;
    }
    return PD_OK;
}

pd_status pd_cell_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_dissolve *dissolve,
                        const pd_cell_desc *desc, pd_cell *cell)
{
    pd_status status = pdi_cell_make(ctx, grid, bonds, dissolve, desc, cell);
    if (status < 0) pd_cell_free(ctx, cell);
    return status;
}

void pd_cell_free(pd_ctx *ctx, pd_cell *cell)
{
    if (cell->potential.grid) pd_potential_free(ctx, &cell->potential);
    for (int e = 0; e < cell->desc.potential.electrodes && cell->curve; e++) pd_electrode_free(ctx, &cell->curve[e]);
    pdi_array_registry_free(ctx, pdi_cell_list, cell);
    memset(cell, 0, sizeof *cell);
}

#undef PDI_CELL_AROUND
