/* machine: clocks, memory, processors and the terminal of the programs. Include it before any other header. */
#ifndef PDCORR_MACHINE_H
#define PDCORR_MACHINE_H
#include <math.h>
#include <time.h>
#if defined(_WIN32)
#include <windows.h>
#include <psapi.h>
#include <shellapi.h>
#include <io.h>
#include <stdlib.h>
#elif defined(__wasi__)
#include <unistd.h>
#else
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

#if defined(_WIN32)
/* [s] on the wall */
static double wall_seconds(void)
{
    LARGE_INTEGER now, rate;
    return QueryPerformanceCounter(&now) && QueryPerformanceFrequency(&rate)
               ? (double)now.QuadPart / (double)rate.QuadPart : 0.0;
}

/* [s] of the processor */
static double cpu_seconds(void)
{
    const double high = 4294967296.0, tick = 1e-7;
    FILETIME begin, end, kernel, user;
    if (!GetProcessTimes(GetCurrentProcess(), &begin, &end, &kernel, &user)) return 0.0;
    return tick * (high * ((double)kernel.dwHighDateTime + (double)user.dwHighDateTime) +
                   (double)kernel.dwLowDateTime + (double)user.dwLowDateTime);
}

/* [MB] at most, since the program started. */
static double peak_memory(void)
{
    PROCESS_MEMORY_COUNTERS use;
    return GetProcessMemoryInfo(GetCurrentProcess(), &use, sizeof use) ? (double)use.PeakWorkingSetSize / 1048576.0
                                                                       : 0.0;
}

static long processors(void)
{
    SYSTEM_INFO info;
    GetSystemInfo(&info);
    return (long)info.dwNumberOfProcessors;
}

static int is_terminal(void) { return _isatty(2); }

/* The arguments as UTF-8, which the library takes; argv where that fails. They stay until the program ends. */
static char **arguments(int *argc, char **argv)
{
    int count = 0;
    LPWSTR *wide = CommandLineToArgvW(GetCommandLineW(), &count);
    char **narrow = wide ? (char **)calloc((size_t)count + 1, sizeof *narrow) : NULL;
    for (int k = 0; k < count && narrow; k++) {
        int size = WideCharToMultiByte(CP_UTF8, 0, wide[k], -1, NULL, 0, NULL, NULL);
        narrow[k] = size > 0 ? (char *)malloc((size_t)size) : NULL;
        if (!narrow[k]) return argv;
        WideCharToMultiByte(CP_UTF8, 0, wide[k], -1, narrow[k], size, NULL, NULL);
    }
    if (!narrow) return argv;
    LocalFree(wide);
    SetConsoleOutputCP(CP_UTF8);
    *argc = count;
    return narrow;
}
#else
static double seconds(clockid_t clock)
{
    struct timespec t;
    return clock_gettime(clock, &t) == 0 ? (double)t.tv_sec + 1e-9 * (double)t.tv_nsec : 0.0;
}

static double wall_seconds(void) { return seconds(CLOCK_MONOTONIC); }

static int is_terminal(void) { return isatty(2); }

#if defined(__wasi__) /* one thread, and memory that never shrinks */
static double cpu_seconds(void) { return NAN; }

static double peak_memory(void) { return (double)__builtin_wasm_memory_size(0) / 16.0; }

static long processors(void) { return 1; }
#else
static double cpu_seconds(void) { return seconds(CLOCK_PROCESS_CPUTIME_ID); }

static long processors(void) { return sysconf(_SC_NPROCESSORS_ONLN); }

/* [MB] at most, since the program started. */
static double peak_memory(void)
{
    struct rusage use;
#ifdef __APPLE__
    const double unit = 1048576.0;
#else
    const double unit = 1024.0;
#endif
    return getrusage(RUSAGE_SELF, &use) == 0 ? (double)use.ru_maxrss / unit : 0.0;
}
#endif
#endif

/* Characters of a line of the terminal. */
static int terminal_width(void)
{
#if defined(TIOCGWINSZ) && !defined(__wasi__)
    struct winsize size;
    if (ioctl(2, TIOCGWINSZ, &size) == 0 && size.ws_col > 1) return size.ws_col;
#endif
    return 80;
}

#endif
