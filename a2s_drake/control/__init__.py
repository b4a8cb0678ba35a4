"""The controller that tracks a path and an attitude."""
