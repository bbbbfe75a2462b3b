/* physics_type: see physics_type.h */
#include "couple/physics_type.h"
#include <string.h>

pd_status pd_physics_type_register(pd_ctx *ctx, const pd_physics_type *type)
{
    const pd_key_section *s = &type->section;
    if (!s->name || !s->name[0] || !s->label || s->label[0] || !s->meaning || (s->count && !s->key))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "physics", "expected a section with a name, a meaning and no label");
    if (!type->build || !type->free || !type->set_process || !type->values)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "physics",
                       "[%s] lacks a callback, expected build, free, set_process, values", s->name);
    if (type->fields < 1 || type->fields > PD_PHYSICS_TYPE_FIELDS || s->count > PD_PHYSICS_TYPE_KEYS)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "physics",
                       "[%s] has %d fields and %d keys, expected 1 to %d and at most %d", s->name, type->fields,
                       s->count, PD_PHYSICS_TYPE_FIELDS, PD_PHYSICS_TYPE_KEYS);
    for (int k = 0; k < ctx->physics_count; k++)
        if (strcmp(ctx->physics[k]->section.name, s->name) == 0)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "physics", "[%s] is registered", s->name);
    if (ctx->physics_count == PD_CTX_PHYSICS)
        return pd_fail(ctx, PD_ERR_SIZE, "physics", "found more than %d, expected fewer", PD_CTX_PHYSICS);
    ctx->physics[ctx->physics_count++] = type;
    return PD_OK;
}
