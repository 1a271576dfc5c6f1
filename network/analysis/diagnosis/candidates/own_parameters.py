"""The numbers of a candidate: those of its patch that are fitted, with priors of engineering size."""

from __future__ import annotations

from dataclasses import replace

from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Effect
from network.catalogue.declaration.entry_path import NumberPath
from network.catalogue.declaration.many_units import ManyUnitsField
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.declaration.patch import Patch
from network.catalogue.typical_values import SCALED, size_of
from network.engine.response.parameters import Parameter, parameter
from network.machine.machine import Machine
from network.platform.quantities.units import Number

AROUND, FARTHEST = 2.0, 4.0
"""Times as far from the machine's as other temperatures (prior 1σ) that of surroundings that a proposal brings may be:
a floor, an oven, a wall in the sun; and how many of these 1σ it goes at most."""


def spell_out(kind: type[Effect], patch: Patch) -> Patch:
    """The patch with every number that will be fitted written down, also where it has a default."""
    given = {number for number, _ in patch.numbers()}
    for field in (kind.fields[name] for name in (kind.strength, *kind.shapes)):
        if isinstance(field, ParamField) and _stands(kind, field, patch):
            path = kind.path_to(field.attribute, patch)
            if path not in given:
                value = field.initial
                patch = patch.with_value(path, field.write(field.proposal() if value is None else value))
    return patch


def own_parameters(machine: Machine, kind: type[Effect], patch: Patch) -> tuple[Parameter, ...]:
    """Strength and shapes of a patch, with priors of engineering size."""
    strength = kind.fields[kind.strength]
    if not isinstance(strength, ParamField):
        return ()
    fields = [strength, *(f for name in kind.shapes if isinstance(f := kind.fields[name], ParamField))]
    paths = {f.attribute: kind.path_to(f.attribute, patch) for f in fields if _stands(kind, f, patch)}
    return tuple(_own(machine, paths[f.attribute], f, f is strength) for f in fields if f.attribute in paths)


def _stands(kind: type[Effect], field: ParamField, patch: Patch) -> bool:
    """Whether the patch has a place for the number."""
    try:
        kind.path_to(field.attribute, patch)
    except StopIteration:
        return False
    return True


def _own(machine: Machine, path: NumberPath, field: ParamField, is_strength: bool) -> Parameter:
    value = _value(machine, path, field)
    if isinstance(field, ManyUnitsField):
        field = parameter(machine, path).field
    if field.unit == "degC":
        return _own_degrees(machine, path, value)
    if value <= 0 or field.may_be_negative:
        by = size_of(machine) if value == 0 and field.unit in SCALED else 1.0
        size = max(abs(value), by * abs(field.proposal()))
        return parameter(machine, path, Number(value, "normal", SETTINGS.signed * size))
    if is_strength:
        return parameter(machine, path, Number(value, "log", SETTINGS.strength))
    has_default = isinstance(field.default, int | float)
    return parameter(machine, path, Number(value, "log", SETTINGS.exponent if has_default else SETTINGS.shape))


def _own_degrees(machine: Machine, path: NumberPath, value: float) -> Parameter:
    """A temperature that a proposal brings: of surroundings, or at which something switches."""
    if path.entry.section != "nodes":
        return parameter(machine, path, Number(value, "normal", SETTINGS.degrees))
    spread = AROUND * SETTINGS.degrees
    own = parameter(machine, path, Number(value, "normal", spread))
    return replace(own, low=value - FARTHEST * spread, high=value + FARTHEST * spread)


def _value(machine: Machine, path: NumberPath, field: ParamField) -> float:
    """The number as the patch has it, its default, or a typical one."""
    entry = machine.by_path[path.entry]
    own = next(name for name, f in entry.fields.items() if f.key == path.key)
    value = entry.__dict__[own]
    return float(value) if isinstance(value, int | float) else field.proposal()
