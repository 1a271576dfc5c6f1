"""ROOM 1: heat flows. One physical effect is one small file; adding a file edits nothing else."""
