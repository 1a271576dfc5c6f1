"""Heat of any course at any part: how likely it makes what is left, where it sits, what it leaves to a name."""
