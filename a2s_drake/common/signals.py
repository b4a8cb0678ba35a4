"""What the signals between blocks are measured in."""

_STATE = "m, rad, m/s, rad/s"

PORT_UNITS: dict[str, str] = {
    "position_reference": "m",
    "position_preview": "m",
    "ship_position": "m",
    "ship_antenna_position": "m",
    "ship_preview": "m",
    "attitude_reference": "rad",
    "attitude_preview": "rad",
    "velocity_preview": "m/s",
    "angular_velocity_preview": "rad/s",
    "rotor_speed_squared_preview": "Hz^2",
    "vehicle_state": _STATE,
    "measured_state": _STATE,
    "predicted_state": _STATE,
    "rotor_speed_squared": "Hz^2",
    "rotor_speed_command": "Hz^2",
    "solver_status": "1",
    "channel_gain": "1",
    "snr_db": "dB",
    "spectral_efficiency": "bit/s/Hz",
    "phase_difference": "rad",
    "reflection": "1, rad",
    "plant_state": "1, m, rad/s, m/s",
    "spatial_forces": "N m, N",
}
"""Port name to unit, for this library's blocks; the parts of a mixed signal in the order that they stand."""

DRAKE_PORT_UNITS: dict[tuple[str, str], str] = {
    ("MultibodyPlant", "body_poses"): "1, m",
    ("Propeller", "spatial_forces"): "N m, N",
}
"""Class and port name to unit, for blocks of Drake's whose ports are wired to none of ours."""
