import pytest
from pydrake.systems.framework import DiagramBuilder

from a2s_drake import Airframe, Link, TwoRayChannel, WiringError, build_wired
from a2s_drake.common.wiring import check_ports
from a2s_drake.vehicle.airframe import make_plant


def test_refuses_dangling_inputs_by_name() -> None:
    builder = DiagramBuilder()
    channel = builder.AddNamedSystem("channel", TwoRayChannel(Link()))
    builder.ExportInput(channel.GetInputPort("ship_antenna_position"), "ship_antenna_position")
    with pytest.raises(WiringError, match="radio leaves inputs unconnected: channel: vehicle_state"):
        build_wired(builder, "radio")


def test_builds_and_names_what_is_whole() -> None:
    builder = DiagramBuilder()
    channel = builder.AddNamedSystem("channel", TwoRayChannel(Link()))
    for name in ("ship_antenna_position", "vehicle_state"):
        builder.ExportInput(channel.GetInputPort(name), name)
    assert build_wired(builder, "radio").get_name() == "radio"


def test_a_plant_needs_its_spatial_forces_and_nothing_else() -> None:
    builder = DiagramBuilder()
    plant, _ = make_plant(Airframe())
    builder.AddNamedSystem("plant", plant)
    with pytest.raises(WiringError, match=r"bare leaves inputs unconnected: plant: applied_spatial_force$"):
        build_wired(builder, "bare")


def test_ports_that_fit_pass_among_others() -> None:
    check_ports("radio", TwoRayChannel(Link()), {"ship_antenna_position": 3}, {"snr_db": 1, "channel_gain": 1})


def test_a_misfit_names_role_class_port_and_both_sizes() -> None:
    with pytest.raises(WiringError) as refusal:
        check_ports("radio", TwoRayChannel(Link()), {"ship_antenna_position": 2}, {"snr": 1})
    assert str(refusal.value) == (
        "radio (TwoRayChannel): input ship_antenna_position has size 3, must have 2; no output snr, which must have "
        "size 1; its outputs: channel_gain, snr_db, spectral_efficiency, phase_difference, reflection"
    )


def test_an_abstract_port_is_no_vector() -> None:
    plant, _ = make_plant(Airframe())
    with pytest.raises(WiringError, match="output body_poses is abstract, must be a vector of size 7"):
        check_ports("plant", plant, {}, {"body_poses": 7})
