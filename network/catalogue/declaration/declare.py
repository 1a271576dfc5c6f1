"""The grammar of every entry a machine file may hold: its fields, their YAML form, their refusals.

A class declares its fields once; reading, writing, refusing, bounds of a fit, schema and tables come from there::

    class Radiation(Link, kind="radiation"):
        emissivity_area = param("m^2", 0, 100, "emissivity times radiating area")

An instance holds scalars as read from a file, or arrays: `stack` lays many entries of one class side by side, so that
their equation is called once.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from network.catalogue.declaration.entry_path import NumberPath
from network.catalogue.declaration.entry_reading import read_values
from network.catalogue.declaration.field import REQUIRED, Field
from network.catalogue.declaration.input_field import InputField, merge_inputs
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.positions import Along
from network.catalogue.declaration.proposals import Runs
from network.catalogue.declaration.registry import enter, list_kinds
from network.platform.quantities.units import Number
from network.platform.refusal import Complaints, Spot
from network.platform.yaml.tree import Branch, Tree

__all__ = ["Advice", "Array", "Declared", "Effect", "list_kinds", "typical_body"]

Array: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.integer[Any]]
Mask: TypeAlias = NDArray[np.bool_]
Advice: TypeAlias = tuple[str, str, str]
"""What an entry says against itself: (field, what is wrong, what would be right)."""


class Declared(ABC):
    """An entry of a machine file. Subclasses declare fields; a class with a `kind` is final and in the registry.

    section: where it stands in the file; fields: in the order declared; one_of: groups of fields of which exactly one
    must be given; strength: the parameter that at 0 means "not there"; shapes: further parameters that a fit frees with
    the strength when it is a candidate, none by default; replaces: kinds whose place it can take, with the parameters
    it keeps ({theirs: ours}), spread and all; sentence: how it reads; changed: parameter → what it means where that has
    grown since once, and where it has fallen.
    """

    section: ClassVar[str] = ""
    kind: ClassVar[str] = ""
    fields: ClassVar[dict[str, Field]] = {}
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    strength: ClassVar[str] = ""
    shapes: ClassVar[tuple[str, ...]] = ()
    replaces: ClassVar[Mapping[str, Mapping[str, str]]] = {}
    sentence: ClassVar[str] = ""
    changed: ClassVar[Mapping[str, tuple[str, str]]] = {}
    derived: ClassVar[tuple[str, ...]] = ()
    """Attributes set by `resolved`, stacked like parameters."""

    name: str
    spot: Spot
    numbers: Mapping[str, Number]

    def __init_subclass__(cls, kind: str = "", **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        inherited = {k: f for base in reversed(cls.__mro__[1:]) for k, f in getattr(base, "fields", {}).items()}
        own = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        cls.fields = {**inherited, **own}
        if kind:
            cls.kind = kind
            if inspect.isabstract(cls):
                raise TypeError(f"{cls.__name__} has a kind and must be final")
            enter(cls)

    def __init__(
        self, name: str = "", spot: Spot | None = None, spots: Mapping[str, Spot] | None = None, **values: Any
    ) -> None:
        numbers = {k: v for k, v in values.items() if isinstance(v, Number)}
        plain = {k: v.value if isinstance(v, Number) else v for k, v in values.items()}
        unknown = set(values) - set(self.fields)
        if unknown:
            raise TypeError(f"{type(self).__name__} has no field {sorted(unknown)}")
        defaults = {k: f.initial for k, f in self.fields.items()}
        self.__dict__.update(defaults | plain)
        self.__dict__.update(name=name, spot=spot or Spot("python"), numbers=numbers, _spots=dict(spots or {}))
        self.__dict__["_units"] = {k: n.unit for k, n in numbers.items() if n.unit}

    def __setattr__(self, key: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is frozen")

    def __repr__(self) -> str:
        stacked = [value for value in self.__dict__.values() if isinstance(value, np.ndarray) and value.ndim]
        if stacked:
            return f"<{len(stacked[0])} {type(self).__name__} in one>"
        inside = ", ".join(f"{k}: {v}" for k, v in self.to_plain().items())
        return f"{self.name or type(self).__name__} {{{inside}}}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and type(self) is type(other) and self.to_plain() == other.to_plain()

    __hash__ = None  # type: ignore[assignment]

    def spot_of(self, field: str) -> Spot:
        spots: Mapping[str, Spot] = self.__dict__["_spots"]
        return spots.get(field, self.spot)

    def is_given(self, field: str) -> bool:
        return self.__dict__[field] is not None

    def field_of(self, attribute: str) -> Field:
        """A field, in the unit that this entry's number came in."""
        field, given = self.fields[attribute], self.__dict__["_units"].get(attribute, "")
        return field.in_unit(given) if given and isinstance(field, ParamField) else field

    def uncertain(self) -> Mapping[str, Number]:
        """The numbers that may be calibrated: those with ± or `unknown`."""
        return {k: n for k, n in self.numbers.items() if n.prior != "known"}

    def needs(self) -> Mapping[str, str]:
        """The input channels this entry reads, with a unit of the kind each must have."""
        return {}

    # -- YAML -------------------------------------------------------------------------------------------------------
    @classmethod
    def read(cls, name: str, tree: Tree, complaints: Complaints, where: str = "") -> Self | None:
        """The entry from its YAML; every fault goes to `complaints`, and None comes back where there was one.

        where: its path in the file, for messages; by default section and name.
        """
        where = where or (f"{cls.section}.{name}" if cls.section else name)
        values = read_values(cls, where, tree, complaints)
        if values is None or not isinstance(tree, Branch):
            return None
        keys = {f.attribute: tree.key_spot(f.key) for f in cls.fields.values() if f.key in tree.items}
        entry = cls(name, tree.spot, keys, **values)
        faults = list(entry.faults())
        for field, wrong, right in faults:
            complaints.refuse(entry.spot_of(field), f"{where}: {wrong}", right)
        return None if faults else entry

    def to_plain(self) -> dict[str, Any]:
        """The entry as it would stand in a file. Reading it again gives an equal entry."""
        body: dict[str, Any] = {"kind": self.kind} if self.kind else {}
        for attribute, field in self.fields.items():
            value = self.numbers.get(attribute, self.__dict__[attribute])
            if value is not None and value != field.initial:
                body[field.key] = self.field_of(attribute).write(value)
        return body

    def faults(self) -> Iterator[Advice]:
        """What the entry itself can tell is wrong (refused). Overridden where fields depend on each other."""
        yield from ()

    def doubts(self) -> Iterator[Advice]:
        """What the entry itself finds doubtful (warned, not refused)."""
        yield from ()

    # -- values and arrays ------------------------------------------------------------------------------------------
    @classmethod
    def params(cls) -> dict[str, ParamField]:
        return {name: field for name, field in cls.fields.items() if isinstance(field, ParamField)}

    def replaced(self, **values: Any) -> Self:
        """A copy with some values exchanged: scalars, arrays, complex numbers (for complex-step derivatives)."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__ | values)
        if not self.numbers.keys().isdisjoint(values):
            other.__dict__["numbers"] = {k: n for k, n in self.numbers.items() if k not in values}
        return other

    def structure(self) -> tuple[object, ...]:
        """Entries of one class with equal structure can be stacked: the same forms and words, other numbers."""
        return (type(self), *(field.structure(self.__dict__[name]) for name, field in self.fields.items()))

    def resolve(self, machine: MachineLike) -> Self:
        """The entry with what only the whole machine knows: the reference, a material's expansion, a length."""
        return self

    @classmethod
    def stack(cls, entries: Sequence[Self]) -> Self:
        """One instance whose parameters are arrays over the entries, in their order."""
        first = entries[0]
        arrays = {
            name: np.array([entry.__dict__[name] for entry in entries], float)
            for name in (*cls.params(), *cls.derived)
            if not isinstance(first.__dict__[name], Along | None)
        }
        return first.replaced(**arrays)

    def some(self, members: Indices) -> Self:
        """A stacked one with some of its entries."""
        values = ((name, self.__dict__[name]) for name in (*self.params(), *self.derived))
        return self.replaced(**{name: v[members] for name, v in values if isinstance(v, np.ndarray) and v.ndim})


@cache
def input_fields(of: type[Declared]) -> tuple[tuple[str, str], ...]:
    """The fields of a class that name an input, each with the input's unit."""
    return tuple((name, field.unit) for name, field in of.fields.items() if isinstance(field, InputField))


class Effect(Declared):
    """Base of what has a heat flow, a displacement or a reading: it can be missing, so it can be proposed."""

    least_run: ClassVar[float] = 0.0
    """s: a recording that is shorter than this cannot tell it from anything that goes up and down once."""
    shows_in_readings: ClassVar[bool] = False
    """Whether a diagnosis finds it in the readings themselves, before anything is proposed."""
    searched: ClassVar[bool] = True
    """Whether a diagnosis tries its proposals, as far as it can."""

    def needs(self) -> Mapping[str, str]:
        named = ((self.__dict__[field], unit) for field, unit in input_fields(type(self)))
        return merge_inputs((name, unit) for name, unit in named if name is not None)

    def remarks(self, u: Mapping[str, Array]) -> Iterator[str]:
        """What is doubtful about it at the inputs of a whole run."""
        yield from ()

    def said(self, **more: str) -> str:
        """The sentence, with numbers in their units; `more`: what the entry itself does not know, like its channel."""
        return self.sentence.format_map(_Words(self, more))

    @classmethod
    def is_searched(cls) -> bool:
        """Whether a diagnosis tries its proposals."""
        return cls.searched

    @classmethod
    @abstractmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Patches: where in this machine the effect could be missing, each with a typical strength."""

    @classmethod
    def proposes_on(cls, machine: MachineLike, runs: Runs) -> Iterator[Mapping[str, Any]]:
        """The same where recordings are known: nothing that they are too short for, and what they bring themselves."""
        return cls.proposes(machine) if runs.longest >= cls.least_run else iter(())

    @classmethod
    def path_to(cls, parameter: str, patch: Mapping[str, Any]) -> NumberPath:
        """Where a parameter of this kind stands in a patch it proposed, like 'links.skin.gain'."""
        path = next(path for path, body in reversed([*Patch(patch).entries()]) if body.get("kind") == cls.kind)
        return NumberPath(path, cls.fields[parameter].key)

    @classmethod
    def told(cls, machine: MachineLike, patch: Mapping[str, Any]) -> str:
        """The sentence of a patch it proposed, with the numbers of the machine the patch was laid over."""
        path = cls.path_to(cls.strength, patch).entry
        entry = machine.by_path[path]
        assert isinstance(entry, Effect)
        return entry.said(channel=path.name)


class _Words(dict[str, Any]):
    """What a sentence may name: the fields as they read, then any attribute of the entry."""

    def __init__(self, entry: Effect, more: Mapping[str, str]) -> None:
        super().__init__(more)
        self.entry = entry

    def __missing__(self, key: str) -> Any:
        value = getattr(self.entry, key)
        return "" if value is None else self.entry.field_of(key).tell(value) if key in self.entry.fields else value


def typical_body(cls: type[Declared], **given: Any) -> dict[str, Any]:
    """The YAML of an entry with typical values for every required parameter, for a proposal, in the first of its forms
    that has something of what is given, or else in the first."""
    first = cls.one_of[0] if cls.one_of else ()
    forms = next((form for form in cls.one_of if not given.keys().isdisjoint(form)), first)
    skipped = {attribute for form in cls.one_of for attribute in form}.difference(forms)
    body: dict[str, Any] = {"kind": cls.kind}
    for attribute, field in cls.params().items():
        if attribute not in skipped and (field.default is REQUIRED or attribute in forms):
            body[field.key] = field.write(field.proposal())
    return body | given
