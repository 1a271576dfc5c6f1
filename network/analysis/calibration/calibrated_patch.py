"""A calibrated machine as a patch of its file: value ± standard error for each number, and what options changed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from network.catalogue.declaration.patch import exchange_value
from network.catalogue.declaration.sections import CALIBRATED
from network.engine.response.parameters import Parameter
from network.machine.file_layers import is_made_of, patch_from
from network.machine.machine import Machine
from network.machine.validity import Validity
from network.platform.quantities.units import Number, difference, unit
from network.platform.refusal import Spot, refuse
from network.platform.yaml.document import Branch, Tree, dump

FILE = "machine.calibrated.yaml"
DIGITS, SPREAD_DIGITS = 6, 3


def text_of(p: Parameter, value: float, spread: float) -> str:
    """A calibrated number as it stands in a file; spread: 1σ of θ. Rounded where nobody would miss it; none of a zero
    that cannot be negative, which no prior of a file spreads."""
    given = unit(p.field.unit)
    shown = difference(given) if p.field.unit == "K" else given
    value = shown.to_si(float(f"{shown.from_si(value):.{DIGITS}g}"))
    if p.is_log:
        spread = float(f"{max(spread, 1e-6) * 100:.{SPREAD_DIGITS}g}") / 100
        return str(p.field.write(Number(value, "log", spread)))
    if value == 0 and not p.field.may_be_negative:
        return str(p.field.write(Number(0.0)))
    scale = difference(given).scale
    spread = float(f"{max(spread, 1e-12 * scale) / scale:.{SPREAD_DIGITS}g}") * scale
    return str(p.field.write(Number(value, "normal", spread)))


def with_fitted_numbers(
    machine: Machine, parameters: Iterable[Parameter], theta: Iterable[float], std: Iterable[float]
) -> Machine:
    """The machine with value ± standard error for each number, so that its tree says so, too; what it said of an
    earlier calibration goes."""
    tree: Tree = machine.tree
    for p, x, s in zip(parameters, theta, std, strict=True):
        tree = exchange_value(tree, (*p.entry.keys, p.field.key), text_of(p, p.value(x), s))
    assert isinstance(tree, Branch)
    items = {key: child for key, child in tree.items.items() if key != CALIBRATED}
    return Machine.read(Branch(items, tree.spot, tree.keys), machine.file)


def with_validity(machine: Machine, validity: Validity) -> Machine:
    """The machine that says of itself how far its calibration holds."""
    return machine.patched({CALIBRATED: validity.to_plain()}, CALIBRATED)


def patch_text(machine: Machine, where: Path, remark: str) -> str:
    """The file of a calibrated machine in a folder: it extends the machine's own file, or is whole where that cannot
    be read."""
    over = patch_from(machine.file, machine.tree, where)
    return f"# {remark}\n" + dump(machine.to_plain() if over is None else {"extends": over[0], **over[1]})


def check_target(machine: Machine, where: Path) -> None:
    """Raises Refused where the result would replace a file that it extends."""
    if is_made_of(machine.file, where / FILE):
        wrong = f"holds {FILE}, and that is a file the machine is made of"
        raise refuse(Spot(str(where)), wrong, "give another -o")
