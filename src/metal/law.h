/* law: the law of dissolution at one node of the fluid: its speed behind a film, its jumps, the salt layer.
 *
 * Metal at the surface dissolves at v(s), where s is the concentration there. What dissolves diffuses through the film
 * between the surface and the node, so that
 *
 *     v = max(v(c + R v), 0),     R = Cs film/D,                                            (theory: eq. 10.4)
 *
 * with the concentration c of the node. V(c) is the first solution above c: any law may be rising, flat, negative or
 * jump. Where a decreasing law jumps, every speed in between is a solution, so V falls by at most 1/R a concentration.
 * A law ends where it is not positive any more: no metal passes that concentration (saturation).
 *
 * Without a film, R = 0, a law that jumps down has no line. There the fluid is held at the jump, and its
 * equations give the speed. The point leaves the jump when that speed lies outside those of both sides (primal-dual
 * active set: Hintermueller, Ito and Kunisch 2002). Saturation is such a jump to zero.
 *
 * A point of a law holds the line that stands for V in the linear equations. A solve gives c. The speed of the line at
 * this c is called asked; V(c) is what the metal gives. The point also keeps c and the speed asked of
 * earlier rounds on both sides of the solution. Where both sides are known, a straight line joins them, and the next
 * line touches V where that one meets V. Newton's method alone runs in circles on laws with a plateau, a step and
 * another plateau.
 */
#ifndef PD_LAW_H
#define PD_LAW_H
#include "metal/material.h"

/* Most metals of a dissolution. */
#define PDI_LAW_METALS 8

#ifdef PDI_INTERNAL

/* The law of one metal at a place. */
typedef struct pdi_law_metal {
    pd_rate_fn rate;
    void *user;
    pd_rate_bounds_fn bounds; /* of it in time; NULL: by its values and the */
    const double *breaks;     /* [break_count] [s] */
    int break_count;
    double whole, part; /* [-], [m3/mol] the rate is multiplied by whole - part c, at least 0; 1, 0: as it is */
    double share;       /* [-] of the metals there */
} pdi_law_metal;

/* A law at a place and a time: that of its metal, or the mean of those of several ones, where none counts below 0. */
typedef struct pdi_law {
    pdi_law_metal metal[PDI_LAW_METALS];
    int metals;
    pd_rate_at at; /* c is the concentration of the last call */
    const double *moment, *part; /* [moments] [s], [-] instants of whose speeds it is the mean, none below 0 */
    int moments;   /* 0: it is that of at.t */
    double top;    /* [mol/m3] concentrations are looked at up to here: those of the metal, or saturation */
    double limit;  /* [mol/m3] the law is 0 from here on; HUGE_VAL: nowhere */
    double touch;  /* [mol/m3] the law touches 0 here without falling below it: no metal passes; 0: nowhere */
} pdi_law;

/* Line v = speed + slope c and what is known of both sides. */
typedef struct pdi_law_point {
    double resist;          /* [mol s/m4] R of the film; HUGE_VAL: nothing passes it */
    double from, seen;      /* [mol/m3] the law is positive between these */
    double end;             /* [mol/m3] and ends here; HUGE_VAL: not known */
    double speed, slope;    /* [m/s], [m4/mol/s], slope <= 0 behind a film */
    double touch;           /* [mol/m3] where the line touches V */
    double low_c, low_v;    /* the metal gives at least the speed low_v that is asked there */
    double high_c, high_v;  /* it gives less; HUGE_VAL: not known */
    double largest;         /* [m/s] V so far */
    int pinned;             /* 1: c is held at a jump of the law, and the speed is what the fluid needs there */
    int beyond;             /* 1: c is, or was, above the jump at `pin` */
    double pin;             /* [mol/m3] the last concentration before the jump */
    double ahead, behind;   /* [m/s] speeds before and behind it */
} pdi_law_point;

/* v [m/s] of metal m alone at concentration c, as it is; that of the law. */
PDI_FN double pdi_law_own(pdi_law *law, int m, double c);
PDI_FN double pdi_law_rate(pdi_law *law, double c);
/* V(c) [m/s], at least 0. NaN or infinite: so is the law, at law->at.c. Of several instants it is the mean of their V:
 * the film follows the law at once, so V of the mean law would be too large. */
PDI_FN double pdi_law_at(pdi_law *law, pdi_law_point *point, double c);
/* The same at the time t [s]. */
PDI_FN double pdi_law_at_instant(pdi_law *law, const pdi_law_point *point, double t, double c);
/* Between which speeds [m/s], of at least 0, the law at c stays from time a to b [s]. */
PDI_FN void pdi_law_bounds(pdi_law *law, double c, double a, double b, double *least, double *most);
/* Smallest concentration from c to `limit` at which the law is not positive; HUGE_VAL: there is none. Zones narrower
 * than 6 % of a concentration and 1e-9 of the top may be missed. */
PDI_FN double pdi_law_end(pdi_law *law, double c, double limit);
/* Smallest concentration up to the top where a positive law falls to 0 and rises again; 0: there is none. Dips
 * narrower than 6 % of a concentration may be missed. */
PDI_FN double pdi_law_touch_point(pdi_law *law);
/* 1: the law touches 0 at c. */
PDI_FN int pdi_law_touches(pdi_law *law, double c);
/* First line, at c >= 0, for a law that is known to be positive between `from` and its end (HUGE_VAL, 0: not known). 0:
 * it is not finite at law->at.c. */
PDI_FN int pdi_law_begin(pdi_law *law, double resist, double from, double end, double c, pdi_law_point *point);
/* 1: the speed that the line asks at c lies on V, within `near` [m/s] or `close` [mol/m3]. 0: another line is taken.
 * -1: the law is not finite at law->at.c. */
PDI_FN int pdi_law_meet(pdi_law *law, double c, double near, double close, pdi_law_point *point);
/* The slope becomes at most `most` [m4/mol/s]; the line still touches V. */
PDI_FN void pdi_law_tame(double most, pdi_law_point *point);
/* Of a pinned point, with the speed [m/s] that the fluid needs: 1: it lies between those of the jump, within `near`,
 * and is the speed of the line. 0: the point has left the jump, and there is another line. */
PDI_FN int pdi_law_meet_pinned(pdi_law *law, double need, double near, pdi_law_point *point);
/* Least V between concentrations a and c where the law rises in between, else HUGE_VAL. It may be below V at both. */
PDI_FN double pdi_law_slowest(pdi_law *law, pdi_law_point *point, double a, double c);

#endif

#endif
