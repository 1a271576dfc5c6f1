"""Small matters of sentences."""


def sentence(words: str) -> str:
    """The words, the first letter large."""
    return words[:1].upper() + words[1:]
