/* symbol: what a linear step does to every wave, from what it does to a single node.
 *
 * On a periodic box that is wider than the step reaches, the response to an impulse holds all of a linear operator: its
 * symbol at the wave vector k is the sum of the response times exp(-i k.x). A step of a Runge-Kutta method multiplies
 * the wave by a polynomial of dt times the symbol, a small matrix where there are several fields.
 */
#ifndef STABILITY_SYMBOL_H
#define STABILITY_SYMBOL_H
#include <complex.h>

enum { SYMBOL_FIELDS = PD_DIM + 2, SYMBOL_WAVES = PD_DIM == 1 ? 512 : PD_DIM == 2 ? 48 : 16, SYMBOL_SQUARES = 22 };

#define SYMBOL_SLACK 2e-5 /* [-] by which a spectral radius may exceed 1: that of 2^22 steps of bounded growth */

typedef double complex symbol_matrix[SYMBOL_FIELDS * SYMBOL_FIELDS];

typedef struct symbol {
    int fields;
    int waves;                         /* in the list */
    double complex *value;             /* [waves][fields][fields] [1/s] */
    double complex turn[SYMBOL_WAVES]; /* exp(-2 pi i p/SYMBOL_WAVES) */
} symbol;

/* Wave vectors of the list: SYMBOL_WAVES along every axis, one of each pair k, -k along the first. */
static int symbol_count(void)
{
    int count = SYMBOL_WAVES / 2 + 1;
    for (int d = 1; d < PD_DIM; d++) count *= SYMBOL_WAVES;
    return count;
}

/* Whole numbers j of wave `wave`: k = 2 pi j / SYMBOL_WAVES. */
static void symbol_wave(int wave, int *j)
{
    int n = SYMBOL_WAVES / 2 + 1;
    for (int d = 0; d < PD_DIM; d++) {
        j[d] = wave % n;
        wave /= n;
        n = SYMBOL_WAVES;
    }
}

static int symbol_build(symbol *s, int fields)
{
    s->fields = fields;
    s->waves = symbol_count();
    for (int p = 0; p < SYMBOL_WAVES; p++) {
        double phase = 6.283185307179586 * p / SYMBOL_WAVES;
        s->turn[p] = cos(phase) - I * sin(phase);
    }
    s->value = (double complex *)calloc((size_t)(s->waves * fields * fields), sizeof *s->value);
    return s->value != NULL;
}

static void symbol_free(symbol *s) { free(s->value); }

/* Adds the response `value` of field a at the offset n [nodes] to an impulse of field b. */
static void symbol_add(symbol *s, int a, int b, const int *n, double value)
{
    if (!(fabs(value) > 0.0)) return;
    for (int w = 0; w < s->waves; w++) {
        int j[PD_DIM], phase = 0;
        symbol_wave(w, j);
        for (int d = 0; d < PD_DIM; d++) phase += j[d] * n[d];
        phase = (phase % SYMBOL_WAVES + SYMBOL_WAVES) % SYMBOL_WAVES;
        s->value[(w * s->fields + a) * s->fields + b] += value * s->turn[phase];
    }
}

static void symbol_multiply(int n, const double complex *a, const double complex *b, double complex *out)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double complex sum = 0.0;
            for (int k = 0; k < n; k++) sum += a[i * n + k] * b[k * n + j];
            out[i * n + j] = sum;
        }
}

/* Spectral radius, by squaring: |G^(2^q)|^(1/2^q). */
static double symbol_radius(int n, const double complex *matrix)
{
    symbol_matrix g, next;
    double size = 0.0;
    memcpy(g, matrix, (size_t)(n * n) * sizeof *g);
    for (int q = 0;; q++) {
        double norm = 0.0;
        for (int i = 0; i < n * n; i++) norm = fmax(norm, cabs(g[i]));
        if (!(norm > 0.0)) return 0.0;
        size += log(norm) / pow(2.0, q);
        if (q == SYMBOL_SQUARES) return exp(size);
        for (int i = 0; i < n * n; i++) g[i] /= norm;
        symbol_multiply(n, g, g, next);
        memcpy(g, next, (size_t)(n * n) * sizeof *g);
    }
}

/* 1 when a step dt [s] of the method of `stages` stages lets no wave grow: 1 + z, or 1 + z + z^2/2 + z^3/6. */
static int symbol_stable(const symbol *s, int stages, double dt)
{
    int n = s->fields;
    for (int w = 0; w < s->waves; w++) {
        symbol_matrix z, g, next;
        for (int i = 0; i < n * n; i++) z[i] = dt * s->value[w * n * n + i];
        for (int i = 0; i < n * n; i++) g[i] = i % (n + 1) == 0;
        for (int stage = stages; stage > 0; stage--) { /* Horner's scheme */
            symbol_multiply(n, z, g, next);
            for (int i = 0; i < n * n; i++) g[i] = next[i] / stage + (i % (n + 1) == 0);
        }
        if (!(symbol_radius(n, g) <= 1.0 + SYMBOL_SLACK)) return 0;
    }
    return 1;
}

/* Longest stable step [s], by bisection from `guess` [s]. */
static double symbol_limit(const symbol *s, int stages, double guess)
{
    double low = guess, high = guess;
    for (int k = 0; k < 40 && !symbol_stable(s, stages, low); k++) low *= 0.5;
    for (int k = 0; k < 40 && symbol_stable(s, stages, high); k++) high *= 2.0;
    while (high - low > 1e-4 * high) {
        double middle = 0.5 * (low + high);
        if (symbol_stable(s, stages, middle)) low = middle;
        else high = middle;
    }
    return low;
}

#endif
