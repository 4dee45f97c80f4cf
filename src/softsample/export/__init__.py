"""The simulated tests for other programs: input of their solvers, series for ParaView."""
