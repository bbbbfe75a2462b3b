/* physics_type: a physics that a program brings along: the keys of its section, how it is built, its process, its
 * fields. Scenes that are read with the context know it then as they know those of this library.
 *
 * examples/11_own_physics.c conducts heat so.
 */
#ifndef PD_PHYSICS_TYPE_H
#define PD_PHYSICS_TYPE_H
#include "flow/flow.h"
#include "solve/physics.h"

#define PD_PHYSICS_TYPE_KEYS 16  /* most keys of a section */
#define PD_PHYSICS_TYPE_FIELDS 4 /* most fields of all physics that programs bring along */

#define PD_KEY_MAX_NUMBER 1e30 /* upper bound of all numbers, in SI: anything larger is a mistake */

/* What a value of a key may be. */
typedef enum pd_key_type {
    PD_KEY_TEXT = 0, /* an expression, a list or a name, as the meaning says; of a physics of a program: an expression
                      * in x, y, z, t */
    PD_KEY_NUMBER,   /* a number from low to high */
    PD_KEY_WHOLE,    /* a whole number from low to high */
    PD_KEY_CHOICE    /* one of the words of choices; its value is their number, from 0 on */
} pd_key_type;

/* The end of a row of keys: its type and what it allows. */
#define PD_KEY_ANY_TEXT PD_KEY_TEXT, 0.0, 0.0, 0, NULL
#define PD_KEY_EXPRESSION PD_KEY_ANY_TEXT
#define PD_KEY_EXPRESSION_NOT_NEGATIVE PD_KEY_TEXT, 0.0, PD_KEY_MAX_NUMBER, 0, NULL
#define PD_KEY_EXPRESSION_POSITIVE PD_KEY_TEXT, 0.0, PD_KEY_MAX_NUMBER, 1, NULL
#define PD_KEY_FROM(low, high) PD_KEY_NUMBER, low, high, 0, NULL
#define PD_KEY_ABOVE(low, high) PD_KEY_NUMBER, low, high, 1, NULL
#define PD_KEY_POSITIVE PD_KEY_ABOVE(0.0, PD_KEY_MAX_NUMBER)
#define PD_KEY_NOT_NEGATIVE PD_KEY_FROM(0.0, PD_KEY_MAX_NUMBER)
#define PD_KEY_ANY_NUMBER PD_KEY_FROM(-PD_KEY_MAX_NUMBER, PD_KEY_MAX_NUMBER)
#define PD_KEY_WHOLE_FROM(low, high) PD_KEY_WHOLE, low, high, 0, NULL
#define PD_KEY_ONE_OF(words) PD_KEY_CHOICE, 0.0, 0.0, 0, words

/* A key of a section. */
typedef struct pd_key {
    const char *keys;         /* one, or several with one meaning: "vx, vy, vz" */
    const char *unit;         /* of the SI, any other of its dimension will do; "-": none; "any": a name of the user's;
                               * "text": a value with = in it; the first key of a section stands without it */
    const char *default_text; /* the default; "required"; "-": absent; "the ...", "that of ...": where it comes from */
    const char *meaning;
    pd_key_type type;
    double low, high;    /* [unit of the key] bounds of a number, and of what is constant; equal: none */
    int low_is_open;     /* 1: low itself is refused */
    const char *choices; /* "strain, stress" */
} pd_key;

/* A section and its keys. */
typedef struct pd_key_section {
    const char *name, *label; /* label: what stands behind the name: "NAME", "FORMULA", "" for nothing */
    const char *meaning;
    const pd_key *key; /* [count] in the order of the guide */
    int count;
} pd_key_section;

/* Cells in which a field has values. */
typedef enum pd_field_place {
    PD_FIELD_IN_FLUID = 0,
    PD_FIELD_IN_METAL,
    PD_FIELD_IN_BOTH,
    PD_FIELD_IN_ALL /* walls and cells outside of the domain, too */
} pd_field_place;

/* What a physics is built on. The objects are borrowed for its life. */
typedef struct pd_physics_view {
    const pd_grid *grid;
    const pd_bonds *bonds;
    const pd_flow *flow; /* NULL: none */
    const void *scene;   /* what the callbacks below read */
    /* Value [SI unit of the key] of key number `key` at x [PD_DIM] [m] and t [s]; NaN: it is not given, and has no
     * default. */
    double (*value)(const struct pd_physics_view *view, int key, const double *x, double t);
    /* 1: section [side ...] number `side` (x-, x+, y-, ...) has the first field as a key: *value [SI] is prescribed at
     * x [m] and t [s]. */
    int (*prescribed)(const struct pd_physics_view *view, int side, const double *x, double t, double *value);
} pd_physics_view;

/* A scalar field of such a physics. */
typedef struct pd_physics_field {
    const char *name; /* "T", a word; rate laws of metals read it under this name at the fluid node */
    const char *unit; /* of the SI: "K"; "": none */
    pd_field_place place;
} pd_physics_field;

/* The physics; what it points to is borrowed for the life of the context. */
typedef struct pd_physics_type {
    pd_key_section section; /* without label: "heat" is [heat]; the scene has this physics when it has the section. All
                             * values are expressions in x, y, z, t */
    const pd_physics_field *field; /* [fields] */
    int fields;                    /* at least 1 */
    /* Build the state of a run. On failure nothing is left. */
    pd_status (*build)(pd_ctx *ctx, const pd_physics_view *view, void **state);
    void (*free)(pd_ctx *ctx, void *state);
    /* Fill in its process, which is zero, with the state as `self`. It steps before the metal does. */
    void (*set_process)(void *state, pd_physics *process);
    /* [grid->total] [SI] values of a field now. */
    const double *(*values)(const void *state, int field);
    double bytes_per_node; /* [byte] for estimates of memory */
} pd_physics_type;

#define pd_physics_type_register PD_NAME(pd_physics_type_register)

/* Make a physics known to all scenes that are read with this context; type is borrowed. PD_ERR_ARGUMENT: its section
 * lacks a name or meaning, has a label other than "", or is registered; one of build, free, set_process and values is
 * NULL; it has no field, more than 4 fields or more than 16 keys. PD_ERR_SIZE: the context holds PD_CTX_PHYSICS of
 * them. After an error nothing is added. */
PD_API pd_status pd_physics_type_register(pd_ctx *ctx, const pd_physics_type *type);

#endif
