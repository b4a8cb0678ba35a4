"""Disturbances at their edges: between gusts, over the seeds, and when a simulation begins anew."""

import numpy as np
from pydrake.systems.analysis import Simulator

from a2s_drake import Airframe, Disturbance
from a2s_drake.navigation.sensors import NavigationSensor
from a2s_drake.vehicle.actuators import InputDelay
from a2s_drake.vehicle.airframe import make_plant
from a2s_drake.world.wind import WindGust, gust_force

PERIOD = 0.02


def test_between_two_gusts_it_is_calm() -> None:
    dut = Disturbance(gust_force=[1.0, -2.0, 4.0], gust_duration=2.0, gust_interval=10.0)
    for time in (*np.arange(0.0, 10.0, 0.5), *np.arange(12.0, 20.0, 0.5)):
        np.testing.assert_allclose(gust_force(float(time), dut), 0.0, atol=1e-12)


def test_wind_changes_while_a_context_is_kept() -> None:
    _, body = make_plant(Airframe())
    gusts = Disturbance(gust_force=[1.0, 0.0, 0.0], gust_duration=2.0, gust_interval=5.0)
    dut = WindGust(gusts, body.index())
    context = dut.CreateDefaultContext()
    forces = []
    for time in (0.0, 5.5, 6.0, 8.0):
        context.SetTime(time)
        (applied,) = dut.GetOutputPort("spatial_forces").Eval(context)
        forces.append(applied.F_Bq_W.translational()[0])
    np.testing.assert_allclose(forces, [0.0, 0.5, 1.0, 0.0], atol=1e-12)


def test_noise_of_one_seed_is_not_that_of_another_a_period_later() -> None:
    def noise(seed: int, sample: int) -> np.ndarray:
        dut = NavigationSensor(PERIOD, Disturbance(position_noise=1.0, noise_seed=seed))
        context = dut.CreateDefaultContext()
        context.SetTime(sample * PERIOD)
        dut.GetInputPort("vehicle_state").FixValue(context, np.zeros(12))
        return dut.GetOutputPort("measured_state").Eval(context)[:3]

    drawn = np.array([noise(seed, sample) for seed in range(4) for sample in range(4)])
    apart = np.abs(drawn[:, np.newaxis] - drawn).max(axis=-1) + np.eye(16)
    assert apart.min() > 1e-3


def test_a_delay_begins_anew_with_the_simulation() -> None:
    dut = InputDelay(1, PERIOD, np.full(6, 7.0))
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    runs = []
    for _ in range(2):
        context.SetTime(0.0)
        simulator.Initialize()
        seen = []
        for k in range(4):
            simulator.AdvanceTo(k * PERIOD)
            simulator.AdvancePendingEvents()
            seen.append(dut.GetOutputPort("rotor_speed_squared").Eval(context)[0])
            dut.GetInputPort("rotor_speed_command").FixValue(context, np.full(6, k + 1.0))
        runs.append(seen)
    assert runs == [[7.0, 1.0, 2.0, 3.0]] * 2
