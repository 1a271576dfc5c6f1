"""Solvers: a plan says which; modal and expm are exact for affine networks, reference is solve_ivp for every network."""
