"""What a flight hangs on, as data."""
