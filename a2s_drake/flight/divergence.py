"""Divergence: the end of a flight in which the body turns too fast for the integration to follow."""

import numpy as np
from pydrake.systems.framework import Context, Diagram, EventStatus

from a2s_drake.common.signals import State
from a2s_drake.scenario.parts import Simulation

# If a body turns by more than this angle, rad, in one step, no fixed-step scheme can tell in which direction it turned.
# The schemes become unstable at smaller angles already: the third-order one at sqrt(3) rad.
_HALF_A_TURN = np.pi

_SLOW_DOWN = "slow the body down by airframe.inertia, disturbance.inertia_factor or disturbance.rotor_efficiency"


class Diverged(FloatingPointError):
    """A vehicle's motion that the integration cannot follow. The message names the quantity and what to change."""


class DivergenceMonitor:
    """Watches a simulation at each integration step: `Simulator.set_monitor` takes it.

    It changes nothing: a flight that ends well is the same with it and without it.
    """

    def __init__(self, diagram: Diagram, simulation: Simulation, period: float) -> None:
        """A monitor of a diagram that exports `vehicle_state`, stepped within a controller's period, s."""
        self._vehicle_state = diagram.GetOutputPort("vehicle_state")
        self._simulation = simulation
        self._step = min(simulation.max_step_size, period)

    def __call__(self, context: Context) -> EventStatus:
        """Lets a simulation go on.

        Raises:
          Diverged: when its state has overflowed, or the body turns by more than half a turn in a step.
        """
        size = _size(context)
        if not np.isfinite(size):
            raise self.overflow()
        # The angular velocity is part of the state. So if the whole state is small, the body cannot turn fast.
        if size * self._step > _HALF_A_TURN:
            omega = State(self._vehicle_state.Eval(context)).angular_velocity
            self._check_speed(float(np.linalg.norm(omega)))
        return EventStatus.DidNothing()

    def _check_speed(self, speed: float) -> None:
        if speed * self._step > _HALF_A_TURN:
            what = f"the body turns at {speed:.4g} rad/s, more than half a turn in an integration step of"
            remedy = f"lower simulation.max_step_size = {self._simulation.max_step_size!r}, or {_SLOW_DOWN}"
            raise Diverged(f"{what} {self._step:g} s; {remedy}")

    def has_overflowed(self, context: Context) -> bool:
        """Whether the continuous state is not finite, or so large that its squares are not."""
        return not np.isfinite(_size(context))

    def overflow(self) -> Diverged:
        """The error for a state that has overflowed."""
        what = f"the vehicle's state overflowed in integration steps of {self._step:g} s"
        step, integrator = self._simulation.max_step_size, self._simulation.integrator
        remedy = f"lower simulation.max_step_size = {step!r}, take another simulation.integrator than {integrator}"
        return Diverged(f"{what}; {remedy}, or {_SLOW_DOWN}")


def _size(context: Context) -> float:
    """The Euclidean norm of the continuous state; not finite where the state overflows."""
    state = context.get_continuous_state_vector().CopyToVector()
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(state @ state))
