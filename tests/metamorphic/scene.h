/* scene: a random scene as an object: sections of keys, whose values know their units, their places and their axes. So
 * it can be rotated, mirrored, shifted, rescaled and written in other units without a word about its physics.
 *
 *   int s = scene_section(&x, "dissolve", "");
 *   scene_key(&x, s, "rate", "%q*(1 + 0.5*sin(0.3*%p))", 1e-9, UNIT_SPEED, 0);
 */
#ifndef METAMORPHIC_SCENE_H
#define METAMORPHIC_SCENE_H
#include "core/config.h"
#include <stdint.h>
#include <stddef.h>

typedef enum unit {
    UNIT_ONE = 0,
    UNIT_LENGTH,
    UNIT_TIME,
    UNIT_SPEED,
    UNIT_DIFFUSIVITY,
    UNIT_CONCENTRATION,
    UNIT_RATE, /* 1/s */
    UNIT_CURRENT_DENSITY,
    UNIT_CURRENT, /* of a given current, per the depth of the dimension */
    UNIT_VOLT,
    UNIT_CONDUCTIVITY,
    UNIT_RESISTANCE, /* ohm m2 */
    UNIT_PRESSURE,
    UNIT_DENSITY,
    UNIT_VISCOSITY,
    UNIT_ACCELERATION,
    UNIT_FORCE,     /* N/m3 */
    UNIT_TOUGHNESS, /* J/m2 */
    UNIT_GROWTH,    /* mol/m2/s */
    UNIT_SPECIFIC,  /* 1/m */
    UNIT_MOLAR_VOLUME,
    UNIT_SECOND_ORDER, /* m3/mol/s */
    UNIT_TEMPERATURE,
    UNIT_FLOW_RATE,
    UNIT_COUNT
} unit;

/* Exponents of m, kg, s, mol, A, K. */
typedef struct dimension {
    double e[6];
} dimension;

typedef enum token_kind { TOKEN_TEXT = 0, TOKEN_NUMBER, TOKEN_PLACE } token_kind;

/* A piece of an expression. A place is sign (x - origin)/length along an axis; folded, of the distance from a plane. */
typedef struct token {
    token_kind kind;
    unit of;
    int axis, sign, fold;
    double value, origin, length, plane;
    char text[40];
} token;

typedef enum entry_kind {
    ENTRY_PLAIN = 0, /* one expression, words */
    ENTRY_COMPONENT, /* the key ends with the letter of its axis, the value is a component of a vector */
    ENTRY_VECTOR,    /* an expression an axis */
    ENTRY_SIZES,     /* a length an axis */
    ENTRY_POINT,
    ENTRY_BOX,
    ENTRY_PLANE, /* an axis and a place on it */
    ENTRY_AXIS,  /* the letter of an axis */
    ENTRY_CORNERS,   /* places one after another */
    ENTRY_DIRECTION, /* plain numbers */
    ENTRY_VOXELS     /* a file that is written beside the scene: raw or, in 2D, a PNG */
} entry_kind;

enum {
    SCENE_TOKENS = 2400,
    SCENE_ENTRIES = 400,
    SCENE_SECTIONS = 64,
    SCENE_NAME = 24,
    SCENE_CORNERS = 4,
    SCENE_VOXELS = 1024
};

typedef struct entry {
    char key[24];
    entry_kind kind;
    int section;
    int axis;     /* component, plane, axis */
    int sign;     /* component: of its value */
    int odd;      /* 1 + axis: of vectors, the component along it changes its sign at the plane, below which it is
                   * that of the image; 0: no */
    double plane; /* [m] */
    int first[3], count[3]; /* tokens of each expression */
    int rotated[3];         /* vector: sign of each */
    double low[3], high[3]; /* point, direction: low; plane: low[0]; voxels: the box that they fill */
    int corners;
    double corner[SCENE_CORNERS][3];
    int image; /* voxels: a PNG where there can be one */
} entry;

/* The voxels of a scene fill its box, so that a mirror side is an end of them. x fastest. */
typedef struct voxels {
    int n[3];
    unsigned char inside[SCENE_VOXELS];
} voxels;

typedef struct section {
    char name[16], label[SCENE_NAME];
    int axis, plus; /* side: which one */
    int gone;       /* taken out */
} section;

/* What a scene models, for the count of physics and for what a pair may assume. */
enum {
    HAS_FLOW = 1,
    HAS_TRANSPORT = 2,
    HAS_DISSOLVE = 4,
    HAS_CORRODE = 8,
    HAS_CHEMISTRY = 16,
    HAS_MINERAL = 32,
    HAS_STATE = 64,
    HAS_MIGRATION = 128,
    HAS_POTENTIAL = 256,
    HAS_SOLID = 512,
    HAS_GAS = 1024,
    HAS_GRAINS = 2048,
    HAS_MEDIUM = 4096,
    HAS_RANDOM = 8192,
    HAS_STEADY = 16384,
    HAS_MOTION = 32768,
    HAS_AXIS = 65536,
    HAS_CRACK = 131072,
    HAS_LIMITED = 262144,
    HAS_FLOW_IN_TIME = 524288,
    HAS_SPRINGS = 1048576
};

typedef struct scene {
    int cells[3];
    double h[3], low[3];
    double until, time; /* [s] 0: no run; a time scale of the scene */
    double D, pressure; /* [m2/s] [Pa] of its species, of its flow; 0: none */
    double current;     /* [A/m2] a scale of what its curves pass; 0: none */
    double moved;       /* [m] by which its sides and grips move metal, at most; 0: by nothing */
    uint32_t has;
    int grid; /* section */
    token pool[SCENE_TOKENS];
    entry list[SCENE_ENTRIES];
    section part[SCENE_SECTIONS];
    int tokens, entries, sections;
    int other_units; /* seed of the units it is written in; 0: those of the SI */
    double rtol;     /* [-] of its steps, by tolerance; 0: they are prescribed */
    int first_order; /* of the steps of species, whose order may hang on rounding */
    int layer;       /* 1: written as one layer in 3D, between mirrors */
    int ring;        /* 1: written as a ring around the x axis */
    voxels mask;
    int full;        /* something did not fit */
} scene;

extern const char *const axis_names[3];
/* Where files lie that scenes name. */
extern char scene_folder[256];

void scene_begin(scene *x);
/* A new section. */
int scene_section(scene *x, const char *name, const char *label);
int scene_side(scene *x, int axis, int plus);
/* A key with an expression: %q double, unit: a quantity; %p axis: the place along it in cells from the low end of the
 * box; %s text; %g plain number; %i int. */
void scene_key(scene *x, int s, const char *key, const char *format, ...);
/* The component of a vector along an axis: `key` without the letter. */
void scene_component(scene *x, int s, const char *key, int axis, const char *format, ...);
/* The next expression of a vector; its first one makes the key. */
void scene_vector(scene *x, int s, const char *key, int axis, const char *format, ...);
void scene_sizes(scene *x, int s, const char *key, const double *sizes);
void scene_point(scene *x, int s, const char *key, const double *at);
void scene_box(scene *x, int s, const char *key, const double *low, const double *high);
void scene_plane(scene *x, int s, const char *key, int axis, double at);
void scene_axis(scene *x, int s, const char *key, int axis);
/* A corner more; the first one makes the key. */
void scene_corner(scene *x, int s, const char *key, const double *at);
void scene_direction(scene *x, int s, const char *key, const double *along);
/* Those of x->mask. */
void scene_voxels(scene *x, int s, int image);
entry *scene_find(scene *x, int s, const char *key);
int scene_physics(const scene *x);
/* It ends after this share of its time. */
void scene_shorten(scene *x, double share);
/* Exponents of a unit of the table, and of [m^e ...] as figures and fields write it; 0: not known. */
dimension unit_dimension(unit of);

/* The text of the scene; 0: it did not fit. */
size_t scene_write(const scene *x, char *text, size_t size);

#endif
