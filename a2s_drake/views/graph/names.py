"""Names for blocks: those that Drake makes up hold a memory address, and would differ on every run."""

import re
from collections.abc import Sequence
from typing import Any

_MADE_UP = re.compile(r".*@[0-9a-f]{8,}")


def class_name(system: Any) -> tuple[str, str]:
    """A system's class without module and scalar type, and the package that it comes from.

    `a2s_drake.link.two_ray.TwoRayChannel_[float]` is `TwoRayChannel` of `a2s_drake`, and
    `drake::systems::Gain<double>` is `Gain` of `drake`.
    """
    full = system.GetSystemType().replace("<locals>.", "").replace("::", ".")
    parts = re.split(r"[<\[]", full)[0].split(".")
    return parts[-1].removesuffix("_") or "System", parts[0]


def block_names(systems: Sequence[Any]) -> list[str]:
    """The systems' names; for those that have none, class and number, as no other has it."""
    names = [system.get_name() for system in systems]
    taken = set(names)
    for i, system in enumerate(systems):
        if not names[i] or _MADE_UP.fullmatch(names[i]):
            own = f"{class_name(system)[0]}_{i}"
            while own in taken:
                own += "_"
            names[i] = own
            taken.add(own)
    return names
