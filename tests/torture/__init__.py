"""Hostile inputs by the thousand, and an oracle for what each of them may lead to: `make torture`."""
