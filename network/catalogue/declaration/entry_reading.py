"""From the YAML of an entry to the values of its fields, with every fault told by its place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, Protocol, Self, TypeVar

from network.catalogue.declaration.field import REQUIRED, Field
from network.catalogue.declaration.registry import section_of
from network.platform.quantities.units import BadNumber
from network.platform.refusal import Complaints, likely, short
from network.platform.yaml.tree import Branch, Items, Leaf, Tree


class Readable(Protocol):
    """What is asked of a class of entries to read one of them."""

    kind: ClassVar[str]
    fields: ClassVar[dict[str, Field]]
    one_of: ClassVar[tuple[tuple[str, ...], ...]]

    @classmethod
    def read(cls, name: str, tree: Tree, complaints: Complaints, where: str = "") -> Self | None: ...


Entry = TypeVar("Entry", bound=Readable)


class Nested(Field):
    """An entry of its own kind inside an entry, or a list of entries chosen by their `kind`."""

    def __init__(self, meaning: str, of: Callable[[], Any], many: bool, required: bool = False) -> None:
        super().__init__(meaning, REQUIRED if required else () if many else None)
        self.of, self.many = of, many

    def parse(self, tree: Tree) -> Any:
        raise NotImplementedError("nested entries are read with parse_entry")

    def parse_entry(self, where: str, tree: Tree, complaints: Complaints) -> Any:
        if not self.many:
            return self.of().read(where, tree, complaints, where)
        if not isinstance(tree, Items):
            raise BadNumber("is not a list", "write [{kind: …, …}, …]")
        read = [read_kind(self.of(), f"{where}.{i}", child, complaints) for i, child in enumerate(tree.entries)]
        return tuple(entry for entry in read if entry is not None)

    def write(self, value: Any) -> Any:
        return [entry.to_plain() for entry in value] if self.many else value.to_plain()

    @property
    def sample(self) -> Any:
        """What an entry of its kind cannot do without."""
        fields = {} if self.many else self.of().fields
        return {f.key: f.sample for f in fields.values() if f.default is REQUIRED} or None

    def schema(self) -> dict[str, Any]:
        """What stands in it is described by its kinds; see network.machine.schema."""
        return {"type": "array" if self.many else "object"}

    def structure(self, value: Any) -> object:
        return tuple(e.structure() for e in value) if self.many else value is not None


def read_kind(kinds: Mapping[str, type[Entry]], where: str, tree: Tree, complaints: Complaints) -> Entry | None:
    """The entry of the class that its `kind` names; `where` is its path in the file."""
    if not isinstance(tree, Branch):
        complaints.refuse(tree.spot, f"{where} is {_shape(tree)}", "write `{kind: …, …}`")
        return None
    child = tree.items.get("kind")
    if not isinstance(child, Leaf) or child.is_null:
        complaints.refuse(tree.spot, f"{where} has no kind", "give one of: " + ", ".join(kinds))
        return None
    if child.text not in kinds:
        elsewhere = section_of(child.text)
        right = f"that kind belongs to {elsewhere}" if elsewhere else likely(child.text, kinds)
        complaints.refuse(child.spot, f"{where} has an unknown kind '{short(child.text)}'", right)
        return None
    return kinds[child.text].read(where.partition(".")[2] or where, tree, complaints, where)


def read_values(cls: type[Entry], where: str, tree: Tree, complaints: Complaints) -> dict[str, Any] | None:
    """Attribute → value for everything given; None after a fault, which goes to `complaints`."""
    if not isinstance(tree, Branch):
        hint = "write `{}` for one without anything" if _shape(tree) == "empty" else "write `{key: value, …}`"
        complaints.refuse(tree.spot, f"{where} is {_shape(tree)}", hint)
        return None
    before = len(complaints.refusals)
    values = dict(_read_given(cls, where, tree, complaints))
    _check_missing(cls, where, tree, complaints)
    _check_forms(cls, where, tree, complaints)
    return values if len(complaints.refusals) == before else None


def _shape(tree: Tree) -> str:
    if isinstance(tree, Leaf):
        return "empty" if tree.is_null else "not a mapping"
    return "a list"


def _read_given(cls: type[Entry], where: str, tree: Branch, complaints: Complaints) -> Iterator[tuple[str, Any]]:
    keys = {field.key: field for field in cls.fields.values()}
    for key, child in tree.items.items():
        if key in keys:
            try:
                yield keys[key].attribute, _value(keys[key], f"{where}.{key}", child, complaints)
            except BadNumber as error:
                spot = error.spot or tree.key_spot(key)
                complaints.refuse(spot, f"{where}: {key} {error.wrong}", error.right)
        elif key != "kind" or not cls.kind:
            is_decimal = key[:1].isdigit() and isinstance(child, Leaf) and child.is_null
            right = "write decimals with a point, like 0.5" if is_decimal else likely(key, keys)
            complaints.refuse(tree.key_spot(key), f"{where} has an unknown key '{short(key)}'", right)


def _value(field: Field, where: str, tree: Tree, complaints: Complaints) -> Any:
    return field.parse_entry(where, tree, complaints) if isinstance(field, Nested) else field.parse(tree)


def _check_missing(cls: type[Entry], where: str, tree: Branch, complaints: Complaints) -> None:
    in_forms = {attribute for form in cls.one_of for attribute in form}
    told = _find_misspelt(cls, tree)
    for attribute, field in cls.fields.items():
        if field.default is REQUIRED and field.key not in {*tree.items, *told} and attribute not in in_forms:
            complaints.refuse(tree.spot, f"{where} lacks '{field.key}'", f"give it: {field.meaning}{field.example}")


def _find_misspelt(cls: type[Entry], tree: Branch) -> set[str]:
    """The keys that were probably meant by unknown ones: told already, not to be called missing as well."""
    keys = [field.key for field in cls.fields.values()]
    hints = {likely(key, keys) for key in tree.items if key not in keys and key != "kind"}
    return {key for key in keys if f"did you mean '{key}'?" in hints}


def _check_forms(cls: type[Entry], where: str, tree: Branch, complaints: Complaints) -> None:
    """Exactly one of the groups in `one_of`, and that one whole."""
    forms = [{cls.fields[a].key for a in form} for form in cls.one_of]
    given = {key for form in forms for key in form if key in {*tree.items, *_find_misspelt(cls, tree)}}
    if not forms or given in forms:
        return
    choices = " | ".join(" + ".join(cls.fields[a].key for a in form) for form in cls.one_of)
    read = " and ".join(f"'{key}'" for key in tree.items if key in given) or "nothing to compute with"
    complaints.refuse(tree.spot, f"{where} has {read}", f"give exactly one of: {choices}")
