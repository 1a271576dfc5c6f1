"""From a machine to a run: the network as arrays, the heat balance, solvers, trajectories, and how answers move."""
