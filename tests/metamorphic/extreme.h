/* extreme: a scene with numbers far from those of any laboratory. It has to end with an answer or a message all the
 * same. */
#ifndef METAMORPHIC_EXTREME_H
#define METAMORPHIC_EXTREME_H
#include "record.h"
#include "compare.h"

/* Lengths by up to 1e9, times by up to 1e6, either way, by themselves or with all that is made of them; a third of the
 * other quantities by up to 1e6. */
void extreme_scene(const scene *x, uint32_t seed, scene *y);
/* A run that crashes or hangs, values that are no numbers, and failures without a message are findings. */
void extreme_check(const scene *x, const record *r, finding *f);

#endif
