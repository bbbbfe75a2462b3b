/* solid_coupling: coupling of solid mechanics to corrosion: the metal of the lattice as a loaded body, static or
 * dynamic.
 *
 * Points are the initial solid nodes. A node that becomes fluid loses its bonds; a partly dissolved one keeps its
 * remaining fraction of stiffness and yield stress. Stress and plastic strain change the dissolution rate (factor). The
 * body is in equilibrium at the end of each step of the run with the remaining metal, and the next step uses its
 * stress: the coupling is explicit, of first order in time. With a density the body moves instead, by velocity Verlet
 * from rest, and does not dissolve. Its material is one of those of the folder `solid`.
 */
#ifndef PD_SOLID_COUPLING_H
#define PD_SOLID_COUPLING_H
#include "metal/dissolve.h"
#include "couple/interpenetration.h"
#include "couple/point_cells.h"
#include "solid/correspondence.h"
#include "solid/quasi_static.h"
#include "solid/precrack.h"
#include "solid/finite_strain.h"
#include "solid/mirror_symmetry.h"
#include "solid/microelastic.h"
#include "solid/ordinary_state.h"
#include "solid/fracture_calibration.h"
#include "solid/verlet.h"

typedef enum pd_solid_coupling_material {
    PD_SOLID_COUPLING_CORRESPONDENCE = 0, /* small strains, elastic or J2-plastic (correspondence.h) */
    /* bond-based model with breaking bonds (microelastic.h); there is no stress */
    PD_SOLID_COUPLING_BOND_BASED = 1,
    PD_SOLID_COUPLING_ORDINARY_STATE = 2, /* ordinary state-based model of small strains (ordinary_state.h) */
    PD_SOLID_COUPLING_NEO_HOOKEAN = 3,    /* large strains (finite_strain.h) */
    PD_SOLID_COUPLING_HENCKY = 4          /* large strains, elastic or J2-plastic (finite_strain.h) */
} pd_solid_coupling_material;

/* Local state that the factor of the dissolution rate may depend on. */
typedef struct pd_local_stress_state {
    double pressure;  /* [Pa] mean of the normal stresses, tension positive */
    double mises;     /* [Pa] stress of von Mises */
    double plastic_strain; /* [-] equivalent plastic strain */
    double x[PD_DIM]; /* [m] */
    double t;         /* [s] */
} pd_local_stress_state;

/* Factor [-] of the dissolution rate at this state, at least 0. */
typedef double (*pd_rate_factor_fn)(void *user, const pd_local_stress_state *at);

/* A pre-crack of the metal. */
typedef struct pd_solid_coupling_precrack {
    const char *name;     /* for messages */
    int corners;          /* 1D: 1; 2D: at least 2, of a line of straight pieces; 3D: at least 3, of a polygon */
    const double *corner; /* [corners][PD_DIM] [m] as of pd_precrack */
} pd_solid_coupling_precrack;

typedef struct pd_solid_coupling_desc {
    double horizon_ratio; /* [-] horizon over the spacing, which is the same along all axes */
    pd_solid_coupling_material material;
    /* stiffness_factor and detach_singular are set by the build; of springs only young, plane and influence count */
    pd_correspondence_desc elastic;
    pd_bond_failure_desc bond_failure; /* failure criterion of bonds, in statics; zero: none breaks. Not for springs */
    double fracture;         /* [J/m2] energy of a crack per area, of springs; 0: nothing breaks */
    double density;          /* [kg/m3] dynamics; 0: statics */
    int loads_in_time;       /* 1: dynamics with loads that depend on time */
    int mirrors;             /* bit s: side s of the box is a plane of symmetry of the metal, too */
    double rtol;             /* [-] as of pd_equilibrium_desc */
    pd_load_fn load;
    void *user;
    pd_rate_factor_fn rate_factor; /* factor of the dissolution rate; NULL: it does not depend on stress */
    void *pace_user;
    const double *base_rate_factor;         /* [total] [-] of the dissolution rate without stress; NULL: 1. Borrowed */
    const pd_solid_coupling_precrack *cuts; /* [cut_count] read by the build */
    int cut_count;
} pd_solid_coupling_desc;

typedef struct pd_solid_coupling {
    pd_solid_coupling_desc desc;
    const pd_grid *grid;
    pd_dissolve *dissolve;   /* NULL: the metal stays */
    int32_t count;           /* points */
    int32_t total;           /* nodes, of `point` */
    int32_t *node;           /* [count] */
    int32_t *point;          /* [total] of a node; -1: none */
    pd_body body;
    pd_correspondence elastic;
    pd_microelastic bond_based;
    pd_ordinary_state ordinary;
    pd_finite_strain finite;
    pd_mirror_symmetry mirrored; /* behind planes of symmetry */
    pd_point_cells sites;        /* cells of points, and of images behind those planes */
    pd_material_interface solid; /* one of them */
    pd_quasi_static static_solver; /* statics */
    pd_verlet dynamic_solver;      /* dynamics */
    double *load, *target;   /* [count + images][PD_DIM] [N/m3], [m] in dynamics: loads, prescribed displacements */
    uint8_t *prescribed;     /* [count + images][PD_DIM] 1: prescribed displacement; filled in by the caller after the
                              * build, except those of images */
    double *stiffness_factor; /* [count + images] [-] stiffness factor: remaining fraction of the metal */
    double *stress;          /* [count + images][PD_DIM^2] [Pa] of the remaining metal, in the last solution */
    double *pressure, *mises; /* [count] [Pa] of that */
    double *plastic_strain;   /* [count + images] [-] equivalent plastic strain, of metal that flows */
    double *out_of_plane_stress; /* [count] [Pa] out-of-plane normal stress in 2D */
    double *density;         /* [count + images] [J/m3] energy that is stored, as the field was asked for last */
    double *rate_factor;     /* [total] [-] of the dissolution rate; empty without `pace` */
    pd_interpenetration overlap; /* of faces that no bond joins */
    int64_t stress_solve;        /* number of the solve that the stress belongs to */
} pd_solid_coupling;

#define pd_solid_coupling_build PD_NAME(pd_solid_coupling_build)
#define pd_solid_coupling_process PD_NAME(pd_solid_coupling_process)
#define pd_solid_coupling_free PD_NAME(pd_solid_coupling_free)

/* The grid is borrowed. PD_ERR_ARGUMENT: unequal spacings, rings, a negative number; springs with plasticity, a rate
 * factor or bond_failure; other metal with `fracture`, or that is plastic or breaks in dynamics; bond_failure.fracture
 * without correspondence; plasticity with neither correspondence nor Hencky; cracks or breaking bonds with planes of
 * symmetry. PD_ERR_GEOMETRY: no metal; no point with bonds (those whose bonds do not span all directions lose them); a
 * pre-crack that crosses none. PD_ERR_SIZE: 2e9 points. After an error nothing is left. */
PD_API pd_status pd_solid_coupling_build(pd_ctx *ctx, const pd_grid *grid, const pd_solid_coupling_desc *desc,
                                         pd_solid_coupling *structure);
/* The process table, statics or dynamics, to be added before that of the dissolution (NULL: the metal does not
 * dissolve), which is built with structure->rate_factor. Keeps `dissolve` in the structure, to which the table points.
 * PD_ERR_ARGUMENT by the start of the process: a bond-based body or one in dynamics is to dissolve. */
PD_API pd_physics pd_solid_coupling_process(pd_solid_coupling *structure, pd_dissolve *dissolve);
PD_API void pd_solid_coupling_free(pd_ctx *ctx, pd_solid_coupling *structure);
/* 1: dynamics; 0: statics. */
static inline int pd_solid_coupling_is_dynamic(const pd_solid_coupling *s) { return s->desc.density > 0.0; }
/* [count][PD_DIM] displacements [m] now. */
static inline const double *pd_solid_coupling_displacements(const pd_solid_coupling *s)
{
    return pd_solid_coupling_is_dynamic(s) ? s->dynamic_solver.u : s->static_solver.u;
}

#ifdef PDI_INTERNAL
/* Describes the arrays; stiffness factors, and in dynamics loads, are stored. */
PDI_FN void pdi_solid_coupling_list(pdi_array_visitor *owner, void *structure);
/* Sets body and description of the chosen material in the structure, without its arrays: for memory estimates. */
PDI_FN void pdi_solid_coupling_attach_material(pd_solid_coupling *structure);
/* The pd_material_interface table of the chosen material, without mirror images; it points into the structure. */
PDI_FN pd_material_interface pdi_solid_coupling_material_interface(pd_solid_coupling *structure);
/* Damage [-] of a point, 0 .. 1: share of the bonds of its family as built that are broken, by failure, cracks or
 * dissolution; 0: its family has no bonds. */
PDI_FN double pdi_solid_coupling_damage(const pd_solid_coupling *structure, int32_t point);
/* 1: surfaces may interpenetrate: there are several components, points with bond lists of their own, as beside gaps,
 * broken bonds now, a failure criterion of bonds, or a fracture energy of springs. 0: no check is needed. */
PDI_FN int pdi_solid_coupling_can_interpenetrate(const pd_solid_coupling *structure);
/* 1: the metal has a yield stress. */
static inline int pdi_solid_coupling_is_plastic(const pd_solid_coupling *s) { return s->desc.elastic.yield > 0.0; }
/* [count][PD_DIM] internal forces [N/m3] now. */
static inline const double *pdi_solid_coupling_forces(const pd_solid_coupling *s)
{
    return pd_solid_coupling_is_dynamic(s) ? s->dynamic_solver.force : s->static_solver.force;
}
/* [count][PD_DIM] loads [N/m3] now. */
static inline const double *pdi_solid_coupling_loads(const pd_solid_coupling *s)
{
    return pd_solid_coupling_is_dynamic(s) ? s->load : s->static_solver.load;
}
#endif

#endif
