import pytest
from pydrake.systems.framework import DiagramBuilder

from a2s_drake import Airframe, Link, TwoRayChannel, WiringError, build_wired
from a2s_drake.airframe import make_plant


def test_refuses_dangling_inputs_by_name() -> None:
    builder = DiagramBuilder()
    channel = builder.AddNamedSystem("channel", TwoRayChannel(Link()))
    builder.ExportInput(channel.GetInputPort("ship_position"), "ship_position")
    with pytest.raises(WiringError, match="radio leaves inputs unconnected: channel: vehicle_state"):
        build_wired(builder, "radio")


def test_builds_and_names_what_is_whole() -> None:
    builder = DiagramBuilder()
    channel = builder.AddNamedSystem("channel", TwoRayChannel(Link()))
    for name in ("ship_position", "vehicle_state"):
        builder.ExportInput(channel.GetInputPort(name), name)
    assert build_wired(builder, "radio").get_name() == "radio"


def test_a_plant_needs_its_spatial_forces_and_nothing_else() -> None:
    builder = DiagramBuilder()
    plant, _ = make_plant(Airframe())
    builder.AddNamedSystem("plant", plant)
    with pytest.raises(WiringError, match=r"bare leaves inputs unconnected: plant: applied_spatial_force$"):
        build_wired(builder, "bare")
