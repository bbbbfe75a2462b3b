/* solid_coupling: see solid_coupling.h */
#include "couple/solid_coupling.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "core/vec.h"
#include "lattice/node_visibility.h"
#include <math.h>
#include <string.h>

/* Elastic strain that is no longer small: Green's strain differs by half of the strain, a tenth. Plastic strain that is
 * no longer small: the metal has doubled its length. */
#define PDI_SOLID_COUPLING_MAX_STRAIN 0.2
#define PDI_SOLID_COUPLING_MAX_PLASTIC_STRAIN 1.0
/* Time steps in dynamics between interpenetration checks: a wave passes one cell in a step, and parts are slower. */
#define PDI_SOLID_COUPLING_CHECK_INTERVAL 16

enum { PDI_SOLID_COUPLING_TENSOR = PD_DIM * PD_DIM };

PDI_FN void pdi_solid_coupling_list(pdi_array_visitor *owner, void *object)
{
    pd_solid_coupling *structure = (pd_solid_coupling *)object;
    int64_t all = (int64_t)structure->count + structure->sites.images;
    PDI_ARRAY(owner, structure, node, structure->count, "1");
    PDI_ARRAY(owner, structure, point, structure->total, "1");
    PDI_ARRAY(owner, structure, prescribed, all * PD_DIM, "1");
    PDI_ARRAY_STATE(owner, structure, stiffness_factor, all, "1");
    PDI_ARRAY(owner, structure, stress, all * PDI_SOLID_COUPLING_TENSOR, "Pa");
    PDI_ARRAY(owner, structure, pressure, structure->count, "Pa");
    PDI_ARRAY(owner, structure, mises, structure->count, "Pa");
    PDI_ARRAY(owner, structure, plastic_strain, pdi_solid_coupling_is_plastic(structure) ? all : 0, "1");
    PDI_ARRAY(owner, structure, out_of_plane_stress, PD_DIM == 2 ? structure->count : 0, "Pa");
    PDI_ARRAY(owner, structure, density, all, "J/m3");
    PDI_ARRAY(owner, structure, rate_factor, structure->desc.rate_factor ? structure->total : 0, "1");
    PDI_SCALAR_STATE(owner, structure, overlap.max_crack_overlap, "m");
    if (!pd_solid_coupling_is_dynamic(structure)) return;
    PDI_ARRAY_STATE(owner, structure, load, all * PD_DIM, "N/m3");
    PDI_ARRAY(owner, structure, target, all * PD_DIM, "m");
}

PDI_FN double pdi_solid_coupling_damage(const pd_solid_coupling *s, int32_t point)
{
    int64_t all = s->body.first_bond[point + 1] - s->body.first_bond[point];
    return all ? 1.0 - (double)pdi_body_bonds_count_intact(&s->body, point) / (double)all : 0.0;
}

/* ---- build ---- */

/* 1: the description has a failure criterion of bonds (bond_failure); the fracture energy of springs does not count. */
static int pdi_solid_coupling_has_failure(const pd_solid_coupling_desc *desc)
{
    return desc->bond_failure.critical > 0.0 || desc->bond_failure.fracture > 0.0;
}

PDI_FN int pdi_solid_coupling_can_interpenetrate(const pd_solid_coupling *s)
{
    return s->overlap.components > 1 || s->body.table_entries > s->body.lattice_entries ||
           !pd_body_is_intact(&s->body) || pdi_solid_coupling_has_failure(&s->desc) || s->desc.fracture > 0.0;
}

/* Builds material points at the solid nodes within the box, their mirror images, and the body with its bonds. Sets
 * node, point (-1: no metal), stiffness factors 1, members of sites, and marks all components of images as prescribed.
 * s->density is work, and 0 afterwards. The arrays of s are allocated before. After an error the caller frees. */
static pd_status pdi_solid_coupling_build_body(pd_ctx *ctx, pd_solid_coupling *s)
{
    const pd_grid *grid = s->grid;
    double *position = NULL, *volume = NULL, cell = 1.0;
    pd_body_desc desc;
    memset(&desc, 0, sizeof desc);
    for (int d = 0; d < PD_DIM; d++) cell *= grid->h[d];
    int32_t all = s->count + s->sites.images;
    pd_status status = PD_NEW(ctx, "solid", (int64_t)all * PD_DIM, position);
    if (status == PD_OK) status = PD_NEW(ctx, "solid", all, volume);
    for (int32_t i = 0, k = 0; i < grid->total && status == PD_OK; i++) {
        int at[PD_DIM];
        pd_grid_index(grid, i, at);
        s->point[i] = -1;
        if (grid->kind[i] != PD_SOLID || !pd_grid_is_inside(grid, at)) continue;
        s->node[k] = i;
        s->point[i] = k;
        pd_grid_position(grid, i, position + (int64_t)k * PD_DIM);
        s->stiffness_factor[k] = 1.0;
        volume[k++] = cell;
    }
    s->sites.node = s->node;
    s->sites.point = s->point;
    s->sites.stiffness_factor = s->stiffness_factor;
    s->sites.depth = s->density;
    s->sites.image_source = s->mirrored.image_source;
    s->sites.image_reflection = s->mirrored.image_reflection;
    if (status == PD_OK) pdi_point_cells_add_images(&s->sites);
    for (int64_t k = (int64_t)s->count * PD_DIM; k < (int64_t)all * PD_DIM; k++) s->prescribed[k] = 1;
    for (int32_t i = s->count; i < all && status == PD_OK; i++) {
        pdi_point_cells_position(&s->sites, i, position + (int64_t)i * PD_DIM);
        volume[i] = cell;
    }
    desc.count = all;
    desc.position = position;
    desc.volume = volume;
    desc.spacing = grid->h[0];
    desc.horizon = s->desc.horizon_ratio * grid->h[0];
    if (status == PD_OK) pdi_point_cells_set_joined(ctx, &s->sites, &desc);
    if (status == PD_OK) status = pd_body_build(ctx, &desc, &s->body);
    s->body.real_count = s->count;
    s->body.image_source = s->mirrored.image_source;
    s->body.image_reflection = s->mirrored.image_reflection;
    memset(s->density, 0, (size_t)all * sizeof *s->density);
    PD_DELETE(ctx, all, volume);
    PD_DELETE(ctx, (int64_t)all * PD_DIM, position);
    return status;
}

/* Adds the number of solid nodes within the box to s->count, and sets up s->sites with the number of their images.
 * Checks the lattice: PD_ERR_ARGUMENT: spacings that differ by more than 1e-9 of the first, or an axisymmetric lattice.
 * PD_ERR_GEOMETRY: no metal. PD_ERR_SIZE: 2e9 points and images, or more. */
static pd_status pdi_solid_coupling_count_points(pd_ctx *ctx, pd_solid_coupling *s)
{
    const pd_grid *grid = s->grid;
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(grid->h[d] - grid->h[0]) > 1e-9 * grid->h[0])
            return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                           "spacings of %g and %g m, expected one spacing along all"
                           " axes",
                           grid->h[0], grid->h[d]);
    if (grid->circumference)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "solid", "an axisymmetric lattice, expected a planar one");
    for (int32_t i = 0; i < grid->total; i++) {
        int at[PD_DIM];
        pd_grid_index(grid, i, at);
        s->count += grid->kind[i] == PD_SOLID && pd_grid_is_inside(grid, at);
    }
    if (!s->count) return pd_fail(ctx, PD_ERR_GEOMETRY, "solid", "no metal, expected a solid that bears loads");
    s->sites.grid = grid;
    s->sites.horizon_ratio = s->desc.horizon_ratio;
    s->sites.mirrors = s->desc.mirrors;
    s->sites.count = s->count;
    pdi_point_cells_count_images(&s->sites);
    if ((double)s->count + (double)s->sites.images < 2e9) return PD_OK;
    return pd_fail(ctx, PD_ERR_SIZE, "solid", "%g nodes of metal and as many as %g images of them: too many",
                   (double)s->count, (double)s->sites.images);
}

/* Breaks the bonds that cross a pre-crack; in 2D with three corners or more, those of each straight piece.
 * PD_ERR_GEOMETRY: all of it crosses no unbroken bond. An error of pd_body_apply_precracks is passed on with the name
 * of the crack. */
static pd_status pdi_solid_coupling_apply_precrack(pd_ctx *ctx, pd_solid_coupling *s,
                                                   const pd_solid_coupling_precrack *cut)
{
    int pieces = PD_DIM == 2 && cut->corners > 2 ? cut->corners - 1 : 1;
    int64_t broken, all = 0;
    for (int k = 0; k < pieces; k++) {
        char message[PD_MESSAGE_SIZE];
        pd_precrack piece;
        piece.corners = PD_DIM == 2 && cut->corners > 2 ? 2 : cut->corners;
        piece.corner = cut->corner + k * PD_DIM;
        pd_status status = pd_body_apply_precracks(ctx, &s->body, &piece, 1, &broken);
        memcpy(message, ctx->message, sizeof message);
        if (status < 0) return pd_fail(ctx, status, "solid", "'%.60s': %.400s", cut->name, message);
        all += broken;
    }
    if (all) return PD_OK;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "solid", "the crack '%.60s' crosses no bond of the metal", cut->name);
}

/* Lets s->overlap point to grid, body and points, and finds the initial components. Convex metal is not searched: its
 * number of components stays 0. The hash table is not prepared here. */
static pd_status pdi_solid_coupling_init_interpenetration(pd_ctx *ctx, pd_solid_coupling *s)
{
    s->overlap.grid = s->grid;
    s->overlap.body = &s->body;
    s->overlap.node = s->node;
    s->overlap.point = s->point;
    s->overlap.stiffness_factor = s->stiffness_factor;
    s->overlap.count = s->count;
    return pdi_node_visibility_is_convex(s->grid) ? PD_OK : pdi_interpenetration_build(ctx, &s->overlap);
}

/* 1: at least one point of the body has an unbroken bond. */
static int pdi_solid_coupling_has_bonds(const pd_solid_coupling *s)
{
    for (int32_t i = 0; i < s->count; i++)
        if (pdi_body_bonds_count_intact(&s->body, i)) return 1;
    return 0;
}

/* Description of the bond-based material. */
static pd_microelastic_desc pdi_solid_coupling_microelastic_desc(const pd_solid_coupling *s)
{
    pd_microelastic_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.young = s->desc.elastic.young;
    desc.plane = s->desc.elastic.plane;
    desc.influence = s->desc.elastic.influence;
    desc.fracture = s->desc.fracture;
    return desc;
}

/* Description of the ordinary state-based material. */
static pd_ordinary_state_desc pdi_solid_coupling_ordinary_desc(const pd_solid_coupling *s)
{
    pd_ordinary_state_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.young = s->desc.elastic.young;
    desc.poisson = s->desc.elastic.poisson;
    desc.plane = s->desc.elastic.plane;
    desc.influence = s->desc.elastic.influence;
    desc.stiffness_factor = s->stiffness_factor;
    desc.linear = 1;
    desc.detach_singular = 1;
    return desc;
}

/* Description of the large-strain material. */
static pd_finite_strain_desc pdi_solid_coupling_finite_strain_desc(const pd_solid_coupling *s)
{
    pd_finite_strain_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.law.kind = s->desc.material == PD_SOLID_COUPLING_NEO_HOOKEAN ? PD_FINITE_STRAIN_NEO_HOOKEAN
                    : pdi_solid_coupling_is_plastic(s)                ? PD_FINITE_STRAIN_J2
                                                                      : PD_FINITE_STRAIN_HENCKY;
    desc.law.young = s->desc.elastic.young;
    desc.law.poisson = s->desc.elastic.poisson;
    desc.law.plane = s->desc.elastic.plane;
    desc.law.yield = s->desc.elastic.yield;
    desc.law.hardening = s->desc.elastic.hardening;
    desc.influence = s->desc.elastic.influence;
    desc.stiffness_factor = s->stiffness_factor;
    desc.store_tangent = 1;
    desc.detach_singular = 1;
    return desc;
}

PDI_FN void pdi_solid_coupling_attach_material(pd_solid_coupling *s)
{
    switch (s->desc.material) {
    case PD_SOLID_COUPLING_BOND_BASED: s->bond_based.body = &s->body; break;
    case PD_SOLID_COUPLING_ORDINARY_STATE: s->ordinary.body = &s->body; break;
    case PD_SOLID_COUPLING_NEO_HOOKEAN:
    case PD_SOLID_COUPLING_HENCKY:
        s->finite.body = &s->body;
        s->finite.desc = pdi_solid_coupling_finite_strain_desc(s);
        break;
    case PD_SOLID_COUPLING_CORRESPONDENCE:
        s->elastic.body = &s->body;
        s->elastic.plastic.count = pdi_solid_coupling_is_plastic(s) ? s->count : 0;
    }
}

PDI_FN pd_material_interface pdi_solid_coupling_material_interface(pd_solid_coupling *s)
{
    switch (s->desc.material) {
    case PD_SOLID_COUPLING_BOND_BASED: return pd_microelastic_material(&s->bond_based);
    case PD_SOLID_COUPLING_ORDINARY_STATE: return pd_ordinary_state_material(&s->ordinary);
    case PD_SOLID_COUPLING_NEO_HOOKEAN:
    case PD_SOLID_COUPLING_HENCKY: return pd_finite_strain_material(&s->finite);
    case PD_SOLID_COUPLING_CORRESPONDENCE: break;
    }
    return pd_correspondence_material(&s->elastic);
}

/* Builds the chosen material on s->body. All but springs get s->stiffness_factor, and detach points whose bonds do not
 * span all directions: these lose their bonds, and it is no error. Correspondence also changes s->desc.elastic so. */
static pd_status pdi_solid_coupling_build_material(pd_ctx *ctx, pd_solid_coupling *s)
{
    pd_microelastic_desc springs = pdi_solid_coupling_microelastic_desc(s);
    pd_ordinary_state_desc ordinary = pdi_solid_coupling_ordinary_desc(s);
    pd_finite_strain_desc finite = pdi_solid_coupling_finite_strain_desc(s);
    switch (s->desc.material) {
    case PD_SOLID_COUPLING_BOND_BASED: return pd_microelastic_build(ctx, &s->body, &springs, &s->bond_based);
    case PD_SOLID_COUPLING_ORDINARY_STATE: return pd_ordinary_state_build(ctx, &s->body, &ordinary, &s->ordinary);
    case PD_SOLID_COUPLING_NEO_HOOKEAN:
    case PD_SOLID_COUPLING_HENCKY: return pd_finite_strain_build(ctx, &s->body, &finite, &s->finite);
    case PD_SOLID_COUPLING_CORRESPONDENCE: break;
    }
    s->desc.elastic.stiffness_factor = s->stiffness_factor;
    s->desc.elastic.detach_singular = 1;
    return pd_correspondence_build(ctx, &s->body, &s->desc.elastic, &s->elastic);
}

/* Replaces the fracture energy [J/m2] of a criterion by the critical bond energy of a growing crack, in 2D and 3D: sets
 * critical, and fracture to 0. In 1D, where a chain breaks at once, and without a fracture energy above 0 the criterion
 * stays. */
static pd_status pdi_solid_coupling_calibrate_fracture(pd_ctx *ctx, const pd_solid_coupling *s,
                                                       pd_bond_failure_desc *criterion)
{
#if PD_DIM > 1
    if (!(criterion->fracture > 0.0)) return PD_OK;
    PD_TRY(pdi_fracture_calibration_compute_critical(ctx, &s->body, &s->desc.elastic, criterion->fracture,
                                                     &criterion->critical));
    criterion->fracture = 0.0;
#endif
    (void)ctx;
    (void)s;
    (void)criterion;
    return PD_OK;
}

/* Builds the quasi-static solver with the supports, loads and failure criterion of the structure. The criterion is that
 * of desc.bond_failure, its fracture energy calibrated to a critical bond energy; of springs, the critical value of the
 * material. */
static pd_status pdi_solid_coupling_build_static(pd_ctx *ctx, pd_solid_coupling *s)
{
    pd_quasi_static_desc rest;
    memset(&rest, 0, sizeof rest);
    rest.prescribed = s->prescribed;
    rest.load = s->desc.load;
    rest.user = s->desc.user;
    rest.criterion = s->desc.bond_failure;
    if (s->desc.material == PD_SOLID_COUPLING_BOND_BASED) rest.criterion.critical = s->bond_based.critical;
    PD_TRY(pdi_solid_coupling_calibrate_fracture(ctx, s, &rest.criterion));
    rest.break_fraction = -1.0;
    rest.rtol = s->desc.rtol;
    return pd_quasi_static_build(ctx, &s->solid, &rest, &s->static_solver);
}

/* Builds the Verlet integrator with the density of the structure; it borrows s->load and s->prescribed. */
static pd_status pdi_solid_coupling_build_dynamic(pd_ctx *ctx, pd_solid_coupling *s)
{
    pd_verlet_desc motion;
    memset(&motion, 0, sizeof motion);
    motion.density = s->desc.density;
    motion.load = s->load;
    motion.prescribed = s->prescribed;
    return pd_verlet_build(ctx, &s->solid, &motion, &s->dynamic_solver);
}

/* PD_ERR_ARGUMENT: an unknown material; a density or fracture energy that is negative or NaN; springs with a failure
 * criterion, a yield stress or a rate factor; other metal with desc->fracture, or with failure or a yield stress in
 * dynamics; bond_failure.fracture of a material other than correspondence; a yield stress of one that is neither
 * correspondence nor Hencky. */
static pd_status pdi_solid_coupling_check(pd_ctx *ctx, const pd_solid_coupling_desc *desc)
{
    int springs = desc->material == PD_SOLID_COUPLING_BOND_BASED, flows = desc->elastic.yield > 0.0;
    if ((int)desc->material < 0 || desc->material > PD_SOLID_COUPLING_HENCKY || !(desc->density >= 0.0) ||
        !(desc->fracture >= 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                       "material %d, a density of %g kg/m3 and %g J/m2, expected 0 "
                       "to %d and numbers that are not negative",
                       (int)desc->material, desc->density, desc->fracture, (int)PD_SOLID_COUPLING_HENCKY);
    if (springs && (pdi_solid_coupling_has_failure(desc) || flows || desc->rate_factor))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                       "bond-based metal with a failure criterion, a yield stress or a factor of dissolution, "
                       "expected an energy of cracks alone");
    if (!springs && (desc->fracture > 0.0 || (desc->density > 0.0 && (pdi_solid_coupling_has_failure(desc) || flows))))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                       "metal with a fracture energy that is not bond-based, or that "
                       "breaks or flows in motion, expected a balance with a failure criterion, or bond-based metal");
    if (desc->bond_failure.fracture > 0.0 && desc->material != PD_SOLID_COUPLING_CORRESPONDENCE)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                       "an energy of cracks of material %d, expected small strains "
                       "by correspondence, bond-based metal, or a critical value of bonds",
                       (int)desc->material);
    if (flows && desc->material != PD_SOLID_COUPLING_CORRESPONDENCE && desc->material != PD_SOLID_COUPLING_HENCKY)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                       "a yield stress of material %d, expected one of small "
                       "strains or Hencky's",
                       (int)desc->material);
    return PD_OK;
}

/* PD_ERR_ARGUMENT: metal with mirror images, which has pre-cracks, a failure criterion of bonds, or a fracture energy
 * of springs: these are not reflected. PD_OK without images. */
static pd_status pdi_solid_coupling_check_images(pd_ctx *ctx, const pd_solid_coupling *s,
                                                 const pd_solid_coupling_desc *desc)
{
    if (!s->sites.images || !(desc->cut_count || pdi_solid_coupling_has_failure(desc) || desc->fracture > 0.0))
        return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                   "metal with a crack, or whose bonds break, meets a plane of "
                   "symmetry (flow = mirror): expected all of the body, or a side that holds it there (ux = 0)");
}

/* Inner part of the build: resets s, then builds body, cracks, material, interpenetration check and solver, in this
 * order. desc is copied without its cuts. Rate factors become base_rate_factor, or 1. PD_ERR_GEOMETRY: after cracks and
 * material no point has an unbroken bond. After an error the caller frees. */
static pd_status pdi_solid_coupling_build_inner(pd_ctx *ctx, const pd_grid *grid, const pd_solid_coupling_desc *desc,
                                                pd_solid_coupling *s)
{
    memset(s, 0, sizeof *s);
    PD_TRY(pdi_solid_coupling_check(ctx, desc));
    s->desc = *desc;
    s->grid = grid;
    s->total = grid->total;
    s->desc.cuts = NULL;
    PD_TRY(pdi_solid_coupling_count_points(ctx, s));
    PD_TRY(pdi_solid_coupling_check_images(ctx, s, desc));
    s->mirrored.count = s->count;
    s->mirrored.images = s->sites.images;
    if (s->sites.images) PD_TRY(pdi_mirror_symmetry_build(ctx, &s->mirrored));
    if (s->sites.images) PD_TRY(pdi_array_registry_build(ctx, pdi_point_cells_list, &s->sites));
    PD_TRY(pdi_array_registry_build(ctx, pdi_solid_coupling_list, s));
    PD_TRY(pdi_solid_coupling_build_body(ctx, s));
    PD_TRY(pdi_solid_coupling_init_interpenetration(ctx, s));
    for (int k = 0; k < desc->cut_count; k++) PD_TRY(pdi_solid_coupling_apply_precrack(ctx, s, &desc->cuts[k]));
    PD_TRY(pdi_solid_coupling_build_material(ctx, s));
    s->solid = pdi_solid_coupling_material_interface(s);
    if (s->sites.images) {
        pd_material_interface inner = s->solid;
        s->solid = pdi_mirror_symmetry_build_interface(&s->mirrored, &inner);
    }
    if (!pdi_solid_coupling_has_bonds(s))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "solid",
                       "the metal is too thin to bear loads: no node has bonds "
                       "along all directions; choose a smaller h");
    if (pdi_solid_coupling_can_interpenetrate(s)) PD_TRY(pdi_interpenetration_prepare(ctx, &s->overlap));
    for (int32_t i = 0; i < s->total && desc->rate_factor; i++)
        s->rate_factor[i] = desc->base_rate_factor ? desc->base_rate_factor[i] : 1.0;
    return pd_solid_coupling_is_dynamic(s) ? pdi_solid_coupling_build_dynamic(ctx, s)
                                            : pdi_solid_coupling_build_static(ctx, s);
}

pd_status pd_solid_coupling_build(pd_ctx *ctx, const pd_grid *grid, const pd_solid_coupling_desc *desc,
                                  pd_solid_coupling *s)
{
    pd_status status = pdi_solid_coupling_build_inner(ctx, grid, desc, s);
    if (status < 0) pd_solid_coupling_free(ctx, s);
    return status;
}

void pd_solid_coupling_free(pd_ctx *ctx, pd_solid_coupling *s)
{
    pd_verlet_free(ctx, &s->dynamic_solver);
    pd_quasi_static_free(ctx, &s->static_solver);
    pd_finite_strain_free(ctx, &s->finite);
    pd_ordinary_state_free(ctx, &s->ordinary);
    pd_microelastic_free(ctx, &s->bond_based);
    pd_correspondence_free(ctx, &s->elastic);
    pdi_interpenetration_free(ctx, &s->overlap);
    pdi_array_registry_free(ctx, pdi_point_cells_list, &s->sites);
    pdi_mirror_symmetry_free(ctx, &s->mirrored);
    pd_body_free(ctx, &s->body);
    pdi_array_registry_free(ctx, pdi_solid_coupling_list, s);
    memset(s, 0, sizeof *s);
}

/* ---- stress ---- */

/* Updates stress, pressure, mises, out-of-plane stress and plastic strain from the displacements now, and stress_solve.
 * Stresses of points are divided by the stiffness factor: those of the remaining metal; they are 0 where it has
 * dissolved. Bond-based materials have none. */
static void pdi_solid_coupling_compute_stress(pd_ctx *ctx, pd_solid_coupling *s)
{
    const pd_material_interface *solid = &s->solid;
    s->stress_solve = s->static_solver.solves;
    if (solid->plastic_strain) solid->plastic_strain(ctx, solid->self, s->plastic_strain);
    if (!solid->stress) return;
    solid->stress(ctx, solid->self, pd_solid_coupling_displacements(s), s->stress);
    for (int32_t i = 0; i < s->count; i++) {
        double *p = s->stress + (int64_t)i * PDI_SOLID_COUPLING_TENSOR;
        double over = s->stiffness_factor[i] > 0.0 ? 1.0 / s->stiffness_factor[i] : 0.0;
        double normal = solid->out_of_plane_stress ? over * solid->out_of_plane_stress(solid->self, i, p) : 0.0;
        for (int k = 0; k < PDI_SOLID_COUPLING_TENSOR; k++) p[k] *= over;
        s->mises[i] = pdi_material_interface_von_mises(p, normal, &s->pressure[i]);
        if (PD_DIM == 2) s->out_of_plane_stress[i] = normal;
    }
}

/* Only for correspondence and ordinary metal. PD_ERR_STATE: at a point the larger of von Mises stress and |pressure| is
 * at least 0.2 of Young's modulus, or the plastic strain at least 1, by the stress that was computed last. */
static pd_status pdi_solid_coupling_check_small_strains(pd_ctx *ctx, const pd_solid_coupling *s)
{
    double young = s->desc.elastic.young, x[PD_DIM];
    if (s->desc.material != PD_SOLID_COUPLING_CORRESPONDENCE && s->desc.material != PD_SOLID_COUPLING_ORDINARY_STATE)
        return PD_OK;
    for (int32_t i = 0; i < s->count; i++) {
        double strain = pd_max(s->mises[i], fabs(s->pressure[i])) / young;
        double slip = s->solid.plastic_strain ? s->plastic_strain[i] : 0.0;
        if (strain < PDI_SOLID_COUPLING_MAX_STRAIN && slip < PDI_SOLID_COUPLING_MAX_PLASTIC_STRAIN) continue;
        pd_grid_position(s->grid, s->node[i], x);
        return pd_fail(ctx, PD_ERR_STATE, "solid",
                       "the metal at x = %g m has a stress of %g of E and a plastic "
                       "strain of %g at t = %g s: expected small strains",
                       x[0], strain, slip, s->static_solver.time);
    }
    return PD_OK;
}

/* Updates s->overlap where its hash table is there; without it does nothing. PD_ERR_STATE: components that were apart
 * at the start overlap (component_overlap > 0), as contact is not computed. Overlaps within one component are kept and
 * are no error. t [s] is for the message. */
static pd_status pdi_solid_coupling_check_interpenetration(pd_ctx *ctx, pd_solid_coupling *s, double t)
{
    pd_interpenetration *o = &s->overlap;
    char place[2][PDI_GRID_POSITION_LENGTH];
    if (!o->bins) return PD_OK;
    pdi_interpenetration_compute(o, pd_solid_coupling_displacements(s));
    if (!(o->component_overlap > 0.0)) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "solid",
                   "two parts of the metal that were apart at the start meet at t = "
                   "%g s: what was at %s m and what was at %s m overlap by %g m; they would pass through each other, "
                   "since contact is not computed",
                   t, pdi_grid_format_position(s->grid, s->node[o->first], place[0]),
                   pdi_grid_format_position(s->grid, s->node[o->other], place[1]), o->component_overlap);
}

/* Sets s->rate_factor at all nodes that are still solid by stress and plastic strain, times base_rate_factor, and makes
 * the dissolution forget the rates that it has found. Does nothing without desc.rate_factor. PD_ERR_STATE: a factor is
 * negative, NaN, or at least 1e100; factors before it are set then. */
static pd_status pdi_solid_coupling_update_rate_factors(pd_ctx *ctx, pd_solid_coupling *s)
{
    pd_local_stress_state at;
    for (int32_t i = 0; i < s->count && s->desc.rate_factor; i++) {
        int32_t node = s->node[i];
        if (s->grid->kind[node] != PD_SOLID) continue;
        pd_grid_position(s->grid, node, at.x);
        at.t = s->static_solver.time;
        at.pressure = s->pressure[i];
        at.mises = s->mises[i];
        at.plastic_strain = s->solid.plastic_strain ? s->plastic_strain[i] : 0.0;
        double pace = s->desc.rate_factor(s->desc.pace_user, &at);
        if (!(pace >= 0.0) || !(pace < 1e100))
            return pd_fail(ctx, PD_ERR_STATE, "solid",
                           "the factor of the speed is %g where the mean stress is %g "
                           "Pa, at x = %g m: expected a finite one of at least 0",
                           pace, at.pressure, at.x[0]);
        s->rate_factor[node] = pace * (s->desc.base_rate_factor ? s->desc.base_rate_factor[node] : 1.0);
    }
    if (s->desc.rate_factor && s->dissolve) s->dissolve->reached = 0; /* what it knows of factors */
    return PD_OK;
}

/* ---- a process ---- */

/* PD_ERR_ARGUMENT: a body in dynamics, or a bond-based one, is to dissolve. */
static pd_status pdi_solid_coupling_check_no_dissolution(pd_ctx *ctx, const pd_solid_coupling *s)
{
    if (!s->dissolve || (!pd_solid_coupling_is_dynamic(s) && s->desc.material != PD_SOLID_COUPLING_BOND_BASED))
        return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "solid",
                   "a body %s is to dissolve, expected one in balance that is not bond-based",
                   pd_solid_coupling_is_dynamic(s) ? "in motion" : "of bond-based metal");
}

/* Sets stiffness factors of points and their images to the content of their node over that of whole metal, where the
 * node is still solid; marks the equilibrium as stale where one has changed at all. s->dissolve is not NULL. */
static void pdi_solid_coupling_update_stiffness(pd_solid_coupling *s)
{
    const pd_dissolve *d = s->dissolve;
    for (int32_t i = 0; i < s->count; i++) {
        if (s->grid->kind[s->node[i]] != PD_SOLID) continue;
        double left = d->transport->c[s->node[i]] / pdi_metal_solid(d, s->node[i]);
        if (!(fabs(left - s->stiffness_factor[i]) > 0.0)) continue;
        s->stiffness_factor[i] = left;
        for (int32_t g = s->sites.images ? s->sites.next_image[i] : -1; g >= 0; g = s->sites.next_image[g])
            s->stiffness_factor[g] = left;
        s->static_solver.stale = 1;
    }
}

/* Statics: updates the stiffness factors by the remaining metal and solves for equilibrium at time t [s]. Where that
 * made a new solution, also computes the stress, checks small strains and interpenetration, and updates rate factors.
 * Returns the status of the solver, or an error of these. */
static pd_status pdi_solid_coupling_solve_at(pd_ctx *ctx, pd_solid_coupling *s, double t)
{
    if (s->dissolve) pdi_solid_coupling_update_stiffness(s);
    pd_status status = pd_quasi_static_solve_at(ctx, &s->static_solver, t);
    if (status < 0) return status;
    if (s->stress_solve != s->static_solver.solves) {
        pdi_solid_coupling_compute_stress(ctx, s);
        PD_TRY(pdi_solid_coupling_check_small_strains(ctx, s));
        PD_TRY(pdi_solid_coupling_check_interpenetration(ctx, s, t));
        PD_TRY(pdi_solid_coupling_update_rate_factors(ctx, s));
    }
    return status;
}

/* Process callback, statics: without dissolution solves at any time t [s] asked for. With dissolution it solves only
 * the first time; then the body stays that of the end of the last step. PD_ERR_ARGUMENT: springs are to dissolve. */
static pd_status pdi_solid_coupling_process_solve_at(pd_ctx *ctx, void *self, double t)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    PD_TRY(pdi_solid_coupling_check_no_dissolution(ctx, s));
    return s->dissolve && s->static_solver.solved ? PD_OK : pdi_solid_coupling_solve_at(ctx, s, t);
}

/* Process callback, statics: equilibrium at the end of a step. */
static pd_status pdi_solid_coupling_process_finish(pd_ctx *ctx, void *self, double t)
{
    return pdi_solid_coupling_solve_at(ctx, (pd_solid_coupling *)self, t);
}

/* Process callback, statics: nodes turned [count] have become fluid; their points lose their bonds. The equilibrium is
 * stale then, unless none of the nodes was a point of the body. */
static pd_status pdi_solid_coupling_process_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    (void)ctx;
    if (pdi_point_cells_dissolve_nodes(&s->sites, &s->body, turned, count)) s->static_solver.stale = 1;
    return PD_OK;
}

/* Process callback, statics: checkpoint. After reading, stress and rate factors are computed anew if there was a
 * solution. */
static pd_status pdi_solid_coupling_process_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    pd_physics rest = pd_quasi_static_process(&s->static_solver);
    PD_TRY(pdi_array_registry_store(ctx, pdi_solid_coupling_list, s, archive));
    PD_TRY(rest.checkpoint(ctx, rest.self, archive));
    if (!archive->is_reading || !s->static_solver.solved) return PD_OK;
    pdi_solid_coupling_compute_stress(ctx, s);
    return pdi_solid_coupling_update_rate_factors(ctx, s);
}

/* ---- motion ---- */

/* Sets s->load [N/m3] to the loads at time t [s], and s->target [m] to the present displacements with the prescribed
 * ones of that time. */
static pd_status pdi_solid_coupling_set_loads(pd_ctx *ctx, pd_solid_coupling *s, double t)
{
    int64_t n = (int64_t)s->count * PD_DIM;
    for (int64_t k = 0; k < n; k++) s->load[k] = 0.0;
    memcpy(s->target, s->dynamic_solver.u, (size_t)n * sizeof *s->target);
    return s->desc.load(ctx, s->desc.user, t, s->target, s->load);
}

/* Process callback, dynamics: sets the loads of time t [s], moves prescribed displacements at once to those of that
 * time, sets the clock of the integrator, and computes the stress. PD_ERR_ARGUMENT: the body is to dissolve. */
static pd_status pdi_solid_coupling_dynamic_start(pd_ctx *ctx, void *self, double t)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    PD_TRY(pdi_solid_coupling_check_no_dissolution(ctx, s));
    PD_TRY(pdi_solid_coupling_set_loads(ctx, s, t));
    memcpy(s->dynamic_solver.u, s->target, (size_t)s->count * PD_DIM * sizeof *s->target);
    s->dynamic_solver.time = t;
    pdi_solid_coupling_compute_stress(ctx, s);
    return PD_OK;
}

/* Velocities of prescribed components: uniform motion to s->target in the step dt [s]. Adds the change of their kinetic
 * energy [J] to the work of the solver. */
static void pdi_solid_coupling_prescribe_velocities(pd_solid_coupling *s, double dt)
{
    pdi_compensated_sum work = {0.0, 0.0};
    for (int64_t k = 0; k < (int64_t)s->count * PD_DIM; k++) {
        double *v = &s->dynamic_solver.v[k], next = (s->target[k] - s->dynamic_solver.u[k]) / dt;
        if (!s->prescribed[k]) continue;
        pdi_compensated_sum_add(&work, 0.5 * s->desc.density * s->body.volume[k / PD_DIM] * (next - *v) * (next + *v));
        *v = next;
    }
    s->dynamic_solver.work += pdi_compensated_sum_total(&work);
}

/* Process callback, dynamics: one step. With desc.loads_in_time, loads are those of its middle, and prescribed
 * displacements move uniformly to those of its end; without it loads and prescribed velocities stay as they are. */
static pd_status pdi_solid_coupling_dynamic_attempt(pd_ctx *ctx, void *self, pd_step *step)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    pd_physics motion = pd_verlet_process(&s->dynamic_solver);
    if (s->desc.loads_in_time) {
        PD_TRY(pdi_solid_coupling_set_loads(ctx, s, step->time + step->dt));
        pdi_solid_coupling_prescribe_velocities(s, step->dt);
        PD_TRY(pdi_solid_coupling_set_loads(ctx, s, step->time + 0.5 * step->dt));
    }
    return motion.attempt(ctx, motion.self, step);
}

/* Process callback, dynamics: lowers step->dt to the stable time step. */
static pd_status pdi_solid_coupling_dynamic_limit(pd_ctx *ctx, void *self, pd_step *step)
{
    pd_physics motion = pd_verlet_process(&((pd_solid_coupling *)self)->dynamic_solver);
    return motion.limit(ctx, motion.self, step);
}

/* Process callback, dynamics: accepts the step. Checks interpenetration when the number of steps is a multiple of 16
 * and the hash table is there. PD_ERR_STATE: as of that check. */
static pd_status pdi_solid_coupling_dynamic_accept(pd_ctx *ctx, void *self, pd_step *step)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    pd_physics motion = pd_verlet_process(&s->dynamic_solver);
    PD_TRY(motion.accept(ctx, motion.self, step));
    int look = s->overlap.bins && s->dynamic_solver.steps % PDI_SOLID_COUPLING_CHECK_INTERVAL == 0;
    return look ? pdi_solid_coupling_check_interpenetration(ctx, s, step->end) : PD_OK;
}

/* Process callback, dynamics: stress and interpenetration at the end of a step of the run. */
static pd_status pdi_solid_coupling_dynamic_finish(pd_ctx *ctx, void *self, double t)
{
    pdi_solid_coupling_compute_stress(ctx, (pd_solid_coupling *)self);
    return pdi_solid_coupling_check_interpenetration(ctx, (pd_solid_coupling *)self, t);
}

/* Process callback, dynamics: checkpoint. After reading, the stress is computed anew. */
static pd_status pdi_solid_coupling_dynamic_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_solid_coupling *s = (pd_solid_coupling *)self;
    pd_physics motion = pd_verlet_process(&s->dynamic_solver);
    PD_TRY(pdi_array_registry_store(ctx, pdi_solid_coupling_list, s, archive));
    PD_TRY(motion.checkpoint(ctx, motion.self, archive));
    if (archive->is_reading) pdi_solid_coupling_compute_stress(ctx, s);
    return PD_OK;
}

/* The process table of dynamics. */
static pd_physics pdi_solid_coupling_dynamic_process(pd_solid_coupling *s)
{
    pd_physics p = pd_verlet_process(&s->dynamic_solver);
    p.name = "solid";
    p.self = s;
    p.has_substeps = 1;
    p.start = pdi_solid_coupling_dynamic_start;
    p.limit = pdi_solid_coupling_dynamic_limit;
    p.attempt = pdi_solid_coupling_dynamic_attempt;
    p.accept = pdi_solid_coupling_dynamic_accept;
    p.finish = pdi_solid_coupling_dynamic_finish;
    p.checkpoint = pdi_solid_coupling_dynamic_store;
    return p;
}

pd_physics pd_solid_coupling_process(pd_solid_coupling *s, pd_dissolve *dissolve)
{
    pd_physics p = pd_quasi_static_process(&s->static_solver);
    s->dissolve = dissolve;
    if (pd_solid_coupling_is_dynamic(s)) return pdi_solid_coupling_dynamic_process(s);
    p.name = "solid";
    p.self = s;
    p.start = pdi_solid_coupling_process_solve_at;
    p.solve_at = pdi_solid_coupling_process_solve_at;
    p.finish = pdi_solid_coupling_process_finish;
    p.nodes_converted = pdi_solid_coupling_process_changed;
    p.checkpoint = pdi_solid_coupling_process_store;
    return p;
}

#undef PDI_SOLID_COUPLING_MAX_STRAIN
#undef PDI_SOLID_COUPLING_MAX_PLASTIC_STRAIN
#undef PDI_SOLID_COUPLING_CHECK_INTERVAL
