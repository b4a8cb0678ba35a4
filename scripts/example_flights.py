"""Flights that several examples need, and what is printed of them."""

from collections.abc import Mapping

from a2s_drake import Flight, Scenario, run_flight
from a2s_drake.flight.metrics import measure
from diagrams import build_closed_loop


def fly_both(*overrides: str) -> dict[str, Flight]:
    """Level and the paper's law, flown in closed loop on Table I with some fields changed."""
    flights = {}
    for name, law in (("level", "level"), ("the paper's law", "three_axis")):
        scenario = Scenario().with_overrides([*overrides, f"attitude_law.name={law}"])
        flights[name] = run_flight(build_closed_loop(scenario), scenario)
    return flights


def tell(flights: Mapping[str, Flight]) -> None:
    """Prints what each flight transmits and how far it strays from its path."""
    for name, flight in flights.items():
        got = measure(flight)
        print(f"{name}: {got.throughput_bit_per_hz:.3f} bit/Hz, {got.position_error_max_m:.3f} m astray at most")
