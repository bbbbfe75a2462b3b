/* config: compile-time switches. PD_DIM is the only required one.
 *
 *   PD_DIM                 1, 2 or 3: the space dimension (required)
 *   PDCORR_IMPLEMENTATION  define in exactly one C file per PD_DIM
 *   PDCORR_STATIC          the same, private to this file: what it does not call is neither compiled nor linked
 *   PDCORR_NO_SCENE        leaves out scene and run of pdcorr_app.h
 *   PDCORR_NO_MODEL        leaves out what scenes are made of: setup, physics; and scene, run
 *   PDCORR_NO_SOLID        leaves out mechanics: solid, couple/solid_coupling, and those four
 *   PDCORR_NO_CHEMISTRY    leaves out species and reactions: chemistry, react, and those four
 *   PDCORR_NO_POTENTIAL    leaves out electrodes and the electric potential: potential, and those four
 *   PDCORR_NO_PHYSICS      leaves out flow, chemistry, transport, react, solid, metal, potential, couple, and those
 *                          four; kernels (core, lattice, solve) stay
 *   PD_API                 what stands before public functions, such as "extern" with an attribute of a shared library;
 *                          not beside PDCORR_STATIC
 *   _OPENMP                set by the compiler (-fopenmp); without it the same bits come out
 */
/* The include guards would silently skip a second dimension. */
#if (defined(PDI_DIM_IS_1) && PD_DIM != 1) || (defined(PDI_DIM_IS_2) && PD_DIM != 2) || \
    (defined(PDI_DIM_IS_3) && PD_DIM != 3)
#error "pdcorr: this file includes the header with two values of PD_DIM: one source file for each dimension is expected"
#endif

#ifndef PD_CONFIG_H
#define PD_CONFIG_H

/* `make install` takes the version of pdcorr.pc and of the CMake files from these three lines. */
#define PD_VERSION_MAJOR 0
#define PD_VERSION_MINOR 1
#define PD_VERSION_PATCH 0
/* The value of a macro as a string literal. */
#define PDI_STRINGIFY2(number) #number
#define PDI_STRINGIFY(number) PDI_STRINGIFY2(number)
#define PD_VERSION \
    PDI_STRINGIFY(PD_VERSION_MAJOR) \
    "." PDI_STRINGIFY(PD_VERSION_MINOR) "." PDI_STRINGIFY(PD_VERSION_PATCH) /* "0.1.0" */

#ifndef PD_DIM
#error "pdcorr: define PD_DIM as 1, 2 or 3 before the header"
#endif
#if PD_DIM < 1 || PD_DIM > 3
#error "pdcorr: PD_DIM must be 1, 2 or 3"
#endif
/* PDI_AXES_HINT: end of the error message about more values than axes: which program has more dimensions. */
#if PD_DIM == 1
#define PDI_DIM_IS_1
#define PDI_AXES_HINT ", one for each axis: pd2d and pd3d run scenes in 2D and 3D"
#elif PD_DIM == 2
#define PDI_DIM_IS_2
#define PDI_AXES_HINT ", one for each axis: pd3d runs scenes in 3D"
#else
#define PDI_DIM_IS_3
#define PDI_AXES_HINT ", one for each axis"
#endif

#if defined(PDCORR_IMPLEMENTATION) && defined(PDCORR_STATIC)
#error "pdcorr: define PDCORR_IMPLEMENTATION or PDCORR_STATIC, not both: one offers to other files what the other hides"
#endif

#include <stddef.h>
#include <stdint.h>

/* Every public function carries the dimension in its linked name (pd_grid_build -> pd_grid_build_2d):
 * two dimensions live in one program, and a mismatch between files is a link error. */
#define PDI_PASTE2(name, dim) name##_##dim##d
#define PDI_PASTE1(name, dim) PDI_PASTE2(name, dim)
#define PD_NAME(name) PDI_PASTE1(name, PD_DIM)

/* PDI_PRIVATE: a static function without the compiler warning when it is unused. */
#if defined(__GNUC__) || defined(__clang__)
#define PDI_PRIVATE static __attribute__((unused))
#else
#define PDI_PRIVATE static
#endif

#if defined(PDCORR_STATIC) && defined(PD_API)
#error "pdcorr: define PDCORR_STATIC or PD_API, not both: one hides what the other offers"
#endif
#ifdef PDCORR_STATIC
#define PD_API PDI_PRIVATE
#elif defined(PD_API)
#elif defined(__cplusplus)
#define PD_API extern "C"
#else
#define PD_API extern
#endif
/* PD_RESTRICT: C99 restrict, also in C++. */
#ifdef __cplusplus
#define PD_RESTRICT __restrict
#else
#define PD_RESTRICT restrict
#endif

/* PDI_SPLIT: the development build compiles each src file by itself; PDI_PUBLIC_ONLY: those of pdcorr_app.h, which see
 * of pdcorr.h what all programs see. */
#if (defined(PDCORR_IMPLEMENTATION) || defined(PDCORR_STATIC) || defined(PDI_SPLIT)) && !defined(PDI_PUBLIC_ONLY)
#define PDI_INTERNAL 1
#endif
#ifdef PDI_SPLIT
#define PDI_APP_INTERNAL 1
#endif
#ifdef PDI_SPLIT
#ifdef __cplusplus
#define PDI_FN extern "C"
#else
#define PDI_FN extern
#endif
#elif defined(PDCORR_STATIC) || defined(PDCORR_NO_SCENE) || defined(PDCORR_NO_MODEL) || \
    defined(PDCORR_NO_SOLID) || defined(PDCORR_NO_CHEMISTRY) || defined(PDCORR_NO_POTENTIAL) || \
    defined(PDCORR_NO_PHYSICS)
#define PDI_FN PDI_PRIVATE
#else
#define PDI_FN static
#endif

/* PDI_COLD: modules off the hot paths are compiled with less optimisation, where the compiler has a pragma for that. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__INTEL_COMPILER) && defined(__OPTIMIZE__) && \
    !defined(__OPTIMIZE_SIZE__)
#define PDI_COLD
#endif

/* PDI_OPTIMISE_SIZE: WebAssembly: modules off the hot paths are optimised for size, since programs are sent over a
 * network. */
#if defined(__clang__) && defined(__wasm__)
#define PDI_OPTIMISE_SIZE
#pragma clang diagnostic ignored "-Wpragma-clang-attribute" /* a module may have no function in a dimension */
#endif

/* PDI_COLD_BEGIN .. PDI_COLD_END: a region of functions off the hot paths, such as those that build an object. */
#ifdef PDI_COLD
#define PDI_COLD_BEGIN _Pragma("GCC push_options") _Pragma("GCC optimize (\"Og\")")
#define PDI_COLD_END _Pragma("GCC pop_options")
#elif defined(PDI_OPTIMISE_SIZE)
#define PDI_COLD_BEGIN _Pragma("clang attribute push (__attribute__((minsize)), apply_to = function)")
#define PDI_COLD_END _Pragma("clang attribute pop")
#else
#define PDI_COLD_BEGIN
#define PDI_COLD_END
#endif

/* PD_PRINTF_LIKE(f, a): the compiler checks arguments from number a on against the format in argument f. */
#if defined(__GNUC__) || defined(__clang__)
#define PD_PRINTF_LIKE(f, a) __attribute__((format(printf, f, a)))
#else
#define PD_PRINTF_LIKE(f, a)
#endif

/* PDI_INLINE: forced inlining of inner loops, which are specialised for constant arguments of their callers. Without
 * optimisation nothing is specialised, and inlining would only cost compile time. */
#ifdef __OPTIMIZE__
#define PDI_INLINE static inline __attribute__((always_inline))
#else
#define PDI_INLINE static inline
#endif

/* Maximum and minimum of two numbers; of a number and NaN the number, as fmax and fmin, whose calls cost ten times as
 * much. */
PDI_INLINE double pd_max(double a, double b) { return a >= b || b != b ? a : b; }
PDI_INLINE double pd_min(double a, double b) { return a <= b || b != b ? a : b; }

#ifdef PDI_INTERNAL
/* PDI_INLINE_HOT: forced inlining, except where code is optimised for size: there all callers share one copy. */
#ifdef PDI_OPTIMISE_SIZE
#define PDI_INLINE_HOT static __attribute__((noinline))
#else
#define PDI_INLINE_HOT PDI_INLINE
#endif

/* PDI_NO_VECTORISE: a function without vectorisation: the copy of an inner loop for trip counts below the vector
 * length. */
#ifdef PDI_COLD
#define PDI_NO_VECTORISE static __attribute__((noinline, noclone, optimize("no-tree-vectorize")))
#else
#define PDI_NO_VECTORISE static
#endif

/* PDI_NOINLINE: no inlining and no cloning: one copy for all callers, since the call costs nothing beside the work. */
#if defined(__clang__)
#define PDI_NOINLINE __attribute__((noinline))
#elif defined(__GNUC__)
#define PDI_NOINLINE __attribute__((noinline, noclone))
#else
#define PDI_NOINLINE
#endif
#endif

#endif
