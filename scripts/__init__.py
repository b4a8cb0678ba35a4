"""Command-line entry points, each with `main(argv=None) -> int`."""
