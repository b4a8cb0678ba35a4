"""The hexarotor: its plant, its prediction model and what follows from both."""
