/* integral_diagnostics: integral diagnostics of flow and transport: fluxes through a plane, transfer from walls and
 * metal, box totals.
 *
 * Fluxes are the sums of bond fluxes that the schemes conserve (theory: eq. 3.2, 6.1), so that two planes with nothing
 * between them agree to rounding. Boxes take the nodes whose centres lie inside. Nothing is allocated or changed but
 * ghosts. In planar 2D amounts are per metre of depth, in 1D per square metre, axisymmetric those of
 * the whole body.
 */
#ifndef PD_INTEGRAL_DIAGNOSTICS_H
#define PD_INTEGRAL_DIAGNOSTICS_H
#include "metal/dissolve.h"

typedef struct pd_diagnostics_plane_result {
    double area;     /* [m^(d-1)] faces between two fluid cells */
    double flow;     /* [m^d/s] volume flux towards + */
    double speed;    /* [m/s] flow over area */
    double pressure; /* [Pa] mean over the area */
    double mean_concentration; /* [mol/m3] concentration, mean over the area */
    /* [mol/m3] concentration of the mixed stream, sum u c / sum u over the faces; NaN at rest */
    double mixed_concentration;
    double species_flux; /* [mol/s] metal that is carried and diffuses towards + */
} pd_diagnostics_plane_result;

typedef struct pd_diagnostics_box_result {
    double volume;   /* [m^d] of the fluid */
    double energy;   /* [J] kinetic */
    double momentum[PD_DIM]; /* [kg m/s] */
    double dissolved; /* [mol] */
    double solid;    /* [mol] left in the metal */
    /* [mol/m3] smallest and largest concentration of the fluid; NaN without fluid */
    double min_concentration, max_concentration;
} pd_diagnostics_box_result;

#define pd_diagnostics_plane PD_NAME(pd_diagnostics_plane)
#define pd_diagnostics_surface_flux PD_NAME(pd_diagnostics_surface_flux)
#define pd_diagnostics_box PD_NAME(pd_diagnostics_box)

/* Fluxes and means over the plane between the cells index - 1 and index of `axis`, index 1 .. n-1; sets all of *result.
 * flow and transport may be NULL; their figures are 0 then, but mixed_concentration is NaN without flow. Means and the
 * speed, flow over area, are NaN where no face is between two fluid cells. The flux of metal is that of all bonds that
 * cross the plane, at the end of the last step. */
PD_API void pd_diagnostics_plane(pd_ctx *ctx, const pd_bonds *bonds, pd_flow *flow, pd_transport *transport, int axis,
                                 int index, pd_diagnostics_plane_result *result);
/* flux [mol/s]: what walls that hold a concentration, and with `dissolve` (or NULL) the metal, give less what they
 * take, to the fluid nodes between lo and hi [m] at the end of the last step. area [m^(d-1)]: of these surfaces beside
 * those nodes: their faces (theory: eq. 6.20), or, where a shape has receded or is one of voxels, by the area weights
 * (10.5) of `paths`; where a closed side meets such a surface a part of a cell is missed. Both are set to 0 first. axis
 * -1: one value each; otherwise [n of that axis], one for each layer of cells. */
PD_API void pd_diagnostics_surface_flux(pd_ctx *ctx, const pd_bond_paths *paths, const pd_transport *transport,
                                        const pd_dissolve *dissolve, const double *lo, const double *hi, int axis,
                                        double *flux, double *area);
/* Totals over the nodes whose centres lie between lo and hi [m], into all of *result. Fluid nodes alone give volume,
 * energy, momentum, `dissolved` and extremes; solid nodes give `solid`. c [total]: concentration of fluid nodes; metal
 * [total]: contents of solid nodes, [mol/m3] both; these and flow may be NULL: their figures are 0 then, extremes of c
 * NaN, as they are without fluid. Axisymmetric: of the whole ring; the radial momentum, which cancels, is 0. */
PD_API void pd_diagnostics_box(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, const pd_flow *flow,
                               const double *c, const double *metal, const double *lo, const double *hi,
                               pd_diagnostics_box_result *result);

#endif
