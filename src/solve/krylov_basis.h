/* krylov_basis: settings and memory of a Krylov solver: work vectors, and of GMRES the basis, in double or single
 * precision or as integers, which may grow in chunks and lend its memory to preconditioners.
 */
#ifndef PD_KRYLOV_BASIS_H
#define PD_KRYLOV_BASIS_H
#include "core/arena.h"
#include "lattice/active_range.h"
#include <math.h>

/* Operator y = A x or preconditioner y = M^-1 x; x and y never alias. */
typedef void (*pd_apply_fn)(void *user, const double *x, double *y);

/* Chunks by which a basis may grow at most. */
#define PD_KRYLOV_MAX_CHUNKS 150

typedef enum pd_krylov_method {
    PD_KRYLOV_GMRES = 0, /* any operator; restart + 3 vectors (flexible: 2 restart + 3; lean: one less) */
    PD_KRYLOV_CG = 1     /* symmetric positive (semi-)definite operator and preconditioner; 5 vectors */
} pd_krylov_method;

/* Storage of the basis of GMRES. */
typedef enum pd_krylov_precision {
    PD_KRYLOV_DOUBLE = 0,
    PD_KRYLOV_SINGLE = 1,
    PD_KRYLOV_INT16 = 2 /* 16-bit integers times a scale for 64 entries */
} pd_krylov_precision;

typedef struct pd_krylov_desc {
    const char *equations; /* name of the equations, "flow", for messages. Borrowed; NULL: "krylov" */
    pd_krylov_method method;
    int64_t n;          /* entries of a vector */
    int64_t first, end; /* all entries of b, x and the results of callbacks are zero before `first` and from `end` on,
                         * in earlier solves, too: sums omit them. Both 0: all n */
    const pd_active_ranges
        *spans;          /* node ranges that the basis of GMRES stores, in each component of a vector: all others are
                          * zero in b and x. n = components times spans->total. Borrowed; NULL: all n entries */
    int components;      /* of a vector field, with spans */
    int restart;         /* [-] GMRES: basis vectors before a restart; 0: 30 */
    int initial_vectors; /* [-] GMRES: basis vectors that are allocated at the start of a solve; more are added when
                          * needed; 0: restart */
    int max_vectors;     /* [-] GMRES: the basis grows up to this many vectors, a few at a time, before a restart; 0:
                          * restart. Where memory is refused it restarts */
    pd_arena *arena;     /* GMRES: lends memory for the growth of the basis until the end of the solve, as far as it
                          * has room. Borrowed; NULL: all is allocated */
    int fixed_restart;   /* 1: GMRES restarts exactly at `restart`, whatever `most` is: PD_ERR_MEMORY where memory for
                          * that is refused */
    int flexible; /* 1: flexible GMRES, which stores the preconditioned basis, too. Needed when the preconditioner
                   * is not linear to rounding in double precision, as a single-precision multigrid cycle on a
                   * stiff operator */
    pd_krylov_precision basis_precision; /* of the basis of GMRES. Residuals stay double; a restart cycle gains up to
                                          * six digits in single precision (Aliaga, Anzt, Gruetzmacher, Quintana-Orti,
                                          * Tomas 2022), up to three as integers */
    int max_iterations;                  /* 0: 200 */
    double rtol;                         /* [-] stop at |b - A x| <= max(rtol |b|, atol); 0: 1e-8 */
    double atol;                         /* [unit of b] */
    const double *diagonal; /* [n] [unit of b over that of x] CG: approximate diagonal D of A. A direction p with p.Ap
                             * at
                             * the rounding level of p.Dp is singular. Borrowed; NULL: only p.Ap <= 0 is detected */
    int zero_guess; /* 1: the initial guess is 0, the x passed in is ignored, which saves one application of A */
    int low_memory; /* 1: low memory: GMRES with zero_guess, not flexible: x serves as a work vector until the solve
                     * ends, and callbacks may overwrite their input vector despite const */
    int skip_true_residual; /* 1: lean GMRES stops on the residual of its recurrence without computing the true one,
                             * which saves one application of A. For callers that check the result themselves */
} pd_krylov_desc;

/* Between solves first, end, fixed_restart, max_iterations, rtol, atol, diagonal and zero_guess of desc may change. */
/* A solver with its work vectors. */
typedef struct pd_krylov {
    pd_krylov_desc desc; /* defaults filled in */
    int vectors;         /* work vectors */
    double *work;        /* [vectors][n] [unit of b or x] */
    int64_t length;      /* entries of a basis vector */
    /* GMRES: columns that the basis holds before it grows, in its present storage format */
    int base_columns;
    /* GMRES, lean: vectors in front of the basis whose memory holds an iterate; 0: none yet */
    int iterate_vectors;
    int basis_vectors;     /* GMRES: allocated vectors of both bases */
    int64_t stride;        /* entries (double or float) from one basis vector to the next */
    int64_t basis_entries; /* entries of the basis without its growth */
    double *basis;         /* GMRES: [basis_vectors][length] [-] basis, then (flexible) preconditioned basis; or NULL */
    float *compressed_basis;    /* the same when compressed; integers and then their scales are stored in it, too */
    double *dense;              /* [-] GMRES: Hessenberg matrix, rotations, right-hand side, coefficients */
    int chunk_columns;          /* GMRES: vectors of a chunk by which the basis grows; 0: it does not grow */
    int columns, built_columns; /* GMRES: capacity of the Hessenberg matrix in columns, now and when it was built */
    /* GMRES: chunks of chunk_columns vectors each, stored as in the basis (flexible: twice) */
    void *chunk[PD_KRYLOV_MAX_CHUNKS];
    int chunk_count;                         /* number of them */
    int chunk_is_lent[PD_KRYLOV_MAX_CHUNKS]; /* 1: the chunk is lent by the arena */
} pd_krylov;

#define pd_krylov_build PD_NAME(pd_krylov_build)
#define pd_krylov_free PD_NAME(pd_krylov_free)

/* Build a solver with all its vectors. PD_ERR_ARGUMENT, PD_ERR_SIZE: as of pdi_krylov_init: a setting is out of range.
 * After these and errors of allocation the solver is zero, and nothing is allocated. */
PD_API pd_status pd_krylov_build(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov);
/* Free all memory that is not lent, and set the solver to zero. */
PD_API void pd_krylov_free(pd_ctx *ctx, pd_krylov *krylov);
#ifdef PDI_INTERNAL
/* pd_krylov_build without the vectors of pdi_krylov_list, which an arena lends for each solve: of the arrays it
 * allocates the dense one of GMRES only. */
PDI_FN pd_status pdi_krylov_build_unallocated(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov);
/* Free the allocated chunks by which the basis has grown, and shrink the Hessenberg matrix to its built size; it stays
 * larger where memory for that is refused. Chunks of the arena were returned at the end of each solve. */
PDI_FN void pdi_krylov_free_growth(pd_ctx *ctx, pd_krylov *krylov);
/* Switch flexible GMRES on or off between solves, in the memory of the basis: without it the basis holds twice the
 * columns, max_vectors at most. Sets the layout anew, also where nothing is switched. The basis must not have grown. */
PDI_FN void pdi_krylov_set_flexible(pd_krylov *krylov, int flexible);
/* Before the basis is lent: take memory for the arrays of `list` from the arena, and make the basis smaller by as much.
 * 1: done. 0: the basis is not in single precision or is flexible, fewer than `least` vectors would remain, or the
 * arena has no room; nothing changes. */
PDI_FN int pdi_krylov_lend_basis(pd_ctx *ctx, pd_krylov *krylov, pd_arena *arena, pdi_array_list_fn list, void *object,
                                 int least);
/* Return the arrays that pdi_krylov_lend_basis has lent, and restore the memory of the basis; its columns are counted
 * anew by pdi_krylov_set_flexible. Returns `status`, or PD_ERR_INTERNAL as of pdi_arena_release. */
PDI_FN pd_status pdi_krylov_restore_basis(pd_ctx *ctx, pd_krylov *krylov, pd_arena *arena, pdi_array_list_fn list,
                                          void *object, pd_status status);
/* List function: the work vectors and the basis, by the sizes that pdi_krylov_init sets; growth is not in it. */
PDI_FN void pdi_krylov_list(pdi_array_visitor *owner, void *object);
/* Check the desc, fill in defaults and sizes; allocates nothing, so that the memory can be counted. PD_ERR_ARGUMENT: n
 * below 1 or not components times spans->total, first and end no range in n, restart not in 1 .. 1000, initial_vectors
 * negative, low_memory without zero_guess, with CG or flexible, max_iterations below 1, rtol not in (0, 1), atol
 * negative or not finite, an unknown method. PD_ERR_SIZE: the vectors overflow an int64_t. After an error the solver is
 * partly set. */
PDI_FN pd_status pdi_krylov_init(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov);
/* Basis vectors whose memory an iterate in double precision takes. */
PDI_FN int pdi_krylov_iterate_size(const pd_krylov_desc *desc);
/* Floats that store the integers of a vector, and those of its scales; both even. */
PDI_FN int64_t pdi_krylov_integer_size(int64_t length);
/* PD_ERR_ARGUMENT: `first` and `end` are no range within the n entries. */
PDI_FN pd_status pdi_krylov_check_range(pd_ctx *ctx, const pd_krylov_desc *d);
/* Present capacity in columns of the basis and the Hessenberg matrix. */
PDI_FN int pdi_krylov_capacity(const pd_krylov *krylov);
/* Enlarge the basis or the Hessenberg matrix, whichever limits the columns; `dense` may move. 1: done. 0: a limit is
 * reached, or memory is refused, and that error is cleared. Negative: memory is refused with desc.fixed_restart. */
PDI_FN int pdi_krylov_grow_basis(pd_ctx *ctx, pd_krylov *krylov);
/* Return the chunks of the arena; allocated ones are kept for the next solve. Returns `status` or an error. */
PDI_FN pd_status pdi_krylov_release_chunks(pd_ctx *ctx, pd_krylov *krylov, pd_status status);
/* Number of the first vector of the preconditioned basis, behind all possible numbers of the basis. */
PDI_FN int pdi_krylov_precond_first(const pd_krylov *k);
/* Basis vector i of a basis in double precision; NULL: the basis is compressed, or there is no such vector. */
PDI_FN double *pdi_krylov_get_double(const pd_krylov *k, int i);
/* Basis vector i of a compressed basis, as floats or as integers and then their scales; NULL: the basis is in double
 * precision, or there is no such vector. */
PDI_FN float *pdi_krylov_get_single(const pd_krylov *k, int i);
#endif

#endif
