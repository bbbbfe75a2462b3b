/* scene: reads a scene file, or a flat parameter file, into a setup.
 *
 *   [constants]  v = 1.3 um/h  tau = 1 h  ...: names for all numbers and expressions
 *   [grid]       h = 5 um (one length or one for each axis)  m = 3  box = a .. b, c .. d  threads = 2
 *   [shape NAME] one of  box = a .. b, ... | ball = centre  radius = r | cylinder = x|y|z  centre  radius |
 *                half_space = yes  point  normal | mask = file.png  corner  cell | raw = file  size  corner  cell |
 *                stl = file  scale  shift (3D) |
 *                union|intersect|difference = NAME, NAME;  outside = yes: the complement
 *                kind = solid|wall (C = held)|medium (D = its diffusivity)|passive (with corrode: fluid there does not
 *                attack)|part  material = mg4ag|steel304|copper|alloy625
 *                grains = 40 um  grain_spread  grain_seed  boundary_width
 *   [side x-]    flow = inlet|outlet|noslip|periodic|mirror|open  profile = parabola|uniform|expression
 *                mean = speed | flow_rate = 1 mL/min  vx = expression in x y z (vy, vz)  C = ...  p = 0
 *                noslip: velocity = 1 m/s, 0 m/s of a wall that slides along itself; C = ... held by the wall
 *                open without flow, with corrode: bulk behind it
 *   [flow]       rho  mu  steady = 1e-6  order = 2|4  force = ...  speed, length: of reported residuals, by default its
 *                own
 *                time = steady|implicit|explicit|given  vx (vy, vz) = expression: flow at the start, or the given flow,
 *                which open sides let in and out  rtol = 1e-4 of implicit steps  eos = tait|linear, c0 = speed of sound
 *                of explicit ones
 *   [gas]        gamma = 1.4  rho, p, vx (vy, vz) = expressions: at the start  order = second|first  cfl = 0.8; alone.
 *                [side x-] flow = slip|mirror|periodic|outlet|inlet (the state of the start)
 *   [transport]  D  initial = expression in x y z  advection = limited|upwind  time = implicit|steady
 *   [dissolve]   rate = speed, an expression in C | law = the same in 1/s per layer of h
 *                rate_scale = 1  Csat  Cs  gb_factor = 1  threshold = 0
 *   [corrode]    bond-based, in place of dissolve: rate = speed | current = A/m2, expressions in C
 *                rate_scale = 1  Csat  Cs  charge  D  initial (without transport)  bulk = 0  gb_factor = 1
 *                control = diffusion|activation  drive = constant|difference  kernel = area|square|inverse
 *                weights = calibrated|printed
 *                repassivation = concentration  breaking = deterministic|stochastic  seed = 1
 *   [table NAME] file = law.csv  x = heading in unit  y = heading in unit  outside = hold|error: a function NAME(x) for
 *                all expressions, monotone between the points
 *   [run]        until  rtol = 4e-3 (of the volume loss; without dissolution 1e-3, of a step of the transport or of
 *                corrode)
 *                fraction of a node that a step takes (25 rtol)  max_step
 *   [output]     every  fields = C, v, p, kind, grain, phase, D, rate, density, damage, energy  images = ...
 *                slice = z 0 um  deformed = 100  prefix  folder
 *   [probe NAME] at = x, y  fields = C, v
 *   [line NAME]  from = x, y  to = x, y  points = 101 | spacing  fields  images
 *   [plane NAME] at = x 1 mm
 *   [force NAME] box = a .. b, c .. d  shape = NAME  balance = yes|no  speed, length (3D: area): reference values of
 *                coefficients
 *   [transfer NAME] box  along = x|y|z  length  surface = C there  fluid = inlet|bulk|C  D  area
 *   [total NAME] box
 *   [measured NAME] file = wire.csv  time = heading in unit  value = heading in unit  spread = heading in unit
 *                of = volume_loss | plane.NAME.flow | ...: points that the run is compared with
 *                start = 0 s: time of the file at which the run begins
 *
 * Named constants in numbers and expressions: Csat, Cs, and rho_m, M_m, z_m of the material.
 */
#ifndef PD_SCENE_H
#define PD_SCENE_H
#include "setup/setup.h"

#define pd_scene_read PD_NAME(pd_scene_read)
#define pd_scene_parse PD_NAME(pd_scene_parse)

/* Read a scene file into setup, for pd_setup_free (on failure it is freed), apply `count` overrides ("key=value",
 * "section.key=value") and check everything that can be checked without a grid. PD_ERR_FILE, PD_ERR_PARSE,
 * PD_ERR_ARGUMENT with file:line, what was found and what was expected. */
PD_API pd_status pd_scene_read(pd_ctx *ctx, const char *path, const char *const *overrides, int count, pd_setup *setup);
/* Read a scene from a text into a setup, with overrides, as pd_scene_read does from a file; `path` is its name in
 * messages, and files that the scene names are relative to the folder of `path`. */
PD_API pd_status pd_scene_parse(pd_ctx *ctx, const char *path, const char *text, const char *const *overrides,
                                int count, pd_setup *setup);

#endif
