/* output_folder: who holds the lock of a folder, on file systems with locks and without them.
 * dims: 2 */
#define _GNU_SOURCE
#include "io/output_folder.h"
#include "scene_file.h"
#if defined(__linux__)
#include <errno.h>
#include <sys/file.h>
#include <sys/syscall.h>

static int has_locks = 1;

/* In place of the function of the C library. */
int flock(int descriptor, int operation)
{
    if (has_locks) return (int)syscall(SYS_flock, descriptor, operation);
    errno = ENOLCK;
    return -1;
}

/* The folder cannot be opened, nor could it be, and its lock file stays: the message holds `part`. */
static void refused_folder(const char *part)
{
    pd_ctx ctx;
    pd_output_folder f;
    pd_ctx_init(&ctx);
    for (int check = 0; check < 2; check++) {
        pd_status status = check ? pdi_output_folder_check(&ctx, path_of("out"), "pin")
                                 : pdi_output_folder_open(&ctx, path_of("out"), "pin", &f);
        CHECK_INT(status, PD_ERR_STATE);
        if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
        CHECK(access(path_of("out/pdcorr.lock"), F_OK) == 0);
    }
}

TEST(one_run_in_a_folder)
{
    pd_ctx ctx;
    pd_output_folder f;
    char part[80];
    need_folder();
    snprintf(part, sizeof part, "another run (process %ld) writes into '", (long)getpid());
    pd_ctx_init(&ctx);
    for (has_locks = 0; has_locks < 2; has_locks++) {
        if (!CHECK_OK(&ctx, pdi_output_folder_open(&ctx, path_of("out"), "pin", &f))) break;
        refused_folder(part); /* by the same process, too */
        pdi_output_folder_close(&f);
        CHECK(access(path_of("out/pdcorr.lock"), F_OK) != 0);
        CHECK_OK(&ctx, pdi_output_folder_check(&ctx, path_of("out"), "pin"));
        CHECK(access(path_of("out/pdcorr.lock"), F_OK) != 0);
        /* a run that goes on */
        if (!CHECK_OK(&ctx, pdi_output_folder_lock_existing(&ctx, path_of("out"), "pin", &f))) break;
        refused_folder(part);
        pdi_output_folder_close(&f);
    }
    has_locks = 1;
}

/* The lock of a run that was killed counts where nothing else tells whether the run goes on. */
TEST(a_lock_that_was_left)
{
    pd_ctx ctx;
    pd_output_folder f;
    pd_ctx_init(&ctx);
    need_folder();
    for (has_locks = 0; has_locks < 2; has_locks++) {
        if (!CHECK_OK(&ctx, pd_file_make_directory(&ctx, path_of("out")))) break;
        put("out/pdcorr.lock", "not a number\n", 13);
        refused_folder("pdcorr.lock' is a link or holds something else, expected the lock of a run or none: remove it");
        put("out/pdcorr.lock", "12345\n", 6);
        if (!has_locks) {
            refused_folder("another run (process 12345) writes into '");
            refused_folder("if none runs, remove '");
            remove(path_of("out/pdcorr.lock"));
        }
        if (!CHECK_OK(&ctx, pdi_output_folder_open(&ctx, path_of("out"), "pin", &f))) break;
        pdi_output_folder_close(&f);
        CHECK(access(path_of("out/pdcorr.lock"), F_OK) != 0);
    }
    has_locks = 1;
}

TEST_MAIN(ENTRY(one_run_in_a_folder) ENTRY(a_lock_that_was_left))
#else
TEST(one_run_in_a_folder) { SKIP("it needs the system calls of Linux"); }

TEST_MAIN(ENTRY(one_run_in_a_folder))
#endif
