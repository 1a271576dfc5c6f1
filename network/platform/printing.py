"""How results show themselves: short at the prompt, whole when printed, as a page in a notebook, as a picture, as a
table. What they say and how they look is asked for here, and given by a room that they know nothing of."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Protocol

from network.platform.data_frame import table_frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 60
"""Characters of a text that a short form shows."""
SEVERAL = 6
"""Entries of a list or mapping that it names."""
_PAGE = '<pre style="line-height:1.25; overflow-x:auto">{}</pre>'


class Printer(Protocol):
    """Whoever puts results into words and pictures."""

    def tell(self, what: Any) -> str:
        """As a person reads it in a terminal."""

    def summarise(self, what: Any) -> dict[str, Any]:
        """As a machine reads it: the contents of a JSON file."""

    def plot(self, what: Any, names: Sequence[str], axes: Axes | None) -> Axes:
        """As a picture, into axes that are given or new ones."""

    def tabulate(self, what: Any) -> tuple[list[str], list[list[Any]]]:
        """As a table: header and rows."""


_FOUND: list[Callable[[], Printer]] = []


def use_printer(find: Callable[[], Printer]) -> None:
    """From now on this one prints; it is not looked for before something is printed."""
    _FOUND[:] = [find]


def tell(what: Any) -> str:
    return _FOUND[0]().tell(what)


def summarise(what: Any) -> dict[str, Any]:
    return _FOUND[0]().summarise(what)


class Brief:
    """Base of what is shown short at the prompt: its fields, arrays by their shape, what it holds by its class."""

    def __repr__(self) -> str:
        shown = ", ".join(f"{f.name}={brief(getattr(self, f.name))}" for f in fields(self) if f.repr)  # type: ignore[arg-type]
        return f"<{type(self).__name__} {shown}>"


class Result(Brief):
    """Base of what a command tells: whole when printed, and in a notebook."""

    def __str__(self) -> str:
        return tell(self)

    def _repr_html_(self) -> str:
        return _PAGE.format(escape(str(self)))


class Drawn(Result):
    """Base of a result that is drawn, too."""

    def plot(self, *names: str, axes: Axes | None = None) -> Axes:
        """Draws channels (without names: what matters most) into matplotlib axes, and returns them.

        Raises Refused for a name that is not there, and for channels that do not go into one unit.
        """
        return _FOUND[0]().plot(self, names, axes)


class Tabled(Drawn):
    """Base of a result that is a table, too."""

    def to_pandas(self) -> Any:
        """The table as a data frame. Raises ImportError without pandas."""
        return table_frame(*_FOUND[0]().tabulate(self))


def brief(value: Any) -> str:
    """A value in a few words."""
    import numpy as np  # which starting a command does without

    if isinstance(value, str):
        return repr(value if len(value) <= MOST else value[: MOST - 1] + "…")
    if isinstance(value, np.ndarray) and value.ndim:
        return f"[{' × '.join(map(str, value.shape))}]"
    if isinstance(value, float | np.floating):
        return f"{float(value):.6g}"
    if isinstance(value, Mapping):
        return "{" + _list_some([str(key) for key in value]) + "}"
    if isinstance(value, tuple | list) and all(isinstance(each, str) for each in value):
        return "(" + _list_some([brief(each) for each in value]) + ")"
    if isinstance(value, tuple | list | set | frozenset):
        return f"{len(value)} × {type(next(iter(value))).__name__}" if value else "()"
    text = "" if is_dataclass(value) else repr(value)
    return text if 0 < len(text) <= MOST and " object at 0x" not in text else type(value).__name__


def _list_some(names: list[str]) -> str:
    more = f", … {len(names)} in all" if len(names) > SEVERAL else ""
    return ", ".join(names[:SEVERAL]) + more
