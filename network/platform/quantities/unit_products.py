"""Plain products of units, `W/(m^2 K)`, from the table alone: what pint would say, without loading it (0.1 s).

Only what can be read in one way: names, whole powers, one fraction bar with a name or a bracket behind it, and no
suffix (a plural) or doubtful prefix. Anything else is pint's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache

from network.platform.quantities.unit_table import DEFINITIONS, NAME, UNPREFIXED

Dimension = tuple[tuple[str, int], ...]
_FACTOR = re.compile(rf"({NAME})(?:\^([+-]?\d))?")
_PRODUCT = rf"{NAME}(?:\^[+-]?\d)?(?: +{NAME}(?:\^[+-]?\d)?)*"
_FORM = re.compile(rf" *(1|{_PRODUCT}) *(?:/ *(?:({NAME}(?:\^[+-]?\d)?)|\( *({_PRODUCT}) *\)) *)?")
_TOKEN = re.compile(rf"\*\*|[*/]|{NAME}|[0-9.]+(?:e[+-]?\d+)?")


@lru_cache(maxsize=1)
def _table() -> tuple[dict[str, str], dict[str, Fraction], dict[str, str]]:
    """Canonical name by every name, factor by every name of a prefix, definition by canonical name."""
    names, prefixes, definitions = dict[str, str](), dict[str, Fraction](), dict[str, str]()
    for line in DEFINITIONS.strip().splitlines():
        own, definition, *aliases = (part.strip() for part in line.split("="))
        if own.endswith("-"):
            prefixes |= {name.rstrip("-"): Fraction(definition) for name in (own, *aliases)}
            continue
        names |= dict.fromkeys((own, *aliases), own)
        definitions[own] = definition
    return names, prefixes, definitions


def read_product(text: str) -> tuple[Fraction, dict[str, int]] | None:
    """Factor to SI and powers of the base dimensions; None where pint is to be asked."""
    match = _FORM.fullmatch(text)
    if match is None:
        return None
    factor, powers = Fraction(1), dict[str, int]()
    for part, sign in ((match[1], 1), (match[2] or match[3] or "", -1)):
        for name, power in _FACTOR.findall(part):
            found = _read_name(name)
            if found is None:
                return None
            exponent = sign * int(power or 1)
            factor *= found[0] ** exponent
            for base, own in found[1]:
                powers[base] = powers.get(base, 0) + own * exponent
    return factor, {base: power for base, power in powers.items() if power}


@lru_cache(maxsize=256)
def _read_name(name: str) -> tuple[Fraction, Dimension] | None:
    """A name as it stands, or one prefix and a name that may have one where there is only one such reading."""
    names, prefixes, _ = _table()
    if name in names:
        return _define(names[name])
    ways = {(factor, names[name[len(prefix) :]]) for prefix, factor in prefixes.items()
            if name.startswith(prefix) and name[len(prefix) :] in names}  # fmt: skip
    if len(ways) != 1:
        return None
    ((factor, base),) = ways
    value, dimension = _define(base)
    return None if base in UNPREFIXED else (factor * value, dimension)


@lru_cache(maxsize=128)
def _define(name: str) -> tuple[Fraction, Dimension]:
    """A unit by its definition, from left to right."""
    names, _, definitions = _table()
    if definitions[name].startswith("["):
        return Fraction(1), ((definitions[name], 1),)
    factor, powers, sign = Fraction(1), dict[str, int](), 1
    for operator, token, power in _terms(definitions[name]):
        sign = -1 if operator == "/" else 1
        value, dimension = _define(names[token]) if token in names else (Fraction(token), ())
        factor *= value ** (sign * power)
        for base, own in dimension:
            powers[base] = powers.get(base, 0) + own * sign * power
    return factor, tuple((base, power) for base, power in powers.items() if power)


def _terms(definition: str) -> Iterator[tuple[str, str, int]]:
    """'kilogram * meter / second ** 2' → ('', kilogram, 1), ('*', meter, 1), ('/', second, 2)."""
    tokens, operator = iter(_TOKEN.findall(definition)), ""
    pending: tuple[str, str] | None = None
    for token in tokens:
        if token == "**" and pending is not None:
            yield *pending, int(next(tokens))
            pending = None
        elif token in "*/":
            if pending is not None:
                yield *pending, 1
            pending, operator = None, token
        else:
            pending = operator, token
    if pending is not None:
        yield *pending, 1
