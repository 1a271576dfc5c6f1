"""What could be missing: patches of the catalogue with their numbers, and what each would show."""
