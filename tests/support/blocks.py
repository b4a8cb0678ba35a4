"""Blocks of a user's own, made in a line."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import LeafSystem

from a2s_drake import Scenario


class Block(LeafSystem):
    """A block of a user's own: its outputs are constant, or functions of its inputs side by side."""

    def __init__(self, inputs: dict[str, int], outputs: dict[str, Callable[[np.ndarray], np.ndarray] | np.ndarray]):
        LeafSystem.__init__(self)
        ports = [self.DeclareVectorInputPort(name, size) for name, size in inputs.items()]
        for name, value in outputs.items():
            calc = value if callable(value) else lambda _, value=value: value
            width = len(calc(np.zeros(sum(inputs.values()))))

            def serve(context, output, calc=calc) -> None:
                output.SetFromVector(calc(np.concatenate([np.zeros(0), *(port.Eval(context) for port in ports)])))

            self.DeclareVectorOutputPort(name, width, serve)


def resting_at(point: list[float]) -> Callable[[Scenario], Block]:
    """A path that stays at a point, for a horizon of 30."""
    return lambda _: Block({}, {"position_reference": np.array(point), "position_preview": np.tile(point, 31)})


def level(_: Scenario) -> Block:
    """A law that asks for level attitude, for a horizon of 30."""
    return Block({}, {"attitude_reference": np.zeros(3), "attitude_preview": np.zeros(93)})
