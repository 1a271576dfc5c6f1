"""ROOM 4: missing physics that takes more than one entry. Each file proposes patches."""
