"""Benchmark: how long the MPC takes and how exact it is, on the problems of a flight, beside other solvers."""
