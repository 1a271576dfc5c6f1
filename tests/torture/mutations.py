"""Machines, scenarios, mappings and recordings changed at random: their structure, their values, their letters."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import suppress
from copy import deepcopy
from functools import lru_cache
from typing import Any

import yaml

NUMBERS = ("0", "-1", "1", "nan", "inf", "-inf", "1e308", "1e-308", "1e30", "-0", "0x10", "1_000", "017", "1,5")
UNITS = ("", "K", "degC", "degF", "W/K", "mm", "m", "m^2", "W", "kW", "N m", "N mm", "rpm", "%", "s", "h", "kg", "J/K")
WORDS = (
    "", " ", "null", "~", "true", "on", "unknown", "unknown 1..5 W/K", "± 10 %", "1 W/K ± ", "steady", "ambient",
    "room", "hot@0.5", "hot@2", "@", "a: b", "[", "{", "*x", "&x 1", "!!int 1", "<<", "---", "\t", "é", "°C", "\u202e",
    "x" * 300, "'", '"', "#", "%", "tcp.z", "tcp.q", "../x.yaml", "/dev/null", ".", "conduction", "1e400",
)  # fmt: skip
Path = tuple[Any, ...]
_LOADER: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def hostile(chance: random.Random) -> str:
    """A value: a number with a unit, or a word, that does not belong there."""
    if chance.random() < 0.6:
        number = chance.choice(NUMBERS) if chance.random() < 0.5 else f"{10 ** chance.uniform(-12, 12):.4g}"
        return f"{number} {chance.choice(UNITS)}".strip()
    return chance.choice(WORDS)


def mutate_yaml(text: str, chance: random.Random) -> str:
    """By its structure mostly, else by its letters; two in five by numbers only, so that many are accepted."""
    tree = _parse(text) if chance.random() < 0.8 else None
    if not isinstance(tree, dict):
        return mutate_letters(text, chance)
    gently = chance.random() < 0.4
    changes = (_nudge,) if gently else _CHANGES
    for _ in range(chance.choice((1, 1, 1, 2, 3, 6))):
        places = [path for path in _paths(tree, ()) if path and not (gently and not _is_number(_get(tree, path)))]
        if places:
            chance.choice(changes)(tree, chance.choice(places), chance)
    return str(yaml.dump(tree, Dumper=_DUMPER, sort_keys=False, allow_unicode=True, width=1000))


def _parse(text: str) -> Any:
    """A tree of its own each time, without references that the file holds."""
    return deepcopy(_tree_of(text))


@lru_cache(maxsize=64)
def _tree_of(text: str) -> Any:
    return yaml.load(text, Loader=_LOADER)


def _paths(tree: Any, path: Path) -> Iterator[Path]:
    yield path
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, child in items:
        yield from _paths(child, (*path, key))


def _get(tree: Any, path: Path) -> Any:
    for key in path:
        tree = tree[key]
    return tree


def _replace(tree: Any, path: Path, chance: random.Random) -> None:
    _get(tree, path[:-1])[path[-1]] = hostile(chance)


def _scale(tree: Any, path: Path, chance: random.Random) -> None:
    """A number by some powers of ten, or its sign."""
    above, value = _get(tree, path[:-1]), _get(tree, path)
    number, _, rest = str(value).partition(" ")
    try:
        scaled = float(number) * chance.choice((-1, 0, 1e-9, 1e-3, 0.1, 0.3, 0.5, 2, 3, 10, 1e3, 1e9))
    except ValueError:
        above[path[-1]] = hostile(chance)
    else:
        above[path[-1]] = f"{scaled:.6g} {rest}".strip()


def _is_number(value: Any) -> bool:
    return isinstance(value, str) and value[:1].isdigit()


def _nudge(tree: Any, path: Path, chance: random.Random) -> None:
    """A number by a factor that it may well be off by."""
    number, _, rest = str(_get(tree, path)).partition(" ")
    with suppress(ValueError):
        _get(tree, path[:-1])[path[-1]] = f"{float(number) * 10 ** chance.uniform(-1.5, 1.5):.6g} {rest}".strip()


def _remove(tree: Any, path: Path, chance: random.Random) -> None:
    del _get(tree, path[:-1])[path[-1]]


def _rename(tree: Any, path: Path, chance: random.Random) -> None:
    above = _get(tree, path[:-1])
    if isinstance(above, dict):
        above[chance.choice((*WORDS, str(path[-1]) + "x"))] = above.pop(path[-1])


def _graft(tree: Any, path: Path, chance: random.Random) -> None:
    """One piece in the place of another."""
    other = chance.choice([p for p in _paths(tree, ()) if p])
    piece = deepcopy(_get(tree, other))
    _get(tree, path[:-1])[path[-1]] = piece


def _wrap(tree: Any, path: Path, chance: random.Random) -> None:
    above, value = _get(tree, path[:-1]), _get(tree, path)
    above[path[-1]] = chance.choice(([value], {"x": value}, [value, value], [], {}))


def _double(tree: Any, path: Path, chance: random.Random) -> None:
    above = _get(tree, path[:-1])
    if isinstance(above, dict):
        above[f"{path[-1]} again"] = above[path[-1]]
    else:
        above.append(above[path[-1]])


_CHANGES: tuple[Callable[[Any, Path, random.Random], None], ...] = (
    _replace, _scale, _scale, _scale, _scale, _remove, _rename, _graft, _wrap, _double,
)  # fmt: skip


def mutate_letters(text: str, chance: random.Random) -> str:
    """Letters, words and lines taken out, doubled, exchanged."""
    for _ in range(chance.randint(1, 4)):
        at = chance.randrange(len(text) + 1)
        end, lines = min(len(text), at + chance.randint(0, 30)), text.split("\n")
        line = chance.randrange(len(lines))
        text = chance.choice(
            (
                text[:at] + text[end:],
                text[:at] + hostile(chance) + text[end:],
                "\n".join(lines[:line] + lines[line + 1 :]),
                "\n".join([*lines[:line], chance.choice(lines), *lines[line:]]),
                text[:at] + text[at:end] * 3 + text[end:],
            )
        )
    return text


def mutate_csv(text: str, chance: random.Random) -> str:
    """Rows and cells, the header, the clock, separators, ends of lines."""
    rows = [line.split(",") for line in text.strip().split("\n")]
    for _ in range(chance.choice((1, 1, 2, 4))):
        k, column = chance.randrange(len(rows)), chance.randrange(len(rows[0]))
        some = slice(min(k, 1) or 1, min(len(rows), k + chance.randint(1, 60)))
        match chance.randrange(9):
            case 0:
                del rows[max(k, 1) : some.stop]
            case 1:
                rows[k:k] = [list(row) for row in rows[some]]
            case 2:
                rows[k][column % len(rows[k])] = hostile(chance)
            case 3:
                factor, shift = chance.choice((-1, 0, 10, 1e3, 1e9)), chance.choice((0, 0, 273.15, 2000, 1e8))
                rows[1:] = [_moved(row, column, factor, shift) for row in rows[1:]]
            case 4:
                rows[some] = [_moved(row, 0, 1, chance.choice((1e8, -1e3, 0.5))) for row in rows[some]]
            case 5:
                gap = chance.choice(("", "nan", "85", "-127"))
                rows[some] = [[*row[:column], gap, *row[column + 1 :]] for row in rows[some]]
            case 6:
                rows = [row[:column] + row[column + 1 :] for row in rows]
            case 7:
                rows[0][column % len(rows[0])] = chance.choice((*WORDS, "time [degC]", "T_hot [rpm]", "ambient [K]"))
            case 8:
                rows[1:] = rows[:0:-1] if chance.random() < 0.3 else rows[1 : max(3, k)]
        if not rows or not rows[0]:
            break
    mark, end = chance.choice((",", ",", ",", ";", "\t")), chance.choice(("\n", "\n", "\r\n"))
    told = end.join(mark.join(row) for row in rows) + end
    return mutate_letters(told, chance) if chance.random() < 0.1 else told


def _moved(row: list[str], column: int, factor: float, shift: float) -> list[str]:
    try:
        value = float(row[column]) * factor + shift
    except (ValueError, IndexError):
        return row
    return [*row[:column], f"{value:.7g}", *row[column + 1 :]]
