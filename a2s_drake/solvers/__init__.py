"""Solvers of quadratic programs behind Drake's interface."""
