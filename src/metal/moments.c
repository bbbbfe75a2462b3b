/* moments: see moments.h */
#include "metal/moments.h"
#include "solve/time_quadrature.h"
#include <math.h>
#include <string.h>

/* The tolerance where none is given. */
#define PDI_MOMENTS_RTOL 1e-3

typedef struct pdi_moments_piece {
    double from, to; /* [s] */
} pdi_moments_piece;

/* A law at a node. */
typedef struct pdi_moments_node {
    pdi_law law;
    pdi_law_point film; /* what the surface is behind */
    double c;     /* [mol/m3] */
    double share; /* [-] of a node's content that it takes in the step, per speed [s/m] */
} pdi_moments_node;

/* 1: a metal beside the node has a law that depends on time. */
static int pdi_moments_timed(const pd_dissolve *d, const pdi_beside *beside)
{
    const pdi_metal_beside *portion = pdi_metal_portion(d, beside);
    for (int m = 0; m < d->kinds; m++) {
        const pd_metal *law = &d->kind[m].law;
        if (!law->uniform && !law->timeless && (portion[m].weight > 0.0 || portion[m].enters > 0.0)) return 1;
    }
    return 0;
}

/* The law at the node in the step of dt [s]. A whole family of fluid may take metal by bonds. */
static void pdi_moments_look(const pd_dissolve *d, const pdi_beside *beside, double dt, pdi_moments_node *node)
{
    pdi_interface_law(d, beside, &node->law);
    node->law.moments = 0;
    memset(&node->film, 0, sizeof node->film);
    node->film.resist = pdi_interface_resist(d, beside);
    node->film.end = HUGE_VAL;
    node->c = pd_max(d->transport->c[beside->node], 0.0);
    node->share = 0.0;
    for (int m = 0; m < d->kinds; m++)
        node->share += dt * pdi_metal_portion(d, beside)[m].enters / d->kind[m].supply;
    if (pdi_metal_bonds(d)) node->share = dt * d->kernel.total;
}

static double pdi_moments_at(void *user, double t)
{
    pdi_moments_node *node = (pdi_moments_node *)user;
    node->law.at.t = t;
    return pd_max(pdi_law_rate(&node->law, node->c), 0.0);
}

/* Behind the film. */
static double pdi_moments_behind(void *user, double t)
{
    pdi_moments_node *node = (pdi_moments_node *)user;
    return pdi_law_at_instant(&node->law, &node->film, t, node->c);
}

static void pdi_moments_bounds(void *user, double from, double to, double *least, double *most)
{
    pdi_moments_node *node = (pdi_moments_node *)user;
    pdi_law_bounds(&node->law, node->c, from, to, least, most);
}

/* 1: instants give the integral at all nodes, of the law and of its speed behind the film. */
static int pdi_moments_all(const pd_dissolve *d, const pdi_moments_piece *piece, double dt, int middle)
{
    double part = (piece->to - piece->from) / dt, mean;
    for (int32_t n = 0; n < d->beside_count; n++) {
        pdi_moments_node node;
        pdi_time_quadrature law = {pdi_moments_at, pdi_moments_bounds, NULL, 0.0, 1.0, PDI_MOMENTS_RTOL};
        if (!pdi_moments_timed(d, &d->beside[n])) continue;
        pdi_moments_look(d, &d->beside[n], dt, &node);
        law.user = &node;
        law.weight = node.share;
        if (d->rtol > 0.0) law.rtol = d->rtol;
        if (pdi_time_quadrature_check(&law, piece->from, piece->to, part, middle, &mean) ==
            PDI_TIME_QUADRATURE_SUBDIVIDE)
            return 0;
        if (!(node.film.resist > 0.0)) continue;
        law.value = pdi_moments_behind;
        law.bounds = NULL;
        if (pdi_time_quadrature_check(&law, piece->from, piece->to, part, middle, &mean) ==
            PDI_TIME_QUADRATURE_SUBDIVIDE)
            return 0;
    }
    return 1;
}

/* What laws that change take of a node at most: by the middle and the end of the step where that is one piece, else by
 * their means. */
static double pdi_moments_loss(const pd_dissolve *d, double t, double dt)
{
    double taken = 0.0;
    for (int32_t n = 0; n < d->beside_count; n++) {
        pdi_moments_node node;
        if (!pdi_moments_timed(d, &d->beside[n])) continue;
        pdi_moments_look(d, &d->beside[n], dt, &node);
        double first = pdi_moments_at(&node, t), last = pdi_moments_at(&node, t + dt);
        double speed = pd_max(last, pdi_moments_at(&node, t + 0.5 * dt));
        if (d->moments) {
            node.law.moments = d->moments;
            speed = pd_max(pdi_law_rate(&node.law, node.c), 0.0);
        }
        if (d->moments || first < speed || first > speed || last < speed) taken = pd_max(taken, node.share * speed);
    }
    return taken;
}

PDI_FN double pdi_moments_find(pd_dissolve *d, double t, double dt, double *taken)
{
    pdi_moments_piece waiting[64], piece;
    int count = 1;
    d->moments = 0;
    waiting[0].from = t;
    waiting[0].to = t + dt;
    *taken = 0.0;
    if (!pdi_moments_all(d, &waiting[0], dt, 1))
        while (count > 0) { /* from the first to the last */
            piece = waiting[--count];
            double middle = 0.5 * (piece.from + piece.to);
            if (d->moments == PDI_MOMENTS_MOST) {
                d->moments = 0;
                return pd_max(0.9 * (piece.from - t) / dt, 1e-3);
            }
            if (count < 62 && middle > piece.from && middle < piece.to && !pdi_moments_all(d, &piece, dt, 0)) {
                waiting[count].from = middle;
                waiting[count++].to = piece.to;
                waiting[count].from = piece.from;
                waiting[count++].to = middle;
                continue;
            }
            for (int k = 0; k < 2; k++) {
                d->moment[d->moments] = pdi_time_quadrature_gauss_point(piece.from, piece.to, k);
                d->part[d->moments++] = 0.5 * (piece.to - piece.from) / dt;
            }
        }
    *taken = pdi_moments_loss(d, t, dt);
    return 1.0;
}

#undef PDI_MOMENTS_RTOL
