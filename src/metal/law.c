/* law: see law.h */
#include "metal/law.h"
#include "core/root_bracket.h"
#include <math.h>

/* The end of a law is sought in strides of concentration. This is a stride over the concentration. */
#define PDI_LAW_GROWTH 0.0625
/* Least stride over the top. */
#define PDI_LAW_LEAST 1e-9
/* Where a law touches 0 it is 0 up to this share of the concentration above: rounding does not pass it. */
#define PDI_LAW_BAND 1e-6
/* A law that falls below this share of what it is around has touched 0. */
#define PDI_LAW_NOTHING 1e-9
/* Most halvings of an interval: then no number is left inside. */
#define PDI_LAW_HALVINGS 200
/* Most rounds for a rising law. */
#define PDI_LAW_ROUNDS 400

PDI_FN double pdi_law_own(pdi_law *law, int m, double c)
{
    const pdi_law_metal *metal = &law->metal[m];
    double mean = 0.0;
    law->at.c = c;
    if (c >= law->limit || (law->touch > 0.0 && c >= law->touch && c <= law->touch * (1.0 + PDI_LAW_BAND))) return 0.0;
    if (!law->moments) mean = metal->rate(metal->user, &law->at);
    for (int k = 0; k < law->moments; k++) {
        law->at.t = law->moment[k];
        double v = metal->rate(metal->user, &law->at);
        if (!(v < 0.0)) mean += law->part[k] * v; /* one that is no number shows */
    }
    return mean * pd_max(metal->whole - metal->part * c, 0.0);
}

/* The bounds of metal m, without the factor of its drive. */
static void pdi_law_own_bounds(pdi_law *law, int m, double a, double b, double *least, double *most)
{
    const pdi_law_metal *metal = &law->metal[m];
    *least = HUGE_VAL;
    *most = -HUGE_VAL;
    if (metal->bounds) {
        metal->bounds(metal->user, &law->at, a, b, least, most);
        return;
    }
    for (int k = 0; k < 3; k++) {
        law->at.t = k < 2 ? (k ? b : a) : 0.5 * (a + b);
        double v = metal->rate(metal->user, &law->at);
        *least = pd_min(*least, v);
        *most = pd_max(*most, v);
    }
    for (int k = 0; k < metal->break_count; k++)
        if (metal->breaks[k] >= a && metal->breaks[k] <= b) *most = HUGE_VAL;
}

PDI_FN void pdi_law_bounds(pdi_law *law, double c, double a, double b, double *least, double *most)
{
    *least = *most = 0.0;
    law->at.c = c;
    for (int m = 0; m < law->metals && c < law->limit; m++) {
        const pdi_law_metal *metal = &law->metal[m];
        double low, high, factor = pd_max(metal->whole - metal->part * c, 0.0);
        if (law->metals > 1) factor *= metal->share;
        if (!(factor > 0.0)) continue;
        pdi_law_own_bounds(law, m, a, b, &low, &high);
        *least += factor * pd_max(low, 0.0);
        *most += factor * pd_max(high, 0.0);
    }
}

PDI_FN double pdi_law_rate(pdi_law *law, double c)
{
    double sum = 0.0;
    if (law->metals == 1) return pdi_law_own(law, 0, c);
    for (int m = 0; m < law->metals; m++) {
        double v = pdi_law_own(law, m, c);
        if (!(v < 0.0)) sum += law->metal[m].share * v; /* one that is no number shows */
    }
    return sum;
}

/* 1: a number that can be computed with. */
static int pdi_law_finite(double v) { return fabs(v) < 1e100; }

/* The end between a, where the law is positive, and b, where it is not. */
static double pdi_law_halve(pdi_law *law, double a, double b)
{
    for (int k = 0; k < PDI_LAW_HALVINGS; k++) {
        double middle = a + 0.5 * (b - a);
        if (!(middle > a) || !(middle < b)) break;
        if (pdi_law_rate(law, middle) > 0.0) a = middle;
        else b = middle;
    }
    return b;
}

/* The next concentration of a search from s to c. */
static double pdi_law_stride(const pdi_law *law, double s, double c)
{
    return pd_min(s + pd_max(PDI_LAW_GROWTH * s, PDI_LAW_LEAST * law->top), c);
}

PDI_FN double pdi_law_end(pdi_law *law, double c, double limit)
{
    double a = c;
    if (!(pdi_law_rate(law, c) > 0.0)) return c;
    while (a < limit) {
        double b = pdi_law_stride(law, a, limit), v = pdi_law_rate(law, b);
        if (!pdi_law_finite(v)) return HUGE_VAL; /* a call that needs the law there fails with a message */
        if (!(v > 0.0)) return pdi_law_halve(law, a, b);
        a = b;
    }
    return HUGE_VAL;
}

/* The least value of a dip between a and b, by thirds; *at: its place. */
static double pdi_law_dip(pdi_law *law, double a, double b, double *at)
{
    double least = HUGE_VAL;
    for (int k = 0; k < PDI_LAW_HALVINGS && b - a > 1e-15 * b; k++) {
        double left = a + (b - a) / 3.0, right = b - (b - a) / 3.0;
        double one = pdi_law_rate(law, left), two = pdi_law_rate(law, right);
        if (pd_min(one, two) < least) *at = one < two ? left : right;
        least = pd_min(least, pd_min(one, two));
        if (one < two) b = right;
        else a = left;
    }
    return least;
}

PDI_FN double pdi_law_touch_point(pdi_law *law)
{
    double a = 0.0, b = 0.0, before = pdi_law_rate(law, 0.0), middle = before, at = 0.0;
    law->touch = 0.0;
    while (b < law->top && middle > 0.0) {
        double c = pdi_law_stride(law, b, law->top), behind = pdi_law_rate(law, c);
        if (before > middle && middle < behind) {
            double least = pdi_law_dip(law, a, c, &at);
            if (least < PDI_LAW_NOTHING * pd_min(before, behind)) return least < 0.0 ? 0.0 : at;
        }
        a = b;
        b = c;
        before = middle;
        middle = behind;
    }
    return 0.0;
}

PDI_FN int pdi_law_touches(pdi_law *law, double c)
{
    double had = law->touch, around, at;
    law->touch = 0.0;
    around = pd_min(pdi_law_rate(law, c * (1.0 - PDI_LAW_GROWTH)), pdi_law_rate(law, c * (1.0 + PDI_LAW_GROWTH)));
    at = pdi_law_rate(law, c);
    law->touch = had;
    return at >= 0.0 && at < PDI_LAW_NOTHING * around;
}

/* The end above c as far as `limit`. What is seen on the way is kept: the law is positive from `from` to `seen`. */
static double pdi_law_point_end(pdi_law *law, pdi_law_point *p, double c, double limit)
{
    if (c < p->from) {
        double end = pdi_law_end(law, c, p->from);
        if (end < p->from) return end;
        p->from = c;
    }
    if (c >= p->end) return pdi_law_end(law, c, limit);
    limit = pd_max(limit, c);
    if (limit <= p->seen || p->end < HUGE_VAL) return p->end;
    p->end = pdi_law_end(law, p->seen, limit);
    p->seen = pd_min(limit, p->end);
    return c < p->end ? p->end : pdi_law_end(law, c, limit);
}

/* Solution of v = v(c + R v) between a, where the law is above v, and b, where it is not. */
static double pdi_law_between(pdi_law *law, double resist, double c, double a, double above, double b, double below)
{
    pdi_root_bracket s = {a, above, b, below, 0, 0};
    double v;
    while (s.b - s.a > 1e-15 * s.b && pdi_root_bracket_get_next(&s, &v)) {
        double g = pdi_law_rate(law, c + resist * v) - v;
        if (!pdi_law_finite(g)) return g;
        pdi_root_bracket_update(&s, v, g);
    }
    return s.b;
}

/* V(c) of one instant, or of any law without a film. */
static double pdi_law_behind(pdi_law *law, pdi_law_point *p, double c)
{
    double a = 0.0, above = pdi_law_rate(law, c), b = above, resist = p->resist;
    if (!pdi_law_finite(above)) return above;
    if (!(above > 0.0) || !(resist > 0.0)) return pd_max(above, 0.0);
    if (!(resist < HUGE_VAL)) { /* the surface is as rich as it can be */
        double v = pdi_law_point_end(law, p, c, law->top) < HUGE_VAL ? 0.0 : pdi_law_rate(law, law->top);
        return pd_min(above, pd_max(v, 0.0));
    }
    for (int k = 0; k < PDI_LAW_ROUNDS; k++) { /* a rising law gives more behind its film */
        double reach = resist * b, most = (pdi_law_point_end(law, p, c, c + reach) - c) / resist;
        if (b >= most) return pdi_law_between(law, resist, c, a, above, most, -most);
        double g = pdi_law_rate(law, c + reach) - b;
        if (!pdi_law_finite(g)) return g;
        if (!(g > 0.0)) return g < 0.0 ? pdi_law_between(law, resist, c, a, above, b, g) : b;
        a = b;
        above = g;
        b += g;
        if (c + reach > law->top) return b; /* no surface is richer than the metal */
    }
    return b;
}

PDI_FN double pdi_law_at_instant(pdi_law *law, const pdi_law_point *p, double t, double c)
{
    pdi_law one = *law;
    pdi_law_point point = *p;
    one.moments = 0;
    one.at.t = t;
    if (c < law->touch) one.limit = pd_min(one.limit, law->touch);
    if (c < p->end) one.limit = pd_min(one.limit, p->end); /* it ends there or earlier */
    point.from = point.seen = c;
    point.end = HUGE_VAL;
    double v = pdi_law_behind(&one, &point, c);
    law->at = one.at;
    return v;
}

PDI_FN double pdi_law_at(pdi_law *law, pdi_law_point *p, double c)
{
    double mean = 0.0;
    if (!law->moments || !(p->resist > 0.0)) return pdi_law_behind(law, p, c);
    for (int k = 0; k < law->moments; k++) mean += law->part[k] * pdi_law_at_instant(law, p, law->moment[k], c);
    return mean;
}

/* A slope is taken from a difference. This is the widest one over the concentration. */
#define PDI_LAW_WIDE 1e-6
/* Least one over the concentration. */
#define PDI_LAW_NARROW 1e-10
/* Behind a film a jump is a line as wide as R times the speed. Widest difference over this width. */
#define PDI_LAW_STEP 0.01

/* Behind a film a difference that changes the speed by less than this share is widened: it would be rounding. */
#define PDI_LAW_CHANGE 1e-8

/* The line that touches V at c. Its slope is taken below c: above c the law may be steeper, or end. Behind a film a
 * rising law gets a flat line; without a film it keeps its slope. */
static int pdi_law_touch(pdi_law *law, double c, pdi_law_point *p)
{
    double now = pdi_law_at(law, p, c), size = pd_max(c, PDI_LAW_LEAST * law->top), width = PDI_LAW_WIDE * size;
    if (!pdi_law_finite(now)) return 0;
    p->largest = pd_max(p->largest, now);
    if (p->resist < HUGE_VAL && p->resist > 0.0)
        width = pd_max(pd_min(width, PDI_LAW_STEP * p->resist * p->largest), PDI_LAW_NARROW * size);
    double other = c > width ? c - width : c + width, jump = p->beyond ? pd_min(p->pin, law->limit) : law->limit;
    if (!(p->resist > 0.0) && c > jump && other <= jump) other = c + width; /* the slope is none of the jump */
    double there = pdi_law_at(law, p, other);
    while (p->resist < HUGE_VAL && width < PDI_LAW_STEP * p->resist * p->largest &&
           fabs(there - now) < PDI_LAW_CHANGE * now) {
        width = pd_min(10.0 * width, PDI_LAW_STEP * p->resist * p->largest);
        other = c > width ? c - width : c + width;
        there = pdi_law_at(law, p, other);
    }
    if (!pdi_law_finite(there)) return 0;
    p->slope = (there - now) / (other - c);
    if (p->resist > 0.0) p->slope = pd_min(p->slope, 0.0);
    p->speed = now - p->slope * c;
    p->touch = c;
    return 1;
}

PDI_FN void pdi_law_tame(double most, pdi_law_point *p)
{
    if (p->pinned || p->slope <= most) return;
    p->speed += (p->slope - most) * p->touch;
    p->slope = most;
}

/* A jump lies within this share of its concentration. */
#define PDI_LAW_AROUND 1e-9
/* The speed falls at a jump by more than this share. */
#define PDI_LAW_DROP 1e-6

/* Pin the point to the jump down of V between a and b. 0: there is none, V is steep. Behind a film V jumps down where
 * a law that rises and falls gets a slower solution. */
static int pdi_law_pin(pdi_law *law, double a, double b, pdi_law_point *p)
{
    double before = pdi_law_at(law, p, a), behind = pdi_law_at(law, p, b);
    for (int k = 0; k < PDI_LAW_HALVINGS; k++) {
        double middle = a + 0.5 * (b - a);
        if (!(middle > a) || !(middle < b)) break;
        double v = pdi_law_at(law, p, middle);
        if (before - v > v - behind) {
            b = middle;
            behind = v;
        } else {
            a = middle;
            before = v;
        }
    }
    if (!(before - pd_max(behind, 0.0) > PDI_LAW_DROP * before)) return 0;
    p->pinned = 1;
    p->pin = a;
    p->ahead = before;
    p->behind = pd_max(behind, 0.0);
    p->largest = pd_max(p->largest, before);
    p->speed = p->slope = 0.0;
    return 1;
}

/* 1: the law jumps down at c, and the point is pinned there. */
static int pdi_law_jumps(pdi_law *law, double c, pdi_law_point *p)
{
    double a = c * (1.0 - PDI_LAW_AROUND), b = c * (1.0 + PDI_LAW_AROUND);
    if (p->resist > 0.0 || !(b > a)) return 0;
    double before = pdi_law_rate(law, a), behind = pdi_law_rate(law, b);
    if (!(before - pd_max(behind, 0.0) > PDI_LAW_DROP * before)) return 0;
    return pdi_law_pin(law, a, b, p);
}

/* The salt layer, and every other jump (theory, 11.6): the fluid stays at the jump while it needs a speed between those
 * before and behind it. */
PDI_FN int pdi_law_meet_pinned(pdi_law *law, double need, double near, pdi_law_point *p)
{
    if (need <= p->ahead + near && need >= p->behind - near) {
        p->speed = pd_min(pd_max(need, p->behind), p->ahead);
        p->slope = 0.0;
        return 1;
    }
    p->pinned = p->beyond = 0;
    p->low_c = p->low_v = 0.0;
    p->high_c = p->high_v = HUGE_VAL;
    if (need > p->ahead) { /* the metal gives less than would hold the fluid here: c falls */
        p->low_c = p->high_c = p->pin;
        p->high_v = need;
        pdi_law_touch(law, p->pin, p);
        return 0;
    }
    p->beyond = 1;
    p->low_c = p->pin; /* beyond the jump the metal still gives more */
    p->low_v = need;
    p->speed = p->behind;
    p->slope = 0.0;
    return 0;
}

PDI_FN int pdi_law_begin(pdi_law *law, double resist, double from, double end, double c, pdi_law_point *p)
{
    p->resist = resist;
    p->from = from <= c && c < end ? from : c;
    p->end = from <= c && c < end ? end : HUGE_VAL;
    p->seen = from <= c && c < end ? pd_min(end, law->top) : c;
    p->largest = p->low_v = 0.0;
    p->low_c = c;
    p->high_c = p->high_v = HUGE_VAL;
    p->pinned = p->beyond = 0;
    if (!(resist > 0.0) && c >= law->limit) { /* it may fall back to saturation */
        p->beyond = 1;
        p->pin = law->limit;
    }
    return pdi_law_jumps(law, c, p) || pdi_law_touch(law, c, p);
}

/* Where V meets the straight line between the two known points (low_c, low_v) and (high_c, high_v): the first meeting
 * before the end of the law, if there is one. NaN: the law is not finite. */
static double pdi_law_crossing(pdi_law *law, pdi_law_point *p)
{
    double a = p->low_c, b = p->high_c, asked_a = p->low_v, asked_b = p->high_v;
    double rise = (asked_b - asked_a) / (b - a), end = pdi_law_point_end(law, p, a, b);
    if (end > a && end < b && asked_a + rise * (end - a) > 0.0) {
        b = end;
        asked_b = asked_a + rise * (end - a);
    }
    double above = pdi_law_at(law, p, a) - asked_a, below = pdi_law_at(law, p, b) - asked_b;
    if (!pdi_law_finite(above) || !pdi_law_finite(below)) return above + below;
    if (!(above > 0.0)) return a;
    if (!(below < 0.0)) return b;
    if (!(p->resist > 0.0) && b <= end && b >= end) { /* what ends the law is a jump where it is positive just before */
        double last = b * (1.0 - PDI_LAW_AROUND);
        if (last > a && pdi_law_at(law, p, last) > asked_a + rise * (last - p->low_c) && pdi_law_pin(law, last, b, p))
            return b;
    }
    pdi_root_bracket s = {a, above, b, below, 0, 0};
    double c;
    while (s.b - s.a > 1e-14 * pd_max(fabs(s.b), fabs(s.a)) && pdi_root_bracket_get_next(&s, &c)) {
        double g = pdi_law_at(law, p, c) - (asked_a + rise * (c - p->low_c));
        if (!pdi_law_finite(g)) return g;
        pdi_root_bracket_update(&s, c, g);
    }
    if (s.b - s.a <= PDI_LAW_AROUND * s.b) pdi_law_pin(law, s.a, s.b, p);
    return s.b;
}

/* Where a rising law meets, above c, the straight line through (low_c, low_v) and (c, asked). */
static double pdi_law_ahead(pdi_law *law, pdi_law_point *p, double c, double asked)
{
    double rise = (asked - p->low_v) / (c - p->low_c), ahead = c;
    if (!(c > p->low_c) || !(rise > 0.0)) return c;
    double end = pdi_law_point_end(law, p, c, law->top);
    pdi_law_point beyond = *p;
    beyond.low_c = c;
    beyond.low_v = asked;
    for (int k = 0; k < PDI_LAW_ROUNDS; k++) {
        double given = pdi_law_at(law, p, ahead), next = c + (given - asked) / rise;
        if (!pdi_law_finite(given)) return given;
        if (next > end || next > law->top) return pd_min(end, law->top);
        if (next <= ahead) { /* beyond the meeting point, or there */
            beyond.high_c = ahead;
            beyond.high_v = asked + rise * (ahead - c);
            return ahead > c ? pdi_law_crossing(law, &beyond) : c;
        }
        ahead = next;
    }
    return ahead;
}

/* 1: V passes the speed `asked` within `close` of c. */
static int pdi_law_passes(pdi_law *law, pdi_law_point *p, double c, double asked, double close)
{
    return pdi_law_at(law, p, pd_max(c - close, 0.0)) >= asked && pdi_law_at(law, p, c + close) <= asked;
}

/* Where the next line touches V, after `asked` was compared with V at c. */
static double pdi_law_next(pdi_law *law, double c, double asked, double given, pdi_law_point *p)
{
    if (given >= asked) {
        pdi_law_point before = *p;
        p->low_c = c;
        p->low_v = asked;
        if (p->beyond && c < p->pin) { /* it has fallen back to the jump */
            p->beyond = 0;
            double a = p->pin * (1.0 - PDI_LAW_AROUND), b = p->pin * (1.0 + PDI_LAW_AROUND);
            if (p->resist > 0.0 ? pdi_law_pin(law, a, b, p) : pdi_law_jumps(law, p->pin, p)) return p->pin;
        }
        if (!(p->resist > 0.0) && !(p->high_c < HUGE_VAL)) return c;
        if (c >= p->high_c) p->high_c = p->high_v = HUGE_VAL; /* its neighbours have moved */
        if (p->high_c < HUGE_VAL) return pdi_law_crossing(law, p);
        return given > before.largest ? pdi_law_ahead(law, &before, c, asked) : c;
    }
    p->high_c = c;
    p->high_v = asked;
    if (c <= p->low_c && !(p->resist > 0.0)) return c; /* nothing is known below: Newton's method */
    if (c <= p->low_c) p->low_c = p->low_v = 0.0; /* fluid at 0 needs the speed 0 there */
    return c > 0.0 ? pdi_law_crossing(law, p) : c;
}

/* 1: the law rises somewhere between a and c. */
static int pdi_law_rises(pdi_law *law, double a, double c)
{
    double last = pdi_law_rate(law, a);
    while (a < c) {
        a = pdi_law_stride(law, a, c);
        double v = pdi_law_rate(law, a);
        if (v > last) return 1;
        last = v;
    }
    return 0;
}

PDI_FN double pdi_law_slowest(pdi_law *law, pdi_law_point *p, double a, double c)
{
    double from = pd_max(pd_min(a, c), 0.0), to = pd_max(a, c), slowest = HUGE_VAL;
    if (!(to > from) || !pdi_law_rises(law, from, to)) return HUGE_VAL;
    while (from < to) {
        from = pdi_law_stride(law, from, to);
        slowest = pd_min(slowest, pdi_law_at(law, p, from));
    }
    return slowest;
}

/* The first concentration on the way from the low side to c at which V is below the straight line between both points;
 * c: none. So metal does not lift its fluid across the end of a law, or across a slow part of it, in one step. */
static double pdi_law_way(pdi_law *law, pdi_law_point *p, double c, double asked)
{
    double a = p->low_c;
    if (!(asked > 0.0) || !(c > a) || !pdi_law_rises(law, a, c)) return c;
    double rise = (asked - p->low_v) / (c - a);
    for (a = pdi_law_stride(law, a, c); a < c; a = pdi_law_stride(law, a, c))
        if (pdi_law_at(law, p, a) < p->low_v + rise * (a - p->low_c)) return a;
    return c;
}

PDI_FN int pdi_law_meet(pdi_law *law, double c, double near, double close, pdi_law_point *p)
{
    double asked = p->speed + p->slope * c;
    c = pd_max(c, 0.0);
    double given = pdi_law_at(law, p, c), way = p->resist > 0.0 ? pdi_law_way(law, p, c, asked) : c;
    if (!pdi_law_finite(given)) return -1;
    p->largest = pd_max(p->largest, given);
    if (way < c) {
        asked = p->low_v + (asked - p->low_v) / (c - p->low_c) * (way - p->low_c);
        given = 0.0;
        c = way;
    } else if (asked >= 0.0) { /* not even within the tolerance is metal deposited, or dissolved beyond the end */
        if (given > 0.0 && fabs(asked - given) <= near) return 1;
        if (pdi_law_passes(law, p, c, asked, close)) return 1;
    }
    double next = pdi_law_next(law, c, asked, given, p);
    if (!pdi_law_finite(next)) return -1;
    if (p->pinned) return 0;
    if (asked < 0.0 && !(given > 0.0)) { /* at rest */
        p->speed = p->slope = 0.0;
        return 0;
    }
    return pdi_law_touch(law, next, p) ? 0 : -1;
}
