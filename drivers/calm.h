/* calm: threads that wait sleep, of all programs. Behind pdcorr.h. */
#ifndef PDCORR_CALM_H
#define PDCORR_CALM_H
#include <stdlib.h>
#if !defined(_WIN32) && !defined(__wasi__)
#include <unistd.h>
#endif

/* The runtime has read its environment before main, so the program starts itself once more, unless the caller has
 * chosen. Why: core/par.h. */
static void calm_threads(char **argv)
{
#if defined(_OPENMP) && !defined(_WIN32) && !defined(__wasi__)
    if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT") || getenv("KMP_BLOCKTIME")) return;
    if (setenv("OMP_WAIT_POLICY", PD_OMP_WAIT_POLICY, 1) == 0 && setenv("GOMP_SPINCOUNT", PD_GOMP_SPINCOUNT, 1) == 0)
        execvp(argv[0], argv); /* it comes back where it failed, and all goes on as it is */
#else
    (void)argv;
#endif
}

#endif
