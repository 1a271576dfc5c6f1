"""Readers of small YAML mappings: keys, durations, quantities, where a run starts. Faults are told by their line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from network.catalogue.declaration.fields import word_of
from network.platform.quantities.unit_names import LONGEST
from network.platform.quantities.unit_table import likely_unit
from network.platform.quantities.units import (
    BadNumber,
    Unit,
    has_spread,
    in_unit,
    parse_number,
    split_number,
    spread_parts,
    unit,
)
from network.platform.refusal import Complaints, Refused, Spot, likely, refuse
from network.platform.yaml.document import Branch, Leaf, Tree, parse
from network.recordings.inputs import Start

ABSOLUTE_ZERO = -273.15
COLDEST, HOTTEST = -80.0, 400.0
"""°C that a part of a machine tool may have, with room to spare."""
STATED = 2.0
"""K: 1σ of a temperature that was noted once and not recorded, like that of a room (convention)."""
_START = "a temperature like `22 degC`, `{housing: 24 degC, others: 22 degC}` or `steady`"


@contextmanager
def collecting(complaints: Complaints, spot: Spot, what: str) -> Iterator[None]:
    """Turns a bad number or a refusal into complaints about `what`, and goes on."""
    try:
        yield
    except BadNumber as error:
        complaints.refuse(spot, f"{what}: {error.wrong}", error.right)
    except Refused as refused:
        complaints.absorb(refused)


def check_keys(
    tree: Branch, where: str, needed: Mapping[str, str], others: Sequence[str], complaints: Complaints
) -> None:
    """Complains about unknown and missing keys; `needed` holds an example for each."""
    known = [*needed, *others]
    for key in tree.items:
        if key not in known:
            complaints.refuse(tree.key_spot(key), f"{where} has an unknown key '{key}'", likely(key, known))
    for key, example in needed.items():
        if key not in tree.items:
            complaints.refuse(tree.spot, f"{where} has no `{key}`", f"add `{key}: {example}`")


def read_keys(
    tree: Branch, readers: Mapping[str, Callable[[Tree], Any]], values: dict[str, Any], complaints: Complaints
) -> None:
    """Reads the keys that are there into `values`, in the order of `readers`; a faulty one is left out."""
    for key in [key for key in readers if key in tree.items]:
        with collecting(complaints, tree.key_spot(key), key):
            values[key] = readers[key](tree.items[key])


def _in(tree: Tree, wanted: str, right: str) -> tuple[str, float]:
    text = word_of(tree, right)
    try:
        return text, in_unit(text, wanted)
    except BadNumber as error:
        raise BadNumber(error.wrong, f"give {right}") from None


def seconds(tree: Tree) -> float:
    """A time above zero [s]. Raises BadNumber."""
    text, value = _in(tree, "s", "a time, like `10 min`")
    if not 0 < value < math.inf:
        raise BadNumber(f"'{text}' is " + ("not finite" if value > 0 else "not above zero"), "give a time above zero")
    return value


def read_time(option: str, text: str) -> float:
    """A time that an option of the command names [s]. Raises Refused."""
    try:
        value = in_unit(text, "s")
    except BadNumber as bad:
        raise refuse(Spot(option), bad.wrong, bad.right) from None
    if not 0 < value < math.inf:
        raise refuse(Spot(option), f"'{text}' is not above zero", "give a time like '10 s'")
    return value


def shift(tree: Tree) -> float:
    """A time of either sign [s], or zero. Raises BadNumber."""
    text, value = _in(tree, "s", "a time, like `1 h`")
    if not math.isfinite(value):
        raise BadNumber(f"'{text}' is not finite", "give a finite time")
    return value


def quantity(tree: Tree) -> tuple[float, Unit]:
    """A value of an input in SI (temperatures in °C) and the unit it came in. Raises BadNumber.

    Only a switch, from 0 to 1, goes without unit; another bare number is written like `3 1`.
    """
    text = word_of(tree, "a number with its unit, like `8000 rpm`")
    if has_spread(text):
        raise BadNumber(f"'{text}' has a spread", "what drives a schedule is known, so drop the ±")
    return _quantity(text)


def run_constant(tree: Tree) -> tuple[float, Unit, float]:
    """A constant of a run in SI, the unit it came in, and its 1σ in SI (0 where it is known): `22 degC ± 2 K`. A
    temperature that is stated without ±, and was not recorded, counts with STATED. Raises BadNumber."""
    text = word_of(tree, "a number with its unit, like `22 degC ± 2 K`")
    if not has_spread(text):
        value, given = _quantity(text)
        return value, given, STATED if given.is_temperature else 0.0
    value, given = _quantity(spread_parts(text)[0])
    return value, given, parse_number(text, given.text, True, (-math.inf, math.inf)).spread


def _quantity(text: str) -> tuple[float, Unit]:
    number, unit_text = split_number(text)
    if not unit_text and not 0 <= number <= 1:
        raise BadNumber(f"'{text}' has no unit", f"write it like `{text} rpm`, only a switch (0 or 1) goes without")
    value = _unit(text, unit_text).to_si(number)
    if not math.isfinite(value) or (unit(unit_text).is_temperature and not value >= ABSOLUTE_ZERO - 1e-9):
        raise BadNumber(f"'{text}' is out of range", "give a finite value, a temperature above absolute zero")
    return value, unit(unit_text)


def _unit(text: str, unit_text: str) -> Unit:
    try:
        return unit(unit_text)
    except BadNumber as error:
        meant = likely_unit(unit_text[:LONGEST])
        right = f"did you mean '{meant}'?" if meant else error.right
        raise BadNumber(f"'{text}' has an {error.wrong}", right) from None


def parse_start(tree: Tree) -> Start:
    """`22 degC`, `{housing: 24 degC, others: 22 degC}` or `steady`. Raises Refused."""
    complaints = Complaints()
    children = dict(tree.items) if isinstance(tree, Branch) else {"others": tree}
    if isinstance(tree, Leaf) and tree.text == "steady":
        return Start(steady=True)
    temperatures = {}
    for node, child in children.items():
        where = f"start.{node}" if isinstance(tree, Branch) else "start"
        with collecting(complaints, tree.key_spot(node) if isinstance(tree, Branch) else tree.spot, where):
            temperatures[node] = _temperature(child)
    complaints.raise_if_any()
    others = temperatures.pop("others", None)
    return Start(others=others, nodes=temperatures or None)


def _temperature(tree: Tree) -> float:
    text, value = _in(tree, "degC", _START)
    if not COLDEST <= value <= HOTTEST:
        raise BadNumber(f"'{text}' is out of range", f"give a temperature from {COLDEST:g} to {HOTTEST:g} degC")
    return value


def start_of(text: str) -> Start:
    """The start given on the command line, in the form of a file. Raises Refused."""
    return parse_start(parse(text, Spot("--start")))
