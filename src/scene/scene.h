/* scene: reads a scene file, or a flat parameter file, into a setup.
 *
 * Sections and keys are those of pd_key_sections, with unit, default, meaning and what they allow; docs/guide.md,
 * chapter 2, explains them.
 *
 * Named constants in numbers and expressions: Csat, Cs, and rho_m, M_m, z_m of the material.
 */
#ifndef PD_SCENE_H
#define PD_SCENE_H
#include "setup/setup.h"

#define pd_scene_read PD_NAME(pd_scene_read)
#define pd_scene_parse PD_NAME(pd_scene_parse)

/* Read a scene file, or a flat parameter file, into setup, for pd_setup_free, with `count` overrides ("key=value",
 * "section.key=value"). On failure setup is freed and zero. Check all that can be checked without a grid. PD_ERR_FILE:
 * the file cannot be read. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line, what was found and what was expected: a wrong
 * or unknown name or value, a key without effect, an empty file, or no physics. */
PD_API pd_status pd_scene_read(pd_ctx *ctx, const char *path, const char *const *overrides, int count, pd_setup *setup);
/* Read a scene from a text into a setup, with overrides, as pd_scene_read does from a file; `path` is its name in
 * messages, and files that the scene names are relative to the folder of `path`. */
PD_API pd_status pd_scene_parse(pd_ctx *ctx, const char *path, const char *text, const char *const *overrides,
                                int count, pd_setup *setup);

#endif
