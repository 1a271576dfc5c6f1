"""Readings that are not true of the machine: found without a model, told, and set aside before anything is judged."""
