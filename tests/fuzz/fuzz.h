/* fuzz: what the fuzzers share. `make fuzz` builds each .c of this folder with clang's libFuzzer and the sanitizers. */
#ifndef FUZZ_H
#define FUZZ_H
#define _XOPEN_SOURCE 700
#include "io/zlib.h"
#include "io/png.h"
#include "io/csv.h"
#include "physics/model.h"
#include "physics/memory_estimate.h"
#include "scene/scene.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A reader that promises something and breaks it ends the fuzzer. */
#define FUZZ_EXPECT(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "broken promise: %s\n", #condition); \
            abort(); \
        } \
    } while (0)

/* A context that may take this much [byte]. */
static inline void fuzz_context(size_t limit, pd_ctx *ctx)
{
    pd_ctx_init(ctx);
    ctx->threads = 1;
    ctx->alloc.limit = limit;
}

/* Done, or refused with a message; nothing is left behind. */
static inline void fuzz_settled(const pd_ctx *ctx, pd_status status)
{
    FUZZ_EXPECT(status >= 0 || (ctx->status == status && ctx->message[0]));
    FUZZ_EXPECT(status != PD_ERR_INTERNAL);
    FUZZ_EXPECT(ctx->in_use == 0);
}

static char fuzz_path[200];

static inline void fuzz_remove(void) { remove(fuzz_path); }

/* The bytes as a file of this process, which the next call replaces. */
static inline const char *fuzz_file(const char *ending, const uint8_t *data, size_t size)
{
    if (!fuzz_path[0] && atexit(fuzz_remove) != 0) abort();
    snprintf(fuzz_path, sizeof fuzz_path, "%s/pdcorr_fuzz_%ld%s", P_tmpdir, (long)getpid(), ending);
    FILE *file = fopen(fuzz_path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) abort();
    return fuzz_path;
}

#endif
