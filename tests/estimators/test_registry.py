import importlib
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from baroarma import NoiseModel
from baroarma.estimators import attitude_names, height_estimator, height_names
from baroarma.estimators.base import AttitudeEstimator, HeightEstimator
from baroarma.estimators.registry import ATTITUDE, HEIGHT, attitude_estimator
from baroarma.testing import HeightEstimatorContract

THIRD_PARTY = Path(__file__).with_name("third_party")
SG13 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)


def install(folder, monkeypatch, entry_points):
    """Put the third party's module on the path, with the metadata that an installer would write."""
    info = folder / "baroarma_lowpass-0.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: baroarma-lowpass\nVersion: 0.1\n")
    sections = [f"[{group}]\n{points}\n" for group, points in entry_points.items()]
    (info / "entry_points.txt").write_text("\n".join(sections))
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.syspath_prepend(str(THIRD_PARTY))
    importlib.invalidate_caches()
    monkeypatch.delitem(sys.modules, "lowpass_height", raising=False)


@pytest.fixture
def third_party(tmp_path, monkeypatch):
    groups = tomllib.loads((THIRD_PARTY / "pyproject.toml").read_text())["project"]["entry-points"]
    points = {group: "\n".join(f"{k} = {v}" for k, v in entries.items()) for group, entries in groups.items()}
    install(tmp_path, monkeypatch, points)


@pytest.mark.parametrize("name", HEIGHT)
def test_every_height_estimator_is_found_by_name(name):
    assert isinstance(height_estimator(name, noise=SG13), HeightEstimator)


@pytest.mark.parametrize("name", [n for n in ATTITUDE if n not in ("vqf", "imufusion")])
def test_every_attitude_estimator_of_ours_is_found_by_name(name):
    assert isinstance(attitude_estimator(name), AttitudeEstimator)


def test_built_in_names_come_first():
    assert height_names()[: len(HEIGHT)] == tuple(HEIGHT)
    assert attitude_names()[: len(ATTITUDE)] == tuple(ATTITUDE)


def test_the_nominal_interval_is_the_noise_models_unless_given():
    assert height_estimator("kalman", noise=SG13).dt == 1 / 50
    assert height_estimator("kalman", noise=SG13, dt=0.01).dt == 0.01


def test_an_unknown_name_lists_the_names_and_a_close_one():
    with pytest.raises(ValueError, match=r"'kalmann'; there are complementary, .*did you mean 'kalman'"):
        height_estimator("kalmann")
    with pytest.raises(ValueError, match=r"no attitude estimator 'xyz'; there are [^;]*$"):
        attitude_estimator("xyz")


def test_an_unknown_setting_lists_the_settings():
    with pytest.raises(ValueError, match=r"'complementary' has no setting 'sigma'; it has .*altitude_sd"):
        height_estimator("complementary", sigma=3)


def test_settings_of_the_common_part_are_known_too():
    assert height_estimator("coloured-kalman", noise=SG13, rest_sd=0.5).rest_sd == 0.5
    with pytest.raises(ValueError, match=r"'kalman' has no setting 'sigma'; it has .*zupt_steps"):
        height_estimator("kalman", noise=SG13, sigma=3)


@pytest.mark.usefixtures("third_party")
def test_a_plug_in_is_found_by_name():
    assert height_names() == (*HEIGHT, "lowpass")
    estimator = height_estimator("lowpass", noise=SG13, time_constant=2.0)
    assert type(estimator).__name__ == "LowPass"
    assert (estimator.white_sd, estimator.time_constant) == (0.46, 2.0)
    with pytest.raises(ValueError, match=r"there are .*, lowpass; did you mean 'lowpass'"):
        height_estimator("low-pass")


@pytest.mark.usefixtures("third_party")
class TestThirdPartyContract(HeightEstimatorContract):
    def make(self):
        return height_estimator("lowpass")


def test_a_broken_plug_in_is_named_and_left_out(tmp_path, monkeypatch):
    points = {
        "baroarma.height": "lost = no_such_module:Filter\nlowpass = lowpass_height:LowPass",
        "baroarma.attitude": "lost = lowpass_height:Nothing",
    }
    install(tmp_path, monkeypatch, points)
    with pytest.warns(UserWarning, match="plug-in 'lost' .no_such_module:Filter. cannot be loaded"):
        assert height_names() == (*HEIGHT, "lowpass")
    with pytest.warns(UserWarning, match="plug-in 'lost' .*cannot be loaded: AttributeError"):
        assert attitude_names() == tuple(ATTITUDE)
    with pytest.raises(ValueError, match=r"plug-in 'lost' .*cannot be loaded: ModuleNotFoundError"):
        height_estimator("lost")


def test_a_plug_in_cannot_take_a_built_in_name(tmp_path, monkeypatch):
    install(tmp_path, monkeypatch, {"baroarma.height": "kalman = lowpass_height:LowPass"})
    with pytest.warns(UserWarning, match="its name 'kalman' is a built-in height estimator's"):
        assert height_names() == tuple(HEIGHT)
    assert type(height_estimator("kalman", dt=0.02)).__name__ == "Kalman"


def test_an_installed_distribution_appears_in_the_help_and_tracks(tmp_path):
    """pip installs the third party's distribution into a folder of its own; the program finds it there."""
    source, site = tmp_path / "source", tmp_path / "site"
    shutil.copytree(THIRD_PARTY, source, ignore=shutil.ignore_patterns("__pycache__"))
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--target", str(site), str(source)], check=True, capture_output=True)
    environment = {**os.environ, "PYTHONPATH": str(site)}

    def baroarma(*arguments):
        command = [sys.executable, "-m", "baroarma", *arguments]
        return subprocess.run(
            command, check=True, capture_output=True, text=True, env=environment, cwd=tmp_path
        )

    name = next(
        iter(
            tomllib.loads((source / "pyproject.toml").read_text())["project"]["entry-points"][
                "baroarma.height"
            ]
        )
    )
    assert name in baroarma("track", "--help").stdout
    baroarma("simulate", "squat", "--duration", "10", "--seed", "1", "--out", "squat.csv")
    baroarma("track", "squat.csv", "--height", name, "--out", "track.csv")
    assert len((tmp_path / "track.csv").read_text().splitlines()) == 501
