/* progress: see progress.h */
#include "io/progress.h"
#include <stdio.h>

#define PDI_PROGRESS_BAR_LENGTH 12 /* [-] characters of the bar */

PDI_FN void pdi_progress_format_duration(double seconds, char *text, size_t size)
{
    if (!(seconds >= 0 && seconds < 3e11)) {
        snprintf(text, size, "?");
        return;
    }
    /* Limits are those after rounding, so that "60.0 s" and "2 min 60 s" cannot appear. */
    if (seconds < 9.995) snprintf(text, size, "%.2f s", seconds);
    else if (seconds < 59.95) snprintf(text, size, "%.1f s", seconds);
    else if (seconds < 3599.5) {
        int whole = (int)(seconds + 0.5);
        snprintf(text, size, "%d min %02d s", whole / 60, whole % 60);
    } else {
        int64_t minutes = (int64_t)(seconds / 60 + 0.5);
        long hours = (long)(minutes / 60);
        if (hours < 100) snprintf(text, size, "%ld h %02d min", hours, (int)(minutes % 60));
        else snprintf(text, size, "%ld d %ld h", hours / 24, hours % 24);
    }
}

PDI_FN void pdi_progress_format_line(double fraction, double elapsed, const char *label, char *line, size_t size)
{
    char bar[PDI_PROGRESS_BAR_LENGTH + 1], spent[32], left[32];
    if (!(fraction > 0)) fraction = 0;
    if (fraction > 1) fraction = 1;
    int filled = (int)(fraction * PDI_PROGRESS_BAR_LENGTH);
    for (int i = 0; i < PDI_PROGRESS_BAR_LENGTH; i++) bar[i] = i < filled ? '#' : '.';
    bar[PDI_PROGRESS_BAR_LENGTH] = 0;
    pdi_progress_format_duration(elapsed, spent, sizeof spent);
    if (fraction >= 1) snprintf(line, size, "%s [%s] 100.0 %%  %s", label, bar, spent);
    else if (fraction < 1e-3 || !(elapsed >= 1))
        snprintf(line, size, "%s [%s] %5.1f %%  %s", label, bar, 100 * fraction, spent);
    else {
        pdi_progress_format_duration(elapsed * (1 - fraction) / fraction, left, sizeof left);
        snprintf(line, size, "%s [%s] %5.1f %%  %s, %s left", label, bar, 100 * fraction, spent, left);
    }
}
