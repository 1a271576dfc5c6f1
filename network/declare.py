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
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from network.fields import REQUIRED, Field, Nested, ParamField
from network.proposals import bodies
from network.refusal import Complaints, Refused, Spot, likely
from network.units import BadNumber, Number
from network.yamlfile import Branch, Leaf, Tree

Array: TypeAlias = NDArray[np.float64]
Advice: TypeAlias = tuple[str, str, str]
"""What an entry says against itself: (field, what is wrong, what would be right)."""

_REGISTRY: dict[str, dict[str, type[Declared]]] = {}


def registered(section: str) -> Mapping[str, type[Declared]]:
    """The kinds of one section of a machine file, sorted by name. The rooms must be loaded (see network.rooms)."""
    return dict(sorted(_REGISTRY.get(section, {}).items()))


class Declared(ABC):
    """An entry of a machine file. Subclasses declare fields; a class with a `kind` is final and in the registry.

    section: where it stands in the file; fields: in the order declared; one_of: groups of fields of which exactly one
    must be given; strength: the parameter that at 0 means "not there"; looks_like: kinds it is confused with;
    replaces: kinds whose place it can take, with the parameters it keeps ({theirs: ours}); sentence: how it reads.
    """

    section: ClassVar[str] = ""
    kind: ClassVar[str] = ""
    fields: ClassVar[dict[str, Field]] = {}
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    strength: ClassVar[str] = ""
    looks_like: ClassVar[tuple[str, ...]] = ()
    replaces: ClassVar[Mapping[str, Mapping[str, str]]] = {}
    sentence: ClassVar[str] = ""
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
            _REGISTRY.setdefault(cls.section, {})[kind] = cls

    def __init__(self, name: str = "", spot: Spot | None = None, spots: Mapping[str, Spot] | None = None, **values: Any):
        numbers = {k: v for k, v in values.items() if isinstance(v, Number)}
        plain = {k: v.value if isinstance(v, Number) else v for k, v in values.items()}
        unknown = set(values) - set(self.fields)
        if unknown:
            raise TypeError(f"{type(self).__name__} has no field {sorted(unknown)}")
        defaults = {k: f.initial for k, f in self.fields.items()}
        self.__dict__.update(defaults | plain)
        self.__dict__.update(name=name, spot=spot or Spot("python"), numbers=numbers, _spots=dict(spots or {}))

    def __setattr__(self, key: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is frozen")

    def __repr__(self) -> str:
        inside = ", ".join(f"{k}: {v}" for k, v in self.to_plain().items())
        return f"{self.name or type(self).__name__} {{{inside}}}"

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.to_plain() == other.to_plain()  # type: ignore[attr-defined]

    __hash__ = None  # type: ignore[assignment]

    def spot_of(self, field: str) -> Spot:
        spots: Mapping[str, Spot] = self.__dict__["_spots"]
        return spots.get(field, self.spot)

    def given(self, field: str) -> bool:
        return self.__dict__[field] is not None

    def uncertain(self) -> Mapping[str, Number]:
        """The numbers that may be calibrated: those with ± or `unknown`."""
        return {k: n for k, n in self.numbers.items() if n.prior != "known"}

    # -- YAML -------------------------------------------------------------------------------------------------------
    @classmethod
    def read(cls, name: str, tree: Tree, complaints: Complaints) -> Self | None:
        """The entry from its YAML; every fault goes to `complaints`, and None comes back where there was one."""
        where = f"{cls.section}.{name}" if cls.section else name
        if isinstance(tree, Leaf):
            hint = "write `{}` for an empty one" if tree.is_null else "write `{key: value, …}`"
            complaints.refuse(tree.spot, f"{where} is not a mapping", hint)
            return None
        if not isinstance(tree, Branch):
            complaints.refuse(tree.spot, f"{where} is a list", "write `{key: value, …}`")
            return None
        before = len(complaints.refusals)
        values = dict(_read_fields(cls, where, tree, complaints))
        _check_forms(cls, where, tree, values, complaints)
        if len(complaints.refusals) > before:
            return None
        keys = {f.attribute: tree.key_spot(f.key) for f in cls.fields.values() if f.key in tree.items}
        entry = cls(name, tree.spot, keys, **values)
        for field, wrong, right in entry.faults():
            complaints.refuse(entry.spot_of(field), f"{where}: {wrong}", right)
        return entry

    def to_plain(self) -> dict[str, Any]:
        """The entry as it would stand in a file. Reading it again gives an equal entry."""
        body: dict[str, Any] = {"kind": self.kind} if self.kind else {}
        for attribute, field in self.fields.items():
            value = self.numbers.get(attribute, self.__dict__[attribute])
            if value is not None and value != field.initial:
                body[field.key] = field.write(value)
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
        return other

    def structure(self) -> tuple[object, ...]:
        """Entries of one class with equal structure can be stacked: the same forms and words, other numbers."""
        return (type(self), *(self._structure_of(name, field) for name, field in self.fields.items()))

    def _structure_of(self, name: str, field: Field) -> object:
        value = self.__dict__[name]
        return value is not None if isinstance(field, ParamField) else field.structure(value)

    def resolved(self, machine: Any) -> Self:
        """The entry with what only the whole machine knows: the reference, a material's expansion, a length."""
        return self

    @classmethod
    def stack(cls, entries: Sequence[Self]) -> Self:
        """One instance whose parameters are arrays over the entries, in their order."""
        first = entries[0]
        arrays = {
            name: np.array([entry.__dict__[name] for entry in entries], float)
            for name in (*cls.params(), *cls.derived)
            if first.__dict__[name] is not None
        }
        return first.replaced(**arrays)


def _read_fields(
    cls: type[Declared], where: str, tree: Branch, complaints: Complaints
) -> Iterator[tuple[str, Any]]:
    keys = {field.key: (attribute, field) for attribute, field in cls.fields.items()}
    for key, child in tree.items.items():
        if key == "kind" and cls.kind:
            continue
        if key not in keys:
            complaints.refuse(tree.key_spot(key), f"{where} has an unknown key '{key}'", likely(key, keys))
            continue
        attribute, field = keys[key]
        try:
            if isinstance(field, Nested):
                yield attribute, field.parse_entry(f"{where}.{key}", child, complaints)
            else:
                yield attribute, field.parse(child)
        except BadNumber as error:
            complaints.refuse(tree.key_spot(key), f"{where}: {key} {error.wrong}", error.right)
        except Refused as refused:
            complaints.absorb(refused)
    for attribute, field in cls.fields.items():
        if field.default is REQUIRED and field.key not in tree.items and not _in_forms(cls, attribute):
            complaints.refuse(tree.spot, f"{where} lacks '{field.key}'", f"give it: {field.meaning}{field.example}")


def _in_forms(cls: type[Declared], attribute: str) -> bool:
    return any(attribute in form for form in cls.one_of)


def _check_forms(
    cls: type[Declared], where: str, tree: Branch, values: Mapping[str, Any], complaints: Complaints
) -> None:
    """Exactly one of the groups in `one_of`, and that one whole."""
    if not cls.one_of:
        return
    choices = " | ".join(" + ".join(cls.fields[a].key for a in form) for form in cls.one_of)
    given = {a for form in cls.one_of for a in form if cls.fields[a].key in tree.items}
    if given not in [set(form) for form in cls.one_of]:
        complaints.refuse(tree.spot, f"{where} needs exactly one of: {choices}", f"give one of: {choices}")


class Effect(Declared):
    """Base of what has a heat flow, a displacement or a reading: it can be missing, so it can be proposed."""

    inputs: ClassVar[Mapping[str, str]] = {}
    """Input channels the equation reads, each with a unit of the kind it must have: {"speed": "rpm"}."""

    def needs(self) -> Mapping[str, str]:
        """The input channels this entry reads, with a unit of the kind each must have."""
        return self.inputs

    def said(self, **more: str) -> str:
        """The sentence, with numbers in their units; `more`: what the entry itself does not know, like its channel."""
        return self.sentence.format_map(_Words(self, more))

    @classmethod
    @abstractmethod
    def proposes(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """Patches: where in this machine the effect could be missing, each with a typical strength."""

    @classmethod
    def path_to(cls, parameter: str, patch: Mapping[str, Any]) -> str:
        """Where a parameter of this kind stands in a patch it proposed, like 'links.skin.gain'."""
        path = next(path for path, body in reversed([*bodies(patch)]) if body.get("kind") == cls.kind)
        return f"{path}.{cls.fields[parameter].key}"

    @classmethod
    def told(cls, machine: Any, patch: Mapping[str, Any]) -> str:
        """The sentence of a patch it proposed, with the numbers of the machine the patch was laid over."""
        path = cls.path_to(cls.strength, patch).rpartition(".")[0]
        channel = path.removeprefix("sensors.").rpartition(".effects.")[0]
        entry: Effect = dict(machine.entries())[path]
        return entry.said(channel=channel)


class _Words(dict[str, Any]):
    """What a sentence may name: the fields as they read, then any attribute of the entry."""

    def __init__(self, entry: Effect, more: Mapping[str, str]) -> None:
        super().__init__(more)
        self.entry = entry

    def __missing__(self, key: str) -> Any:
        value, field = getattr(self.entry, key), self.entry.fields.get(key)
        return "" if value is None else field.tell(value) if field else value


def typical_body(cls: type[Declared], **given: Any) -> dict[str, Any]:
    """The YAML of an entry with typical values for every required parameter, for a proposal."""
    forms = set(cls.one_of[0]) if cls.one_of else set()
    skipped = {attribute for form in cls.one_of for attribute in form} - forms
    body: dict[str, Any] = {"kind": cls.kind}
    for attribute, field in cls.params().items():
        if attribute not in skipped and (field.default is REQUIRED or attribute in forms):
            body[field.key] = field.write(field.proposal())
    return body | given
