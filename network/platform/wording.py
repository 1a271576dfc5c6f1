"""Small matters of sentences."""

import textwrap

WIDTH = 116
"""Of the lines of a file."""


def comment(words: str) -> list[str]:
    """Comment lines of a file."""
    return textwrap.wrap(" ".join(words.split()), WIDTH, initial_indent="# ", subsequent_indent="#   ")


def sentence(words: str) -> str:
    """The words, the first letter large."""
    return words[:1].upper() + words[1:]


def name_of(word: str) -> str:
    """A kind, a key or another word with underscores, as a reader says it."""
    return word.replace("_", " ")


def join_either(names: list[str]) -> str:
    """a; a or b; a, b or c."""
    return _join(names, " or ")


def join_names(names: list[str]) -> str:
    """a; a and b; a, b and c."""
    return _join(names, " and ")


def _join(names: list[str], last: str) -> str:
    return last.join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
