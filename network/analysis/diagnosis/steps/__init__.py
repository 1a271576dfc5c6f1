"""Step by step: what is fitted, kept beside what was found, tested again and taken out."""
