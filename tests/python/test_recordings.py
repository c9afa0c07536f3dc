"""`diagnose` on realistic recordings from a simulator that shares no code with the program."""

import json

import numpy as np
import pytest

import recordings

BY_NAME = {recording.name: recording for recording in recordings.RECORDINGS}


def test_a_low_pass_of_a_ramp_lags_by_its_time_constant():
    ramp = np.arange(2000) * 1e-3
    assert recordings.filtered(ramp, 1e-3, 0.05)[-1] == pytest.approx(ramp[-1] - 0.05, abs=1e-12)


def test_a_wander_has_the_same_power_in_every_octave():
    signal = recordings.one_over_f(100.0)(1 << 15, 100.0, np.random.default_rng(1))
    power = np.abs(np.fft.rfft(signal)) ** 2
    octaves = [power[1 << k : 2 << k].sum() for k in range(8, 14)]
    assert max(octaves) < 1.5 * min(octaves)


@pytest.mark.parametrize("name", ["white", "12-bit-150", "creep-fast", "bore-41-for-40", "position-held", "position-lost"])
def test_a_recording_gets_the_answer_that_it_deserves(name, pneutherm, tmp_path):
    recording = BY_NAME[name]
    answer = recordings.write(tmp_path, recording, 0)
    pneutherm("diagnose", "rig.toml", "--json", "diagnosis.json", cwd=tmp_path)
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    assert recordings.judge(recording, "none", found) == "right", (found["verdict"], found["effects"])
    if recording.judges_lambda0:
        lambda0 = found["after"]["parameters"]["lambda0_w_per_m2_k"]
        assert lambda0["value"] == pytest.approx(answer["lambda0_w_per_m2_k"], rel=0.01)
