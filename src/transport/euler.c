/* euler: see euler.h */
#include "transport/euler.h"
#include <string.h>

static pd_status pdi_euler_start(pd_ctx *ctx, void *self, double t)
{
    return pdi_transport_at(ctx, ((pd_euler *)self)->transport, t);
}

static pd_status pdi_euler_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    PDI_TRY(pdi_process_longest(ctx, self, s));
    s->dt = pdi_process_even(s->limit - s->time, s->dt);
    return PD_OK;
}

static pd_status pdi_euler_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_euler *e = (pd_euler *)self;
    double end = s->time + s->dt;
    if (s->at) PDI_TRY(s->at(ctx, s->at_user, end));
    PDI_TRY(pdi_transport_at(ctx, e->transport, end));
    return pd_transport_implicit(ctx, e->transport, s->dt, &e->result);
}

static pd_status pdi_euler_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_euler *e = (pd_euler *)self;
    (void)ctx;
    e->krylov += e->result.krylov;
    e->out += s->dt * e->transport->outflow;
    e->in += s->dt * e->transport->inflow;
    return PD_OK;
}

static pd_status pdi_euler_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    (void)turned;
    (void)count;
    return pd_transport_update(ctx, ((pd_euler *)self)->transport);
}

static pd_status pdi_euler_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_euler *e = (pd_euler *)self;
    PDI_TRY(pdi_transport_store(ctx, e->transport, archive));
    PDI_TRY(PDI_KEEP(ctx, archive, "euler.out", &e->out, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "euler.in", &e->in, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "limiter steps", &e->result.limiter, 1));
    return PDI_KEEP(ctx, archive, "krylov of transport", &e->krylov, 1);
}

static void pdi_euler_balance(pd_ctx *ctx, void *self, int k, pd_amounts *amounts)
{
    const pd_euler *e = (const pd_euler *)self;
    (void)k;
    amounts->dissolved += pd_transport_stock(ctx, e->transport);
    amounts->carry += pd_transport_carried(ctx, e->transport);
    amounts->out += e->out;
    amounts->in += e->in;
}

pd_process pd_euler_process(pd_transport *transport, pd_euler *e)
{
    pd_process p;
    memset(&p, 0, sizeof p);
    memset(e, 0, sizeof *e);
    e->transport = transport;
    p.name = "implicit transport";
    p.self = e;
    p.element = pdi_transport_element();
    p.elements = 1;
    p.start = pdi_euler_start;
    p.limit = pdi_euler_limit;
    p.attempt = pdi_euler_attempt;
    p.accept = pdi_euler_accept;
    p.changed = pdi_euler_changed;
    p.store = pdi_euler_store;
    p.balance = pdi_euler_balance;
    return p;
}
