"""Packages that only some of the project needs."""

import importlib
import importlib.util
from typing import Any


def is_installed(package: str) -> bool:
    """Whether a package can be imported."""
    try:
        return importlib.util.find_spec(package) is not None
    except ValueError:  # what an import blocked in sys.modules looks like
        return False


def require(package: str, otherwise: str) -> Any:
    """A package's module.

    Raises:
      ModuleNotFoundError: with the words of `otherwise`, when the package is missing.
    """
    try:
        return importlib.import_module(package)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(otherwise) from error
