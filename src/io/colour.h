/* colour: colour maps for fields, computed in OKLab (Ottosson 2020), where equal distances look equally different. */
#ifndef PD_COLOUR_H
#define PD_COLOUR_H
#include "core/config.h"

/* Colour maps. */
typedef enum pd_colour_map {
    PD_COLOUR_MAP_SEQUENTIAL = 0, /* dark violet over teal to light yellow */
    PD_COLOUR_MAP_DIVERGING = 1,  /* blue over near white (the middle) to red, for signed fields */
    PD_COLOUR_MAP_LABELS = 2,     /* a colour for each whole number: grains, kinds */
    PD_COLOUR_MAP_GREY = 3,       /* dark to light grey */
    PD_COLOUR_MAP_VIRIDIS = 4     /* through the colours of the map of that name (van der Walt and Smith 2015) */
} pd_colour_map;

#ifdef PDI_APP_INTERNAL
#define PDI_COLOUR_TABLE_SIZE 256 /* colours of a table */
/* Fill table[PDI_COLOUR_TABLE_SIZE] with the colours 0xRRGGBB of a map from low to high, at equal distances in OKLab.
 * Not for PD_COLOUR_MAP_LABELS. */
PDI_FN void pdi_colour_fill_table(pd_colour_map map, uint32_t *table);
/* Colour 0xRRGGBB of a whole number of either sign, for PD_COLOUR_MAP_LABELS: hue by the golden angle, one of three
 * lightnesses by the number modulo 3. So neighbours differ in both. */
PDI_FN uint32_t pdi_colour_get_label_colour(int64_t number);
/* Colour 0xRRGGBB of curve k >= 0 of a plot (Okabe and Ito 2008: distinguishable for colour-blind readers); the six
 * colours repeat. */
PDI_FN uint32_t pdi_colour_get_series_colour(int k);
#endif

#endif
