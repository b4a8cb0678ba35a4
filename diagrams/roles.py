"""The roles of blocks in a drawing: what each is called there, and which outputs its block must and may have."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from a2s_drake.control.controller import feedforward_ports
from a2s_drake.scenario.parts import Mpc

NAMES = {
    "path": "uav_path",
    "ship": "ship",
    "ship_motion": "ship_motion",
    "channel": "channel",
    "navigation": "navigation_sensor",
    "ship_report": "ship_report",
    "receiver": "snr_receiver",
    "observer": "observer",
    "law": "attitude_reference",
    "controller": "mpc",
    "airframe": "airframe",
}
"""What the block of each role is called in a drawing."""


@dataclass(frozen=True)
class Role:
    """The outputs of a block in some role, by name and size.

    Attributes:
      must: those that it must have.
      may: those that it may have; the size is None where any is right, or the output is abstract.
    """

    must: Mapping[str, int]
    may: Mapping[str, int | None] = field(default_factory=dict)


def roles(mpc: Mpc) -> dict[str, Role]:
    """Every role by name, for a controller's horizon."""
    preview = 3 * (mpc.horizon + 1)
    gains = dict.fromkeys(("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"), 1)
    known = {"measured_state": 12, "ship_preview": preview, "snr_measurement": 2}
    estimates = {"phasor": 3, "phasor_covariance": 9, "force_estimate": 3}
    return {
        "path": Role({"position_reference": 3, "position_preview": preview}),
        "ship": Role({"ship_position": 3}, {"ship_preview": preview}),
        "ship_motion": Role({"ship_antenna_position": 3}),
        "channel": Role(gains, {"reflection": 2}),
        "navigation": Role({"measured_state": 12}),
        "ship_report": Role({"ship_preview": preview}),
        "receiver": Role({"snr_measurement": 2}),
        "observer": Role({}, known | estimates),
        "law": Role(
            {"attitude_reference": 3, "attitude_preview": preview}, moved_position(mpc) | feedforward_ports(mpc)
        ),
        "controller": Role({"rotor_speed_squared": 6}, {"predicted_state": None, "solver_status": None}),
        "airframe": Role({"vehicle_state": 12}, {"body_poses": None}),
    }


def moved_position(mpc: Mpc) -> dict[str, int]:
    """The outputs of a law that moves the position, by name and size."""
    return {"position_command": 3, "position_command_preview": 3 * (mpc.horizon + 1)}
