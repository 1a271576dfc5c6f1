"""Solvers: a plan says which; modal and expm are exact for affine networks, reference (solve_ivp) serves every one."""
