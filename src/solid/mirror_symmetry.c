/* mirror_symmetry: see mirror_symmetry.h */
#include "solid/mirror_symmetry.h"
#include "core/par.h"
#include <string.h>

/* Describes the arrays of images. */
static void pdi_mirror_symmetry_list(pdi_array_visitor *owner, void *object)
{
    pd_mirror_symmetry *mirrored = (pd_mirror_symmetry *)object;
    int64_t all = (int64_t)mirrored->count + mirrored->images;
    PDI_ARRAY(owner, mirrored, image_source, mirrored->images, "1");
    PDI_ARRAY(owner, mirrored, image_reflection, mirrored->images, "1");
    PDI_ARRAY(owner, mirrored, is_image, all * PD_DIM, "1");
    PDI_ARRAY(owner, mirrored, u, all * PD_DIM, "m");
    PDI_ARRAY(owner, mirrored, v, all * PD_DIM, "m");
    PDI_ARRAY(owner, mirrored, density, all, "J/m3");
}

/* Copies vectors x of the real points to all [count + images][PD_DIM], with reflected ones for the images. x and all
 * differ. */
static void pdi_mirror_symmetry_expand_images(const pd_mirror_symmetry *m, const double *x, double *all)
{
    memcpy(all, x, (size_t)m->count * PD_DIM * sizeof *all);
    for (int32_t g = 0; g < m->images; g++)
        for (int d = 0; d < PD_DIM; d++) {
            double value = x[(int64_t)m->image_source[g] * PD_DIM + d];
            all[((int64_t)m->count + g) * PD_DIM + d] = m->image_reflection[g] >> d & 1 ? -value : value;
        }
}

/* Sets the forces on images to zero. */
static void pdi_mirror_symmetry_clear_images(const pd_mirror_symmetry *m, double *force)
{
    memset(force + (int64_t)m->count * PD_DIM, 0, (size_t)m->images * PD_DIM * sizeof *force);
}

/* pd_material_interface.force at u of the real points, with images that follow them; zero on images. */
static pd_status pdi_mirror_symmetry_ops_force(pd_ctx *ctx, void *self, const double *u, double *force)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_mirror_symmetry_expand_images(m, u, m->u);
    pd_status status = m->material.force(ctx, m->material.self, m->u, force);
    pdi_mirror_symmetry_clear_images(m, force);
    return status;
}

/* pd_material_interface.tangent along du of the real points; zero on images. */
static void pdi_mirror_symmetry_ops_tangent(const pd_ctx *ctx, void *self, const double *du, double *df)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_mirror_symmetry_expand_images(m, du, m->v);
    m->material.tangent(ctx, m->material.self, m->v, df);
    pdi_mirror_symmetry_clear_images(m, df);
}

/* pd_material_interface.blocks of the material. */
static void pdi_mirror_symmetry_ops_blocks(const pd_ctx *ctx, void *self, double *block)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    m->material.blocks(ctx, m->material.self, block);
}

/* pd_material_interface.moduli of the material. */
static void pdi_mirror_symmetry_ops_moduli(const pd_ctx *ctx, void *self, double *lambda, double *mu)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    m->material.moduli(ctx, m->material.self, lambda, mu);
}

/* pd_material_interface.density: elastic energy density [J/m3] of the real points and their images, at displacements u
 * of the real points. */
static void pdi_mirror_symmetry_ops_density(const pd_ctx *ctx, void *self, const double *u, double *density)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_mirror_symmetry_expand_images(m, u, m->u);
    m->material.density(ctx, m->material.self, m->u, density);
}

/* pd_material_interface.energy: sum over the real points. */
static double pdi_mirror_symmetry_ops_energy(const pd_ctx *ctx, void *self, const double *u)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_compensated_sum all = {0.0, 0.0};
    pdi_mirror_symmetry_ops_density(ctx, self, u, m->density);
    for (int32_t i = 0; i < m->count; i++) pdi_compensated_sum_add(&all, m->material.body->volume[i] * m->density[i]);
    return pdi_compensated_sum_total(&all);
}

/* pd_material_interface.stress at u of the real points. */
static void pdi_mirror_symmetry_ops_stress(const pd_ctx *ctx, void *self, const double *u, double *stress)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_mirror_symmetry_expand_images(m, u, m->u);
    m->material.stress(ctx, m->material.self, m->u, stress);
}

/* pd_material_interface.out_of_plane_stress of the material. */
static double pdi_mirror_symmetry_ops_normal_stress(const void *self, int32_t i, const double *stress)
{
    const pd_mirror_symmetry *m = (const pd_mirror_symmetry *)self;
    return m->material.out_of_plane_stress(m->material.self, i, stress);
}

/* pd_material_interface.dissipated of the material. */
static double pdi_mirror_symmetry_ops_dissipated(const void *self)
{
    const pd_mirror_symmetry *m = (const pd_mirror_symmetry *)self;
    return m->material.dissipated(m->material.self);
}

/* pd_material_interface.plastic_strain of the material. */
static void pdi_mirror_symmetry_ops_plastic_strain(const pd_ctx *ctx, const void *self, double *strain)
{
    const pd_mirror_symmetry *m = (const pd_mirror_symmetry *)self;
    m->material.plastic_strain(ctx, m->material.self, strain);
}

/* pd_material_interface.dynamic_force with displacements and velocities of the real points; zero on images. Returns how
 * many bonds broke, with those of images. */
static int64_t pdi_mirror_symmetry_ops_move(const pd_ctx *ctx, void *self, const double *u, const double *v, double dt,
                                            double *force)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_mirror_symmetry_expand_images(m, u, m->u);
    if (v) pdi_mirror_symmetry_expand_images(m, v, m->v);
    int64_t broken = m->material.dynamic_force(ctx, m->material.self, m->u, v ? m->v : NULL, dt, force);
    pdi_mirror_symmetry_clear_images(m, force);
    return broken;
}

/* pd_material_interface.update of the material. */
static pd_status pdi_mirror_symmetry_ops_update(pd_ctx *ctx, void *self)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    return m->material.update(ctx, m->material.self);
}

/* pd_material_interface.commit at u of the real points. */
static pd_status pdi_mirror_symmetry_ops_commit(pd_ctx *ctx, void *self, const double *u)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    pdi_mirror_symmetry_expand_images(m, u, m->u);
    return m->material.commit(ctx, m->material.self, m->u);
}

/* pd_material_interface.stable_step of the material. */
static double pdi_mirror_symmetry_ops_stable_step(const void *self, double density)
{
    const pd_mirror_symmetry *m = (const pd_mirror_symmetry *)self;
    return m->material.stable_step(m->material.self, density);
}

/* pd_material_interface.store of the material. */
static pd_status pdi_mirror_symmetry_ops_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_mirror_symmetry *m = (pd_mirror_symmetry *)self;
    return m->material.store(ctx, m->material.self, archive);
}

PDI_FN pd_status pdi_mirror_symmetry_build(pd_ctx *ctx, pd_mirror_symmetry *m)
{
    return pdi_array_registry_build(ctx, pdi_mirror_symmetry_list, m);
}

PDI_FN void pdi_mirror_symmetry_free(pd_ctx *ctx, pd_mirror_symmetry *m)
{
    pdi_array_registry_free(ctx, pdi_mirror_symmetry_list, m);
    memset(m, 0, sizeof *m);
}

PDI_FN pd_material_interface pdi_mirror_symmetry_build_interface(pd_mirror_symmetry *m,
                                                                 const pd_material_interface *material)
{
    pd_material_interface s = *material;
    m->material = *material;
    for (int32_t g = 0; g < m->images; g++)
        for (int d = 0; d < PD_DIM; d++)
            m->is_image[((int64_t)m->count + g) * PD_DIM + d] = (uint8_t) !(m->image_reflection[g] >> d & 1);
    s.self = m;
    s.is_image = m->is_image;
    s.force = pdi_mirror_symmetry_ops_force;
    s.tangent = pdi_mirror_symmetry_ops_tangent;
    s.blocks = pdi_mirror_symmetry_ops_blocks;
    s.moduli = material->moduli ? pdi_mirror_symmetry_ops_moduli : NULL;
    s.energy = pdi_mirror_symmetry_ops_energy;
    s.density = pdi_mirror_symmetry_ops_density;
    s.bond_energy = NULL;
    s.force_state = NULL;
    s.stress = material->stress ? pdi_mirror_symmetry_ops_stress : NULL;
    s.out_of_plane_stress = material->out_of_plane_stress ? pdi_mirror_symmetry_ops_normal_stress : NULL;
    s.dissipated = material->dissipated ? pdi_mirror_symmetry_ops_dissipated : NULL;
    s.plastic_strain = material->plastic_strain ? pdi_mirror_symmetry_ops_plastic_strain : NULL;
    s.dynamic_force = material->dynamic_force ? pdi_mirror_symmetry_ops_move : NULL;
    s.update = pdi_mirror_symmetry_ops_update;
    s.commit = material->commit ? pdi_mirror_symmetry_ops_commit : NULL;
    s.stable_step = material->stable_step ? pdi_mirror_symmetry_ops_stable_step : NULL;
    s.store = material->store ? pdi_mirror_symmetry_ops_store : NULL;
    return s;
}
