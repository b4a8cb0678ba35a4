"""The MPC as a sampled Drake block."""

import numpy as np
from pydrake.common.containers import namedview
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from a2s_drake.common.signals import NUM_INPUTS, NUM_STATES, Fallback, SolverStatus, State
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Decision, Planner
from a2s_drake.scenario.parts import Airframe, Mpc

# The clock state holds the time of the last decision, and how many samples in a row the plan was only shifted. When
# that number is the horizon's length, nothing is left of the plan.
_Clock = namedview("_Clock", ["time", "shifts"])
_NEVER = -np.inf


def feedforward_ports(mpc: Mpc) -> dict[str, int]:
    """Names and sizes of the inputs that a controller has with `feedforward`, and of a law's outputs that feed them."""
    samples = 3 * (mpc.horizon + 1)
    return {
        "velocity_preview": samples,
        "angular_velocity_preview": samples,
        "rotor_speed_squared_preview": NUM_INPUTS * mpc.horizon,
    }


class MpcController(LeafSystem):
    """Model predictive control of the hexarotor's pose.

    ```
                           +---------------+
    vehicle_state       -->|               |--> rotor_speed_squared
    position_preview    -->| MpcController |--> predicted_state
    attitude_preview    -->|               |--> solver_status
                           +---------------+
    ```

    - `vehicle_state` (12): [p (m, W), eta (rad), v (m/s, W), omega (rad/s, B)].
    - `position_preview` (3(N+1)): reference position now, now + T_s, ..., m, W, row by row.
    - `attitude_preview` (3(N+1)): reference roll, pitch, yaw at the same instants, rad.
    - `rotor_speed_squared` (6): Omega^2 of each rotor, Hz^2, always within the rotor bounds.
    - `predicted_state` (12(N+1)): the plan's states, row by row.
    - `solver_status` (4): see `a2s_drake.common.signals.SolverStatus`.

    With `feedforward` it has three inputs more, and its cost weighs differences from these where it otherwise weighs
    the quantities themselves, as the paper does:

    - `velocity_preview` (3(N+1)): reference velocity at the same instants, m/s, W.
    - `angular_velocity_preview` (3(N+1)): reference angular velocity, rad/s, B.
    - `rotor_speed_squared_preview` (6N): reference Omega^2 over each period, Hz^2.

    Sampled: it decides when simulation begins and then every `mpc.period`; the outputs hold in between. The state of
    the context holds the plan, so one block serves many contexts.
    """

    def __init__(
        self, airframe: Airframe, mpc: Mpc, planner: Planner | None = None, *, feedforward: bool = False
    ) -> None:
        """A controller for a vehicle; without a `planner` of your own, one is made from the settings."""
        LeafSystem.__init__(self)
        self._planner = planner or Planner(airframe, mpc)
        self._horizon = mpc.horizon
        samples = 3 * (mpc.horizon + 1)
        self._vehicle_state = self.DeclareVectorInputPort("vehicle_state", NUM_STATES)
        self._position_preview = self.DeclareVectorInputPort("position_preview", samples)
        self._attitude_preview = self.DeclareVectorInputPort("attitude_preview", samples)
        self._feedforward = {
            name: self.DeclareVectorInputPort(name, size)
            for name, size in (feedforward_ports(mpc).items() if feedforward else ())
        }

        rest = self._planner.hover_plan(np.zeros(NUM_STATES))
        self._states = self.DeclareDiscreteState(rest.state.ravel())
        self._inputs = self.DeclareDiscreteState(rest.input.ravel())
        self._status = self.DeclareDiscreteState(SolverStatus([0.0, 0.0, 0.0, Fallback.HOVER])[:])
        self._clock = self.DeclareDiscreteState(_Clock([_NEVER, 0.0])[:])
        self._measured = self.DeclareDiscreteState(np.full(NUM_STATES, np.nan))  # by the last decision

        self.DeclareVectorOutputPort(
            "rotor_speed_squared",
            NUM_INPUTS,
            self._calc_rotor_speed_squared,
            {self.discrete_state_ticket(self._inputs)},
        )
        self.DeclareStateOutputPort("predicted_state", self._states)
        self.DeclareStateOutputPort("solver_status", self._status)

        self.DeclareInitializationDiscreteUpdateEvent(self._update_from_cold)
        self.DeclarePeriodicDiscreteUpdateEvent(mpc.period, 0.0, self._update_plan)

    def _calc_rotor_speed_squared(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state(self._inputs).value()[:NUM_INPUTS])

    def _update_from_cold(self, context: Context, discrete_state: DiscreteValues) -> None:
        self._decide(context, None, 0, discrete_state)

    def _update_plan(self, context: Context, discrete_state: DiscreteValues) -> None:
        clock = _Clock(context.get_discrete_state(self._clock).value())
        if context.get_time() == clock.time:
            # The periodic event at the start follows the initialization event at the same instant. It has nothing to
            # add, and must not shift the plan a second time.
            return
        started = clock.time != _NEVER and clock.shifts < self._horizon
        previous = self.plan(context) if started else None
        self._decide(context, previous, int(clock.shifts), discrete_state)

    def plan(self, context: Context) -> Plan:
        """The plan that a context of this block holds: hover before the first decision."""
        states = context.get_discrete_state(self._states).value()
        inputs = context.get_discrete_state(self._inputs).value()
        return Plan(states.reshape(-1, NUM_STATES).copy(), inputs.reshape(-1, NUM_INPUTS).copy())

    def reference(self, context: Context) -> Reference:
        """The targets that the inputs of a context preview."""
        position = self._position_preview.Eval(context).reshape(-1, 3)
        attitude = self._attitude_preview.Eval(context).reshape(-1, 3)
        if not self._feedforward:
            return Reference.of_pose(position, attitude)
        velocity, angular_velocity, u = (port.Eval(context) for port in self._feedforward.values())
        state = State.of(position, attitude, velocity.reshape(-1, 3), angular_velocity.reshape(-1, 3))
        return Reference(state.array, u.reshape(-1, NUM_INPUTS))

    def _decide(self, context: Context, previous: Plan | None, shifts: int, discrete_state: DiscreteValues) -> None:
        state, reference = self._vehicle_state.Eval(context), self.reference(context)
        before = context.get_discrete_state(self._measured).value()
        decision = self._planner.decide(state, reference, previous, before)
        discrete_state.set_value(self._measured, state)
        self._store(decision, context.get_time(), shifts, discrete_state)

    def _store(self, decision: Decision, time: float, shifts: int, discrete_state: DiscreteValues) -> None:
        # The hover plan is not continued. The next decision starts afresh, as after a plan that was shifted to its end.
        shifts = {Fallback.SHIFTED_PLAN: shifts + 1, Fallback.HOVER: self._horizon}.get(decision.fallback, 0)
        status = SolverStatus(np.zeros(4))
        status.success = float(decision.fallback is Fallback.NONE)
        status.iterations = decision.iterations
        status.objective = decision.objective
        status.fallback = float(decision.fallback)
        discrete_state.set_value(self._states, decision.plan.state.ravel())
        discrete_state.set_value(self._inputs, decision.plan.input.ravel())
        discrete_state.set_value(self._status, status[:])
        discrete_state.set_value(self._clock, _Clock([time, shifts])[:])
