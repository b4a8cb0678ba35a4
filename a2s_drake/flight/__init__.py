"""One run of a diagram: flown, logged, measured and written."""
