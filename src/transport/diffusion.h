/* diffusion: the conductances of bonds beside walls, between materials, and to values that are held on walls.
 *
 * Far from everything a bond conducts D a(n). The bonds that a wall cuts are missing, also for diffusion along the
 * wall, so bonds between two nodes of cut families conduct more, by a factor that restores the second moments of the
 * family on average over the layers (theory: eq. 6.7, 6.8). Between two diffusivities the parts of a bond are
 * resistances in series (eq. 6.3). Conductances are symmetric and positive: what they do is conservative and keeps the
 * maximum principle.
 */
#ifndef PD_DIFFUSION_H
#define PD_DIFFUSION_H
#include "core/array_registry.h"
#include "lattice/node_loop.h"
#include "lattice/bond_diffusivity.h"

#define PD_DIFFUSION_TENSOR (PD_DIM * (PD_DIM + 1) / 2)

/* Zero-initialise. */
typedef struct pd_diffusion_desc {
    double diffusivity;  /* [m2/s] where `field` is NULL */
    pd_point_fn field;   /* [m2/s] diffusivity at nodes; NULL: constant */
    pd_point_fn level;   /* [m] signed distance from the interface where `field` jumps; NULL: it does not */
    pd_point_fn held;    /* [mol/m3] value held on walls and solids, at points of their surface; NaN: no flux there.
                          * NULL: no flux anywhere */
    void *user;          /* of all three */
    int walls_only;      /* 1: `held` is not asked on solids, which hold nothing */
    int smooth;          /* 1: nobody asks what values held make of gradients */
} pd_diffusion_desc;

typedef struct pd_diffusion {
    pd_diffusion_desc desc;
    const pd_bonds *bonds;
    double *unit;                       /* [count][PD_DIM] [-] direction of each bond in cells */
    double flattest;                    /* [-] square of the longest bond, in cells, to the next plane of the lattice */
    int32_t *place;                     /* [total] where the numbers of a node stand that has cut bonds, or of a ghost
                                         * that stands for one; -1: it has none */
    int32_t capacity, used;             /* of places; those from `used` on were never taken */
    int32_t *spare, spares;             /* [capacity] places that nodes have left */
    float *tensor;                      /* [capacity][PD_DIFFUSION_TENSOR] [-] K - I of rows (eq. 6.8): xx, xy, yy, xz,
                                         * yz, zz */
    float *metal;                       /* [capacity][PD_DIFFUSION_TENSOR] [-] the same for what metal cuts, along its
                                         * surface; or NULL */
    float *facing;                      /* [capacity][PD_DIM] [-] the normal of that surface in cells, or NULL */
    int metals;                         /* 1: there are those two */
    uint32_t *renewed;                  /* [total] version of the bonds in which these numbers of a node, or of what its
                                         * ghost stands for, were renewed */
    uint32_t version;                   /* of the bonds, that all of it belongs to; 0: none */
    pd_bond_diffusivity media;          /* where the diffusivity is a field; empty as above */
    double *field;                      /* [total] [m2/s] at nodes, of `media`; NULL: constant */
    double *wall_rate;                  /* [total] [1/s] conductance to held walls, or NULL */
    double *wall_source;                /* [capacity] [mol/m3/s] sum of conductance times held value, or NULL */
    double *wall_value, *wall_rest;     /* [capacity] [mol/m3], [mol/m3/s] one of the values that the node sees, and
                                         * what `wall_source` is beside `wall_rate` times that; or NULL */
    double *wall_grad, *wall_grad_rate; /* [capacity][PD_DIM] [mol/m4], [1/m] held values add grad - rate c to the
                                         * gradient at their node; or NULL, with desc.smooth, too */
    uint8_t *wall_part;                 /* [capacity] 1: a cut bond of the node sees no held value, or NULL */
    uint8_t *held;                      /* [count of a family] work */
    double held_least, held_most;       /* [mol/m3] bounds of the values held; least > most: none */
} pd_diffusion;

#ifdef PDI_INTERNAL
/* Bonds are borrowed. PD_ERR_ARGUMENT: a diffusivity is negative or not finite. */
PDI_FN pd_status pdi_diffusion_build(pd_ctx *ctx, const pd_bonds *bonds, const pd_diffusion_desc *desc,
                                     pd_diffusion *diffusion);
/* After pd_bonds_update. */
PDI_FN pd_status pdi_diffusion_update(pd_ctx *ctx, pd_diffusion *diffusion);
/* `held` gives other values than before, on the same surfaces. */
PDI_FN void pdi_diffusion_renew(pd_diffusion *diffusion);
PDI_FN void pdi_diffusion_free(pd_ctx *ctx, pd_diffusion *diffusion);

/* Arrays of a pd_diffusion by the lattice, and by the places. */
PDI_FN void pdi_diffusion_list(pdi_array_visitor *owner, void *object);
PDI_FN void pdi_diffusion_place_list(pdi_array_visitor *owner, void *object);
/* What held walls give [mol/s] towards + along bonds that cross the plane before index `index` of `axis`: field c and
 * what it leaves to rounding, or NULL. */
PDI_FN double pdi_diffusion_through(const pd_diffusion *diffusion, const double *c, const double *rest, int axis,
                                    int index);
/* Conductance [1/s] of the cut bond k of row r to the value that a wall holds where it meets it, *value; 0: it holds
 * none there. */
PDI_FN double pdi_diffusion_wall(const pd_diffusion *diffusion, int32_t r, int k, double *value);
/* What bond k between rows conducts more than between whole families, over that. */
PDI_FN float pdi_diffusion_more(const pd_diffusion *diffusion, int32_t i, int k);
/* Conductance [1/s] of bond k of the nodes i .. i+count-1; rows: they have rows. */
PDI_FN void pdi_diffusion_bond(const pd_diffusion *diffusion, int32_t i, int k, int count, int rows, double *bond);
/* wall_source at node i. */
static inline double pdi_diffusion_given(const pd_diffusion *d, int32_t i)
{
    return d->place[i] < 0 ? 0.0 : d->wall_source[d->place[i]];
}
/* What held walls give to node i with the concentration c + rest [mol/m3/s]: differences first, since beside a good
 * conductor they drown in their products. */
static inline double pdi_diffusion_gain(const pd_diffusion *d, int32_t i, double c, double rest)
{
    if (!d->wall_rate || d->place[i] < 0) return 0.0;
    return d->wall_rate[i] * ((d->wall_value[d->place[i]] - c) - rest) + d->wall_rest[d->place[i]];
}
#endif

#endif
