"""What a prediction says about itself."""

import baroarma as ba

NOISE = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)


def test_the_result_tells_its_story():
    found = ba.predict_accuracy(NOISE, "simple", "sg14-a", 30.0)
    assert found.t.shape == found.height_sd.shape == found.velocity_sd.shape == (1500,)
    assert repr(found) == (
        f"<Prediction for sg14-a: rms {found.height_rms:.3g} m and {found.velocity_rms:.3g} m/s over 30 s>"
    )
    lines = found.summary().splitlines()
    assert [line.split("  ")[0] for line in lines[2:8]] == [
        "sd after 2 s", "sd after 5 s", "sd after 10 s", "sd after 20 s", "sd after 30 s", "rms over 30 s"
    ]  # fmt: skip
    assert f"{found.velocity_sd[500]:.4f}" in lines[4]
    assert lines[8].split()[-2:] == ["-", f"{found.steady_velocity_sd:.4f}"]
    assert f">{found.height_rms:.4f}</td>" in found._repr_html_()
    assert not found.height_sd.flags.writeable
    assert found.to_dict()["velocity_sd_m_s"] == found.velocity_sd.tolist()
