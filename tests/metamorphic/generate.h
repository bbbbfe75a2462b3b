/* generate: random scenes, small ones, that run in well under a second. */
#ifndef METAMORPHIC_GENERATE_H
#define METAMORPHIC_GENERATE_H
#include "scene.h"

#define STATE_HALF 0.5 /* [mol/m3] of Mg2+, at which states of surfaces have half their rate */

typedef enum scene_class {
    CLASS_EXACT = 0, /* prescribed steps, tolerances at their end */
    CLASS_TOLERANCE, /* default steps */
    CLASS_LATTICE,
    CLASS_RING /* prescribed steps; what may stand around an axis */
} scene_class;

/* through: share of bodies whose faces go through nodes, where rounding may say which cells are theirs. */
void generate_scene(uint32_t seed, scene_class of, double through, scene *x);

/* What the parts of the generator share. */
typedef struct draw {
    scene *x;
    uint32_t state;
    scene_class of;
    int metals; /* solids of materials of their own */
    int shapes;
    int holds;     /* a solid that is held runs from side to side along this axis, -1: none */
    int flow_axis; /* -1: none */
    int given;     /* 1: the flow is given, and nothing stands in it */
    int periodic[3];
    double m;       /* [-] horizon of the fluid */
    int solid_m;    /* of the solid; 0: as it is without the key */
    double grain;   /* [-] diameter of grains over h */
    int loose;      /* 1: the bar ends in the fluid */
    double D;       /* [m2/s] */
    double length;  /* [m] a few cells */
    double through; /* [-] share of bodies with faces through nodes */
    char fields[256];
} draw;

/* 1: steps are prescribed and tolerances at their end. */
int draw_exact(const draw *g);
double draw_fraction(draw *g);
double draw_between(draw *g, double low, double high);
double draw_decade(draw *g, double low, double high);
int draw_chance(draw *g, double chance);
int draw_whole(draw *g, int low, int high);

void generate_shapes(draw *g);
void generate_sides(draw *g);
void generate_flow(draw *g);
void generate_transport(draw *g);
void generate_metal(draw *g);
void generate_chemistry(draw *g);
void generate_potential(draw *g);
void generate_solid(draw *g);
void generate_gas(draw *g);

#endif
