"""Model predictive control: prediction model, mathematical program, solvers, decision with fallbacks, block."""
