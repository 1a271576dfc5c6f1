"""A machine: its entries read from a file, checked over the whole, changed by patches and levels."""
