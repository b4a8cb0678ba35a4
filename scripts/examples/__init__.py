"""Short programs that teach the library: read them from top to bottom."""
