"""Diagnosis: where simulation and recordings differ, which physics was left out, and whether adding it holds."""
