"""The table of typical sensors tells its sources, and a noise is compared with it by density."""

import csv
import math
from pathlib import Path
from xml.etree import ElementTree

import pytest

import baroarma
from baroarma import NoiseModel, compare_with_sensors, identify, read, sensors
from baroarma.sensor_table import KINDS
from baroarma.simulation import simulate_rest

TABLE = sensors()


def test_every_row_has_a_source_a_known_kind_and_believable_numbers():
    for row in TABLE:
        assert row.sensor, row
        assert row.mode, row
        assert len(row.source) > 10, row
        assert row.kind in KINDS, row
        assert 0.01 < row.rms_noise_pa < 20, row  # no barometer of a consumer is better or worse
        assert row.rate_hz is None or 0.01 < row.rate_hz <= 2000, row
        assert row.tco_pa_per_k is None or 0.1 <= row.tco_pa_per_k <= 10, row
    assert len({(row.sensor, row.mode) for row in TABLE}) == len(TABLE)


def test_the_file_has_the_columns_that_are_documented():
    path = Path(baroarma.__file__).parent / "sensors.csv"
    with path.open(encoding="utf-8") as file:
        header = next(csv.reader(file))
    assert header == list(TABLE.rows[0].__dataclass_fields__)


def test_a_data_sheets_metres_are_ours():
    # BMP085, Table 3 of its data sheet prints metres beside the hPa: 0.5, 0.4, 0.3, 0.25, rounded to 0.05 m
    modes = [row for row in sensors("bmp085") if row.kind == "data sheet"]
    assert [row.noise_m for row in modes] == pytest.approx([0.5, 0.4, 0.3, 0.25], abs=0.05)


def test_oversampling_lowers_the_noise_and_hardly_its_density():
    for name in ("BMP085", "BMP581", "MS5611", "SPL06"):
        modes = [row for row in sensors(name) if row.kind != "measured" and row.density]
        modes = [row for row in modes if row.kind != "paper"]
        noise = [row.rms_noise_pa for row in modes]
        assert noise == sorted(noise, reverse=True), name
        # averaging n samples takes n times as long, and some fixed time
        densities = [row.density for row in modes]
        assert max(densities) < 2 * min(densities), name


def test_behind_a_filter_there_is_no_density():
    assert all(row.density is None for row in sensors("BMP280") if row.filter != "off")
    embedded = [row for row in sensors("LPS2") if row.filter == "embedded"]
    assert embedded
    assert all(row.rate_hz and row.density is None for row in embedded)
    assert all(row.density == row.rms_noise_pa / math.sqrt(row.rate_hz) for row in sensors("BMP581"))


def test_a_sensors_own_noise_is_the_most_alike_at_any_rate():
    for sensor in TABLE:
        if not sensor.density:
            continue
        raw = NoiseModel(0, 0, sensor.noise_m, rate_hz=sensor.rate_hz)
        for noise in (raw, raw.at_rate(7.0)):
            table = compare_with_sensors(noise)
            assert table.factors[0] == pytest.approx(1)
            assert table.rows[0].density == pytest.approx(sensor.density)


def test_twice_the_noise_is_twice_every_sensors():
    once = compare_with_sensors(NoiseModel(0, 0, 0.1, rate_hz=20))
    twice = compare_with_sensors(NoiseModel(0.3, 1.0, 0.2, 0.01, rate_hz=20))  # the other terms don't count
    factors = dict(zip(once.rows, once.factors, strict=True))
    assert {row: pytest.approx(2 * factors[row]) for row in once.rows} == dict(
        zip(twice.rows, twice.factors, strict=True)
    )


def test_an_identified_rest_is_recognised():
    found = identify(simulate_rest(300, rate_hz=25, device="gy-87", seed=1)).model
    table = compare_with_sensors(found, pressure=100_000.0)
    density = 3 / math.sqrt(25)  # Pa/sqrt(Hz), as simulated, and 1 Pa of quantisation adds 0.5 % to 3 Pa
    row, factor = table.rows[0], table.factors[0]
    assert factor * row.density == pytest.approx(density, rel=0.03)  # 7500 samples: 0.8 %


def test_pressures_make_pascals_of_metres():
    noise = NoiseModel(0, 0, 0.2, rate_hz=20)
    low, high = compare_with_sensors(noise), compare_with_sensors(noise, pressure=89_875.0)  # 1000 m
    ratio = dict(zip(high.rows, high.factors, strict=True))[low.rows[0]] / low.factors[0]
    assert ratio == pytest.approx(89_875 / 101_325 * 288.15 / 281.65, rel=1e-4)  # p/T of the ISA


def test_it_is_shown_as_text_frame_and_html():
    table = compare_with_sensors(NoiseModel(0, 0, 0.125, rate_hz=80))
    lines = table.summary().splitlines()
    assert lines[0] == "White noise of 0.168 Pa/√Hz (0.125 m at 80 Hz) is"
    assert len(lines) == 4
    frame = table.to_frame()
    assert frame["times_as_noisy"].tolist() == list(table.factors)
    assert "times_as_noisy" not in TABLE.to_frame()
    html = table._repr_html_()
    assert html.count("<tr>") == len(table) + 1
    assert "BST-BMP085-DS000-06" in html
    assert TABLE._repr_html_().count("<tr>") == len(TABLE) + 1


def text_of(element):
    return "".join(element.itertext()).strip()


def cells(table):
    """Header and rows of the HTML."""
    root = ElementTree.fromstring(table._repr_html_())
    head, *rows = root.iter("tr")
    assert [text_of(caption) for caption in root.iter("caption")] == [table.title]
    return [text_of(cell) for cell in head], [[text_of(cell) for cell in row] for row in rows]


def test_html_has_a_cell_for_each_number_and_what_is_not_told_stays_empty():
    names = ["sensor", "mode", "noise Pa", "m", "rate Hz", "filter", "± Pa", "TCO Pa/K", "kind", "source"]
    head, rows = cells(TABLE)
    assert head == names
    for row, found in zip(TABLE, rows, strict=True):
        told = dict(zip(names, found, strict=True))
        assert [told[name] for name in ("sensor", "mode", "filter", "kind", "source")] == [
            row.sensor, row.mode, row.filter, row.kind, row.source
        ]  # fmt: skip
        assert float(told["noise Pa"]) == pytest.approx(row.rms_noise_pa, rel=1e-5)  # six digits
        assert float(told["m"]) == pytest.approx(row.noise_m, rel=0.05)  # two digits
        for name, value in (
            ("rate Hz", row.rate_hz),
            ("± Pa", row.absolute_pa),
            ("TCO Pa/K", row.tco_pa_per_k),
        ):
            assert told[name] == ("" if value is None else f"{value:.4g}")
    compared = compare_with_sensors(NoiseModel(0, 0, 0.125, rate_hz=80))
    head, rows = cells(compared)
    assert head == ["this noise is", *names]
    assert [row[0] for row in rows] == [f"× {factor:.2g}" for factor in compared.factors]
    assert [row[1] for row in rows] == [row.sensor for row in compared]


def test_the_line_counts_rows_and_sensors():
    assert repr(sensors("BMP085")) == f"<SensorTable: {len(sensors('BMP085'))} rows of 1 sensors>"
    assert repr(TABLE) == f"<SensorTable: {len(TABLE)} rows of {len({row.sensor for row in TABLE})} sensors>"


def test_the_summary_names_the_three_most_alike():
    table = compare_with_sensors(NoiseModel(0, 0, 0.125, rate_hz=80))
    for line, row, factor in zip(table.summary().splitlines()[1:], table.rows, table.factors, strict=False):
        assert line == f"  {factor:5.2f} times {row.sensor}, {row.mode} ({row.kind})"
    distances = [abs(math.log(factor)) for factor in table.factors]
    assert distances == sorted(distances)
    assert len(table) == sum(row.density is not None for row in TABLE)
    assert TABLE.summary() == "Typical barometers"


def test_a_frame_has_a_column_for_each_field():
    frame = TABLE.to_frame()
    assert list(frame) == [*TABLE.rows[0].__dataclass_fields__, "noise_m"]
    assert frame.rms_noise_pa.tolist() == [row.rms_noise_pa for row in TABLE]
    assert frame.noise_m.tolist() == [row.noise_m for row in TABLE]


def test_what_is_not_there_is_told():
    with pytest.raises(ValueError, match="there is no sensor 'HP03' in the table; there are BMP085, BMP180"):
        sensors("HP03")
    with pytest.raises(ValueError, match="no white noise to compare"):
        compare_with_sensors(NoiseModel(0.2, 1.0, 0.0, rate_hz=20))


def test_measured_rows_are_what_identify_finds(shared_data):
    rest = read(shared_data / "ms5611_static_80hz" / "rest_baro.csv.gz")
    table = compare_with_sensors(identify(rest).model)
    assert table.rows[0].mode == "on an Arduino"
    assert table.factors[0] == pytest.approx(1, abs=0.05)  # two digits in the table
