"""Results in words for the terminal."""
