"""How the ship carries its antenna: on an upright mast, at its true height."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem


class ShipMotion(LeafSystem):
    """Where the ship's antenna truly is.

    ```
                        +------------+
    ship_position    -->| ShipMotion |--> ship_antenna_position
                        +------------+
    ```

    - `ship_position` (3): the ship's reference point at mean sea level, m, W.
    - `ship_antenna_position` (3): the phase centre of the ship's antenna, m, W.

    The ship neither heaves nor pitches: the antenna stands upright above the reference point. Stateless.
    """

    def __init__(self, antenna_height: float) -> None:
        """A mast that carries the antenna at a true height above mean sea level, m."""
        LeafSystem.__init__(self)
        self._mast = np.array([0.0, 0.0, antenna_height])
        self._ship_position = self.DeclareVectorInputPort("ship_position", 3)
        self.DeclareVectorOutputPort("ship_antenna_position", 3, self._calc_antenna, {self._ship_position.ticket()})

    def _calc_antenna(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._ship_position.Eval(context) + self._mast)
