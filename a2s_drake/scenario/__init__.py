"""What a flight depends on, as data."""
