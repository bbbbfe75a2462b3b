/* reactive: see reactive.h */
#include "react/reactive.h"
#include "core/par.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if PDI_FLUX_FIELDS < PD_SPECIES_MAX
#error "the fields of a sweep have to hold all species"
#endif

/* Basis vectors of the linear solver. */
#define PDI_REACTIVE_BASIS 20
#define PDI_REACTIVE_STEPS 60
/* Share of the ions of the richest fluid that water without any has of them, with migration: without, nothing conducts
 * and the potential is no number. */
#define PDI_REACTIVE_WATER 1e-6
/* Share of the sum of |z| c that given concentrations may lack to be neutral. */
#define PDI_REACTIVE_NEUTRAL 1e-6

PDI_COLD_BEGIN
PDI_FN pd_arena *pdi_reactive_arena(pd_reactive *r) { return r->desc.arena ? r->desc.arena : &r->own; }

/* ---- what it holds ---- */

double *pd_reactive_field(pd_reactive *r, int species)
{
    int n = r->components.solute_of_species[species];
    for (int s = 0; s < r->minerals.count; s++)
        if (r->minerals.mineral[s].species == species) return r->solid + (int64_t)s * r->grid->total;
    return n < 0 ? NULL : r->c + (int64_t)n * r->grid->total;
}

double *pd_reactive_source(pd_reactive *r, int species)
{
    int n = r->components.solute_of_species[species];
    return n < 0 ? NULL : r->source + (int64_t)n * r->grid->total;
}

double pd_reactive_ph(const pd_reactive *r, int32_t node)
{
    double c[PD_SPECIES_MAX];
    if (r->proton < 0) return NAN;
    pd_reactive_get(r, r->c, node, c);
    return 3.0 - (log(c[r->proton]) + pdi_components_compute_ln_gamma(&r->components, c)) / log(10.0);
}

double pd_reactive_potential(const pd_reactive *r, int32_t node)
{
    if (!r->migration.on || r->migration.idle[node]) return (double)NAN;
    return r->migration.psi[node] * r->migration.volt;
}

double pd_reactive_neutrality(const pd_reactive *r)
{
    double worst = 0.0, most = 0.0;
    for (int32_t i = 0; i < r->grid->total; i++) {
        double c[PD_SPECIES_MAX], charge = 0.0, size = 0.0;
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        for (int n = 0; n < r->components.solutes; n++) {
            charge += r->components.charge[n] * c[n];
            size += abs(r->components.charge[n]) * c[n];
        }
        worst = pd_max(worst, fabs(charge));
        most = pd_max(most, size);
    }
    return most > 0.0 ? worst / most : 0.0;
}

double pd_reactive_saturation(const pd_reactive *r, int index, int32_t node)
{
    double c[PD_SPECIES_MAX], most = NAN;
    pd_reactive_get(r, r->c, node, c);
    for (int s = 0; s < r->minerals.count; s++)
        if (index < 0 || s == index) /* NaN gives way */
            most = pd_max(most, pdi_mineral_compute_ln_omega(&r->components, &r->minerals, s, c) / log(10.0));
    return most;
}

double pd_reactive_film(const pd_reactive *r, int32_t node)
{
    double n[PD_MINERAL_MAX];
    if (!r->minerals.count) return 0.0;
    pdi_reactive_solids(r, r->solid, node, n);
    return pdi_mineral_compute_volume_fraction(&r->minerals, n);
}

/* What one unit of mineral s has of a row. */
static double pdi_reactive_mineral(const pd_reactive *r, int row, int s)
{
    double sum = 0.0;
    for (int n = 0; n < r->components.solutes; n++) sum += r->minerals.nu[s][n] * r->part[row][n];
    return sum;
}

double pd_reactive_part(const pd_reactive *r, int row, int species)
{
    int n = r->components.solute_of_species[species];
    for (int s = 0; s < r->minerals.count; s++)
        if (r->minerals.mineral[s].species == species) return pdi_reactive_mineral(r, row, s);
    return n < 0 ? 0.0 : r->part[row][n];
}

/* Amounts of a row in minerals, with the sizes of their terms. */
static double pdi_reactive_solid(const pd_reactive *r, int row, double *size)
{
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int s = 0; s < r->minerals.count; s++) {
        const double *solid = r->solid + (int64_t)s * r->grid->total;
        double part = pdi_reactive_mineral(r, row, s);
        for (int32_t i = 0; i < r->grid->total; i++) {
            if (r->grid->kind[i] != PD_FLUID) continue;
            double term = pd_grid_circumference(r->grid, i) * part * solid[i];
            pdi_compensated_sum_add(&sum, term);
            *size += fabs(term) * r->bonds->stencil->volume;
        }
    }
    return pdi_compensated_sum_total(&sum) * r->bonds->stencil->volume;
}

/* Amounts of a row in the fluid: with the sizes of its terms, or of what is carried and what fills what metal left. */
static double pdi_reactive_amount(const pd_reactive *r, int row, int carried, double *size)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double around = pd_grid_circumference(r->grid, i);
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < (carried ? s->count : s->solutes); n++) {
            double part = r->part[row][carried ? s->component_solute[n] : n];
            double of = (carried ? r->carry : r->c)[n * total + i];
            if (carried && r->swept) of += r->swept[n * total + i];
            double term = around * part * of;
            pdi_compensated_sum_add(&sum, term);
            *size += fabs(term) * r->bonds->stencil->volume;
        }
    }
    return pdi_compensated_sum_total(&sum) * r->bonds->stencil->volume;
}

void pd_reactive_balance_of(pd_ctx *ctx, const pd_reactive *r, int row, pd_reactive_balance *b)
{
    double size = 0.0;
    (void)ctx;
    memset(b, 0, sizeof *b);
    memcpy(b->name, r->name[row], sizeof b->name);
    b->start = r->start[row];
    b->dissolved = pdi_reactive_amount(r, row, 0, &size);
    b->solid = pdi_reactive_solid(r, row, &size);
    b->carry = pdi_reactive_amount(r, row, 1, &size);
    for (int n = 0; n < r->components.solutes; n++) {
        b->in += r->part[row][n] * r->in[n];
        b->out += r->part[row][n] * r->out[n];
        size += fabs(r->part[row][n]) * (fabs(r->in[n]) + fabs(r->out[n]));
    }
    b->imbalance = b->dissolved + b->solid + b->carry + b->out - b->in - b->start;
    b->relative = size > 0.0 ? fabs(b->imbalance) / size : 0.0;
}

/* 1: node i of a field holds no solute. */
static int pdi_reactive_empty(const pd_reactive *r, const double *field, int32_t i)
{
    double sum = 0.0;
    for (int n = 0; n < r->components.solutes; n++) sum += fabs(field[(int64_t)n * r->grid->total + i]);
    return !(sum > 0.0);
}

PDI_FN void pdi_reactive_guess(pd_reactive *r)
{
    int64_t total = r->grid->total;
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double mean[PD_SPECIES_MAX] = {0.0};
        int count = 0;
        if (r->grid->kind[i] != PD_FLUID || !pdi_reactive_empty(r, r->c, i)) continue;
        for (int k = 0; k < r->bonds->stencil->count; k++) {
            int32_t far = i + r->bonds->paths.shift[k];
            if (!pdi_flux_open(&r->flux, i, k)) continue;
            if (r->grid->kind[far] == PD_IMAGE) far = pd_grid_find_source(r->grid, far, NULL);
            if (far < 0 || r->grid->kind[far] != PD_FLUID || pdi_reactive_empty(r, r->begin, far)) continue;
            for (int n = 0; n < r->components.solutes; n++) mean[n] += r->begin[n * total + far];
            count++;
        }
        for (int n = 0; n < r->components.solutes && count; n++) r->c[n * total + i] = mean[n] / count;
    }
}

PDI_FN void pdi_reactive_trace(const pd_reactive *r, double *size)
{
    double most = 0.0;
    for (int k = 0; k < r->components.count; k++) most = pd_max(most, size[k]);
    for (int k = 0; k < r->components.count; k++)
        if (size[k] > 0.0) size[k] = pd_max(size[k], PDI_REACTIVE_TRACE * most);
}

PDI_FN void pdi_reactive_pass(pd_reactive *r, double dt)
{
    const pd_components *s = &r->components;
    const pd_grid *grid = r->grid;
    int64_t total = grid->total;
    pdi_compensated_sum in[PD_SPECIES_MAX], out[PD_SPECIES_MAX];
    memset(in, 0, sizeof in);
    memset(out, 0, sizeof out);
    for (int32_t i = 0; i < grid->total; i++) {
        double around = pd_grid_circumference(grid, i);
        if (grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < s->solutes; n++) {
            pdi_compensated_sum_add(&in[n], r->source[n * total + i] * around);
            if (!r->diffusion.wall_rate || !(r->wall[n] == r->wall[n])) continue;
            double gain = r->ratio[n] * r->diffusion.wall_rate[i] * (r->wall[n] - r->c[n * total + i]);
            if (r->migration.on)
                gain = -pdi_migrate_leave(r->ratio[n] * r->diffusion.wall_rate[i], 0.0,
                                          -s->charge[n] * r->migration.psi[i], r->c[n * total + i], r->wall[n]);
            if (r->pass) gain *= r->pass[i];
            pdi_compensated_sum_add(gain > 0.0 ? &in[n] : &out[n], fabs(gain) * around);
        }
    }
    for (int32_t p = 0; p < r->boundary.count; p++) {
        int32_t i = r->boundary.node[p];
        double around = pd_grid_circumference(grid, i), flux, bond, upwind;
        for (int k = 0; k < r->bonds->stencil->count; k++) {
            int32_t j = i + r->bonds->paths.shift[k];
            if (!pdi_flux_open(&r->flux, i, k)) continue;
            if (grid->kind[j] != PD_OUTLET && grid->kind[j] != PD_INLET) continue;
            pdi_flux_bond(&r->flux, i, k, &flux, &bond, &upwind);
            if (r->pass) bond *= pdi_bond_diffusivity_harmonic_mean(r->pass[i], r->pass[j]);
            for (int n = 0; n < s->solutes; n++) {
                double here = r->c[n * total + i], there = grid->kind[j] == PD_OUTLET ? here : r->c[n * total + j];
                double leave = 0.5 * flux * (here + there) - pd_max(fabs(0.5 * flux), r->ratio[n] * bond) *
                                                             (there - here);
                if (r->migration.on && grid->kind[j] == PD_INLET)
                    leave = pdi_migrate_leave(r->ratio[n] * bond, flux,
                                              s->charge[n] * (r->migration.psi[j] - r->migration.psi[i]), here, there);
                pdi_compensated_sum_add(grid->kind[j] == PD_OUTLET ? &out[n] : &in[n],
                                        around * (grid->kind[j] == PD_OUTLET ? leave : -leave));
            }
        }
    }
    for (int n = 0; n < s->solutes; n++) {
        r->in[n] += dt * r->bonds->stencil->volume * pdi_compensated_sum_total(&in[n]);
        r->out[n] += dt * r->bonds->stencil->volume * pdi_compensated_sum_total(&out[n]);
    }
}

/* A row of the balance: `times` atoms of an element less `less` of another (0: none). */
static void pdi_reactive_row(const pd_species *species, int count, int element, int less, int times, pd_reactive *r)
{
    char one[8], other[8];
    if (r->rows == PD_REACTIVE_ROWS - 1) return;
    pd_species_get_symbol(element, one);
    r->name[r->rows][0] = 0;
    pd_append(r->name[r->rows], PD_REACTIVE_NAME, "%s", one);
    if (less) {
        pd_species_get_symbol(less, other);
        pd_append(r->name[r->rows], PD_REACTIVE_NAME, "-%d%s", times, other);
    }
    for (int i = 0; i < count; i++) {
        int n = r->components.solute_of_species[i];
        if (n < 0) continue;
        r->part[r->rows][n] = pdi_species_count_atoms(&species[i], element);
        if (less) r->part[r->rows][n] -= times * pdi_species_count_atoms(&species[i], less);
    }
    r->rows++;
}

/* Elements that the solvent has not, in order; then of those that it has one less another; then the charge. */
static void pdi_reactive_rows(const pd_species *species, int count, pd_reactive *r)
{
    const pd_species *solvent = NULL;
    for (int i = 0; i < count; i++)
        if (species[i].phase == PD_PHASE_SOLVENT) solvent = &species[i];
    for (int e = 1; e < 119; e++) {
        int there = 0;
        for (int i = 0; i < count; i++)
            if (species[i].phase == PD_PHASE_SOLUTE && pdi_species_count_atoms(&species[i], e)) there = 1;
        if (there && !(solvent && pdi_species_count_atoms(solvent, e))) pdi_reactive_row(species, count, e, 0, 0, r);
    }
    for (int e = 1; solvent && e < 119; e++) { /* H2O: H less 2 O */
        int last = solvent->element[solvent->elements - 1], atoms = pdi_species_count_atoms(solvent, last);
        if (e == last || !pdi_species_count_atoms(solvent, e) || atoms != 1) continue;
        pdi_reactive_row(species, count, e, last, pdi_species_count_atoms(solvent, e), r);
    }
    pd_append(r->name[r->rows], PD_REACTIVE_NAME, "charge");
    for (int n = 0; n < r->components.solutes; n++) r->part[r->rows][n] = r->components.charge[n];
    r->rows++;
}

/* ---- the object ---- */

/* What is given is neutral but for its digits. */
static pd_status pdi_reactive_neutral(pd_ctx *ctx, const pd_reactive *r, const char *where, double *c)
{
    double size, charge = r->migration.on ? pdi_migration_charge(&r->migration, c, &size) : 0.0;
    if (!r->migration.on) return PD_OK;
    if (fabs(charge) > PDI_REACTIVE_NEUTRAL * size)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s: the charges sum to %g mol/m3, expected 0 for migration",
                       where, charge);
    pdi_migration_neutralise(&r->migration, c);
    return PD_OK;
}

/* Bring c [solutes] to the equilibrium of its totals. */
static pd_status pdi_reactive_settle(pd_ctx *ctx, const pd_reactive *r, const char *where, double *c)
{
    double total[PD_SPECIES_MAX];
    for (int n = 0; n < r->components.solutes; n++)
        if (!(c[n] >= 0.0) || !(c[n] < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s: solute %d of %d has %g mol/m3, expected a finite "
                           "value of at least 0", where, n + 1, r->components.solutes, c[n]);
    PD_TRY(pdi_reactive_neutral(ctx, r, where, c));
    pdi_components_compute_totals(&r->components, c, total);
    if (pdi_components_solve(&r->components, total, c) == PD_OK) return pdi_reactive_neutral(ctx, r, where, c);
    return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s: no equilibrium of the concentrations was found", where);
}

static void pdi_reactive_fill(pd_reactive *r, uint8_t kind, const double *c)
{
    for (int32_t i = 0; i < r->grid->total; i++)
        if (r->grid->kind[i] == kind) pdi_reactive_put(r, c, i, r->c);
}

/* [mol/m3] Sum of the ions of c; NaN: of a wall that does not hold them all. */
static double pdi_reactive_ions(const pd_reactive *r, const double *c)
{
    double sum = 0.0;
    for (int n = 0; n < r->components.solutes; n++)
        if (r->components.charge[n]) sum += c[n];
    return sum;
}

/* With migration: fluid and inlets with next to no ions get a trace of those of the richest. */
static void pdi_reactive_water(pd_reactive *r)
{
    double rich[PD_SPECIES_MAX], c[PD_SPECIES_MAX], most = pdi_reactive_ions(r, r->inlet);
    if (!r->migration.on) return;
    memcpy(rich, r->inlet, sizeof rich);
    if (pdi_reactive_ions(r, r->wall) > most) memcpy(rich, r->wall, sizeof rich);
    most = pdi_reactive_ions(r, rich);
    for (int32_t i = 0; i < r->grid->total; i++) {
        pd_reactive_get(r, r->c, i, c);
        if (r->grid->kind[i] != PD_FLUID || !(pdi_reactive_ions(r, c) > most)) continue;
        memcpy(rich, c, sizeof rich);
        most = pdi_reactive_ions(r, rich);
    }
    double least = PDI_REACTIVE_WATER * most;
    for (int n = 0; n < r->components.solutes; n++) rich[n] *= r->components.charge[n] ? PDI_REACTIVE_WATER : 0.0;
    for (int32_t i = 0; i < r->grid->total; i++) {
        pd_reactive_get(r, r->c, i, c);
        if (r->grid->kind[i] != PD_FLUID || !(pdi_reactive_ions(r, c) < least)) continue;
        for (int n = 0; n < r->components.solutes; n++) c[n] += rich[n];
        pdi_reactive_put(r, c, i, r->c);
    }
    if (!(pdi_reactive_ions(r, r->inlet) < least)) return;
    for (int n = 0; n < r->components.solutes; n++) r->inlet[n] += rich[n];
}

pd_status pd_reactive_begin(pd_ctx *ctx, pd_reactive *r)
{
    double size = 0.0;
    pdi_reactive_water(r);
    for (int32_t i = 0; i < r->grid->total; i++) {
        double c[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        PD_TRY(pdi_reactive_settle(ctx, r, "a node", c));
        pdi_reactive_put(r, c, i, r->c);
    }
    pdi_reactive_fill(r, PD_INLET, r->inlet);
    memset(r->carry, 0, (size_t)r->components.count * (size_t)r->grid->total * sizeof *r->carry);
    memset(r->in, 0, sizeof r->in);
    memset(r->out, 0, sizeof r->out);
    for (int row = 0; row < r->rows; row++)
        r->start[row] = pdi_reactive_amount(r, row, 0, &size) + pdi_reactive_solid(r, row, &size);
    return PD_OK;
}

/* 1: minerals take room, so that less is left for diffusion. */
static int pdi_reactive_shrinks(const pd_reactive *r)
{
    for (int s = 0; s < r->minerals.count; s++)
        if (r->minerals.mineral[s].volume > 0.0) return 1;
    return 0;
}

PDI_FN void pdi_reactive_list(pdi_array_visitor *owner, void *object)
{
    pd_reactive *reactive = (pd_reactive *)object;
    if (!reactive->grid) return;
    int64_t total = reactive->grid->total;
    PDI_ARRAY_STATE(owner, reactive, c, reactive->components.solutes * total, "mol/m3");
    PDI_ARRAY_STATE(owner, reactive, carry, reactive->components.count * total, "mol/m3");
    PDI_ARRAY(owner, reactive, source, reactive->components.solutes * total, "mol/m3/s");
    if (reactive->minerals.count) PDI_ARRAY_STATE(owner, reactive, solid, reactive->minerals.count * total, "mol/m3");
    if (pdi_reactive_shrinks(reactive)) {
        PDI_ARRAY(owner, reactive, pass, total, "1");
        PDI_ARRAY(owner, reactive, filled, total, "1");
        PDI_ARRAY_STATE(owner, reactive, narrow, total, "1/s");
    }
    pdi_migration_list(owner, &reactive->migration);
    if (reactive->filters) PDI_ARRAY(owner, reactive, filter, reactive->filters, "");
}

/* Values of the desc in the order of the solutes. */
static void pdi_reactive_pick(const pd_reactive *r, const double *of, double *c)
{
    for (int i = 0; i < r->desc.count; i++)
        if (r->components.solute_of_species[i] >= 0) c[r->components.solute_of_species[i]] = of ? of[i] : 0.0;
}

/* The mean diffusivity of the fluxes, and what the species have of it. */
static pd_status pdi_reactive_diffusivities(pd_ctx *ctx, const pd_species *species, pd_reactive *r)
{
    double least = HUGE_VAL, most = 0.0, of[PD_SPECIES_MAX];
    int even = 1;
    for (int i = 0; i < r->desc.count; i++) {
        int n = r->components.solute_of_species[i];
        double d = species[i].diffusivity;
        if (n < 0) continue;
        if (!(d >= 0.0) || !(d < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s has D = %g m2/s, expected a finite value of at least "
                           "0", species[i].name, d);
        of[n] = d;
        if (d > 0.0) least = pd_min(least, d);
        most = pd_max(most, d);
        if (strcmp(species[i].name, "H+") == 0) r->proton = n;
    }
    r->diffusion.desc.diffusivity = most > 0.0 ? (least < most ? sqrt(least * most) : most) : 0.0;
    for (int n = 0; n < r->components.solutes; n++) {
        r->ratio[n] = most > 0.0 ? of[n] / r->diffusion.desc.diffusivity : 0.0;
        if (n && !(of[n] >= of[0] && of[n] <= of[0])) even = 0;
    }
    r->linear = !r->components.kinetics && !r->minerals.count && (even || !r->components.equilibrium_components) &&
                !r->migration.on;
    return PD_OK;
}

static void pdi_reactive_krylov(const pd_reactive *r, pd_krylov_desc *kd)
{
    memset(kd, 0, sizeof *kd);
    kd->equations = "species";
    kd->components = r->components.count;
    kd->n = (int64_t)kd->components * r->grid->total;
    kd->spans = &r->bonds->active_ranges;
    kd->restart = PDI_REACTIVE_BASIS;
    kd->max_vectors = 10 * PDI_REACTIVE_BASIS;
    kd->flexible = 1;
    /* below the rounding of floats: psi in water beside salt, whose unknown is a charge; and what fast reactions leave
     * of amounts that they bring to rest */
    kd->basis_precision = r->migration.on || r->components.kinetics ? PD_KRYLOV_DOUBLE : PD_KRYLOV_SINGLE;
    kd->zero_guess = 1;
}

PDI_FN void pdi_reactive_slots(pd_reactive *r)
{
    r->slots = r->components.members * pdi_components_count_columns(&r->components) +
               (r->components.kinetics + r->minerals.count) * r->components.count;
    if (!r->slots) r->slots = 1;
    r->filters = r->components.kinetics;
    for (int m = 0; m < r->minerals.count; m++)
        r->filters += r->minerals.mineral[m].rate > 0.0 || r->minerals.mineral[m].surface_rate > 0.0;
}

PDI_FN void pdi_reactive_work_list(pdi_array_visitor *owner, void *object)
{
    pd_reactive *reactive = (pd_reactive *)object;
    const pd_components *s = &reactive->components;
    int64_t total = reactive->grid->total;
    PDI_ARRAY_UNINIT(owner, reactive, begin, s->solutes * total, "mol/m3");
    PDI_ARRAY_UNINIT(owner, reactive, base, s->solutes * total, "mol/m3");
    PDI_ARRAY(owner, reactive, total, s->count * total, "mol/m3");
    PDI_ARRAY(owner, reactive, move, s->solutes * total, "mol/m3");
    PDI_ARRAY(owner, reactive, work, 2 * s->count * total, "");
    if (reactive->desc.order == 2) PDI_ARRAY_UNINIT(owner, reactive, slope, s->count * total, "mol/m3");
    if (reactive->minerals.count) {
        int64_t count = reactive->minerals.count * total;
        PDI_ARRAY_UNINIT(owner, reactive, solid_begin, count, "mol/m3");
        PDI_ARRAY_UNINIT(owner, reactive, solid_base, count, "mol/m3");
        PDI_ARRAY_UNINIT(owner, reactive, solid_start, count, "mol/m3");
        if (reactive->desc.order == 2) PDI_ARRAY_UNINIT(owner, reactive, solid_slope, count, "mol/m3");
    }
    PDI_ARRAY(owner, reactive, part_of, total, "mol/m3/s");
    PDI_ARRAY(owner, reactive, spent, s->count * total, "1");
    PDI_ARRAY(owner, reactive, rates, 2 * total, "1/s");
    PDI_ARRAY_UNINIT(owner, reactive, by, reactive->slots * total, "");
    PDI_ARRAY(owner, reactive, still, total, "1/s");
    pdi_flux_list(owner, &reactive->flux);
    pdi_inverse_list(owner, &reactive->inverse);
    pdi_migration_work_list(owner, &reactive->migration);
    for (int n = 0; n < reactive->filters; n++) {
        pd_reactive_filter *filter = &reactive->filter[n];
        PDI_ARRAY(owner, filter, absorb, total, "1/s");
        pdi_inverse_list(owner, &filter->inverse);
    }
}

PDI_FN size_t pdi_reactive_room(pd_reactive *r)
{
    size_t setup = pdi_inverse_room(&r->inverse), linear = pdi_arena_count_bytes(pdi_krylov_list, &r->krylov);
    if (r->migration.on) setup += pdi_arena_count_bytes(pdi_multigrid_setup_list, &r->migration.mg);
    return pdi_arena_count_bytes(pdi_reactive_work_list, r) + (setup > linear ? setup : linear);
}

PDI_FN pd_status pdi_reactive_plan(pd_ctx *ctx, pd_reactive *r, pd_krylov_desc *linear)
{
    pd_multigrid_desc md;
    pdi_compact_operator_multigrid_desc(r->grid, &md);
    md.symmetric = r->flow == NULL;
    md.arena = pdi_reactive_arena(r);
    r->inverse.flux = &r->flux;
    r->inverse.spread = 1.0;
    PD_TRY(pdi_inverse_plan(ctx, &md, &r->inverse));
    PD_TRY(pdi_migration_plan(ctx, &md, &r->flux, &r->components, &r->migration));
    for (int n = 0, m = 0; n < r->filters; n++) {
        r->filter[n].mineral = -1;
        if (n >= r->components.kinetics) {
            while (!(r->minerals.mineral[m].rate > 0.0) && !(r->minerals.mineral[m].surface_rate > 0.0)) m++;
            r->filter[n].mineral = m++;
        }
        r->filter[n].flux = r->flux;
        r->filter[n].inverse.flux = &r->filter[n].flux;
        r->filter[n].inverse.spread = 1.0;
        PD_TRY(pdi_inverse_plan(ctx, &md, &r->filter[n].inverse));
    }
    pdi_reactive_krylov(r, linear);
    return pdi_krylov_init(ctx, linear, &r->krylov);
}

static pd_status pdi_reactive_solvers(pd_ctx *ctx, pd_reactive *r)
{
    pd_krylov_desc kd;
    PD_TRY(pdi_reactive_plan(ctx, r, &kd));
    PD_TRY(pdi_krylov_build_unallocated(ctx, &kd, &r->krylov));
    return pdi_arena_reserve(ctx, pdi_reactive_arena(r), pdi_reactive_room(r));
}

pd_status pd_reactive_system(pd_ctx *ctx, const pd_reactive_desc *desc, pd_reactive *r)
{
    pd_reaction rest[PD_REACTION_MAX];
    int few = desc->reaction_count >= 0 && desc->reaction_count <= PD_REACTION_MAX && desc->count >= 1 &&
              desc->count <= PD_SPECIES_MAX; /* else the components say so */
    if (!desc->mineral_count || !few)
        return pdi_components_build(ctx, desc->species, desc->count, desc->reactions, desc->reaction_count,
                                    desc->activity, desc->temperature, &r->components);
    int count =
        pdi_mineral_copy_solid_free_reactions(desc->species, desc->count, desc->reactions, desc->reaction_count, rest);
    PD_TRY(pdi_components_build(ctx, desc->species, desc->count, rest, count, desc->activity, desc->temperature,
                                &r->components));
    return pdi_mineral_build(ctx, &r->components, desc->species, desc->count, desc->reactions, desc->reaction_count,
                              desc->minerals, desc->mineral_count, &r->minerals);
}

static pd_status pdi_reactive_fill_solids(pd_ctx *ctx, const pd_reactive_desc *desc, pd_reactive *r)
{
    if (!(desc->tortuosity >= 0.0) || !(desc->tortuosity < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "the tortuosity is %g, expected a positive number, or 0 for "
                       "1", desc->tortuosity);
    for (int s = 0; s < r->minerals.count; s++) {
        double n = desc->initial[r->minerals.mineral[s].species];
        if (!(n >= 0.0) || !(n < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "mineral %d of %d has %g mol/m3, expected a finite value "
                           "of at least 0", s + 1, r->minerals.count, n);
        for (int32_t i = 0; i < r->grid->total; i++)
            if (r->grid->kind[i] == PD_FLUID) r->solid[(int64_t)s * r->grid->total + i] = n;
    }
    return PD_OK;
}

static pd_status pdi_reactive_make(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                                   const pd_reactive_desc *desc, pd_reactive *r)
{
    double c[PD_SPECIES_MAX];
    memset(r, 0, sizeof *r);
    PD_TRY(pd_reactive_system(ctx, desc, r));
    if (!(desc->tolerance >= 0.0) || !(desc->tolerance < 1.0) || desc->most < 0 || desc->order < 0 ||
        desc->order > 2 || !desc->initial)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "tolerance %g, %d steps of Newton, order %d, concentrations "
                       "at the start: %s; expected a tolerance of 0 to 1, at least 0 steps, order 1 or 2, "
                       "concentrations", desc->tolerance, desc->most, desc->order, desc->initial ? "yes" : "none");
    r->desc = *desc;
    if (!(r->desc.tolerance > 0.0)) r->desc.tolerance = PDI_REACTIVE_TOLERANCE;
    if (!r->desc.most) r->desc.most = PDI_REACTIVE_STEPS;
    if (!(r->desc.tortuosity > 0.0)) r->desc.tortuosity = 1.0;
    r->grid = grid;
    r->bonds = bonds;
    r->flow = flow;
    r->proton = -1;
    r->migration.on = desc->migration != 0;
    r->migration.components = &r->components;
    r->flux.bonds = bonds;
    r->migration.flux = &r->flux;
    pdi_reactive_slots(r);
    PD_TRY(pdi_reactive_diffusivities(ctx, desc->species, r));
    PD_TRY(pdi_migration_begin(ctx, desc->temperature, r->ratio, r->wall, &r->migration));
    pdi_reactive_rows(desc->species, desc->count, r);
    pdi_reactive_pick(r, desc->wall, r->wall);
    for (int n = 0; n < r->components.solutes; n++) {
        if (!desc->held || !desc->wall) r->wall[n] = NAN;
        r->closed[n] = r->wall[n] == r->wall[n] ? 0.0 : NAN;
        if (r->wall[n] < 0.0 || r->wall[n] > 1e100)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "a wall holds %g mol/m3, expected a finite value of at "
                           "least 0", r->wall[n]);
    }
    PD_TRY(pdi_array_registry_build(ctx, pdi_reactive_list, r));
    pdi_reactive_pick(r, desc->inlet ? desc->inlet : desc->initial, r->inlet);
    pdi_reactive_pick(r, desc->initial, c);
    PD_TRY(pdi_reactive_settle(ctx, r, "inlet", r->inlet));
    PD_TRY(pdi_reactive_settle(ctx, r, "initial", c));
    pdi_reactive_fill(r, PD_FLUID, c);
    PD_TRY(pdi_reactive_fill_solids(ctx, desc, r));
    pdi_migration_inlets(&r->migration, desc->inlet_potential);
    pd_diffusion_desc dd;
    memset(&dd, 0, sizeof dd);
    dd.diffusivity = r->diffusion.desc.diffusivity;
    dd.held = desc->wall ? desc->held : NULL;
    dd.user = desc->user;
    dd.smooth = 1;
    PD_TRY(pdi_diffusion_build(ctx, bonds, &dd, &r->diffusion));
    PD_TRY(pdi_open_boundary_build(ctx, bonds, &r->boundary));
    r->flux.flow = flow;
    r->flux.diffusion = &r->diffusion;
    r->flux.boundary = &r->boundary;
    PD_TRY(pdi_flux_build(ctx, &r->flux));
    PD_TRY(pdi_reactive_solvers(ctx, r));
    r->desc.species = NULL;
    r->desc.reactions = NULL;
    r->desc.minerals = NULL;
    r->desc.initial = r->desc.inlet = r->desc.wall = NULL;
    return pd_reactive_begin(ctx, r);
}

pd_status pd_reactive_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                            const pd_reactive_desc *desc, pd_reactive *r)
{
    pd_status status = pdi_reactive_make(ctx, grid, bonds, flow, desc, r);
    if (status < 0) pd_reactive_free(ctx, r);
    return status;
}

pd_status pd_reactive_update(pd_ctx *ctx, pd_reactive *r)
{
    PD_TRY(pdi_diffusion_update(ctx, &r->diffusion));
    PD_TRY(pdi_open_boundary_update(ctx, &r->boundary));
    pdi_reactive_fill(r, PD_INLET, r->inlet);
    pdi_migration_inlets(&r->migration, r->desc.inlet_potential);
    return pdi_flux_fit(ctx, &r->flux);
}

void pd_reactive_free(pd_ctx *ctx, pd_reactive *r)
{
    pdi_flux_free(ctx, &r->flux);
    pdi_open_boundary_free(ctx, &r->boundary);
    pdi_diffusion_free(ctx, &r->diffusion);
    pdi_inverse_free(ctx, &r->inverse);
    pdi_migration_free(ctx, &r->migration);
    for (int n = 0; n < r->filters && r->filter; n++) pdi_inverse_free(ctx, &r->filter[n].inverse);
    pd_krylov_free(ctx, &r->krylov);
    pdi_array_registry_free(ctx, pdi_reactive_list, r);
    pd_arena_free(ctx, &r->own);
    memset(r, 0, sizeof *r);
}
PDI_COLD_END
