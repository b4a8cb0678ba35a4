"""Made-up flights: metrics, figures and tables need the log alone, not the hours of simulation behind it."""

from typing import Any

import numpy as np

from a2s_drake import Flight, Scenario, WallClock

SAMPLES = 5


def made_up_flight(law: str = "three_axis", **arrays: Any) -> Flight:
    """A flight of five samples at rest on its references, SNR 15 (so 4 bit/s/Hz), but for the arrays given."""
    scenario = Scenario().with_value("attitude_law.name", law)
    n = SAMPLES
    columns: dict[str, np.ndarray] = {
        "time": 0.02 * np.arange(n),
        "position": np.zeros((n, 3)),
        "attitude": np.zeros((n, 3)),
        "velocity": np.zeros((n, 3)),
        "angular_velocity": np.zeros((n, 3)),
        "rotor_speed": np.full((n, 6), 58.0),
        "position_reference": np.zeros((n, 3)),
        "attitude_reference": np.zeros((n, 3)),
        "ship_position": np.tile([90.0, 0.0, -20.0], (n, 1)),
        "channel_gain": np.full(n, 15e-9),
        "snr_db": np.full(n, 10.0 * np.log10(15.0)),
        "spectral_efficiency": np.full(n, 4.0),
        "phase_difference": np.zeros(n),
        "solver_success": np.ones(n),
        "solver_iterations": np.full(n, 20.0),
        "solver_fallback": np.zeros(n),
        "position_command": np.zeros((n, 3)),
    }
    clock = WallClock(np.array([9e-3, 1e-3, 2e-3, 3e-3, 4e-3]), 0.05)
    return Flight(scenario, **(columns | arrays), wall_clock=clock)
