import dataclasses

import numpy as np

from a2s_drake import Scenario
from a2s_drake.study.paper.comparison import comparison_table
from tests.support.flights import SAMPLES, made_up_flight


def test_table_sets_gains_beside_the_papers() -> None:
    flights = {
        law: made_up_flight(law, spectral_efficiency=np.full(SAMPLES, rate))
        for law, rate in (("three_axis", 6.0), ("pitch_only", 5.0), ("level", 4.0))
    }
    lines = comparison_table(flights).splitlines()
    assert lines[3].split()[:2] == ["three_axis", "0.600"]
    assert "+50.00 %" in lines[3]
    assert "+22.2 %" in lines[3]
    assert "+20.00 %" in lines[3]
    assert "+11.4 %" in lines[3]
    assert "+25.00 %" in lines[4]
    assert lines[3].split()[-1] == "1.6"  # 0.08 s flown in 0.05 s


def test_another_mission_has_no_figures_in_the_paper() -> None:
    scenario = Scenario().with_value("mission.radius", 2.0)
    flights = {
        law: dataclasses.replace(made_up_flight(law), scenario=scenario)
        for law in ("three_axis", "pitch_only", "level")
    }
    assert "22.2" not in comparison_table(flights)
