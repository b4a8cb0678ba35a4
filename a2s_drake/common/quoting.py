"""Quoting: how a message shows what somebody typed, on one line and never at great length."""

import reprlib

# Lengths, in characters, of a value or a name in a message, of a path, and of a whole message.
VALUE_LENGTH = 80
PATH_LENGTH = 200
MESSAGE_LENGTH = 480


class _Short(reprlib.Repr):
    """The repr of a value, of which only the first entries are looked at where there are many."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlist = self.maxtuple = self.maxarray = 8
        self.maxstring = self.maxlong = self.maxother = VALUE_LENGTH

    def repr_int(self, x: int, level: int) -> str:
        """As for every value; Python refuses to write out integers of more than 4300 digits."""
        try:
            return super().repr_int(x, level)
        except ValueError:
            return f"an integer of about {int(x.bit_length() * 0.30103) + 1} digits"


def shorten(text: str, length: int) -> str:
    """A text of at most some characters; what is too much goes from the middle."""
    if len(text) <= length:
        return text
    kept = length - 3
    return f"{text[: kept - kept // 2]}...{text[len(text) - kept // 2 :]}"


def one_line(text: str, length: int) -> str:
    """A text on one line of at most some characters; line breaks and the like are written as escapes."""
    short = shorten(text, length)
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in short)
    return shorten(shown, length)


def quoted(value: object) -> str:
    """A value as Python writes it, on one line and shortened."""
    return one_line(_Short().repr(value), VALUE_LENGTH)


def named(name: str) -> str:
    """The name of a field or a key: as it is, but quoted where it is empty, long, or hides a character."""
    return name if name.isprintable() and 0 < len(name) <= VALUE_LENGTH else quoted(name)
