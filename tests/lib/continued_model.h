/* continued_model: a model of a scene that goes on from a checkpoint, and one with more threads, against one that was
 * never stopped. Include it behind other headers. */
#ifndef CONTINUED_MODEL_H
#define CONTINUED_MODEL_H
#include "checkpoint_model.h"
#include "scene_file.h"
#include "model_scene.h"

/* Room for what `keep` saves of the model, and how much that is. */
static double saved[8192];
static int32_t saved_count;

static void same(const char *what, void (*keep)(void))
{
    static double before[8192];
    int32_t count = saved_count, other = 0;
    memcpy(before, saved, sizeof before);
    keep();
    CHECK_INT(saved_count, count);
    for (int32_t k = 0; k < count; k++) other += memcmp(&before[k], &saved[k], sizeof *saved) != 0;
    if (!CHECK_INT(other, 0)) NOTE("%s: %d of %d values", what, (int)other, (int)count);
}

/* The bits at `end` [s]; the checkpoint is of `first`. */
static void continued(const char *text, double first, double end, void (*keep)(void))
{
    need_folder();
    if (!open_threads(text, NULL, 0, 1)) return;
    if (!run_to(first)) return;
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("half"), &model));
    if (!run_to(end)) return;
    keep();
    close_model();
    if (!open_threads(text, NULL, 0, 1)) return;
    if (CHECK_OK(&ctx, checkpoint_load(&ctx, path_of("half"), &model)) && run_to(end)) same("goes on", keep);
    close_model();
    if (!open_threads(text, NULL, 0, 2)) return;
    if (run_to(first) && run_to(end)) same("two threads", keep);
    close_model();
}

#endif
