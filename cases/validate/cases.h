/* cases: the table of all cases of this dimension, in the order in which they run. */
#ifndef VAL_CASES_H
#define VAL_CASES_H
#include "case.h"
#include "operators.h"
#include "flow.h"
#include "enclosed.h"
#include "startup.h"
#include "cylinder.h"
#include "transport.h"
#include "rotation.h"
#include "exchange.h"
#include "annulus.h"
#include "turn_table.h"
#include "turn.h"
#include "dissolution.h"
#include "stefan.h"
#include "front.h"
#include "crevice.h"
#include "wire.h"
#if PD_DIM == 3
#include "peer.h"
#endif
#include "gas.h"
#include "clock.h"
#include "solid.h"
#include "round.h"
#include "waves.h"
#include "fracture.h"
#include "chemistry.h"
#include "reaction.h"
#include "migration.h"
#include "mineral.h"
#include "measured.h"
#include "pit.h"
#include "plates.h"
#include "galvanic.h"
#include "film.h"

static const val_case *const val_cases[] = {
    &patch_case,
#if PD_DIM == 2
    &poiseuille_case,
    &flux_case,
    &cavity_case,
    &cylinder_case,
    &taylor_case,
    &startup_case,
#endif
#if PD_DIM > 1
    &isotropy_case,
#endif
#if PD_DIM == 3
    &hagen_case,
    &duct_case,
    &channel_case,
    &cylinder_case,
#endif
    &diffusion_case,
    &advection_case,
#if PD_DIM < 3
    &rotation_case,
#endif
#if PD_DIM == 2
    &turn_case,
    &graetz_case,
    &annulus_case,
#endif
    &stefan_case,
    &rate_case,
    &ledger_case,
    &front_case,
#if PD_DIM == 2
    &crevice_case,
    &wire_case,
#endif
#if PD_DIM == 3
    &peer_case,
#endif
    &sod_case,
#if PD_DIM == 2
    &clock_case,
#endif
    &solid_patch_case,
#if PD_DIM == 2
    &kirsch_case,
    &lame_case,
    &hill_case,
    &gutman_case,
#endif
#if PD_DIM > 1
    &cantilever_case,
#endif
#if PD_DIM == 1
    &dispersion_case,
#endif
    &bar_wave_case,
#if PD_DIM == 2
    &crack_case,
    &specimen_case,
#endif
#if PD_DIM > 1
    &toughness_case,
#endif
#if PD_DIM == 2
    &branching_case,
#endif
#if PD_DIM == 1
    &chemistry_case,
#endif
    &reaction_case,
    &migration_case,
    &mineral_case,
#if PD_DIM < 3
    &measured_case,
    &pit_case,
    &plates_case,
#endif
#if PD_DIM > 1
    &galvanic_case,
#endif
#if PD_DIM == 1
    &film_case,
#endif
};

enum { VAL_CASE_COUNT = (int)(sizeof val_cases / sizeof val_cases[0]) };

#endif
