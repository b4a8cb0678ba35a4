"""The truth outside the UAV: the ship, the sea and the wind."""
