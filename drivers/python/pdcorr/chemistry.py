"""The equilibrium of an electrolyte, without a lattice (guide, 5.10)."""
from __future__ import annotations

import os
from ctypes import c_char_p, c_double
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

from . import _declared
from ._library import Context, Error, Status
from .sim import _is_text, _override


@dataclass(frozen=True)
class Speciation:
    """A solution in equilibrium. Concentrations in mol/m3; of minerals their amount over the volume of water.

    ph: NaN without H+. activity: of solutes, with mol/L. saturation: log10(IAP/K) of minerals, formed or not.
    """

    ph: float
    strength: float
    charge: float
    temperature: float
    species: dict[str, float]
    activity: dict[str, float]
    minerals: dict[str, float]
    saturation: dict[str, float]


def speciate(electrolyte: str | os.PathLike, overrides: Mapping[str, Any] | None = None, *,
             add: Mapping[str, float] | None = None, **values: Any) -> Speciation:
    """The equilibrium of an electrolyte: a file, a scene, or a text of several lines with their sections.

    overrides: {"species.Mg2+.initial": "2 mM", "chemistry.minerals": "all"}. add: neutral reagents and how much of
    each [mol/m3] comes in: {"Na+ + OH-": 0.5}.
    """
    if not _is_text(electrolyte) and not os.path.exists(electrolyte):
        raise Error(Status.PD_ERR_FILE, f"{os.fspath(electrolyte)}: there is no such file")
    context = Context(1, 0, 0)
    changes = [_override(key, value).encode() for key, value in {**(overrides or {}), **values}.items()]
    given = (c_char_p * max(len(changes), 1))(*changes)
    recipe, state = context.types.pd_electrolyte(), context.types.pd_electrolyte_state()
    if _is_text(electrolyte):
        context.call("pd_electrolyte_parse", os.fsencode(Path("electrolyte")), electrolyte.encode(), given,
                     len(changes), recipe)
    else:
        context.call("pd_electrolyte_read", os.fsencode(electrolyte), given, len(changes), recipe)
    amounts = (c_double * len(recipe.initial))(*recipe.initial)
    for reagent, amount in (add or {}).items():
        per = (c_double * len(recipe.initial))()
        context.call("pd_electrolyte_reagent", recipe, reagent.encode(), per)
        for place in range(recipe.count):
            amounts[place] += amount * per[place]
    context.call("pd_electrolyte_solve", recipe, amounts, state)
    names = [recipe.species[place].name.decode() for place in range(recipe.count)]
    phases = [recipe.species[place].phase for place in range(recipe.count)]
    solutes = [place for place, phase in enumerate(phases) if phase == _declared.PD_PHASE_SOLUTE]
    solids = [place for place, phase in enumerate(phases) if phase == _declared.PD_PHASE_SOLID]
    return Speciation(
        ph=state.ph, strength=state.strength, charge=state.charge, temperature=recipe.temperature,
        species={names[k]: amounts[k] for k in solutes},
        activity={names[k]: 10.0 ** state.result.log_activity[k] for k in solutes},
        minerals={names[k]: amounts[k] for k in solids},
        saturation={names[k]: state.saturation[k] for k in solids})
