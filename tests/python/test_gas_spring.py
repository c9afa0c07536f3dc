"""The whole loop on measured data: the model improves, and transfers to a record not used for it."""

import pytest

import gas_spring
from conftest import PROGRAM

pytestmark = pytest.mark.skipif(not gas_spring.is_there(), reason="the measured gas spring records are not here")


def test_a_model_of_one_record_predicts_the_other(tmp_path):
    one = gas_spring.loop(PROGRAM, "upper", "friction", tmp_path)
    found = one["found"]
    # More than noise remains on a real rig: the effects describe the data but are not called the cause.
    assert found["verdict"] == "improved"
    assert found["after"]["rmse_pa"]["held_out"] < 0.25 * found["before"]["rmse_pa"]["held_out"]
    assert one["own"] < 0.15
    assert one["other_whole"] < 0.21
