"""ROOM 2: how temperature rise or heat moves the tool centre point. One effect, one file."""
