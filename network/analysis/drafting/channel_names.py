"""What the name of a column tells of it: surroundings, a set point, an axis of displacement; and names for parts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

OUTDOORS = "outdoor outdoors outside outer exterior ext aussen draussen extern exterieur esterno exterior 外気 室外"
SURROUNDINGS = (
    "ambient amb ambience environment env umgebung umg umgeb umwelt surrounding surroundings ambiente ambiante "
    "ambiance atmosphere omgeving omgivning okoli otoczenie 环境 環境"
)
ROOMS = (
    "room hall shop workshop lab labor climate raum halle hallen werkstatt klima sala salle local piece stanza "
    "室温 室内"
)
WORDS = tuple(text.split() for text in (OUTDOORS, SURROUNDINGS, ROOMS))
"""Words for what surrounds a machine, from the farthest to the nearest: a heated room has its outdoors."""
LONG, LONGER = 4, 7
"""Letters from which a word is known at the beginning of a longer one, like Raumtemperatur, and anywhere in it."""
SET_POINTS = frozenset(
    ["set", "setpoint", "sp", "soll", "sollwert", "target", "goal", "consigna", "consigne", "command", "cmd", "目标"]
)
COUNTERS = frozenset(["sample", "index", "row", "no", "nr", "counter", "count", "step", "line"])
COOLING = ("cool", "chill", "kühl", "kuehl", "fan", "lüfter", "luefter", "refroid", "raffredd", "ventil", "冷")
"""What words of an input begin with that may take heat away."""
_AXIS = re.compile(r"(?:^|[^a-z])(?:d|delta|disp|displacement|u|pos)?[ _-]?([xyz])(?:$|[^a-z])")
_UNITS = frozenset(["c", "degc", "k", "f", "degf", "um", "mm", "m", "rpm", "pct", "w", "kw", "s", "min", "h", "v", "a"])
_PREFIXES = frozenset(["t", "temp", "temperature", "temperatur", "sensor", "th", "tc", "pt", "ntc"])


def words_of(name: str) -> list[str]:
    """The words of a name, in small letters: T_bed_ref_C → t, bed, ref, c; headMotor → head, motor."""
    parted = re.sub(r"(?<=[a-zäöü])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[\W_\d]+", parted.lower()) if word]


def nearness(name: str) -> int | None:
    """0 for outdoors, 1 for surroundings, 2 for a room; None for a name that tells of none."""
    words = words_of(name)
    for rank, known in enumerate(WORDS):
        if any(_tells(word, known) for word in words):
            return rank
    return None


def _tells(word: str, known: Sequence[str]) -> bool:
    """Whether a word is one of these, with a T before it, or holds one."""
    return word in known or (word[0] == "t" and word[1:] in known) or any(_holds(word, part) for part in known)


def _holds(word: str, part: str) -> bool:
    is_anywhere = not part.isascii() or len(part) >= LONGER
    return part in word if is_anywhere else len(part) >= LONG and word.startswith(part)


def is_set_point(name: str) -> bool:
    return any(word in SET_POINTS or word.startswith(("setpoint", "sollwert")) for word in words_of(name))


def is_counter(name: str) -> bool:
    return any(word in COUNTERS for word in words_of(name))


def is_cooling(name: str) -> bool:
    return any(word.startswith(COOLING) for word in words_of(name))


def axis_in(name: str) -> str:
    """x, y or z where a name tells of one, '' else."""
    found = _AXIS.search(name.lower())
    return found[1] if found else ""


def name_part(sensors: Sequence[str], taken: Iterable[str]) -> str:
    """A part's name from those of its sensors, without the T of a temperature and the unit behind: what they have in
    common, else the names of two, else that of the first."""
    lists = [_core(name) for name in sensors]
    common = [word for word in lists[0] if all(word in other for other in lists)]
    first, *others = [" ".join(words) for words in lists]
    alone = f"{first} and {others[0]}" if len(others) == 1 else f"{first} and alike" if others else first
    name = " ".join(re.sub(r"[@,\[\]]", " ", " ".join(common) or alone).split()) or sensors[0]
    return fresh_name(name, taken)


def fresh_name(name: str, taken: Iterable[str]) -> str:
    """The name, with a number behind where it is taken or means an axis."""
    known = set(taken)
    name = f"part {name}" if re.fullmatch(r"(tcp\.)?[xyzabc]", name) else name
    return next(n for n in (name, *(f"{name} {k}" for k in range(2, len(known) + 3))) if n not in known)


def _core(name: str) -> list[str]:
    words = [word for word in re.split(r"[\s_]+", name) if word]
    if len(words) > 1 and words[-1].lower() in _UNITS:
        words = words[:-1]
    if len(words) > 1 and words[0].lower() in _PREFIXES:
        words = words[1:]
    return words
