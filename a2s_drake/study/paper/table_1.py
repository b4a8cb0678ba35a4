"""Table I of the paper beside the scenario that stands in for it."""

from a2s_drake.scenario.scenario import Scenario


def table_1_rows(scenario: Scenario) -> list[list[str]]:
    """Rows of quantity, the paper's value and the scenario's."""
    airframe, link, mission, mpc, law = (
        scenario.airframe,
        scenario.link,
        scenario.mission,
        scenario.mpc,
        scenario.attitude_law,
    )

    def listed(values: list[float]) -> str:
        return ", ".join(f"{value:g}" for value in values)

    return [
        ["mass (kg)", "2.57", f"{airframe.mass:g}"],
        ["inertia (kg m^2)", "0.11, 0.11, 0.19", listed(airframe.inertia)],
        ["antenna offset (m)", "0.39, 0.39, 0.195", listed(link.antenna_offset)],
        ["rotor speed (Hz)", "16 to 100", f"{airframe.rotor_speed_min:g} to {airframe.rotor_speed_max:g}"],
        ["rotor tilt (deg), arm (m)", "not given", f"{airframe.tilt_deg:g}, {airframe.arm_length:g}"],
        ["thrust (N/Hz^2)", "not given", f"{airframe.thrust_coefficient:g}"],
        ["drag per thrust (m), its sign", "not given", f"{airframe.drag_to_thrust:g}, {airframe.drag_sign:+d}"],
        ["carrier (GHz)", "3", f"{link.carrier_hz / 1e9:g}"],
        ["wavelength (cm)", "about 10", f"{100 * link.wavelength:.6g}"],
        ["reflection magnitude", "0.8", f"{link.reflection_magnitude:g}"],
        ["ship antenna height (m)", "10", f"{link.ship_antenna_height:g}"],
        ["ship from (m)", "90, 0, -20", listed([*mission.ship_start, mission.sea_level])],
        ["ship to (m)", "100, 0, -20", listed([*mission.ship_end, mission.sea_level])],
        ["radius (m), duration (s)", "2.65, 40", f"{mission.radius:g}, {mission.duration:g}"],
        ["transmit, noise power (dBm)", "10, -80", f"{link.transmit_power_dbm:g}, {link.noise_power_dbm:g}"],
        ["sampling (s), horizon", "0.02, 30", f"{mpc.period:g}, {mpc.horizon}"],
        ["weights of position, attitude", "100, 50", f"{mpc.position_weight:g}, {mpc.attitude_weight:g}"],
        ["weights of velocity, angular rate", "1, 10", f"{mpc.velocity_weight:g}, {mpc.angular_velocity_weight:g}"],
        ["terminal weights of these two", "not given", "as above"],
        ["weight of input (1/Hz^4)", "3.2e-08", f"{mpc.input_weight:g}"],
        ["position box (m)", "not given", f"{listed(mpc.position_lower)} to {listed(mpc.position_upper)}"],
        ["velocity bound (m/s)", "1", f"{mpc.velocity_limit:g}"],
        ["angular-rate bound (rad/s)", "1", f"{mpc.angular_velocity_limit:g}"],
        ["Euler-angle bound (deg)", "15", f"{mpc.attitude_limit_deg:g}"],
        ["candidate box (deg), no candidate", "15, unclear", f"{law.candidate_limit_deg:g}, {law.fallback}"],
        ["temperature (1/rad^2), indices", "7, -50 to 50", f"{law.temperature:g}, {law.index_min} to {law.index_max}"],
    ]
