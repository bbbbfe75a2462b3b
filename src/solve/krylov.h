/* krylov: iterative solvers for A x = b over callbacks; they know no physics.
 *
 * All vectors have desc.n entries and every sum runs over all of them. Work vectors start as zeros, so entries that
 * the callbacks never write (ghosts, solid nodes) stay zero when they are zero in b and x.
 */
#ifndef PD_KRYLOV_H
#define PD_KRYLOV_H
#include "core/arena.h"
#include "lattice/span.h"
#include <math.h>

/* y = A x or y = M^-1 x; x and y never alias. */
typedef void (*pd_apply_fn)(void *user, const double *x, double *y);

/* Times that a basis may grow. */
#define PD_KRYLOV_MORE 150

typedef enum pd_krylov_method {
    PD_KRYLOV_GMRES = 0, /* any operator; restart + 3 vectors (flexible: 2 restart + 3; lean: one less) */
    PD_KRYLOV_CG = 1     /* symmetric positive (semi-)definite operator and preconditioner; 5 vectors */
} pd_krylov_method;

typedef enum pd_krylov_precision {
    PD_KRYLOV_DOUBLE = 0,
    PD_KRYLOV_SINGLE = 1,
    PD_KRYLOV_INTEGER = 2 /* 16 bits times a scale that 64 entries share */
} pd_krylov_precision;

typedef struct pd_krylov_desc {
    const char *of;     /* what is solved, "flow", for messages of a solve. Borrowed; NULL: "krylov" */
    pd_krylov_method method;
    int64_t n;          /* entries of a vector */
    int64_t first, end; /* all entries of b, x and what the callbacks make are zero before `first` and from `end` on,
                         * and those of earlier solves were: sums leave them out. end 0: all n */
    const pd_spans *spans; /* the basis of GMRES takes their nodes only, in `components` parts of a vector: all others
                            * are zero in b and x. n = components times spans->total. Borrowed; NULL: all n entries */
    int components;
    int restart;        /* [-] GMRES: basis vectors; 0: 30 */
    int least;          /* [-] GMRES: basis vectors that there is room for at the start of a solve, which takes more of
                         * them as it needs them; 0: restart */
    int most;           /* [-] GMRES: it takes memory for up to so many of them, a few at a time, before it restarts; 0:
                         * restart. Where memory is refused it restarts */
    pd_arena *arena;    /* GMRES: lends what the basis grows by for the rest of a solve, as far as it has room.
                         * Borrowed; NULL: all is allocated */
    int fixed;          /* 1: GMRES restarts at `restart` whatever `most` is, and not before it: PD_ERR_MEMORY where
                         * memory for that is refused */
    int flexible;       /* 1: GMRES keeps the preconditioned basis. Needed when the preconditioner is not linear to
                         * rounding in double precision, as a multigrid cycle in single precision on a stiff operator */
    pd_krylov_precision compressed; /* of the basis of GMRES. Residuals stay double; a cycle gains up to six digits in
                         * single precision (Aliaga, Anzt, Gruetzmacher, Quintana-Orti, Tomas 2022), up to three as
                         * integers */
    int max_iterations; /* 0: 200 */
    double rtol;        /* [-] stop at |b - A x| <= max(rtol |b|, atol); 0: 1e-8 */
    double atol;        /* [unit of b] */
    const double *diagonal; /* [n] [unit of b over that of x] CG: of A, about. A direction whose stiffness is rounding
                         * beside it has none. Borrowed; NULL: only negative ones are seen */
    int zero_guess;     /* 1: the x passed in is ignored and taken as 0, which saves one application */
    int lean;           /* 1: GMRES with zero_guess, not flexible: x is the other work vector until the solve ends, and
                         * callbacks may leave anything in the vector that they are given, const in name alone */
    int trusting;       /* 1: lean GMRES takes the residual that its recurrence gives for the true one once that meets
                         * the tolerance, which saves one application. For callers that check what x leads to */
} pd_krylov_desc;

/* Between solves first, end, fixed, max_iterations, rtol, atol, diagonal and zero_guess of desc may be changed. */
typedef struct pd_krylov {
    pd_krylov_desc desc; /* defaults filled in */
    int vectors;         /* work vectors */
    double *work;        /* [vectors][n] [unit of b or x] */
    int64_t length;      /* entries of a vector of the basis */
    int base;            /* GMRES: columns that the basis has room for before it grows, in its form of now */
    int shift;           /* GMRES, lean: vectors in front of the basis that an iterate takes; 0: none does yet */
    int basis_vectors;
    int64_t stride;      /* entries of double or single precision from one vector of the basis to the next */
    int64_t built;       /* of the basis without what has grown */
    double *basis;       /* GMRES: [basis_vectors][length] [-] basis, then (flexible) the preconditioned one; or NULL */
    float *single;       /* the same when compressed; integers, and then their scales, stand in it, too */
    double *small;       /* [-] GMRES: Hessenberg matrix, rotations, right-hand side, coefficients */
    int grow;            /* GMRES: vectors that the basis grows by, as few as `more` has room for; 0: it does not */
    int columns, few;    /* GMRES: that the Hessenberg matrix has room for, and had when it was built */
    void *more[PD_KRYLOV_MORE]; /* GMRES: what has grown, `grow` vectors each as in the basis (flexible: twice) */
    int chunks;          /* of them */
    int lent[PD_KRYLOV_MORE]; /* 1: by the arena */
} pd_krylov;

typedef struct pd_krylov_result {
    int iterations;
    int applies, precond_applies;
    double residual0, residual; /* [unit of b] true |b - A x| of the guess and of the returned x
                                 * (trusting: that of the recurrence) */
    int converged;
} pd_krylov_result;

#ifdef PDI_INTERNAL
/* Tolerances of the linear solves of Newton's method. */
#define PDI_KRYLOV_LOOSE 0.1
#define PDI_KRYLOV_TIGHT 1e-3
/* How well a linear system is solved when the last step has left that share of the residual (Eisenstat and Walker 1996,
 * choice 2). */
static inline double pdi_krylov_forcing(double left)
{
    return pdi_min(PDI_KRYLOV_LOOSE, pdi_max(PDI_KRYLOV_TIGHT, 0.9 * left * left));
}
/* The same for equations that bend within a step, so that squares promise too much (their choice 1). */
static inline double pdi_krylov_forcing_first(double left)
{
    return pdi_min(PDI_KRYLOV_LOOSE, pdi_max(PDI_KRYLOV_TIGHT, 0.9 * left));
}
/* Allocate all work. PD_ERR_ARGUMENT: a knob is out of range. */
PDI_FN pd_status pdi_krylov_build(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov);
/* The same but for the vectors, pdi_krylov_list: an arena lends them for each solve. */
PDI_FN pd_status pdi_krylov_prepare(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov);
PDI_FN void pdi_krylov_free(pd_ctx *ctx, pd_krylov *krylov);
/* The least norm [unit of b] that has digits: squares below the least normal number over its rounding have none. A
 * residual below it counts as zero. */
PDI_FN double pdi_krylov_least(void);
/* Give back what has grown and was allocated; the arena has the rest back from the end of each solve on. */
PDI_FN void pdi_krylov_trim(pd_ctx *ctx, pd_krylov *krylov);
/* GMRES that was built flexible, and has not grown: switch that off, which leaves room for twice the columns, or on. */
PDI_FN void pdi_krylov_pair(pd_krylov *krylov, int flexible);
/* Lend arrays of `list` in place of vectors of a basis that is not lent, where it is of single precision, not flexible,
 * and `least` vectors are left; then with more of them by pdi_krylov_pair. 0: they are not lent. */
PDI_FN int pdi_krylov_cede(pd_ctx *ctx, pd_krylov *krylov, pd_arena *arena, pdi_list_fn list, void *object, int least);
/* What was lent so goes back. */
PDI_FN pd_status pdi_krylov_regain(pd_ctx *ctx, pd_krylov *krylov, pd_arena *arena, pdi_list_fn list, void *object,
                                   pd_status status);
/* Solve A x = b, preconditioned from the right (CG: symmetrically). precond NULL: none; user goes to all callbacks.
 * x: guess in, solution out; result may be NULL. Allocates nothing but what `most` lets it.
 * PD_NOT_CONVERGED: iteration limit or stagnation; x is the best iterate seen. PD_ERR_DIVERGED: NaN or infinity came
 * out of a callback, or CG met an indefinite operator or a direction without stiffness, which is vector 1 of the work;
 * x is the best iterate seen. PD_ERR_ARGUMENT: b or x is not
 * finite.
 * Sources: Saad 2003 (GMRES alg. 9.5, 9.6; CG alg. 9.1), Notay 2000 (flexible CG). */
PDI_FN pd_status pdi_krylov_solve(pd_ctx *ctx, pd_krylov *krylov, pd_apply_fn apply, pd_apply_fn precond, void *user,
                                  const double *b, double *x, pd_krylov_result *result);

/* Vectors of a pd_krylov, and one without them, which can be counted. */
PDI_FN void pdi_krylov_list(pdi_owner *owner, void *object);
PDI_FN pd_status pdi_krylov_plan(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov);
#endif

#endif
