"""What a script imports first when it runs: signals are answered, and every standard stream is there."""

from scripts import ending

ending.listen(ending.end_at_once)

from scripts import streams  # noqa: E402 - signals first: any import takes time

streams.open_closed()
streams.guard()
