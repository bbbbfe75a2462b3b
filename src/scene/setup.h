/* setup: everything that a run needs to know, as data: what scene files and flat files are turned into.
 *
 * A setup holds no field and no solver; model.h builds those. What has_... leaves out costs nothing.
 */
#ifndef PD_SETUP_H
#define PD_SETUP_H
#include "metal/material.h"
#include "metal/grain.h"
#include "metal/dissolve.h"
#include "metal/metal.h"
#include "flow/gas.h"
#include "couple/structure.h"
#include "chemistry/electrolyte.h"
#include "potential/electrode.h"
#include "react/coat.h"
#include "io/file.h"
#include "scene/expr.h"
#include "scene/text.h"

#define PD_SETUP_NAME 64 /* [byte] of a name with its end */
#define PD_SETUP_PROBES 16 /* most [probe] sections */
#define PD_SETUP_MONITORS 32 /* most monitors */
#define PD_SETUP_NOTES 48 /* most notes */
#define PD_SETUP_MASKS 8 /* most masks */
#define PD_SETUP_SURFACES 8 /* most surfaces of triangles */
#define PD_SETUP_WALLS 32 /* most shapes that are walls */
#define PD_SETUP_CONTOURS 32 /* most lines of one value in a picture */
#define PD_SETUP_METALS 4 /* one of each material */
#define PD_SETUP_RECORDS 8 /* most [measured] sections */
#define PD_SETUP_SHAPES 64 /* [shape] sections */
#define PD_SETUP_GRIPS 16 /* most sides and shapes that hold or load a body */
#define PD_SETUP_CUTS 16 /* most [cut] sections */
#define PD_SETUP_CORNERS 32 /* most corners of a cut */
#define PD_SETUP_ELECTRODES 16 /* [electrode] sections */
#define PD_SETUP_STATES PD_COAT_MOST /* [surface] sections */

/* What can be written, drawn and probed. */
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
    PD_FIELD_PRESSURE,
    PD_FIELD_SLIP,
    PD_FIELD_BROKEN,
    PD_FIELD_STORED,
    PD_FIELD_XX, /* stresses */
    PD_FIELD_YY,
    PD_FIELD_ZZ,
    PD_FIELD_XY,
    PD_FIELD_YZ,
    PD_FIELD_ZX,
    PD_FIELD_PHI,     /* of the electric potential */
    PD_FIELD_J,
    PD_FIELD_I,
    PD_FIELD_PH,      /* of the electrolyte */
    PD_FIELD_POTENTIAL, /* that its ions migrate in */
    PD_FIELD_FILM,    /* share of a cell that minerals take */
    PD_FIELD_SI,      /* largest saturation index of the minerals */
    PD_FIELD_SPECIES, /* the first of its species; the others behind it, in their order, then states of surfaces */
    PD_FIELD_COUNT = PD_FIELD_SPECIES + PD_SPECIES_MOST
} pd_field;

typedef uint64_t pd_fields; /* bit k: pd_field k */

/* Parts of a model, in the order of the summary. */
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

typedef enum pd_profile {
    PD_PROFILE_REST = 0, /* no velocity */
    PD_PROFILE_UNIFORM,
    PD_PROFILE_PARABOLA, /* the developed flow of the opening */
    PD_PROFILE_EXPRESSION
} pd_profile;

typedef struct pd_setup_side {
    pd_side kind;
    pd_profile profile;
    double mean;              /* [m/s] speed into the box; unread with flow_rate, or an expression that is not scaled */
    int scaled;               /* 1: an expression is scaled to mean or flow_rate */
    double flow_rate;         /* [m3/s] 0: mean holds; any positive one with `stream`. Planar 2D: through a tube as wide
                               * as the open part of the side */
    pd_expr stream;           /* of t; mean or flow_rate, when they change in time */
    pd_expr velocity[PD_DIM]; /* of x, y, z, t; in m/s */
    int open;                 /* inlet where a given flow enters, outlet where it leaves */
    pd_expr entering;         /* of x, y, z, t; in mol/m3: concentration of what enters */
    pd_expr slide[PD_DIM];    /* of x, y, z, t; in m/s: of a wall along itself */
    int slides;
    int holds;                /* a wall that holds a concentration */
    int steeps;               /* a wall that holds the species of what enters */
    pd_expr held;             /* of x, y, z, t; in mol/m3 */
    int line;                 /* of the file, 0: none */
} pd_setup_side;

/* One of the shapes that are walls. */
typedef struct pd_setup_wall {
    int shape;   /* index */
    int section; /* of the text */
    int holds;   /* it holds a concentration */
    pd_expr held; /* of x, y, z, t; in mol/m3 */
} pd_setup_wall;

/* How the flow gets from one instant to the next. */
typedef enum pd_motion {
    PD_MOTION_STEADY = 0,
    PD_MOTION_IMPLICIT, /* incompressible, implicit.h */
    PD_MOTION_EXPLICIT, /* weakly compressible, unsteady.h */
    PD_MOTION_GIVEN     /* prescribed once and for all */
} pd_motion;

typedef struct pd_setup_probe {
    char name[PD_SETUP_NAME];
    double at[PD_DIM]; /* [m] */
    pd_fields fields;
    int line;          /* of the file */
} pd_setup_probe;

/* A function that the expressions of the scene know. */
typedef struct pd_setup_table {
    char name[PD_SETUP_NAME];
    pd_curve curve; /* SI */
} pd_setup_table;

/* What is watched in a run, besides the probes. */
typedef enum pd_monitor_kind {
    PD_MONITOR_LINE = 0, /* fields along a straight line, at output times */
    PD_MONITOR_PLANE,    /* what passes a plane of the lattice */
    PD_MONITOR_FORCE,    /* of the flow on what a box holds */
    PD_MONITOR_TRANSFER, /* metal from walls and solids in a box to the fluid */
    PD_MONITOR_TOTAL,    /* what a box holds */
    PD_MONITOR_GRIP,     /* force of a grip on a body */
    PD_MONITOR_SOLID,    /* energies of a body, and its extremes */
    PD_MONITOR_CUT,      /* the tip of a crack */
    PD_MONITOR_ELECTRODE, /* its potential and current */
    PD_MONITOR_STATE     /* of surfaces: its mean and extremes */
} pd_monitor_kind;

/* The concentration of the fluid that a Sherwood number refers to. */
typedef enum pd_against {
    PD_AGAINST_VALUE = 0,
    PD_AGAINST_INLET,
    PD_AGAINST_BULK /* of the mixed stream, layer by layer of `axis` */
} pd_against;

typedef struct pd_setup_monitor {
    pd_monitor_kind kind;
    char name[PD_SETUP_NAME];
    int line;                      /* of the file */
    double lo[PD_DIM], hi[PD_DIM]; /* [m] the box; line: its ends */
    pd_fields fields, images;      /* line */
    int points;                    /* line */
    int axis;                      /* plane: across it; transfer: of the local values, -1: none */
    int index;                     /* plane: between the cells index - 1 and index; grip, cut, electrode: its
                                  * place */
    int balance;                   /* force: measured around the box, too */
    int shape;                     /* force: 1 + index of the only shape that counts, 0: everything */
    double speed;                  /* [m/s] force: reference, 0: no coefficients */
    double area;                   /* [m^(d-1)] force: reference; transfer: of the surface, 0: measured */
    double length;                 /* [m] transfer: reference, 0: no Sherwood number */
    double diffusivity;            /* [m2/s] transfer */
    double surface, fluid;         /* [mol/m3] transfer: concentrations that drive */
    pd_against against;
} pd_setup_monitor;

/* Measured points of a watched figure. */
typedef struct pd_setup_record {
    char name[PD_SETUP_NAME];
    char figure[2 * PD_SETUP_NAME]; /* "volume_loss", "plane.up.flow" */
    int line;                       /* of the file */
    int points;
    double *time;                   /* [points] [s] of the run, rising */
    double *value;                  /* [points] [unit of the column in SI] */
    double *spread;                 /* [points] [unit of the column in SI]; NULL: not known */
    char unit[PD_UNITS_TEXT];       /* of the column */
    double scale;                   /* [-] size of that unit in SI */
    pd_dims dims;
} pd_setup_record;

/* Numerical settings that a scene may leave open. */
typedef enum pd_knob { PD_KNOB_STEADY = 0, PD_KNOB_FLOW_RTOL, PD_KNOB_RTOL, PD_KNOB_FRACTION } pd_knob;

/* A metal of the scene. */
typedef struct pd_setup_metal {
    pd_material material;
    double solid_c;    /* [mol/m3] Cs */
    int shape;         /* where it is; -1: all solid that is not of a later metal */
    pd_expr rate;      /* of C, t, x, y, z, grain, pH, species; in m/s, in 1/s per layer, or in A/m2 */
    int species;       /* that the rate has behind pH, */
    int of[PD_EXPR_VARS]; /* by their place in the electrolyte; behind them it has all states of surfaces */
    double rate_scale; /* [-] 1 for a speed, [m] thickness of the layer, [m3/(A s)] speed of a current density */
    int polarised;     /* 1: among ions that migrate it has a potential: that of its electrode, or a given one: */
    pd_expr potential; /* of t; in V, against inlets and walls that hold species */
    double shed[PD_SPECIES_MOST]; /* [-] species that come with one of the metal; negative: they go */
    double gas_shed;   /* [-] of the gas */
} pd_setup_metal;

/* What holds or loads a body: a side of the box, or all of it in a shape. */
typedef struct pd_setup_grip {
    int side;               /* -1: the shape */
    int shape;              /* index */
    int section;            /* of the text */
    int moves[PD_DIM];      /* 1: the displacement along this axis is given */
    pd_expr move[PD_DIM];   /* of x, y, z, t; in m */
    int pulls;              /* 1: a side with a traction */
    pd_expr pull[PD_DIM];   /* of x, y, z, t; in Pa */
    int presses;            /* 1: a side under pressure */
    pd_expr press;          /* of x, y, z, t; in Pa */
} pd_setup_grip;

/* A crack that metal has from the start: a place (1D), a line of straight pieces (2D), a plane convex polygon (3D). */
typedef struct pd_setup_cut {
    char name[PD_SETUP_NAME];
    int corners;
    double corner[PD_SETUP_CORNERS * PD_DIM]; /* [m] */
    int watched;                              /* 1: its tip has a table */
    double way[PD_DIM];                       /* [-] in which it grows, of any length */
    int rings;                                /* contours of J: 2 or 0 */
    double radius[3];                         /* [m] about the tip, between which they lie */
    int line;                                 /* of the file */
} pd_setup_cut;

/* Mechanics of the metal. */
typedef struct pd_setup_body {
    double young, poisson;   /* [Pa], [-] */
    pd_plane plane;
    pd_influence influence;
    double m;                /* [-] horizon ratio of its bonds */
    double yield, hardening; /* [Pa] 0: it does not flow */
    pd_structure_material material;
    double stretch;          /* [-] at which bonds break, 0: none does */
    double strength;         /* [Pa] largest principal stress at which they do, 0: none does */
    double toughness;        /* [J/m2] that a crack takes; 0: none breaks */
    double density;          /* [kg/m3] it moves; 0: it is in balance */
    int timed;               /* 1: loads depend on time */
    double rtol;             /* [-] */
    pd_expr force[PD_DIM];   /* of x, y, z, t; in N/m3 */
    int weighs;              /* 1: there is one */
    pd_setup_grip grip[PD_SETUP_GRIPS];
    int grips;
    pd_setup_cut cut[PD_SETUP_CUTS];
    int cuts;
    int paces;               /* 1: the speed of the law is multiplied */
    pd_expr pace;            /* of sigma_h, mises, eps_p, x, y, z, t */
} pd_setup_body;

/* How fields are drawn; zero: as without keys. */
typedef struct pd_setup_drawing {
    double range[PD_FIELD_COUNT][2]; /* [unit of the field] of the colours; equal: that of all frames */
    int map[PD_FIELD_COUNT];         /* 1 + pd_map; 0: that of the field */
    pd_fields log;                   /* by their logarithm */
    double percentile;               /* [-] share of the values of a frame that count for its range; 0: all */
    int width;                       /* [pixel] of the field; 0: as of pd_picture */
    int smooth;                      /* 1: linear between the middles of cells */
    int animate;                     /* 1: a film of each field */
    unsigned formats;                /* bit 0: PNG, bit 1: SVG; 0: PNG */
    int contours[PD_FIELD_COUNT];    /* lines of one value */
    int levels[PD_FIELD_COUNT];      /* 1: their values are given; 0: they part the range of colours evenly */
    double level[PD_FIELD_COUNT][PD_SETUP_CONTOURS]; /* [unit of the field] */
    int streamlines[PD_FIELD_COUNT]; /* of the flow, over the field: as of pd_picture; 0: none */
    int vectors[PD_FIELD_COUNT];     /* the same of arrows */
    int surface;                     /* 3D: 1: the metal's surface is drawn; 2 + pd_field: in the colours of a field */
    double way[3];                   /* [-] in which the eye looking at it stands */
} pd_setup_drawing;

/* What surfaces of metal carry, with a law for its rate. */
typedef struct pd_setup_state {
    char name[PD_SETUP_NAME];
    int line;               /* of the file */
    char unit[PD_UNITS_TEXT]; /* "": a plain number */
    char label[PD_SETUP_NAME + PD_UNITS_TEXT + 4]; /* "theta", "l [m]" */
    uint32_t electrodes;    /* bit k: electrode k carries it; without electrodes all metal that dissolves */
    pd_expr initial;        /* of x, y, z */
    double low, high;       /* [unit of it] bounds; infinite: none */
    pd_expr rate;           /* of C, t, x, y, z, grain (unread), i, E, pH, species, states */
    int species;            /* that the rate has behind pH, */
    int of[PD_EXPR_VARS];   /* by their place in the electrolyte */
} pd_setup_state;

/* Metal with a polarisation curve. */
typedef struct pd_setup_electrode {
    char name[PD_SETUP_NAME];
    int line;                 /* of the file */
    int shape;                /* index; -1: it is all metal of a material */
    int metal;                /* index of that */
    int primary;              /* 1: charges pass freely at term.equilibrium */
    pd_electrode_term term;   /* otherwise; tables are those below */
    int points;
    double *potential, *current; /* [points] [V] [A/m2] */
    double table_range[2];    /* [V] beyond them a table in its curve holds its ends; infinite: none does */
    double film;              /* [m2/S] */
    int shares;               /* 1: its currents are multiplied: */
    pd_expr share;            /* of x, y, z, t and all states of surfaces */
    int holds, gives;         /* 1: its potential, or its current, is given: */
    pd_expr given;            /* of t; in V, or in A (per m in planar 2D, per m2 in 1D) */
    int wire;                 /* electrodes of one number are connected: the first of them */
    int bare;                 /* 1: among ions that migrate, it has no curve beside the law of its metal */
    int reads;                /* 1: among them its curve is this one, in species: */
    pd_expr law;              /* of E, pH and species; in A/m2 */
    int species;              /* that it has behind pH, */
    int of[PD_EXPR_VARS];     /* by their place in the electrolyte */
    int reacts;               /* 1: its current enters the species: */
    double shed[PD_SPECIES_MOST]; /* [-] of each with one electron that leaves the fluid for the metal */
} pd_setup_electrode;

/* The electric potential of the fluid. */
typedef struct pd_setup_potential {
    double conductivity;      /* [S/m]; 0: that of the species */
    double tolerance;         /* [-] */
    int held[2 * PD_DIM];     /* 1: the fluid has a given potential at a side: */
    double hold[2 * PD_DIM];  /* [V] */
    pd_setup_electrode electrode[PD_SETUP_ELECTRODES];
    int electrodes;
    int reacts;               /* 1: one of them */
} pd_setup_potential;

/* A shape that is metal. */
typedef struct pd_setup_piece {
    char name[PD_SETUP_NAME];
    int shape, metal;         /* indices */
} pd_setup_piece;

typedef struct pd_setup {
    char name[PD_SETUP_NAME];  /* of the case: the file without folder and ending */
    char folder[PD_PATH_SIZE]; /* of the output */
    char source[PD_PATH_SIZE]; /* the file as it was named, for messages */
    int line[PD_PART_COUNT];   /* of the file: the section of each part, 0: none */
    int shape_line;            /* of the first solid, without solid of the first shape; 0: none */
    char *fingerprint;          /* what makes it this scene and no other, a line each; NULL: not read from a file */
    size_t fingerprint_size;   /* [byte] */
    int threads;               /* 0: all */
    unsigned given;            /* bit k: pd_knob k stands in the file */
    /* lattice and geometry */
    double m;                          /* [-] horizon over the spacing, of the fluid */
    double metal_m;                    /* [-] of the bonds across the surface of metal */
    double h[PD_DIM];                  /* [m] */
    double lo[PD_DIM], hi[PD_DIM];     /* [m] box */
    int axisymmetric;                  /* 2D: x is the axis, y the distance from it */
    pd_shape *shape;                   /* [PD_SHAPE_MAX], children first */
    int shapes;                        /* entries in use */
    int named[PD_SETUP_SHAPES];        /* of the [shape] sections in their order: the shape of a body; no body: -1 */
    pd_setup_piece piece[PD_SETUP_SHAPES];
    int pieces;                        /* of `solid`, in the order of the file */
    int solid, wall, medium, passive;  /* indices, -1: none */
    int solution;                      /* the same: fluid that begins with `inside` of the electrolyte */
    pd_setup_wall walls[PD_SETUP_WALLS]; /* the parts of `wall` */
    int wall_count;
    uint8_t *mask[PD_SETUP_MASKS];     /* voxels that shapes borrow */
    size_t mask_size[PD_SETUP_MASKS];
    int masks;
    pd_facets *surface[PD_SETUP_SURFACES]; /* that shapes borrow */
    int surfaces;
    pd_setup_side side[2 * PD_DIM];    /* x-, x+, y-, ... */
    int has_flow, has_gas, has_transport, has_grains;
    int has_dissolve;                  /* metal goes */
    int has_corrode;                   /* it goes by bond-based corrosion */
    int has_solid;                     /* it is elastic */
    /* flow */
    double rho;             /* [kg/m3] */
    double mu;              /* [Pa s] */
    double force[PD_DIM];   /* [m/s2] */
    pd_expr body[PD_DIM];   /* of x, y, z, t; in m/s2: the force when it is no constant */
    int pushed;             /* 1: it is none */
    double p_out;           /* [Pa] */
    double speed;           /* [m/s] reference; 0: mean speed of the inlet */
    double length;          /* [m] reference; 0: width of the inlet */
    double steady;          /* [-] residual */
    pd_motion motion;
    int flow_order;         /* 2 or 4; 0: 4 in steady flow where it pays */
    pd_expr start[PD_DIM];  /* of x, y, z; in m/s: given flow, or flow or gas at the start */
    double flow_rtol;       /* [-] error of an implicit step */
    int linear;             /* explicit: equation of state p = c0^2 (rho - rho0), else Tait */
    double sound;           /* [m/s] explicit: c0 */
    /* gas */
    double gas_gamma;       /* [-] */
    pd_expr gas_rho, gas_p; /* of x, y, z; in kg/m3, in Pa: at the start, and held behind inlets */
    pd_gas_order gas_order;
    double gas_cfl;         /* [-] */
    /* transport */
    double diffusivity;     /* [m2/s] */
    double medium_diffusivity; /* [m2/s] of fluid inside the medium */
    double inlet;           /* [mol/m3] of all inlets when `enters` is 0 */
    int enters;             /* 1: the sides say what enters */
    pd_expr initial;        /* of x, y, z; in mol/m3 */
    pd_advection advection;
    double limiter;         /* [-] change of the field at which the limiter stops; 0: that of transport.h */
    int migrates;           /* ions of the electrolyte move in the potential that keeps it neutral */
    int settle;             /* the steady field, and nothing else in time */
    /* dissolution */
    pd_setup_metal metal[PD_SETUP_METALS];
    int metals;             /* at least 1 */
    double saturation;      /* [mol/m3] Csat; 0: not given */
    double gb_factor;       /* [-] */
    double threshold;       /* [-] */
    pd_grain_desc grain;
    /* bond-based corrosion, with D and `initial` of transport, Cs, Csat and rate of dissolution */
    double bulk;            /* [mol/m3] held behind open sides, and everywhere with `activation` */
    int activation;         /* 1: activation control */
    double repassivation;   /* [mol/m3] 0: no films form */
    int stochastic;         /* 1: mechanical bonds break at random */
    int seed;               /* of that */
    pd_drive drive;
    pd_kernel kernel;
    pd_weights weights;
    pd_setup_body metal_body;
    /* species and reactions */
    int has_chemistry;
    pd_electrolyte electrolyte;      /* its solids are the minerals: */
    pd_mineral mineral[PD_MINERAL_MOST];
    int minerals;
    double tortuosity;               /* [-] of their pores */
    double cover;                    /* [m] thickness under which 1/e of metal is bare; 0: they cover none */
    char species_label[PD_SPECIES_MOST][PD_SPECIES_NAME + 12]; /* "Mg2+ [mol/m3]" */
    int sheds;                       /* 1: what metal loses enters the species by a reaction at its surface */
    char gas[PD_SPECIES_NAME];       /* that comes off; "": none */
    /* electric potential */
    int has_potential;
    pd_setup_potential potential;
    /* states of surfaces */
    pd_setup_state state[PD_SETUP_STATES];
    int states;
    /* functions of the expressions */
    pd_setup_table *table;   /* [tables] */
    pd_expr_table *function; /* [tables] of `table`, as expressions want them */
    int tables;
    /* run */
    double until;           /* [s] */
    double rtol;            /* [-] of the volume loss; without dissolution: error of a step of the transport; 0: 1e-3 */
    double fraction;        /* [-] largest share of a node that one step takes */
    double max_step;        /* [s] 0: none */
    /* output */
    double every;           /* [s] */
    pd_fields fields, images;
    char prefix[PD_SETUP_NAME];
    int slice_axis;         /* 3D: the axis across the drawn plane */
    double slice_at;        /* [m] */
    pd_setup_drawing drawing;
    double deformed;        /* [-] factor of the displacements in pictures of the metal; 0: drawn where it was */
    pd_setup_probe probe[PD_SETUP_PROBES];
    int probes;
    pd_setup_monitor monitor[PD_SETUP_MONITORS];
    int monitors;
    pd_setup_record record[PD_SETUP_RECORDS];
    int records;
    /* what the reader has to say about the file, a line each */
    char note[PD_SETUP_NOTES][200];
    int notes;
} pd_setup;

#define pd_setup_free PD_NAME(pd_setup_free)
#define pd_setup_function PD_NAME(pd_setup_function)
#define pd_setup_breaks PD_NAME(pd_setup_breaks)

#ifdef PDI_INTERNAL
/* Start a setup: no physics, walls all around, defaults of all numbers. */
PDI_FN pd_status pdi_setup_init(pd_ctx *ctx, pd_setup *setup);
#endif
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
 * and so on for x+, y-, ... A coordinate for each axis. A checkpoint does not know functions. PD_ERR_ARGUMENT: no such
 * key, or the scene does not give that value. */
PD_API pd_status pd_setup_function(pd_ctx *ctx, pd_setup *setup, const char *key, pd_expr_fn fn, void *user,
                                   uint32_t uses);
/* When such a function jumps, or a pulse of it begins or ends: t [count] [s] ascending; copied. Steps do not pass over
 * what it does then. Between breaks it counts as being between its values at both ends and in the middle of any time.
 * PD_ERR_ARGUMENT: no such key, no function stands there, or times that do not ascend. */
PD_API pd_status pd_setup_breaks(pd_ctx *ctx, pd_setup *setup, const char *key, const double *t, int count);

#ifdef PDI_INTERNAL
/* Name of a field in files: "C", "v", "Mg2+", ...; "": the setup has no such species. */
PDI_FN const char *pdi_setup_field_name(const pd_setup *setup, pd_field field);
/* "C [mol/m3]" */
PDI_FN const char *pdi_setup_field_label(const pd_setup *setup, pd_field field);
/* unit[PD_UNITS_TEXT]: "mol/m3"; "": it is a plain number. */
PDI_FN void pdi_setup_field_unit(const pd_setup *setup, pd_field field, char *unit);
/* The field of this name; PD_FIELD_COUNT: there is none. */
PDI_FN int pdi_setup_field_find(const pd_setup *setup, const char *name);
/* What the species are; all but their concentrations and the arena. */
PDI_FN void pdi_setup_reactive(const pd_setup *setup, pd_reactive_desc *desc);
/* Species of the electrolyte whose concentration it is; -1: it is none. */
PDI_FN int pdi_setup_field_species(const pd_setup *setup, int64_t field);
/* State of surfaces that it is; -1: it is none. */
PDI_FN int pdi_setup_field_state(const pd_setup *setup, int64_t field);
/* 1: displacements, stresses and the like. */
PDI_FN int pdi_setup_field_body(pd_field field);
/* 1: a stress along axes. */
PDI_FN int pdi_setup_field_stress(pd_field field);
/* Its bit. */
static inline pd_fields pdi_setup_field_bit(int64_t field) { return (pd_fields)1 << field; }
/* 1: its values are whole numbers that name something. */
PDI_FN int pdi_setup_field_numbered(pd_field field);
/* 1: the metal has the field. */
PDI_FN int pdi_setup_field_metal(pd_field field);
/* Section of a kind of monitor: "line", ... */
PDI_FN const char *pdi_setup_monitor_name(pd_monitor_kind kind);
/* Why the field does not exist in this setup: "[flow]", "[transport]", ...; NULL: it does. */
PDI_FN const char *pdi_setup_field_needs(const pd_setup *setup, pd_field field);
/* "x-", "x+", "y-", ... */
PDI_FN const char *pdi_setup_side_name(int side);
/* 1: something asks for the area of surfaces: metal that goes, boundaries of grains, transfer from walls. */
PDI_FN int pdi_setup_surfaces(const pd_setup *setup);
/* Layers of ghosts: largest n with |n| < m + 1/2 of any horizon of the lattice. */
PDI_FN int pdi_setup_layers(const pd_setup *setup);
/* pd_bonds_options of its bonds. */
PDI_FN int pdi_setup_bonds(const pd_setup *setup);
/* Cells of the box along an axis. */
PDI_FN int pdi_setup_cells(const pd_setup *setup, int axis);
/* The variables x, y, z of expressions, PD_DIM of them, and t behind them: PDI_SETUP_PLACE in all. */
#define PDI_SETUP_PLACE (PD_DIM + 1)
PDI_FN const pd_expr_symbol *pdi_setup_position(void);
/* The variables C, t, x, y, z, grain of laws: those of a pd_rate_at. Beside electrodes i and E follow: PDI_SETUP_LAW in
 * all. */
#define PDI_SETUP_GRAIN (PD_DIM + 2)
#define PDI_SETUP_CURRENT (PD_DIM + 3)
#define PDI_SETUP_SURFACE (PD_DIM + 4)
#define PDI_SETUP_LAW (PD_DIM + 5)
PDI_FN const pd_expr_symbol *pdi_setup_law(void);
/* Behind them pH, and the species that a law names. 1: it depends on one of these, or on E among ions that migrate; on
 * i or E of electrodes. */
#define PDI_SETUP_PH PDI_SETUP_LAW
static inline int pdi_setup_chemical(const pd_setup_metal *metal)
{
    return metal->rate.uses >> PDI_SETUP_PH != 0 ||
           (metal->polarised && (metal->rate.uses >> PDI_SETUP_SURFACE & 1u) != 0);
}
/* The first metal with a law in the species or in E among ions that migrate; -1: none. */
static inline int pdi_setup_attacked(const pd_setup *setup)
{
    for (int k = 0; k < setup->metals && setup->has_dissolve; k++)
        if (pdi_setup_chemical(&setup->metal[k])) return k;
    return -1;
}
/* Metals that such laws tell apart: all where several have one, else 1. */
static inline int pdi_setup_apart(const pd_setup *setup)
{
    int count = 0;
    for (int k = 0; k < setup->metals && setup->has_dissolve; k++) count += pdi_setup_chemical(&setup->metal[k]);
    return count > 1 ? setup->metals : 1;
}
/* 1: electrodes among ions that migrate. */
static inline int pdi_setup_polarises(const pd_setup *setup) { return setup->migrates && setup->has_potential; }
static inline int pdi_setup_electric(const pd_setup_metal *metal)
{
    return !metal->polarised && (metal->rate.uses >> PDI_SETUP_CURRENT & 3u) != 0;
}
/* The variables sigma_h, mises, eps_p, x, y, z, t of what stress does to the speed. */
#define PDI_SETUP_PACE (PD_DIM + 4)
PDI_FN const pd_expr_symbol *pdi_setup_pace(void);
/* Value of the law at C = 0, t = 0 and x = 0, times rate_scale [m/s]. */
PDI_FN double pdi_setup_speed(const pd_setup_metal *metal);
/* Value of an expression in x, y, z, t. */
PDI_FN double pdi_setup_eval(const pd_expr *expr, const double *x, double t);
/* 1: it depends on t. */
static inline int pdi_setup_timed(const pd_expr *expr) { return (int)(expr->uses >> PD_DIM & 1u); }
/* Append a shape; *index is its place. PD_ERR_SIZE: too many. */
PDI_FN pd_status pdi_setup_shape(pd_ctx *ctx, pd_setup *setup, const pd_shape *shape, int *index);
/* The union of shape `index` and *whole (-1: nothing yet) becomes *whole. */
PDI_FN pd_status pdi_setup_join(pd_ctx *ctx, pd_setup *setup, int index, int *whole);
/* The complement of *index becomes *index. */
PDI_FN pd_status pdi_setup_outside(pd_ctx *ctx, pd_setup *setup, int *index);
/* The folder of the output, which a file may choose below the current one. PD_ERR_ARGUMENT with its line. */
PDI_FN pd_status pdi_setup_folder(pd_ctx *ctx, pd_text *text, int section, const char *key, pd_setup *setup);
/* Free the measured points. */
PDI_FN void pdi_setup_forget(pd_ctx *ctx, pd_setup *setup);
/* Room for a surface of triangles, all zero; the setup owns it. */
PDI_FN pd_status pdi_setup_surface(pd_ctx *ctx, pd_setup *setup, pd_facets **surface);
/* Take a mask of `size` bytes; the setup owns it. */
PDI_FN pd_status pdi_setup_mask(pd_ctx *ctx, pd_setup *setup, size_t size, uint8_t **mask);
/* A line for the summary. Lines beyond the room are dropped. */
PDI_FN void pdi_setup_note(pd_setup *setup, const char *format, ...) PD_PRINTF_LIKE(2, 3);
/* The value with a unit of readable size ("80 um") into text[PD_UNITS_TEXT]; unit has the dimension. */
PDI_FN void pdi_setup_show(double value, const char *unit, char *text);
/* name[PD_SETUP_NAME] and, when `folder` is not NULL, folder[PD_PATH_SIZE] of a path. */
PDI_FN void pdi_setup_split_path(const char *path, char *name, char *folder);
#endif

#endif
