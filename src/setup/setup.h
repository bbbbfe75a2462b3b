/* setup: the parsed input of a simulation as plain data: lattice, geometry, boundary conditions, physics, run control
 * and output. The readers of scene files and of flat parameter files fill it.
 *
 * A setup holds no field and no solver; model.h builds those. Physics whose has_... is 0 is not built.
 */
#ifndef PD_SETUP_H
#define PD_SETUP_H
#include "metal/material.h"
#include "metal/grain.h"
#include "metal/dissolve.h"
#include "metal/metal.h"
#include "flow/gas.h"
#include "couple/solid_coupling.h"
#include "couple/physics_type.h"
#include "chemistry/electrolyte.h"
#include "potential/electrode.h"
#include "react/coat.h"
#include "setup/expr.h"
#include "setup/units.h"

#define PD_SETUP_NAME 64 /* [byte] of a name with its end */
#define PD_SETUP_PROBES 16 /* most [probe] sections */
#define PD_SETUP_MONITORS 32 /* most monitors */
#define PD_SETUP_NOTES 48 /* most notes */
#define PD_SETUP_MASKS 8 /* most masks */
#define PD_SETUP_SURFACES 8 /* most surfaces of triangles */
#define PD_SETUP_WALLS 32 /* most shapes that are walls */
#define PD_SETUP_CONTOURS 32 /* most lines of one value in a picture */
#define PD_SETUP_METALS 4 /* one of each material */
#define PD_SETUP_MEASURED_MAX 8 /* most [measured] sections */
#define PD_SETUP_SHAPES 64 /* [shape] sections */
#define PD_SETUP_MECHANICAL_BCS 16 /* most sides and shapes that hold or load a body */
#define PD_SETUP_PRECRACKS 16      /* most [crack] sections */
#define PD_SETUP_CORNERS 32 /* most corners of a cut */
#define PD_SETUP_ELECTRODES 16 /* [electrode] sections */
#define PD_SETUP_SURFACE_STATES PD_COAT_MOST /* [surface] sections */

/* Fields of a run that can be written to files, drawn as images and probed. */
typedef enum pd_field {
    PD_FIELD_C = 0,
    PD_FIELD_V,
    PD_FIELD_P,
    PD_FIELD_KIND,
    PD_FIELD_GRAIN,
    PD_FIELD_PHASE,
    PD_FIELD_D,
    PD_FIELD_RATE,
    PD_FIELD_DENSITY,
    PD_FIELD_DAMAGE,
    PD_FIELD_ENERGY,
    PD_FIELD_U,
    PD_FIELD_MISES,
    PD_FIELD_MEAN_STRESS,
    PD_FIELD_PLASTIC_STRAIN,
    PD_FIELD_BROKEN,
    PD_FIELD_STRAIN_ENERGY,
    PD_FIELD_SIGMA_XX, /* stresses */
    PD_FIELD_SIGMA_YY,
    PD_FIELD_SIGMA_ZZ,
    PD_FIELD_SIGMA_XY,
    PD_FIELD_SIGMA_YZ,
    PD_FIELD_SIGMA_ZX,
    PD_FIELD_PHI,                 /* electric potential of the fluid, module potential */
    PD_FIELD_CURRENT_FLUID,       /* current density in the fluid */
    PD_FIELD_CURRENT_METAL,       /* current density at the metal surface */
    PD_FIELD_PH,                  /* pH of the electrolyte */
    PD_FIELD_DIFFUSION_POTENTIAL, /* diffusion potential of migrating ions, from electroneutrality */
    PD_FIELD_MINERAL_FRACTION,    /* volume fraction of a cell that minerals fill */
    PD_FIELD_SATURATION_INDEX,    /* largest saturation index of the minerals */
    PD_FIELD_SPECIES, /* concentration of the first species; then the other species in order, then surface states */
    PD_FIELD_COUNT = PD_FIELD_SPECIES + PD_SPECIES_MAX
} pd_field;

typedef uint64_t pd_fields; /* set of fields: bit k stands for pd_field k */

/* Components of a model, in the order of the printed summary. */
typedef enum pd_part {
    PD_PART_GRID = 0, /* stencil, lattice, bonds */
    PD_PART_FLOW,     /* fields and steady solver */
    PD_PART_GAS,
    PD_PART_TRANSPORT,
    PD_PART_DISSOLVE,
    PD_PART_GRAIN,
    PD_PART_SOLID,
    PD_PART_CHEMISTRY,
    PD_PART_POTENTIAL,
    PD_PART_COUNT
} pd_part;

/* Velocity profile of an inlet. */
typedef enum pd_profile {
    PD_PROFILE_NONE = 0, /* no inflow */
    PD_PROFILE_UNIFORM,
    PD_PROFILE_PARABOLA, /* fully developed laminar flow of the opening */
    PD_PROFILE_EXPRESSION
} pd_profile;

/* Boundary conditions of one side of the box. */
typedef struct pd_setup_side {
    pd_side kind;
    pd_profile profile;
    double mean_speed;        /* [m/s] mean inflow speed; unused with flow_rate or with an unscaled expression */
    int is_scaled;            /* 1: the profile expression is scaled to mean or flow_rate */
    double flow_rate;         /* [m3/s] volume flow rate. 0: mean is used instead. With inflow_of_time any
                               * positive value. Planar 2D: of a tube as wide as the open part of the side */
    pd_expr inflow_of_time;   /* mean [m/s] or flow_rate [m3/s] as a function of t, when it changes in time */
    pd_expr velocity[PD_DIM]; /* [m/s] of x, y, z, t: inlet velocity of profile = expression */
    int is_open;              /* 1: inlet where the prescribed flow enters, outlet where it leaves */
    pd_expr inlet_c;          /* [mol/m3] of x, y, z, t: concentration of the inflow */
    pd_expr wall_velocity[PD_DIM]; /* [m/s] of x, y, z, t: tangential velocity of a moving wall */
    int has_wall_velocity;         /* 1: the wall moves tangentially */
    int has_fixed_c;               /* 1: wall with a Dirichlet condition for the concentration */
    int has_fixed_species;         /* 1: wall with a Dirichlet condition for all species, at their inlet values */
    pd_expr fixed_c;               /* [mol/m3] of x, y, z, t: the Dirichlet concentration of the wall */
    int line;                 /* line of the section in the file, 0: none */
} pd_setup_side;

/* A shape that is a solid wall, with its boundary condition. */
typedef struct pd_setup_wall {
    int shape;   /* index of the shape in pd_setup.shape */
    int section; /* index of its section in the text */
    int has_fixed_c; /* 1: Dirichlet condition for the concentration */
    pd_expr fixed_c; /* [mol/m3] of x, y, z, t: the Dirichlet concentration */
} pd_setup_wall;

/* Time treatment of the flow. */
typedef enum pd_flow_time {
    PD_FLOW_STEADY = 0,
    PD_FLOW_IMPLICIT,  /* incompressible, implicit.h */
    PD_FLOW_EXPLICIT,  /* weakly compressible, weakly_compressible.h */
    PD_FLOW_PRESCRIBED /* prescribed once and for all */
} pd_flow_time;

typedef struct pd_setup_probe {
    char name[PD_SETUP_NAME];
    double position[PD_DIM]; /* [m] */
    pd_fields fields;
    int line;          /* of the file */
} pd_setup_probe;

/* A tabulated function that the expressions of the scene can call by name. */
typedef struct pd_setup_table {
    char name[PD_SETUP_NAME];
    pd_monotone_cubic curve; /* monotone interpolant in SI units */
} pd_setup_table;

/* Quantities that a run records over time, besides the probes. */
typedef enum pd_monitor_kind {
    PD_MONITOR_LINE = 0,      /* fields along a straight line, at output times */
    PD_MONITOR_PLANE,         /* flow rate and solute flux through a plane of the lattice */
    PD_MONITOR_FORCE,         /* force of the flow on the bodies in a box */
    PD_MONITOR_TRANSFER,      /* mass transfer from walls and solids in a box to the fluid, Sherwood number */
    PD_MONITOR_TOTAL,         /* amounts inside a box */
    PD_MONITOR_MECHANICAL_BC, /* reaction force of a mechanical boundary condition */
    PD_MONITOR_SOLID,         /* energies and extreme values of the loaded body */
    PD_MONITOR_PRECRACK,      /* crack tip and J-integral of a pre-crack */
    PD_MONITOR_ELECTRODE,     /* potential and current of an electrode */
    PD_MONITOR_SURFACE_STATE  /* mean and extreme values of a surface state */
} pd_monitor_kind;

/* Reference concentration of the fluid in a Sherwood number. */
typedef enum pd_reference_fluid {
    PD_REFERENCE_FLUID_VALUE = 0,
    PD_REFERENCE_FLUID_INLET,
    PD_REFERENCE_FLUID_BULK /* flow-averaged (mixing-cup) concentration of each layer across `axis` */
} pd_reference_fluid;

/* One recorded quantity: a [line], [plane], [force], [transfer] or [total] section, or one that other sections add. */
typedef struct pd_setup_monitor {
    pd_monitor_kind kind;
    char name[PD_SETUP_NAME];
    int line;                      /* of the file */
    double lo[PD_DIM], hi[PD_DIM]; /* [m] corners of the box; line: its end points */
    pd_fields fields, images;      /* line */
    int points;                    /* line: number of sampling points */
    int axis;                      /* plane: its normal; transfer: axis of the local values, -1: none */
    int index;                     /* plane: it lies between the cells index - 1 and index; grip, cut, electrode,
                                  * state: index in its array */
    int momentum_balance;          /* force: 1: also from the momentum balance around the box */
    int shape;                     /* force: 1 + index of the only shape that counts, 0: all bodies in the box */
    double speed;                  /* [m/s] force: reference speed of the coefficients, 0: no coefficients */
    double area;                   /* [m^(d-1)] force: reference area; transfer: surface area, 0: measured */
    double length;                 /* [m] transfer: reference length, 0: no Sherwood number */
    double diffusivity;            /* [m2/s] transfer: of the Sherwood number */
    double surface_c, fluid_c;     /* [mol/m3] transfer: concentrations at the surface and of the reference fluid */
    pd_reference_fluid reference;
} pd_setup_monitor;

/* Experimental data points of a scalar output, read from a [measured] section, that the run is compared with. */
typedef struct pd_setup_measured {
    char name[PD_SETUP_NAME];
    char output_name[2 * PD_SETUP_NAME]; /* "volume_loss", "plane.up.flow" */
    int line;                       /* of the file */
    int points;
    double *time;                   /* [points] [s] of the run, rising */
    double *value;                  /* [points] [unit of the column in SI] */
    double *spread;                 /* [points] [unit of the column in SI]; NULL: not known */
    char unit[PD_UNITS_TEXT];       /* of the column */
    double scale;                   /* [-] size of that unit in SI */
    pd_dims dims;
} pd_setup_measured;

/* Solver settings that the preset `accuracy` of a scene may choose when the scene does not give them. */
typedef enum pd_solver_setting {
    PD_SOLVER_SETTING_STEADY = 0,
    PD_SOLVER_SETTING_FLOW_RTOL,
    PD_SOLVER_SETTING_RTOL,
    PD_SOLVER_SETTING_FRACTION
} pd_solver_setting;

/* A metal of the scene: material, dissolution rate law, electrode potential and surface reaction. */
typedef struct pd_setup_metal {
    pd_material material;
    double solid_c;    /* [mol/m3] Cs: molar concentration of the intact metal */
    int shape;         /* index of its shape; -1: all solid that belongs to no later metal */
    pd_expr rate;      /* rate law in C, t, x, y, z, grain, i, E, pH, species, surface states; [m/s], [1/s] or [A/m2] */
    int species_count; /* number of species variables of the rate law, which follow pH */
    int species_index[PD_EXPR_VARS]; /* their indices in the electrolyte; behind them follow all surface states */
    double rate_scale; /* factor from rate to recession speed: [-] of a speed, [m] of layers, [m3/(A s)] of a current */
    int has_potential; /* 1: with migrating ions it has an electrode potential, of an electrode or `potential` */
    pd_expr potential; /* [V] of t: prescribed potential against inlets and walls that hold the species */
    /* [-] moles of each species released per mole of metal; negative: consumed */
    double species_released[PD_SPECIES_MAX];
    double gas_released; /* [-] moles of gas released per mole of metal */
} pd_setup_metal;

/* A mechanical boundary condition: prescribed displacement, traction or pressure on a side of the box or in a shape. */
typedef struct pd_setup_mechanical_bc {
    int side;               /* -1: the shape */
    int shape;              /* index of the shape, -1: a side */
    int section;            /* index of its section in the text */
    int has_displacement[PD_DIM]; /* 1: the displacement along this axis is prescribed */
    pd_expr displacement[PD_DIM]; /* [m] of x, y, z, t: prescribed displacement */
    int has_traction;             /* 1: a side with a traction */
    pd_expr traction[PD_DIM];     /* [Pa] of x, y, z, t: traction */
    int has_pressure;             /* 1: a side under pressure */
    pd_expr pressure;             /* [Pa] of x, y, z, t: pressure */
} pd_setup_mechanical_bc;

/* A pre-crack of the metal: a point (1D), a polyline (2D) or a plane convex polygon (3D) that cuts bonds. */
typedef struct pd_setup_precrack {
    char name[PD_SETUP_NAME];
    int corners;
    double corner[PD_SETUP_CORNERS * PD_DIM]; /* [m] */
    int is_recorded;                          /* 1: the crack tip is recorded in a table */
    double direction[PD_DIM];                 /* [-] direction of growth, of any length */
    int j_domains;                            /* number of domains of the J-integral: 2 or 0 */
    double radius[3];                         /* [m] radii about the tip that bound those domains */
    int line;                                 /* line of the section in the file */
} pd_setup_precrack;

/* Solid mechanics of the metal: elastic constants, failure criterion, loads and supports. */
typedef struct pd_setup_mechanics {
    double young, poisson;   /* [Pa], [-] */
    pd_plane plane;
    pd_influence influence;
    double m;                /* [-] horizon of the mechanical bonds over the spacing h */
    double yield, hardening; /* [Pa] yield stress and hardening modulus; yield 0: no plastic flow */
    pd_solid_coupling_material material;
    double stretch;          /* [-] critical bond stretch, 0: unused */
    double strength;         /* [Pa] critical largest principal stress, 0: unused */
    double toughness;        /* [J/m2] critical energy release rate, 0: unused */
    double density;          /* [kg/m3] of dynamics; 0: quasi-static equilibrium */
    int is_time_dependent;   /* 1: loads depend on time */
    double rtol;             /* [-] relative tolerance of equilibrium */
    pd_expr force[PD_DIM];   /* [N/m3] of x, y, z, t: body force */
    int has_body_force;      /* 1: there is a body force */
    pd_setup_mechanical_bc mechanical_bc[PD_SETUP_MECHANICAL_BCS];
    int mechanical_bcs;
    pd_setup_precrack precrack[PD_SETUP_PRECRACKS];
    int precracks;
    int has_rate_factor; /* 1: stress changes the dissolution rate */
    pd_expr rate_factor; /* [-] factor of the dissolution rate, of sigma_h, mises, eps_p, x, y, z, t */
} pd_setup_mechanics;

/* Options of images: colour ranges and maps, contours, streamlines, arrows, surface view. All zero: defaults. */
typedef struct pd_setup_image_options {
    double range[PD_FIELD_COUNT][2]; /* [unit of the field] colour range; equal ends: range of all frames */
    int map[PD_FIELD_COUNT];         /* 1 + pd_colour_map; 0: default colour map of the field */
    pd_fields log;                   /* fields drawn on a logarithmic scale */
    double percentile;               /* [-] central fraction of the values of a frame in its colour range; 0: all */
    int width;                       /* [pixel] image width of the field; 0: default of pd_field_plot */
    int smooth;                      /* 1: linear interpolation between cell centres */
    int animate;                     /* 1: an animation of each field */
    unsigned formats;                /* bit 0: PNG, bit 1: SVG; 0: PNG */
    int contours[PD_FIELD_COUNT];    /* number of contour lines */
    /* 1: contour values are in contour_value; 0: evenly spaced over the colour range */
    int has_contour_values[PD_FIELD_COUNT];
    double contour_value[PD_FIELD_COUNT][PD_SETUP_CONTOURS]; /* [unit of the field] contour values */
    int streamlines[PD_FIELD_COUNT]; /* density of streamlines drawn over the field, as of pd_field_plot; 0: none */
    int vectors[PD_FIELD_COUNT];     /* density of velocity arrows drawn over the field; 0: none */
    int surface;                     /* 3D: 1: view of the metal surface; 2 + pd_field: coloured by that field */
    double view_direction[3];        /* [-] direction from the surface to the viewer */
} pd_setup_image_options;

/* A state variable of metal surfaces (film coverage, thickness) with its rate law, from a [surface NAME] section. */
typedef struct pd_setup_surface_state {
    char name[PD_SETUP_NAME];
    int line;               /* line of the section in the file */
    char unit[PD_UNITS_TEXT]; /* SI unit; "": dimensionless */
    char label[PD_SETUP_NAME + PD_UNITS_TEXT + 4]; /* name and unit: "theta", "l [m]" */
    uint32_t electrodes;    /* bit k: electrode k carries it; without electrodes all dissolving metal does */
    pd_expr initial;        /* of x, y, z: initial value */
    double low, high;       /* [unit of the state] bounds; infinite: none */
    pd_expr rate;           /* time derivative, of C, t, x, y, z, grain (unused), i, E, pH, species, surface states */
    int species_count;      /* number of species variables of the rate, which follow pH */
    int species_index[PD_EXPR_VARS]; /* their indices in the electrolyte */
} pd_setup_surface_state;

/* An electrode: metal with a polarisation curve, its electrical control and half-reaction. */
typedef struct pd_setup_electrode {
    char name[PD_SETUP_NAME];
    int line;                 /* line of the section in the file */
    int shape;                /* index of its shape; -1: all metal of a material */
    int metal;                /* index of its metal */
    int primary;              /* 1: primary current distribution: no kinetics, potential term.equilibrium */
    pd_electrode_term term;   /* polarisation curve otherwise; its table is the one below */
    int points;               /* of the table of the polarisation curve */
    double *potential, *current; /* [points] [V] [A/m2] table of the polarisation curve */
    double table_range[2];    /* [V] range of measured tables inside the curve, constant beyond; infinite: no table */
    double film_resistance;   /* [m2/S] area-specific film resistance */
    int has_current_factor;   /* 1: the current density is multiplied by current_factor */
    pd_expr current_factor;   /* [-] of x, y, z, t and all surface states */
    /* 1: potential control, 1: current control, with the value in fixed_value */
    int has_fixed_potential, has_fixed_current;
    /* [V] or [A] (per m in planar 2D, per m2 in 1D) of t: prescribed potential or current */
    pd_expr fixed_value;
    int circuit; /* connected electrodes share one number: the index of the first of them */
    /* 1: with migrating ions, no polarisation curve beside the rate law of its metal */
    int has_no_curve;
    int has_species_curve;           /* 1: with migrating ions, the polarisation curve is species_curve */
    pd_expr species_curve;           /* [A/m2] of E, pH and species: polarisation curve */
    int species_count;               /* number of species variables of species_curve, which follow pH */
    int species_index[PD_EXPR_VARS]; /* their indices in the electrolyte */
    int has_reaction;                /* 1: its half-reaction releases or consumes species */
    /* [-] moles of each species per mole of electrons that pass from fluid to metal */
    double species_released[PD_SPECIES_MAX];
} pd_setup_electrode;

/* Electric potential of the fluid: conductivity, boundary values, electrodes. */
typedef struct pd_setup_potential {
    double conductivity;      /* [S/m] of the fluid; 0: computed from the species */
    double tolerance;         /* [-] relative tolerance of the current balance */
    int has_fixed_potential[2 * PD_DIM]; /* 1: Dirichlet condition for the potential at a side */
    double fixed_potential[2 * PD_DIM];  /* [V] its value */
    pd_setup_electrode electrode[PD_SETUP_ELECTRODES];
    int electrodes;
    int has_reaction; /* 1: some electrode has a half-reaction */
} pd_setup_potential;

/* A shape of kind = solid and its metal. */
typedef struct pd_setup_solid_shape {
    char name[PD_SETUP_NAME];
    int shape, metal;         /* indices */
} pd_setup_solid_shape;

/* A physics of the program in a scene that has its section. */
typedef struct pd_setup_registered {
    const pd_physics_type *type;
    pd_expr value[PD_PHYSICS_TYPE_KEYS]; /* [SI unit of the key] of x, y, z, t */
    uint32_t given;                      /* bit k: key k has a value, given or by default */
    pd_expr prescribed[2 * PD_DIM];      /* [SI unit of the field] of x, y, z, t: the first field at sides */
    uint32_t prescribed_sides;           /* bit s: side s prescribes it */
    char label[PD_PHYSICS_TYPE_FIELDS][PD_SETUP_NAME + PD_UNITS_TEXT + 4]; /* names of the fields with units: "T [K]" */
    int line;                                                              /* of the section in the file */
} pd_setup_registered;

typedef struct pd_setup {
    char name[PD_SETUP_NAME];  /* case name: the file name without folder and ending */
    char folder[PD_PATH_SIZE]; /* output folder */
    char source[PD_PATH_SIZE]; /* path of the scene file as given, for messages */
    int line[PD_PART_COUNT];   /* line of the section of each component in the file, 0: none */
    int shape_line;            /* line of the first solid shape, else of the first shape; 0: none */
    char *fingerprint;          /* normalised input that identifies the scene, one item a line; NULL: no file */
    size_t fingerprint_size;   /* [byte] */
    int threads;               /* number of threads, 0: all */
    unsigned settings_given;   /* bit k: the scene sets solver setting pd_solver_setting k */
    /* lattice and geometry */
    double fluid_m;                    /* [-] horizon of the fluid operators over the spacing */
    double metal_m;                    /* [-] horizon of the bonds between metal and fluid over the spacing */
    double h[PD_DIM];                  /* [m] grid spacing along each axis */
    double lo[PD_DIM], hi[PD_DIM];     /* [m] corners of the box */
    int axisymmetric;                  /* 1: 2D, x is the axis, y the radius */
    pd_shape *shape;                   /* [PD_SHAPE_MAX] geometry tree, children before their parents */
    int shapes;                        /* entries in use */
    int section_shape[PD_SETUP_SHAPES]; /* for [shape] section k: index of its shape if solid or wall, else -1 */
    pd_setup_solid_shape solid_shape[PD_SETUP_SHAPES];
    int solid_shapes;                  /* number of shapes joined in `solid`, in the order of the file */
    int solid, wall, medium, passive;  /* index of the union of all shapes of that kind, -1: none */
    int solution;                      /* the same for fluid that starts with the composition `inside` */
    pd_setup_wall wall_shape[PD_SETUP_WALLS]; /* the shapes joined in `wall` */
    int wall_count;
    uint8_t *mask[PD_SETUP_MASKS];     /* voxel masks that shapes point to; owned */
    size_t mask_size[PD_SETUP_MASKS];
    int masks;
    pd_facets *facets[PD_SETUP_SURFACES]; /* triangle surfaces that shapes point to; owned */
    int facets_count;
    pd_setup_side side[2 * PD_DIM];    /* boundary conditions of the sides x-, x+, y-, ... */
    int has_flow, has_gas, has_transport, has_grains;
    int has_dissolve;                  /* 1: metal dissolves */
    int has_corrode;                   /* 1: it dissolves by bond-based corrosion */
    int has_solid;                     /* 1: the metal is a loaded body */
    /* flow */
    double rho;             /* [kg/m3] */
    double mu;              /* [Pa s] */
    double force[PD_DIM];   /* [m/s2] constant body force per mass */
    pd_expr body_force[PD_DIM]; /* [m/s2] of x, y, z, t: body force per mass that is not constant */
    int has_body_force_expr;    /* 1: body_force is used in place of `force` */
    double p_out;           /* [Pa] outlet pressure */
    double speed;           /* [m/s] reference speed; 0: mean speed of the inlet */
    double length;          /* [m] reference length; 0: width of the inlet */
    double steady_tolerance; /* [-] tolerance of the steady residual */
    pd_flow_time flow_time;
    int flow_order;         /* order of the flow discretisation, 2 or 4; 0: 4 in steady flow where it pays */
    pd_expr initial_velocity[PD_DIM]; /* [m/s] of x, y, z: prescribed velocity, or initial velocity of flow or gas */
    double flow_rtol;       /* [-] error tolerance of an implicit step */
    int linear_eos;         /* explicit: 1: equation of state p = c0^2 (rho - rho0), 0: Tait */
    double sound_speed;     /* [m/s] explicit: artificial speed of sound c0 */
    /* gas */
    double gas_gamma;       /* [-] ratio of specific heats */
    pd_expr gas_rho, gas_p; /* [kg/m3] [Pa] of x, y, z: initial state, and inlet state */
    pd_gas_order gas_order;
    double gas_cfl;         /* [-] CFL number */
    /* transport */
    double diffusivity;     /* [m2/s] */
    double medium_diffusivity; /* [m2/s] of fluid inside the medium */
    double inlet_c;            /* [mol/m3] concentration of all inlets when has_inlet_c_by_side is 0 */
    int has_inlet_c_by_side;   /* 1: each side has its own inlet concentration, side[].inlet_c */
    pd_expr initial_c;         /* [mol/m3] of x, y, z: initial concentration */
    pd_advection advection;
    double limiter_tolerance; /* [-] tolerance of the flux limiter iteration; 0: default of transport.h */
    int has_migration;        /* 1: ions migrate in the diffusion potential of electroneutrality */
    int steady_transport;     /* 1: only the steady concentration is solved for */
    /* dissolution */
    pd_setup_metal metal[PD_SETUP_METALS];
    int metals;             /* at least 1 */
    double saturation;      /* [mol/m3] Csat; 0: not given */
    double gb_factor;       /* [-] factor of the dissolution rate in grain boundaries */
    double threshold;       /* [-] remaining fraction of the metal at which a node becomes fluid */
    pd_grain_desc grain;
    /* bond-based corrosion, with D and `initial` of transport, Cs, Csat and rate of dissolution */
    double bulk_c;          /* [mol/m3] concentration behind open sides, and everywhere with `activation` */
    int activation;         /* 1: activation control */
    double repassivation;   /* [mol/m3] concentration below which a passive film forms; 0: none forms */
    int stochastic;         /* 1: mechanical bonds break at random */
    int seed;               /* of the random breaking */
    pd_drive drive;
    pd_kernel kernel;
    pd_weights weights;
    pd_setup_mechanics metal_body;
    /* species and reactions */
    int has_chemistry;
    pd_electrolyte electrolyte;      /* its solids are the minerals: */
    pd_mineral mineral[PD_MINERAL_MAX];
    int minerals;
    double tortuosity;               /* [-] tortuosity of the pores of minerals */
    /* [m] mineral thickness that leaves 1/e of the metal bare; 0: none shields it */
    double shielding_thickness;
    char species_label[PD_SPECIES_MAX][PD_SPECIES_NAME + 12]; /* "Mg2+ [mol/m3]" */
    /* 1: dissolved metal enters the species by a reaction at its surface */
    int has_surface_reaction;
    char gas[PD_SPECIES_NAME];       /* gas that this reaction evolves; "": none */
    /* electric potential */
    int has_potential;
    pd_setup_potential potential;
    /* physics of the program */
    pd_setup_registered registered[PD_CTX_PHYSICS];
    int registered_count;
    /* states of surfaces */
    pd_setup_surface_state state[PD_SETUP_SURFACE_STATES];
    int states;
    /* functions of the expressions */
    pd_setup_table *table;   /* [tables] tabulated functions */
    pd_expr_table *function; /* [tables] the same as declarations for expressions */
    int tables;
    /* run */
    double end_time;        /* [s] end time */
    double rtol;            /* [-] tolerance of the volume loss; without dissolution of a transport step; 0: 1e-3 */
    double max_node_fraction; /* [-] largest fraction of a node that dissolves in one step */
    double max_step;        /* [s] largest time step, 0: no limit */
    /* output */
    double output_interval;   /* [s] interval of output */
    pd_fields fields, images; /* fields written to files, fields drawn as images */
    char prefix[PD_SETUP_NAME];
    int slice_axis;         /* 3D: normal of the drawn plane */
    double slice_at;        /* [m] its coordinate */
    pd_setup_image_options drawing;
    /* [byte] memory of the largest picture, for estimates; NULL: nothing is drawn */
    double (*picture_bytes)(const struct pd_setup *setup);
    double displacement_scale; /* [-] magnification of displacements in images of the metal; 0: undeformed */
    pd_setup_probe probe[PD_SETUP_PROBES];
    int probes;
    pd_setup_monitor monitor[PD_SETUP_MONITORS];
    int monitors;
    pd_setup_measured measured[PD_SETUP_MEASURED_MAX];
    int measured_count;
    /* notes of the readers for the printed summary, a line each */
    char note[PD_SETUP_NOTES][200];
    int notes;
} pd_setup;

#define pd_setup_free PD_NAME(pd_setup_free)
#define pd_setup_set_function PD_NAME(pd_setup_set_function)
#define pd_setup_set_breaks PD_NAME(pd_setup_set_breaks)
#define pd_setup_add_complement PD_NAME(pd_setup_add_complement)
#define pd_setup_add_facets PD_NAME(pd_setup_add_facets)
#define pd_setup_add_mask PD_NAME(pd_setup_add_mask)
#define pd_setup_add_note PD_NAME(pd_setup_add_note)
#define pd_setup_add_shape PD_NAME(pd_setup_add_shape)
#define pd_setup_add_union PD_NAME(pd_setup_add_union)
#define pd_setup_compute_rate_at_zero PD_NAME(pd_setup_compute_rate_at_zero)
#define pd_setup_count_cells PD_NAME(pd_setup_count_cells)
#define pd_setup_count_ghost_layers PD_NAME(pd_setup_count_ghost_layers)
#define pd_setup_format_value PD_NAME(pd_setup_format_value)
#define pd_setup_free_measured PD_NAME(pd_setup_free_measured)
#define pd_setup_get_position_symbols PD_NAME(pd_setup_get_position_symbols)
#define pd_setup_get_rate_symbols PD_NAME(pd_setup_get_rate_symbols)
#define pd_setup_get_reactive_desc PD_NAME(pd_setup_get_reactive_desc)
#define pd_setup_get_stress_symbols PD_NAME(pd_setup_get_stress_symbols)
#define pd_setup_init PD_NAME(pd_setup_init)
#define pd_setup_monitor_section_name PD_NAME(pd_setup_monitor_section_name)
#define pd_setup_side_name PD_NAME(pd_setup_side_name)
/* Zero a setup and set its defaults: no physics, walls on all sides, no shapes (-1), one metal (mg4ag) with rate_scale
 * 1, folder "output". Allocates the array of shapes; on failure the setup is zero. */
PD_API pd_status pd_setup_init(pd_ctx *ctx, pd_setup *setup);

/* Free all memory that the setup owns and set it to zero. A zeroed one is allowed. */
PD_API void pd_setup_free(pd_ctx *ctx, pd_setup *setup);
/* Put a function in the place of a value that the scene gives. `uses`: bit k: it depends on variable k.
 *
 *   key      value                                      variables
 *   rate     recession speed of the one metal [m/s]     C [mol/m3], t [s], x, y, z [m], grain: its number, a whole one
 *   rate.steel304  the same of one of several metals, by its material
 *   initial  concentration of the fluid [mol/m3]        x, y, z [m]
 *   x-.C     the same of what enters, or of a wall      x, y, z [m], t [s]
 *   x-.mean  speed into the box of an inlet [m/s]       the same, of which t alone counts
 *   x-.vx    velocity at an inlet [m/s] with profile = expression, all components of which the scene gives; the same
 *
 * and so on for x+, y-, ... A coordinate for each axis. For `rate` rate_scale becomes 1, for `mean` flow_rate 0; C of
 * an inlet gives each side its own (has_inlet_c_by_side). Breaks of an earlier function go. A checkpoint does not
 * know functions. PD_ERR_ARGUMENT, nothing changed: no such key, or the scene does not give that value. */
PD_API pd_status pd_setup_set_function(pd_ctx *ctx, pd_setup *setup, const char *key, pd_expr_fn fn, void *user,
                                       uint32_t uses);
/* When such a function jumps, or a pulse of it begins or ends: t [count] [s] ascending; copied, in place of earlier
 * ones; count 0: none. Steps do not pass over what it does then. Between breaks it counts as being between its values
 * at both ends and in the middle of any time. PD_ERR_ARGUMENT, earlier breaks stay: no such key, no function stands
 * there, count < 0, or times that do not ascend strictly or are not finite. */
PD_API pd_status pd_setup_set_breaks(pd_ctx *ctx, pd_setup *setup, const char *key, const double *t, int count);

#define PD_SETUP_POSITION_VARS (PD_DIM + 1)

#define PD_SETUP_RATE_GRAIN (PD_DIM + 2)     /* index of the variable grain of a rate law */
#define PD_SETUP_RATE_CURRENT (PD_DIM + 3)   /* index of i, current density of the electrode */
#define PD_SETUP_RATE_POTENTIAL (PD_DIM + 4) /* index of E, potential of the electrode */
#define PD_SETUP_RATE_FIELD (PD_DIM + 5)     /* index of the first field of the physics of the program */
#define PD_SETUP_RATE_VARS (PD_SETUP_RATE_FIELD + PD_PHYSICS_TYPE_FIELDS) /* number of these variables */

/* Index of the variable pH of a rate law; behind it follow the species that the law names, then surface states. */
#define PD_SETUP_RATE_PH PD_SETUP_RATE_VARS

#define PD_SETUP_STRESS_VARS (PD_DIM + 4)
/* Zero and fill the description of the reactive species solver from the setup: species, reactions, minerals, activity
 * model, temperature, tortuosity, migration, time order (1 for steady transport, else 2). Arrays are borrowed.
 * Concentrations and arena are left to the caller. */
PD_API void pd_setup_get_reactive_desc(const pd_setup *setup, pd_reactive_desc *desc);
/* Name of the scene section of a kind of monitor: "line", "plane", ... */
PD_API const char *pd_setup_monitor_section_name(pd_monitor_kind kind);
/* Name of a side of the box, number 2 axis + (1: upper): "x-", "x+", "y-", ... */
PD_API const char *pd_setup_side_name(int side);
/* Number of ghost layers of the lattice: largest whole n < m + 1/2 of the horizons in use, m in spacings: fluid_m, and
 * metal_m where surface areas are needed. */
PD_API int pd_setup_count_ghost_layers(const pd_setup *setup);
/* Number of cells of the box along an axis: its length over h, rounded to the nearest whole number. */
PD_API int pd_setup_count_cells(const pd_setup *setup, int axis);
/* Symbol table of expressions in space and time: x, y, z (PD_DIM of them), then t; PD_SETUP_POSITION_VARS entries. */
PD_API const pd_expr_symbol *pd_setup_get_position_symbols(void);
/* Symbol table of dissolution rate laws: C, t, x, y, z, grain as in pd_rate_at, then current density i and potential E
 * of electrodes, and nameless places for fields; PD_SETUP_RATE_VARS entries. */
PD_API const pd_expr_symbol *pd_setup_get_rate_symbols(void);
/* 1: the rate law of the metal depends on pH, species or surface states, or on E where the metal has an electrode
 * potential with migrating ions. */
static inline int pd_setup_has_species_rate(const pd_setup_metal *metal)
{
    return metal->rate.variables_used >> PD_SETUP_RATE_PH != 0 ||
           (metal->has_potential && (metal->rate.variables_used >> PD_SETUP_RATE_POTENTIAL & 1u) != 0);
}
/* Index of the first metal whose rate law depends on species or, with migrating ions, on E; -1: none does, or nothing
 * dissolves. */
static inline int pd_setup_find_species_rate_metal(const pd_setup *setup)
{
    for (int k = 0; k < setup->metals && setup->has_dissolve; k++)
        if (pd_setup_has_species_rate(&setup->metal[k])) return k;
    return -1;
}
/* Number of metals that the species solver distinguishes: all of them when two or more have such a rate law, else 1,
 * also without dissolution. */
static inline int pd_setup_count_species_rate_metals(const pd_setup *setup)
{
    int count = 0;
    for (int k = 0; k < setup->metals && setup->has_dissolve; k++)
        count += pd_setup_has_species_rate(&setup->metal[k]);
    return count > 1 ? setup->metals : 1;
}
/* 1: electrodes in an electrolyte whose ions migrate. */
static inline int pd_setup_has_ion_electrodes(const pd_setup *setup)
{
    return setup->has_migration && setup->has_potential;
}
/* 1: the rate law depends on a field of the physics that the program brings along. */
static inline int pd_setup_reads_registered_field(const pd_setup_metal *metal)
{
    return (metal->rate.variables_used >> PD_SETUP_RATE_FIELD & (((uint32_t)1 << PD_PHYSICS_TYPE_FIELDS) - 1u)) != 0;
}
/* Symbol table of the stress factor of the dissolution rate: sigma_h, mises, eps_p, x, y, z, t; PD_SETUP_STRESS_VARS
 * entries. */
PD_API const pd_expr_symbol *pd_setup_get_stress_symbols(void);
/* Recession speed [m/s] of the rate law, rate_scale included, where all its variables are 0: C = 0, t = 0, x = 0. */
PD_API double pd_setup_compute_rate_at_zero(const pd_setup_metal *metal);
/* 1: an expression in x, y, z, t depends on t. */
static inline int pd_setup_is_time_dependent(const pd_expr *expr)
{
    return (int)(expr->variables_used >> PD_DIM & 1u);
}
/* Append a copy of a shape to the geometry tree; *index: its position. PD_ERR_SIZE, nothing changed: it holds
 * PD_SHAPE_MAX shapes. */
PD_API pd_status pd_setup_add_shape(pd_ctx *ctx, pd_setup *setup, const pd_shape *shape, int *index);
/* Append the union of the shapes `index` and *whole and put its index into *whole. *whole < 0: it becomes `index`, and
 * nothing is appended. PD_ERR_SIZE: too many shapes. */
PD_API pd_status pd_setup_add_union(pd_ctx *ctx, pd_setup *setup, int index, int *whole);
/* Append the complement of the shape *index and put its index into *index. PD_ERR_SIZE: too many shapes. */
PD_API pd_status pd_setup_add_complement(pd_ctx *ctx, pd_setup *setup, int *index);
/* Free the experimental data of all [measured] sections, which are then none; measured_count becomes 0. */
PD_API void pd_setup_free_measured(pd_ctx *ctx, pd_setup *setup);
/* Allocate an empty triangle surface, owned by the setup, into *surface. PD_ERR_SIZE: there are PD_SETUP_SURFACES. */
PD_API pd_status pd_setup_add_facets(pd_ctx *ctx, pd_setup *setup, pd_facets **surface);
/* Allocate a voxel mask of `size` zeroed bytes, owned by the setup, into *mask. PD_ERR_SIZE: there are
 * PD_SETUP_MASKS. */
PD_API pd_status pd_setup_add_mask(pd_ctx *ctx, pd_setup *setup, size_t size, uint8_t **mask);
/* Add a note, printf style, to the printed summary, cut off at its length of 200 bytes. Notes beyond PD_SETUP_NOTES are
 * dropped. */
PD_API void pd_setup_add_note(pd_setup *setup, const char *format, ...) PD_PRINTF_LIKE(2, 3);
/* Print a SI value with a unit of readable size ("80 um") into text[PD_UNITS_TEXT]; `unit` gives the dimension; a text
 * that is no unit counts as plain number. */
PD_API void pd_setup_format_value(double value, const char *unit, char *text);

#ifdef PDI_INTERNAL
/* 1: some physics needs surface areas: dissolution, grain boundaries, electric potential, mass transfer monitors. */
PDI_FN int pdi_setup_has_surface_area(const pd_setup *setup);
/* Options (pd_bonds_options) for building the bonds of the lattice: 0 with flow, PD_BONDS_NO_FLOW with gas, and else
 * PD_BONDS_LOW_MEMORY, too. */
PDI_FN int pdi_setup_get_bond_options(const pd_setup *setup);
/* 1: the rate law depends on i or E of the electric potential solver; 0 for a metal whose E is that of migrating
 * ions. */
static inline int pdi_setup_has_electric_rate(const pd_setup_metal *metal)
{
    return !metal->has_potential && (metal->rate.variables_used >> PD_SETUP_RATE_CURRENT & 3u) != 0;
}
/* Value of an expression in x, y, z, t at the point x[PD_DIM] [m] and time t [s]. */
PDI_FN double pdi_setup_eval_expr(const pd_expr *expr, const double *x, double t);
#endif

#endif
