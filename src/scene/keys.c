/* keys: see keys.h. Text in `...` stands for itself in a scene. Look-ups of readers are held against units and defaults
 * (pdi_keys_is_consistent), the tables of docs/guide.md against all of it (tests/scene/test_keys.c). */
#include "scene/keys.h"
#include "io/field_plot.h"
#include <string.h>

#ifdef PDI_NO_MEANINGS /* for programs that are sent over a network and print no keys */
#define PDI_DOC(text) ""
#else
#define PDI_DOC(text) text
#endif

/* [V] largest potentials and Tafel slopes: anything larger is a mistake. */
#define PDI_KEYS_MAX_VOLTAGE 1e4
/* [K] water that is neither ice nor steam. */
#define PDI_KEYS_MIN_T 273.0
#define PDI_KEYS_MAX_T 373.2

static const pd_key pdi_keys_of_constants[] = {
    {"NAME", "any", "-", PDI_DOC("a value of any dimension, an expression of those above it"), PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_grid[] = {
    {"h", "m", "required", PDI_DOC("spacing, one or one an axis"), PD_KEY_ANY_TEXT},
    {"m", "-", "1; beside `[corrode]` that of its bonds",
     PDI_DOC("horizon of the fluid over h, 1 to 6; 1.328 in 2D and 1.387 in 3D make diffusion isotropic, as "
             "viscosity is with 1 (theory: 1.4)"),
     PD_KEY_FROM(1.0, 6.0)},
    {"box", "m", "required", PDI_DOC("extent, a range an axis, whole numbers of cells"), PD_KEY_ANY_TEXT},
    {"geometry", "-", "planar",
     PDI_DOC("2D: `planar`, or `axisymmetric`: x runs along the axis, y is the distance from it, cells are rings "
             "and amounts those of the whole body. The box begins at y = 0, the axis, which needs no `[side y-]`, "
             "or at least one horizon (m cells) away"),
     PD_KEY_ONE_OF("planar, axisymmetric")},
    {"threads", "-", "0", PDI_DOC("threads, 0 to 1024; 0: all. The `--threads` option goes first"),
     PD_KEY_WHOLE_FROM(0, 1024)}};

static const pd_key pdi_keys_of_shape[] = {
    {"box", "m", "-", PDI_DOC("box, a range an axis"), PD_KEY_ANY_TEXT},
    {"ball", "m", "-", PDI_DOC("centre of a ball (a disc in 2D), with `radius`"), PD_KEY_ANY_TEXT},
    {"cylinder", "-", "-",
     PDI_DOC("`x`, `y` or `z`: unbounded along that axis, with `radius`. 2D: a plane section, so `x` is a slab"),
     PD_KEY_ANY_TEXT},
    {"half_space", "-", "-", PDI_DOC("`yes`: points behind a plane, with `point` and `normal`"),
     PD_KEY_ONE_OF("no, yes")},
    {"mask", "-", "-",
     PDI_DOC("2D: PNG file, relative to the scene; white is inside, transparent is not; with `corner` and `cell`"),
     PD_KEY_ANY_TEXT},
    {"raw", "-", "-", PDI_DOC("file of one byte a voxel, x fastest; not 0 is inside; with `size`, `corner` and `cell`"),
     PD_KEY_ANY_TEXT},
    {"stl", "-", "-",
     PDI_DOC("3D: STL file (text or binary), relative to the scene: closed surfaces, normals outward; with `scale`. "
             "Those that overlap or touch are one body; one with normals inward is a cavity of what it lies in. Where "
             "it ends at a side of the box is a face of it"),
     PD_KEY_ANY_TEXT},
    {"union, intersect, difference", "-", "-",
     PDI_DOC("2 to 8 names of shapes above; `difference`: first minus the others"), PD_KEY_ANY_TEXT},
    {"radius", "m", "required there", PDI_DOC("of a ball or a cylinder"), PD_KEY_POSITIVE},
    {"centre", "m", "the origin", PDI_DOC("a point of the axis of a cylinder"), PD_KEY_ANY_TEXT},
    {"point", "m", "required there", PDI_DOC("a point of the plane of a half space"), PD_KEY_ANY_TEXT},
    {"normal", "-", "required there", PDI_DOC("outward normal of that plane, plain numbers"), PD_KEY_ANY_TEXT},
    {"corner", "m", "required there", PDI_DOC("place of the first corner of a mask or a raw file"), PD_KEY_ANY_TEXT},
    {"cell", "m", "required there", PDI_DOC("size of a pixel or voxel, one or one an axis"), PD_KEY_ANY_TEXT},
    {"size", "-", "required there", PDI_DOC("voxels of a raw file, a number an axis"), PD_KEY_ANY_TEXT},
    {"scale", "m", "required there", PDI_DOC("length of one unit of an STL file"), PD_KEY_POSITIVE},
    {"shift", "m", "the origin", PDI_DOC("where the origin of an STL file lies"), PD_KEY_ANY_TEXT},
    {"outside", "-", "no", PDI_DOC("`yes`: the complement"), PD_KEY_ONE_OF("no, yes")},
    {"kind", "-", "part",
     PDI_DOC("`solid` (dissolves), `wall`, `medium` (fluid with a diffusivity of its own), `passive` (with "
             "`[corrode]`: fluid there does not attack, as in front of a passive film), `grip` (with `[solid]`: "
             "the metal there is held), `solution` (fluid that begins with `inside` of the species, 2.20), `part` "
             "(operand of a set operation only)"),
     PD_KEY_ANY_TEXT},
    {"C", "mol/m3", "no flux", PDI_DOC("`wall`: concentration that its surface holds"), PD_KEY_ANY_TEXT},
    {"D", "m2/s", "required there", PDI_DOC("`medium`: diffusivity inside"), PD_KEY_NOT_NEGATIVE},
    {"material", "-", "the first one that is named, else mg4ag",
     PDI_DOC("preset of the metal: `mg4ag`, `steel304`, `copper`, `alloy625` (density, molar mass, charge; sources "
             "in `src/metal/material.h`). Solids may be of different metals"),
     PD_KEY_ANY_TEXT},
    {"grain_size", "m", "no grains", PDI_DOC("mean grain diameter; the grains of all solids are the same"),
     PD_KEY_POSITIVE},
    {"grain_size_deviation", "m", "0",
     PDI_DOC("standard deviation of the diameter; 0: random seeds (2D: 26 % of the diameter); else up to 44 %, 22 "
             "%, 13 % of it in 1D, 2D, 3D"),
     PD_KEY_NOT_NEGATIVE},
    {"grain_seed", "-", "1", PDI_DOC("whole number, another polycrystal each"), PD_KEY_WHOLE_FROM(0, 2147483647)},
    {"grain_boundary_width", "m", "0.5 um", PDI_DOC("physical width of a grain boundary"), PD_KEY_NOT_NEGATIVE},
    {"ux, uy, uz", "m", "-",
     PDI_DOC("`grip`: displacement of the metal in it, expressions in x, y, z, t; an axis without one is free"),
     PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_side[] = {
    {"flow", "-", "noslip; with `[gas]` slip",
     PDI_DOC("`noslip`, `inlet`, `outlet`, `periodic` (both sides of the axis), `mirror` (plane of symmetry, free "
             "slip), `open` (with `time = prescribed`: inlet where the flow enters, outlet where it leaves; with "
             "`[corrode]`: `bulk` behind it), `slip` (with `[gas]`: a wall)"),
     PD_KEY_ANY_TEXT},
    {"profile", "-", "required there",
     PDI_DOC("inlet: `uniform`, `parabola` (developed flow of the opening, whatever its shape), `expression`"),
     PD_KEY_ONE_OF("uniform, parabola, expression")},
    {"mean", "m/s", "required, or `flow_rate`; not with an expression",
     PDI_DOC("inlet: mean speed into the box, expression in t; an expression of the place is scaled to it"),
     PD_KEY_NOT_NEGATIVE},
    {"flow_rate", "m3/s", "-",
     PDI_DOC("inlet: volume per time, expression in t. Planar 2D: through a tube as wide as the opening"),
     PD_KEY_POSITIVE},
    {"vx, vy, vz", "m/s", "0, one of them required",
     PDI_DOC("`profile = expression`: velocity, expressions in x, y, z, t"), PD_KEY_ANY_TEXT},
    {"p", "Pa", "0", PDI_DOC("outlet: pressure"), PD_KEY_ANY_NUMBER},
    {"velocity", "m/s", "0",
     PDI_DOC("noslip: velocity of the wall along itself, an expression in x, y, z, t an axis, 0 across it"),
     PD_KEY_ANY_TEXT},
    {"C", "mol/m3", "inlet, open: 0; wall: no flux",
     PDI_DOC("inlet, open: concentration of the inflow; noslip: concentration held by the wall; expressions in x, "
             "y, z, t"),
     PD_KEY_EXPRESSION_NOT_NEGATIVE},
    {"species", "-", "closed",
     PDI_DOC("noslip: `closed`, or `inlet`: the wall holds the species of what enters (2.20)"),
     PD_KEY_ONE_OF("closed, inlet")},
    {"ux, uy, uz", "m", "-",
     PDI_DOC("with `[solid]`: displacement of the metal at the side, expressions in x, y, z, t; an axis without "
             "one is free"),
     PD_KEY_ANY_TEXT},
    {"traction", "Pa", "-",
     PDI_DOC("with `[solid]`: force per area on the metal at the side, an expression in x, y, z, t an axis"),
     PD_KEY_ANY_TEXT},
    {"pressure", "Pa", "-", PDI_DOC("with `[solid]`: force per area against the side, an expression in x, y, z, t"),
     PD_KEY_ANY_TEXT},
    {"potential", "V", "no current passes",
     PDI_DOC("with `[potential]`: noslip, inlet, open: potential that the fluid has there"),
     PD_KEY_FROM(-PDI_KEYS_MAX_VOLTAGE, PDI_KEYS_MAX_VOLTAGE)}};

static const pd_key pdi_keys_of_flow[] = {
    {"rho", "kg/m3", "required", PDI_DOC("density"), PD_KEY_POSITIVE},
    {"mu", "Pa s", "required", PDI_DOC("viscosity"), PD_KEY_POSITIVE},
    {"steady_tolerance", "-", "1e-6",
     PDI_DOC("residual at which the flow is steady (theory: eq. 3.25, 3.26), up to 0.1, against scales of the flow "
             "itself"),
     PD_KEY_ABOVE(0.0, 0.1)},
    {"order", "-", "auto",
     PDI_DOC("order of the error in the spacing, 2 or 4 (theory: 3.8): 4 takes `m = 1`, a planar box, and `time = "
             "steady` or `implicit`. `auto`: 4 in steady flow in closed boxes without shapes whose walls meet, "
             "with `m = 1`, a Reynolds number of at most 1000 and one of a cell of at most 16; else 2. The summary "
             "names order 4"),
     PD_KEY_ONE_OF("auto, 2, 4")},
    {"body_force", "m/s2", "0", PDI_DOC("body force per mass, an expression in x, y, z, t an axis"), PD_KEY_ANY_TEXT},
    {"reference_speed", "m/s", "mean speed of the inlet, else a scale of the flow (theory: eq. 3.9)",
     PDI_DOC("reference value that residuals and `Re` are reported with; nothing else depends on it"), PD_KEY_POSITIVE},
    {"reference_length", "m", "width of the inlet, else a scale of the flow (theory: eq. 3.9)",
     PDI_DOC("as `reference_speed`"), PD_KEY_POSITIVE},
    {"time", "-", "steady",
     PDI_DOC("`steady`; `implicit`: incompressible flow in time, steps by error; `explicit`: weakly compressible "
             "flow in time; `prescribed`: `vx`, `vy`, `vz` for ever"),
     PD_KEY_ONE_OF("steady, implicit, explicit, prescribed")},
    {"vx, vy, vz", "m/s", "0",
     PDI_DOC("flow at the start, or prescribed flow (free of divergence), expressions in x, y, z"), PD_KEY_ANY_TEXT},
    {"rtol", "-", "1e-4", PDI_DOC("`implicit`: error of a step against the speed of the flow (theory: eq. 3.9)"),
     PD_KEY_ABOVE(0.0, 0.1)},
    {"eos", "-", "tait", PDI_DOC("`explicit`: `tait` or `linear`"), PD_KEY_ONE_OF("tait, linear")},
    {"c0", "m/s", "required there", PDI_DOC("`explicit`: speed of sound, ten times the largest speed or more"),
     PD_KEY_POSITIVE}};

static const pd_key pdi_keys_of_gas[] = {
    {"gamma", "-", "1.4", PDI_DOC("ratio of the heat capacities, above 1"), PD_KEY_ABOVE(1.0, 10.0)},
    {"rho", "kg/m3", "required", PDI_DOC("density at the start, an expression in x, y, z, positive"),
     PD_KEY_EXPRESSION_POSITIVE},
    {"p", "Pa", "required", PDI_DOC("pressure at the start, an expression in x, y, z, positive"),
     PD_KEY_EXPRESSION_POSITIVE},
    {"vx, vy, vz", "m/s", "0", PDI_DOC("velocity at the start, expressions in x, y, z"), PD_KEY_ANY_TEXT},
    {"order", "-", "second", PDI_DOC("`second` where smooth, `first`"), PD_KEY_ONE_OF("second, first")},
    {"cfl", "-", "0.8", PDI_DOC("share of the longest stable step (theory: eq. 4.10), up to 1"),
     PD_KEY_ABOVE(0.0, 1.0)}};

static const pd_key pdi_keys_of_transport[] = {
    {"D", "m2/s", "required", PDI_DOC("diffusivity"), PD_KEY_NOT_NEGATIVE},
    {"initial", "mol/m3", "0", PDI_DOC("concentration at the start, expression in x, y, z, not negative"),
     PD_KEY_EXPRESSION_NOT_NEGATIVE},
    {"advection", "-", "limited", PDI_DOC("`limited` (second order where smooth), `upwind` (first order)"),
     PD_KEY_ONE_OF("limited, upwind")},
    {"time", "-", "that of `[chemistry]`, else implicit",
     PDI_DOC("`implicit`: in time; `steady`: the steady field at once; the run fails when balances lack more than "
             "1e-6 of what passes, and `defect=` says how much (theory: eq. 6.23)"),
     PD_KEY_ONE_OF("implicit, steady")}};

static const pd_key pdi_keys_of_dissolve[] = {
    {"rate", "m/s", "`rate`, `law` or `current` required",
     PDI_DOC("recession speed of the surface, expression in `C`, t, x, y, z, or in pH and species (2.20)"),
     PD_KEY_ANY_TEXT},
    {"law", "1/s", "-", PDI_DOC("the same in layers of `h` per time: speed = law h. Depends on the grid"),
     PD_KEY_ANY_TEXT},
    {"current", "A/m2", "-",
     PDI_DOC("the same as a current density: speed = `i/(z F Cs)`; `i` is that of the `[electrode]`"), PD_KEY_ANY_TEXT},
    {"rate_scale", "-", "1", PDI_DOC("factor of `rate`, `law` or `current`"), PD_KEY_FROM(0.0, 1e6)},
    {"Csat", "mol/m3", "none", PDI_DOC("saturation concentration, a constant for the expressions"), PD_KEY_POSITIVE},
    {"Cs", "mol/m3", "density over molar mass", PDI_DOC("concentration of the intact metal"), PD_KEY_POSITIVE},
    {"charge", "-", "that of the material", PDI_DOC("electrons that an atom gives off, for currents in the summary"),
     PD_KEY_ABOVE(0.0, 10.0)},
    {"potential", "V", "none",
     PDI_DOC("with `migration = yes`: potential of the metal against inlets and walls that hold species, an "
             "expression in t. The law may depend on `E`, that potential less the one of the ions at the surface "
             "(2.20)"),
     PD_KEY_ANY_TEXT},
    {"grain_boundary_factor", "-", "1", PDI_DOC("factor on the speed in a grain boundary; needs `grain_size`"),
     PD_KEY_FROM(0.0, 1e6)},
    {"reaction", "text", "none",
     PDI_DOC("by which the metal enters the species of `[chemistry]`, for example `Mg + 2 H2O = Mg2+ + 2 OH- + "
             "H2(g)`: balanced in elements and charge, the metal by its symbol; `e-` is what a current takes away, "
             "as in `Fe = Fe2+ + 2 e-`"),
     PD_KEY_ANY_TEXT},
    {"threshold", "-", "0", PDI_DOC("share of the content that stays in a node when it turns fluid, up to 0.99"),
     PD_KEY_FROM(0.0, 0.99)},
    {"m", "-", "3, or that of the fluid when it is longer",
     PDI_DOC("horizon of the bonds of metal over h, at least that of the fluid, up to 6"), PD_KEY_FROM(1.0, 6.0)}};

static const pd_key pdi_keys_of_corrode[] = {
    {"rate", "m/s", "`rate` or `current` required",
     PDI_DOC("recession speed of the surface, expression in `C`, t, x, y, z, or in pH and species (2.20)"),
     PD_KEY_ANY_TEXT},
    {"current", "A/m2", "-", PDI_DOC("the same as a current density: speed = `i/(z F Cs)`"), PD_KEY_ANY_TEXT},
    {"rate_scale", "-", "1", PDI_DOC("factor of `rate` or `current`"), PD_KEY_FROM(0.0, 1e6)},
    {"reaction", "text", "none",
     PDI_DOC("by which the metal enters the species of `[chemistry]`, for example `Mg + 2 H2O = Mg2+ + 2 OH- + "
             "H2(g)`: balanced in elements and charge, the metal by its symbol"),
     PD_KEY_ANY_TEXT},
    {"Csat", "mol/m3", "required",
     PDI_DOC("saturation concentration: a node that is down to it turns fluid; fluid that has reached it takes no "
             "more (salt layer)"),
     PD_KEY_POSITIVE},
    {"Cs", "mol/m3", "density over molar mass", PDI_DOC("concentration of the intact metal"), PD_KEY_POSITIVE},
    {"charge", "-", "that of the material", PDI_DOC("electrons given off by one atom, `z_m`"), PD_KEY_ABOVE(0.0, 10.0)},
    {"D", "m2/s", "required; `activation` 0", PDI_DOC("diffusivity of the fluid"), PD_KEY_NOT_NEGATIVE},
    {"initial", "mol/m3", "0", PDI_DOC("concentration of the fluid at the start, expression in x, y, z, not negative"),
     PD_KEY_EXPRESSION_NOT_NEGATIVE},
    {"bulk", "mol/m3", "0", PDI_DOC("concentration behind open sides; with `activation` of all fluid, up to `Csat`"),
     PD_KEY_NOT_NEGATIVE},
    {"control", "-", "diffusion",
     PDI_DOC("`diffusion`: dissolved metal has to diffuse away; `activation`: it is gone at once"),
     PD_KEY_ONE_OF("diffusion, activation")},
    {"driving_force", "-", "constant",
     PDI_DOC("`constant`: the law holds at every concentration; `difference`: loss in proportion to the difference "
             "of metal and fluid, as in the literature"),
     PD_KEY_ONE_OF("constant, difference")},
    {"kernel", "-", "area",
     PDI_DOC("weights of the bonds: `area` (same speed in all directions), `square`, `inverse` (one over the "
             "squared, the simple length)"),
     PD_KEY_ONE_OF("area, square, inverse")},
    {"weights", "-", "calibrated",
     PDI_DOC("`calibrated`: a flat front moves at the rate; `published`: coefficients of the continuum, slower on a "
             "lattice; not for `area`"),
     PD_KEY_ONE_OF("calibrated, published")},
    {"grain_boundary_factor", "-", "1", PDI_DOC("factor on the speed in a grain boundary; needs `grain_size`"),
     PD_KEY_FROM(0.0, 1e6)},
    {"repassivation", "mol/m3", "none forms",
     PDI_DOC("solution beside metal that has once been below it does not attack any more: a film has formed (with "
             "diffusion)"),
     PD_KEY_POSITIVE},
    {"breaking", "-", "deterministic",
     PDI_DOC("`deterministic`: a node turns fluid at `Csat`; `stochastic`: when the last of its mechanical bonds "
             "has broken, which happens at random as its metal goes, at `Csat` at the latest (theory: 11.5)"),
     PD_KEY_ONE_OF("deterministic, stochastic")},
    {"seed", "-", "1", PDI_DOC("`stochastic`: whole number, other bonds each"), PD_KEY_WHOLE_FROM(0, 2147483647)},
    {"m", "-", "that of `[grid]`; 3", PDI_DOC("horizon of the bonds of metal over h, 1 to 6"), PD_KEY_FROM(1.0, 6.0)}};

static const pd_key pdi_keys_of_solid[] = {
    {"E", "Pa", "required", PDI_DOC("Young's modulus"), PD_KEY_ABOVE(0.0, PD_KEY_MAX_NUMBER)},
    {"nu", "-", "required",
     PDI_DOC("Poisson's ratio, which 1D does not have; `bond_based` has 1/4, in plane stress 1/3"),
     PD_KEY_FROM(-0.999, 0.499)},
    {"model", "-", "correspondence",
     PDI_DOC("`correspondence`: small strains, of any Poisson's ratio (theory: 14.2); `ordinary`: the linear "
             "peridynamic solid, of small strains (14.5); `neo_hookean`, `hencky`: strains of any size (14.4); "
             "`bond_based`: bonds that pull for themselves, displacements of any size, no stress (15.2)"),
     PD_KEY_ONE_OF("correspondence, bond_based, ordinary, neo_hookean, hencky")},
    {"plane", "-", "strain", PDI_DOC("2D: `strain` or `stress`"), PD_KEY_ONE_OF("strain, stress")},
    {"yield_stress", "Pa", "0: it does not flow",
     PDI_DOC("stress of von Mises at which the metal flows; with `correspondence` (not in `plane = stress`) and "
             "`hencky`"),
     PD_KEY_NOT_NEGATIVE},
    {"hardening_modulus", "Pa", "0", PDI_DOC("by how much `yield_stress` grows with the plastic strain"),
     PD_KEY_NOT_NEGATIVE},
    {"fracture_energy", "J/m2", "0: none breaks",
     PDI_DOC(
         "energy per area at which a crack runs; of `correspondence` without `yield_stress`, in balance (3D: m = 1.5 "
         "to 3), and of `bond_based`"),
     PD_KEY_NOT_NEGATIVE},
    {"strength", "Pa", "0: none breaks",
     PDI_DOC("bonds break whose ends have a larger principal stress, in the mean; in balance"), PD_KEY_NOT_NEGATIVE},
    {"critical_stretch", "-", "0: none breaks", PDI_DOC("bonds break that are stretched by more; in balance"),
     PD_KEY_NOT_NEGATIVE},
    {"dynamics", "-", "no", PDI_DOC("`yes`: the metal moves from rest at t = 0"), PD_KEY_ONE_OF("no, yes")},
    {"density", "kg/m3", "required there", PDI_DOC("mass density of the metal that moves"), PD_KEY_POSITIVE},
    {"body_force", "N/m3", "0", PDI_DOC("a force on all of the metal, an expression in x, y, z, t an axis"),
     PD_KEY_ANY_TEXT},
    {"dissolution_factor", "-", "1",
     PDI_DOC("factor of the speed at which the metal dissolves, an expression in sigma_h, mises, eps_p, x, y, z, t"),
     PD_KEY_ANY_TEXT},
    {"m", "-", "2; `bond_based` 3", PDI_DOC("horizon of the bonds over h"), PD_KEY_FROM(1.0, 6.0)},
    {"influence", "-", "constant", PDI_DOC("how bonds count by their length: `constant`, `inverse`, `linear`"),
     PD_KEY_ONE_OF("constant, inverse, linear")},
    {"rtol", "-", "1e-8",
     PDI_DOC("of the balance: forces that are left, over the loads and the forces on what is held"),
     PD_KEY_FROM(1e-13, 1e-3)}};

static const pd_key pdi_keys_of_crack[] = {
    {"points", "m", "required", PDI_DOC("corners one after another, all coordinates of each; up to 32"),
     PD_KEY_ANY_TEXT},
    {"direction", "-", "2D: that of the last piece; 3D: no table",
     PDI_DOC("direction in which the crack grows, plain numbers"), PD_KEY_ANY_TEXT},
    {"contour_radii", "m", "no J", PDI_DOC("2D: three radii about the tip, a horizon `m h` or more apart"),
     PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_table[] = {
    {"file", "-", "required",
     PDI_DOC("CSV file, relative to the scene: `#` lines are comments, then one line of headings, then a row a "
             "point"),
     PD_KEY_ANY_TEXT},
    {"x", "-", "required", PDI_DOC("column of the argument, `heading in unit`; without `in` plain numbers"),
     PD_KEY_ANY_TEXT},
    {"y", "-", "required", PDI_DOC("column of the value, as for `x`"), PD_KEY_ANY_TEXT},
    {"outside", "-", "hold",
     PDI_DOC("beyond the first and last `x`: `hold` (the value there holds) or `error` (the run ends with a "
             "message)"),
     PD_KEY_ONE_OF("hold, error")}};

static const pd_key pdi_keys_of_run[] = {
    {"until", "s", "-", PDI_DOC("end; required with `[transport]` and `[corrode]`"), PD_KEY_POSITIVE},
    {"rtol", "-", "4e-3; without dissolution and with `[corrode]` 1e-3",
     PDI_DOC(
         "aim for the error of the volume loss, up to 0.1: errors in time of the law sum up to at most "
         "five times it, those of fluid whose law has not started go with its root (theory: eq. 10.15); "
         "sets `max_dissolved_fraction = 25 rtol`. A step goes by the surface at its start: bodies of few cells that "
         "shrink lose too much by up to half of `max_dissolved_fraction` of the cells at their surface. What a stream "
         "has carried off of the dissolved metal has no tolerance of its own where the law hardly reads "
         "it: `max_step` holds it. Without dissolution: error of a step of the transport against the "
         "largest concentration; with `[corrode]` of the concentration over `Csat`, too"),
     PD_KEY_ABOVE(0.0, 0.1)},
    {"max_dissolved_fraction", "-",
     "25 rtol; with `[corrode]` 0.2, `activation` 0.1, `driving_force = difference` 0.01",
     PDI_DOC("largest share of its content that a node loses in a step, up to 1; overrides `rtol`"),
     PD_KEY_ABOVE(0.0, 1.0)},
    {"max_step", "s", "0", PDI_DOC("longest step of the run, and so between rows of the tables; 0: none"),
     PD_KEY_NOT_NEGATIVE}};

static const pd_key pdi_keys_of_output[] = {
    {"every", "s", "until/20", PDI_DOC("time between frames"), PD_KEY_POSITIVE},
    {"fields", "-",
     "C, v, p, kind, grain, pH, phi as far as they exist; with `[gas]` density, v, p, energy, kind; with `[solid]` "
     "C, v, p, kind, grain, u, mises, sigma_h, eps_p, broken",
     PDI_DOC("fields of the VTK files: `C`, `v`, `p`, `kind`, `grain`, `phase`, `D`, `rate`, `density`, `damage`, "
             "`energy`, `u`, `mises`, `sigma_h`, `eps_p`, `broken`, `strain_energy`, `sigma_xx` and the other "
             "stresses, `phi`, `j`, `i`, `pH`, `potential`, `film`, `SI`, a species such as `Mg2+`, a state of "
             "[surface NAME], or `none`"),
     PD_KEY_ANY_TEXT},
    {"images", "-", "none", PDI_DOC("fields that are drawn, from the same list"), PD_KEY_ANY_TEXT},
    {"range", "of the field", "of all frames",
     PDI_DOC("colours of a drawn field go from one value to the other, for example `C 0 .. 500 mol/m3, v 0 .. 1 "
             "mm/s`"),
     PD_KEY_ANY_TEXT},
    {"percentile", "-", "100 %",
     PDI_DOC("values of a frame, in the middle of all, that count for a range that is not given"),
     PD_KEY_ABOVE(0.0, 1.0)},
    {"log_scale", "-", "none",
     PDI_DOC("drawn fields whose colours go by the logarithm; values of zero and below stay blank"), PD_KEY_ANY_TEXT},
    {"colormap", "-", "violet; diverging for p, sigma_h and stresses",
     PDI_DOC("2D and 3D: colours `violet`, `viridis`, `grey` or `diverging`, for all drawn fields or behind the "
             "name of one: `grey, p diverging`"),
     PD_KEY_ANY_TEXT},
    {"width", "-", "1000",
     PDI_DOC("2D and 3D: pixels that the width of a drawn field aims at, its height at nine tenths of that; 120 to "
             "4000"),
     PD_KEY_WHOLE_FROM(PD_FIELD_PLOT_MIN_WIDTH, PD_FIELD_PLOT_MAX_WIDTH)},
    {"cells", "-", "blocky",
     PDI_DOC("2D and 3D: `blocky`: a cell has one colour; `smooth`: colours are linear between the middles of cells"),
     PD_KEY_ONE_OF("blocky, smooth")},
    {"format", "-", "png", PDI_DOC("of the pictures of fields and of the volume loss: `png`, `svg` or both"),
     PD_KEY_ANY_TEXT},
    {"animate", "-", "no", PDI_DOC("`yes`: a film of each drawn field, `C_film.png`"), PD_KEY_ONE_OF("no, yes")},
    {"contours", "of the field", "none",
     PDI_DOC("2D and 3D: lines of one value of a drawn field: how many, `C 8`, or their values, `C at 100 200 "
             "mol/m3, p 5`"),
     PD_KEY_ANY_TEXT},
    {"streamlines", "-", "none",
     PDI_DOC("2D and 3D: drawn fields with evenly spaced lines along the flow, for example `v, C`; behind a field, "
             "how many fit side by side into `width`, 4 to 100: `v 50`, without 36"),
     PD_KEY_ANY_TEXT},
    {"vectors", "-", "none",
     PDI_DOC("2D and 3D: drawn fields with arrows as long as the flow is fast, likewise; without a number 30"),
     PD_KEY_ANY_TEXT},
    {"surface", "-", "no",
     PDI_DOC("3D: `yes`: pictures of the metal's surface, shaded; the name of a field: in its colours; `images = none`"
             ": none"),
     PD_KEY_ANY_TEXT},
    {"view", "-", "1, -1, 1", PDI_DOC("3D: direction in which the eye that looks at the surface stands"),
     PD_KEY_ANY_TEXT},
    {"deformation_scale", "-", "0",
     PDI_DOC("with `[solid]`, 2D and 3D: images of fields of the metal show it where it has moved to, with its "
             "displacements times this factor; 0: where it was"),
     PD_KEY_NOT_NEGATIVE},
    {"slice", "m", "z, middle of the box", PDI_DOC("3D: the drawn plane, for example `z 0 um`"), PD_KEY_ANY_TEXT},
    {"prefix", "-", "corr", PDI_DOC("start of the names of VTK files"), PD_KEY_ANY_TEXT},
    {"folder", "-", "the name of the scene, below output/",
     PDI_DOC("folder of the output, when `--out` is not given; below the current one: neither absolute nor with "
             "`..`"),
     PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_probe[] = {
    {"at", "m", "required", PDI_DOC("place, a coordinate an axis"), PD_KEY_ANY_TEXT},
    {"fields", "-", "C; without transport pH, phi or v", PDI_DOC("some of those of `[output]`"), PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_line[] = {
    {"from, to", "m", "required", PDI_DOC("ends, a coordinate an axis"), PD_KEY_ANY_TEXT},
    {"points", "-", "`points` or `spacing` required", PDI_DOC("number of points, with the ends"),
     PD_KEY_WHOLE_FROM(2, PDI_KEYS_MAX_POINTS)},
    {"spacing", "m", "-", PDI_DOC("largest distance between points"), PD_KEY_POSITIVE},
    {"fields", "-", "C, v, p, pH as far as they exist", PDI_DOC("some of those of `[output]`"), PD_KEY_ANY_TEXT},
    {"images", "-", "all", PDI_DOC("those of the fields that are drawn, or `none`"), PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_plane[] = {
    {"at", "m", "required",
     PDI_DOC("axis and place, for example `x -250 um`; the nearest plane between cells is taken"), PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_force[] = {
    {"box", "m", "required without `shape`; with it the whole box",
     PDI_DOC("holds the body; a range an axis. It may cut walls and cells"), PD_KEY_ANY_TEXT},
    {"shape", "-", "all surfaces in the box",
     PDI_DOC("name of a `[shape]` of `kind` solid or wall: only its surfaces count, not those of other bodies or "
             "of the sides"),
     PD_KEY_ANY_TEXT},
    {"balance", "-", "yes; with `shape` no",
     PDI_DOC("`no`: on the surface only. A balance needs two cells of fluid on both sides of the box, and is of "
             "all that the box holds"),
     PD_KEY_ONE_OF("no, yes")},
    {"reference_speed", "m/s", "no coefficients", PDI_DOC("reference value `U` of the coefficients `2 F/(rho U^2 A)`"),
     PD_KEY_POSITIVE},
    {"reference_length", "m", "required with `reference_speed`", PDI_DOC("2D: reference value `A` of the coefficients"),
     PD_KEY_POSITIVE},
    {"reference_area", "m2", "required with `reference_speed`", PDI_DOC("3D: reference value `A` of the coefficients"),
     PD_KEY_POSITIVE}};

static const pd_key pdi_keys_of_transfer[] = {
    {"box", "m", "everything", PDI_DOC("nodes that count; a range an axis"), PD_KEY_ANY_TEXT},
    {"along", "-", "none",
     PDI_DOC("axis of local values: at output times `transfer_NAME_000012_t....csv` and its plot, a row for each "
             "layer of cells"),
     PD_KEY_ANY_TEXT},
    {"reference_length", "m", "no Sherwood number", PDI_DOC("reference length `L` of Sherwood numbers"),
     PD_KEY_POSITIVE},
    {"surface", "mol/m3", "required with `reference_length`", PDI_DOC("concentration at the surface"),
     PD_KEY_NOT_NEGATIVE},
    {"fluid", "mol/m3", "required with `reference_length`",
     PDI_DOC("concentration of the fluid: `inlet`, `bulk` (of the mixed stream of each layer; needs `along`), or a "
             "value"),
     PD_KEY_EXPRESSION_NOT_NEGATIVE},
    {"D", "m2/s", "that of `[transport]`", PDI_DOC("diffusivity of the Sherwood number"), PD_KEY_POSITIVE},
    {"area", "m^(d-1)", "measured", PDI_DOC("area of the surface"), PD_KEY_POSITIVE}};

static const pd_key pdi_keys_of_total[] = {
    {"box", "m", "everything", PDI_DOC("nodes that count; a range an axis"), PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_measured[] = {
    {"file", "-", "required", PDI_DOC("CSV file, relative to the scene, as for a table (2.17)"), PD_KEY_ANY_TEXT},
    {"time", "-", "the first", PDI_DOC("column of the times, `heading in unit`; they may not fall"), PD_KEY_ANY_TEXT},
    {"value", "-", "the second", PDI_DOC("column of the values"), PD_KEY_ANY_TEXT},
    {"standard_deviation", "-", "the one whose heading starts with `spread`, else none",
     PDI_DOC("column of their spread, for example a standard deviation"), PD_KEY_ANY_TEXT},
    {"of", "-", "`volume_loss`",
     PDI_DOC("figure that was measured: `volume_loss`, or one of a section of 2.13 to 2.16, of a grip, "
             "of the solid, of an electrode or of a probe: `plane.NAME.flow`, `total.NAME.solid`, `grip.x+.fx`, "
             "`solid.metal.u_max`, `electrode.NAME.E`, `probe.NAME.C`, `probe.NAME.pH`"),
     PD_KEY_ANY_TEXT},
    {"start", "s", "0", PDI_DOC("time of the file at which the run begins"), PD_KEY_ANY_NUMBER}};

static const pd_key pdi_keys_of_chemistry[] = {
    {"include", "-", "none",
     PDI_DOC("files with more of these sections, relative to this one, for example "
             "`electrolytes/hbss.electrolyte`; what stands here goes before what they say"),
     PD_KEY_ANY_TEXT},
    {"activity", "-", "davies",
     PDI_DOC("`davies` (up to 0.5 mol/L) or `ideal`: coefficients of activity 1 (theory: 7.3)"),
     PD_KEY_ONE_OF("ideal, davies")},
    {"temperature", "K", "298.15 K",
     PDI_DOC("273 to 373: Davies' equation, constants with an `enthalpy`, rates and diffusivities with an "
             "`activation_energy` follow it; expressions know it as `T`"),
     PD_KEY_FROM(PDI_KEYS_MIN_T, PDI_KEYS_MAX_T)},
    {"diffusion", "-", "given",
     PDI_DOC(
         "`given`: each `D` holds as it is written, but for an `activation_energy`; `viscosity`: those are of 25 C, "
         "and follow temperature and viscosity of water by Stokes and Einstein (theory: eq. 7.14)"),
     PD_KEY_ONE_OF("given, viscosity")},
    {"pH", "-", "that of the equilibrium",
     PDI_DOC("at the start: acid or base comes to what is written, with its `counter_ion`, until the equilibrium has "
             "this pH"),
     PD_KEY_FROM(-2.0, 16.0)},
    {"inlet_pH", "-", "that of `pH`", PDI_DOC("the same of what enters"), PD_KEY_FROM(-2.0, 16.0)},
    {"inside_pH", "-", "that of `pH`", PDI_DOC("the same at the start in shapes of `kind = solution`"),
     PD_KEY_FROM(-2.0, 16.0)},
    {"counter_ion", "-", "that of `balance_ion`", PDI_DOC("ion that comes or goes with the acid or base of `pH`"),
     PD_KEY_ANY_TEXT},
    {"balance_ion", "-", "none: charges have to sum to 0",
     PDI_DOC("ion that makes up for the sum of charges of what is written"), PD_KEY_ANY_TEXT},
    {"time", "-", "implicit",
     PDI_DOC("of a run: `implicit`, steps in time with the error `rtol` of `[run]`, or `steady`: the fields at "
             "rest alone"),
     PD_KEY_ONE_OF("implicit, steady")},
    {"migration", "-", "no",
     PDI_DOC("of a run: `yes`: ions also move in the potential that keeps the fluid neutral while they diffuse at "
             "different speeds (theory: 8.7), which is the field `potential` [V]; `no`: each diffuses by itself"),
     PD_KEY_ONE_OF("no, yes")},
    {"minerals", "-", "given",
     PDI_DOC("`given`: those alone dissolve and grow that have an amount at the start; `all`: each forms that can. "
             "Of a run: `given` are those with `[mineral ...]`, and `all` puts the others in equilibrium"),
     PD_KEY_ONE_OF("given, all")},
    {"tortuosity", "-", "1",
     PDI_DOC("tau of the diffusivity `D eps/tau` in cells of which minerals leave the share eps open"),
     PD_KEY_NOT_NEGATIVE},
    {"covering_thickness", "m", "0: minerals cover no metal",
     PDI_DOC("thickness d0 of minerals: under a film d thick the share `exp(-d/d0)` of the metal dissolves"),
     PD_KEY_NOT_NEGATIVE}};

static const pd_key pdi_keys_of_mineral[] = {
    {"rate", "mol/m2/s", "none: in equilibrium",
     PDI_DOC("k of its growth by `k A (Omega^p - 1)` with Omega = IAP/K; below saturation it dissolves"),
     PD_KEY_NOT_NEGATIVE},
    {"area", "1/m", "0",
     PDI_DOC("surface it has over the volume of a cell, whatever there is of it; `rate` needs it or `surface`"),
     PD_KEY_NOT_NEGATIVE},
    {"surface", "m2/mol", "0", PDI_DOC("surface over its amount, which it follows as it grows and dissolves"),
     PD_KEY_NOT_NEGATIVE},
    {"exponent", "-", "1", PDI_DOC("p of that law"), PD_KEY_NOT_NEGATIVE},
    {"nucleation", "-", "0", PDI_DOC("saturation index log10 Omega from which it forms in a cell that has none"),
     PD_KEY_NOT_NEGATIVE},
    {"porosity", "-", "0.1",
     PDI_DOC("share of a cell that it leaves open when it can grow no more; unread without `volume`"),
     PD_KEY_FROM(0.0, 1.0)}};

static const pd_key pdi_keys_of_species[] = {
    {"D", "m2/s", "not known", PDI_DOC("diffusivity; a species that moves needs it"), PD_KEY_NOT_NEGATIVE},
    {"activation_energy", "J/mol", "none: D holds as it is written",
     PDI_DOC("energy of activation of `D`, which is that of 25 C then (theory: eq. 7.13)"), PD_KEY_ANY_NUMBER},
    {"charge", "-", "that of the name", PDI_DOC("needed where the name is no formula with its charge"),
     PD_KEY_WHOLE_FROM(-20, 20)},
    {"formula", "-", "the name",
     PDI_DOC("atoms, without charge, of a name that is no formula, for example `C6H12O6` of glucose"), PD_KEY_ANY_TEXT},
    {"initial", "mol/m3", "0",
     PDI_DOC("concentration that is put in at the start, also in mM or mol/L; of a solid its amount over the "
             "volume of water"),
     PD_KEY_NOT_NEGATIVE},
    {"inlet", "mol/m3", "that of `initial`", PDI_DOC("the same of what enters, and of walls with `species = inlet`"),
     PD_KEY_NOT_NEGATIVE},
    {"inside", "mol/m3", "that of `initial`", PDI_DOC("the same at the start in shapes of `kind = solution`"),
     PD_KEY_NOT_NEGATIVE},
    {"volume", "m3/mol", "0: it takes no room", PDI_DOC("molar volume of a solid, which narrows pores in a run"),
     PD_KEY_NOT_NEGATIVE}};

static const pd_key pdi_keys_of_reaction[] = {
    {"equation", "text", "required",
     PDI_DOC("stands behind the header without its key: `Mg2+ + 2 OH- = Mg(OH)2(s)`, with blanks around + and =. "
             "Elements and charge have to balance"),
     PD_KEY_ANY_TEXT},
    {"K", "of the reaction", "required, or `log10_K`, or both rates",
     PDI_DOC("constant of the equilibrium of the equation as it is written, with its unit: products over "
             "reactants, water and solids being 1"),
     PD_KEY_ANY_TEXT},
    {"log10_K", "-", "required, or `K`, or both rates", PDI_DOC("its decimal logarithm with mol/L"), PD_KEY_ANY_NUMBER},
    {"enthalpy", "J/mol", "none: K holds as it is written",
     PDI_DOC("of the equation as it is written; the constant is that of 25 C then, and follows the temperature by "
             "van 't Hoff's equation (theory: eq. 7.12)"),
     PD_KEY_ANY_NUMBER},
    {"forward", "of the reaction", "none: the reaction is in equilibrium",
     PDI_DOC("rate constant from left to right at infinite dilution, with its unit, for example `1.4e11 L/mol/s`"),
     PD_KEY_ANY_TEXT},
    {"backward", "of the reaction", "`forward` over K", PDI_DOC("from right to left"), PD_KEY_ANY_TEXT},
    {"activation_energy", "J/mol", "none: rates hold as they are written",
     PDI_DOC("energy of activation of `forward`; rates are those of 25 C then; that of `backward` is less by the "
             "`enthalpy`"),
     PD_KEY_ANY_NUMBER}};

static const pd_key pdi_keys_of_potential[] = {
    {"conductivity", "S/m", "that of the species",
     PDI_DOC("of the fluid; with `[chemistry]` it follows from charges, diffusivities and concentrations (theory: "
             "eq. 12.6)"),
     PD_KEY_POSITIVE},
    {"tolerance", "-", "1e-12", PDI_DOC("of what the balances of currents lack, over the currents"),
     PD_KEY_ABOVE(0.0, 0.1)}};

static const pd_key pdi_keys_of_electrode[] = {
    {"shape", "-", "`shape` or `material` required",
     PDI_DOC("name of a solid `[shape]` whose metal it is; where electrodes overlap the later one counts"),
     PD_KEY_ANY_TEXT},
    {"material", "-", "-", PDI_DOC("all metal of a material"), PD_KEY_ANY_TEXT},
    {"curve", "-", "required",
     PDI_DOC(
         "`butler_volmer`: both slopes; `tafel`: one of them; `linear`: `polarisation_resistance`; `expression`: `i`; "
         "`primary`: current passes freely at `E0` (theory: 12.2). With `migration = yes` it may be "
         "absent: its metal dissolves alone"),
     PD_KEY_ONE_OF("butler_volmer, tafel, linear, expression, primary")},
    {"i0", "A/m2", "required there", PDI_DOC("exchange current density, or that of free corrosion"), PD_KEY_POSITIVE},
    {"E0", "V", "0", PDI_DOC("equilibrium potential, or that of free corrosion"),
     PD_KEY_FROM(-PDI_KEYS_MAX_VOLTAGE, PDI_KEYS_MAX_VOLTAGE)},
    {"anodic_slope", "V", "none",
     PDI_DOC("change of E by which the anodic current grows tenfold (Tafel's slope), positive"),
     PD_KEY_ABOVE(0.0, PDI_KEYS_MAX_VOLTAGE)},
    {"cathodic_slope", "V", "none", PDI_DOC("the same of the cathodic current, positive"),
     PD_KEY_ABOVE(0.0, PDI_KEYS_MAX_VOLTAGE)},
    {"anodic_limit", "A/m2", "0: none", PDI_DOC("limiting current density of the anodic branch"), PD_KEY_NOT_NEGATIVE},
    {"cathodic_limit", "A/m2", "0: none", PDI_DOC("the same of the cathodic one, positive"), PD_KEY_NOT_NEGATIVE},
    {"polarisation_resistance", "ohm m2", "required there", PDI_DOC("`linear`: polarisation resistance"),
     PD_KEY_POSITIVE},
    {"i", "A/m2", "required there",
     PDI_DOC("`expression`: current density, positive from metal to fluid, in `E`, with `migration = yes` also "
             "in pH and species; also of a `[table]`: `i = f(E)`. It must not fall as E rises"),
     PD_KEY_ANY_TEXT},
    {"range", "V", "required there",
     PDI_DOC("`expression`: from where to where E may lie; straight on beyond, with a note; `E_least`, `E_most` and "
             "`range_left` of its result line tell what was met; none with pH or species"),
     PD_KEY_ANY_TEXT},
    {"film_resistance", "ohm m2", "0", PDI_DOC("resistance of a coating or film on it"), PD_KEY_NOT_NEGATIVE},
    {"potential", "V", "it follows from the current", PDI_DOC("given potential of the metal, expression in t"),
     PD_KEY_ANY_TEXT},
    {"current", "A", "0: it corrodes freely",
     PDI_DOC("given current from metal to fluid, expression in t; per m of depth in planar 2D, per m2 in 1D"),
     PD_KEY_ANY_TEXT},
    {"reaction", "text", "none",
     PDI_DOC("half-reaction of its current, by which it enters the species of `[chemistry]`: `O2 + 2 H2O + 4 "
             "e- = 4 OH-`, balanced in elements and charge; anodic with `e-` on the right"),
     PD_KEY_ANY_TEXT},
    {"current_factor", "-", "1",
     PDI_DOC("factor of its currents, an expression in states of surfaces (2.22), x, y, z, t; at least 0"),
     PD_KEY_ANY_TEXT},
    {"connected", "-", "none", PDI_DOC("names of electrodes that it is wired to. Metals that touch are connected, too"),
     PD_KEY_ANY_TEXT}};

static const pd_key pdi_keys_of_surface[] = {
    {"of", "-", "all electrodes; without them all metal that dissolves",
     PDI_DOC("names of the electrodes that carry the state"), PD_KEY_ANY_TEXT},
    {"initial", "of the state", "required",
     PDI_DOC("value at the start, an expression in x, y, z; its unit is that of the state"), PD_KEY_ANY_TEXT},
    {"rate", "of the state per s", "required",
     PDI_DOC("change in time, an expression in the concentrations at the surface, `[Mg2+]`, in pH, in E and i "
             "of the electrode, the temperature T, t, x, y, z and all states"),
     PD_KEY_ANY_TEXT},
    {"min", "of the state", "none",
     PDI_DOC("where the law ends: a state that is there stays as long as its rate is negative"), PD_KEY_ANY_TEXT},
    {"max", "of the state", "none", PDI_DOC("the same above"), PD_KEY_ANY_TEXT}};

#undef PDI_DOC
#undef PDI_KEYS_MAX_VOLTAGE
#undef PDI_KEYS_MIN_T
#undef PDI_KEYS_MAX_T

#define PDI_KEYS_OF(table) (table), (int)(sizeof(table) / sizeof(table)[0])
static const pd_key_section pdi_keys_sections[] = {
    {"constants", "", "names for values of any dimension", PDI_KEYS_OF(pdi_keys_of_constants)},
    {"grid", "", "spacing, horizon and extent of the lattice", PDI_KEYS_OF(pdi_keys_of_grid)},
    {"shape", "NAME", "a body, a wall, or a part of one", PDI_KEYS_OF(pdi_keys_of_shape)},
    {"side", "x-", "a side of the box: x-, x+, y-, y+, z-, z+", PDI_KEYS_OF(pdi_keys_of_side)},
    {"flow", "", "flow of the liquid", PDI_KEYS_OF(pdi_keys_of_flow)},
    {"gas", "", "an ideal gas, alone", PDI_KEYS_OF(pdi_keys_of_gas)},
    {"transport", "", "what the liquid carries", PDI_KEYS_OF(pdi_keys_of_transport)},
    {"dissolve", "", "metal that dissolves by a law at its surface; [dissolve METAL]: one of several",
     PDI_KEYS_OF(pdi_keys_of_dissolve)},
    {"corrode", "", "bond-based corrosion, in place of [dissolve]; [corrode METAL]: one of several",
     PDI_KEYS_OF(pdi_keys_of_corrode)},
    {"solid", "", "the metal bears loads", PDI_KEYS_OF(pdi_keys_of_solid)},
    {"crack", "NAME", "a crack at the start", PDI_KEYS_OF(pdi_keys_of_crack)},
    {"table", "NAME", "a function of two columns of a file", PDI_KEYS_OF(pdi_keys_of_table)},
    {"chemistry", "", "an electrolyte: activities, pH, files to include", PDI_KEYS_OF(pdi_keys_of_chemistry)},
    {"species", "FORMULA", "an ion, a molecule or a solid: Mg2+, HCO3-, Mg(OH)2(s)", PDI_KEYS_OF(pdi_keys_of_species)},
    {"reaction", "NAME", "a reaction as text, in equilibrium or with its speed", PDI_KEYS_OF(pdi_keys_of_reaction)},
    {"mineral", "FORMULA", "a solid that forms and dissolves in a run: Mg(OH)2(s)", PDI_KEYS_OF(pdi_keys_of_mineral)},
    {"potential", "", "electric potential of the fluid", PDI_KEYS_OF(pdi_keys_of_potential)},
    {"electrode", "NAME", "metal with a polarisation curve", PDI_KEYS_OF(pdi_keys_of_electrode)},
    {"surface", "NAME", "a state that surfaces of metal carry, such as the thickness of a film",
     PDI_KEYS_OF(pdi_keys_of_surface)},
    {"run", "", "end and steps", PDI_KEYS_OF(pdi_keys_of_run)},
    {"output", "", "files and pictures", PDI_KEYS_OF(pdi_keys_of_output)},
    {"probe", "NAME", "values at a place", PDI_KEYS_OF(pdi_keys_of_probe)},
    {"line", "NAME", "values along a line", PDI_KEYS_OF(pdi_keys_of_line)},
    {"plane", "NAME", "what passes a plane", PDI_KEYS_OF(pdi_keys_of_plane)},
    {"force", "NAME", "the force of the flow on a body", PDI_KEYS_OF(pdi_keys_of_force)},
    {"transfer", "NAME", "what the fluid in a box gets from solids", PDI_KEYS_OF(pdi_keys_of_transfer)},
    {"total", "NAME", "what a box holds", PDI_KEYS_OF(pdi_keys_of_total)},
    {"measured", "NAME", "points that the run is compared with", PDI_KEYS_OF(pdi_keys_of_measured)}};
#undef PDI_KEYS_OF
#define PDI_KEYS_SECTION_COUNT ((int)(sizeof pdi_keys_sections / sizeof pdi_keys_sections[0]))

const pd_key_section *pd_key_sections(int *count)
{
    *count = PDI_KEYS_SECTION_COUNT;
    return pdi_keys_sections;
}

PDI_FN const pd_key_section *pdi_keys_find_section(const char *name)
{
    for (int k = 0; k < PDI_KEYS_SECTION_COUNT; k++)
        if (strcmp(pdi_keys_sections[k].name, name) == 0) return &pdi_keys_sections[k];
    return NULL;
}

/* 1: the word is an item of the comma-separated list. */
static int pdi_keys_is_listed(const char *list, const char *word)
{
    for (size_t size; *list; list += size, list += strspn(list, ", ")) {
        size = strcspn(list, ",");
        if (strlen(word) == size && memcmp(list, word, size) == 0) return 1;
    }
    return 0;
}

PDI_FN const pd_key_section *pdi_keys_find_known_section(const pd_ctx *ctx, const char *name)
{
    for (int k = 0; k < ctx->physics_count; k++)
        if (strcmp(ctx->physics[k]->section.name, name) == 0) return &ctx->physics[k]->section;
    return pdi_keys_find_section(name);
}

PDI_FN int pdi_keys_is_field(const pd_ctx *ctx, const char *name)
{
    for (int k = 0; k < ctx->physics_count; k++)
        for (int f = 0; f < ctx->physics[k]->fields; f++)
            if (strcmp(ctx->physics[k]->field[f].name, name) == 0) return 1;
    return 0;
}

PDI_FN const pd_key *pdi_keys_find_key(const pd_key_section *section, const char *key)
{
    for (int k = 0; k < section->count; k++)
        if (pdi_keys_is_listed(section->key[k].keys, key) || strcmp(section->key[k].unit, "any") == 0)
            return &section->key[k];
    return NULL;
}

#ifdef PD_DEBUG
/* 1: `part` occurs in the text as a whole word or number. */
static int pdi_keys_has_word(const char *text, const char *part)
{
    size_t size = strlen(part);
    for (const char *at = strstr(text, part); at; at = strstr(at + 1, part)) {
        int begins = at == text || at[-1] == ' ' || at[-1] == '`';
        if (begins && (at[size] == '\0' || strchr(" ,:;`", at[size]))) return 1;
    }
    return 0;
}

PDI_FN int pdi_keys_is_consistent(const char *section, const char *key, const char *unit, const char *fallback)
{
    const pd_key_section *s = pdi_keys_find_section(section);
    const pd_key *k = s ? pdi_keys_find_key(s, key) : NULL;
    if (!k) return !section[0];
    if (unit && unit[0] == '\0') unit = "-"; /* a plain number */
    if (unit && strcmp(k->unit, unit) != 0 && strcmp(k->unit, "any") != 0 && strcmp(k->unit, "m^(d-1)") != 0) return 0;
    if (!fallback || strncmp(k->default_text, "the ", 4) == 0 || strncmp(k->default_text, "that of ", 8) == 0) return 1;
    return pdi_keys_has_word(k->default_text, fallback);
}
#endif

#undef PDI_KEYS_SECTION_COUNT
