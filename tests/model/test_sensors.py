import numpy as np
import pytest

from hbench.config.sensors import TemperatureSensor
from hbench.model.noise import new_noise
from hbench.model.plant import forces, initial_state, new_work
from hbench.model.sensing import convert, sensed
from hbench.model.sensors import N_SENSED, SENSORS, sensor_gains, sensor_parameters

BAR, OIL_K = 1e5, 318.15
VALUES = np.array([0.17, 78.84 * BAR, 28.42 * BAR, 12.7 * BAR, 8.9 * BAR, 150 * BAR, 1234.0])


def with_adc(sensors, **changes):
    return sensors.model_copy(update={"adc": sensors.adc.model_copy(update=changes)})


def words_of(values, sensors, seed=0):
    words = np.zeros(len(SENSORS), dtype=np.uint16)
    values = np.asarray(values, dtype=float)
    convert(values, OIL_K, sensor_parameters(sensors), new_noise(seed), words)
    return words


@pytest.fixture(scope="module")
def exact(bench):
    return with_adc(bench.sensors, noisy=False, quantised=False)


@pytest.fixture(scope="module")
def quantised(bench):
    return with_adc(bench.sensors, noisy=False, quantised=True)


def calibrated(words, sensors):
    gains = sensor_gains(sensors)
    return np.array([gains[n][0] * w / 16 + gains[n][1] for n, w in zip(SENSORS, words, strict=1)])


@pytest.mark.parametrize(("name", "counts"), [("exact", 1 / 32), ("quantised", 1 / 2)])
def test_calibration_inverts_the_sensors(request, name, counts):
    sensors = request.getfixturevalue(name)
    rng = np.random.default_rng(0)
    for _ in range(50):
        values = VALUES * rng.uniform(0.1, 1.4, len(VALUES))
        errors = calibrated(words_of(values, sensors), sensors) - values
        lsb = np.array([sensor_gains(sensors)[name][0] for name in SENSORS])
        assert np.all(np.abs(errors) <= counts * lsb * (1 + 1e-9))


def test_pressure_scaling_is_that_of_appendix_b(exact):
    # 125 bar of 250: 5 V, 1.58 V at the converter, 4096 * 1.58 / 3 counts
    assert words_of(np.full(7, 125 * BAR), exact)[1] / 16 == pytest.approx(
        4096 * 1.58 / 3, abs=1 / 32
    )


def test_pressure_clips_at_9_49_v_of_10(exact):
    # the amplifier gives 3.16 V at full scale: 237.3 bar fill the converter
    below, above = (
        words_of(np.full(7, 237.2 * BAR), exact),
        words_of(np.full(7, 237.4 * BAR), exact),
    )
    assert below[1] < 4095 * 16
    assert above[1] == 4095 * 16
    assert words_of(np.full(7, -1 * BAR), exact)[1] == 0


def test_load_cell_is_equation_c_6(exact):
    values = VALUES.copy()
    values[6] = -4000.0
    u_out = 3 * (words_of(values, exact)[6] / 16) / 4096 - 1.5
    force = 4 * u_out * 200e-6 * 210e9 / (2 * 10.46 * 2.1 * (1 + 0.3) * 360)
    assert force == pytest.approx(-4000.0, abs=0.2)  # 1/16 count is 0.37 N


def test_quantised_words_are_whole_counts(quantised):
    assert np.all(words_of(VALUES, quantised) % 16 == 0)


def test_noise_of_a_tick_is_that_of_averaged_conversions(bench):
    """Against conversions with numpy's own noise, each rounded to a count."""
    sensors, adc = bench.sensors, bench.sensors.adc
    par, noise = sensor_parameters(sensors), new_noise(5)
    values = np.tile(VALUES, (4000, 1)) * np.linspace(0.9, 1.1, 4000)[:, None]
    words = np.zeros((4000, 7), dtype=np.uint16)
    for value, word in zip(values, words, strict=True):
        convert(value, OIL_K, par, noise, word)
    truth = values * np.array(par.per_unit) + np.array(par.zero)
    rng = np.random.default_rng(0)
    sigma = adc.noise * 4096 / 3
    conversions = rng.normal(0, sigma, (*truth.shape, adc.oversampling))
    brute = np.rint(truth[..., None] + conversions).mean(axis=-1)
    assert (words / 16 - truth).std() == pytest.approx((brute - truth).std(), rel=0.03)
    assert (words / 16 - truth).mean() == pytest.approx(0, abs=4 * 0.1 / np.sqrt(28_000))


def test_the_oil_temperature_is_the_eighth_word_and_changes_no_other(exact):
    """0 to 100 degC are 0 to 10 V, of which an amplifier of 0.3 leaves 3 V."""
    sensor = TemperatureSensor(span="100 K", lowest="0 degC", output="10 V", amplifier=0.3)
    with_oil = exact.model_copy(update={"temperature": sensor})
    words = np.zeros(8, dtype=np.uint16)
    convert(VALUES, OIL_K, sensor_parameters(with_oil), new_noise(0), words)
    assert words[7] == round(16 * 4096 * 0.45)
    gain, offset = sensor_gains(with_oil)["temp_tank"]
    assert gain * words[7] / 16 + offset == pytest.approx(OIL_K, abs=gain / 32)
    np.testing.assert_array_equal(words[:7], words_of(VALUES, exact))
    assert "temp_tank" not in sensor_gains(exact)


def test_same_seed_same_bytes(bench):
    assert (
        words_of(VALUES, bench.sensors, 1).tobytes() == words_of(VALUES, bench.sensors, 1).tobytes()
    )
    assert (
        words_of(VALUES, bench.sensors, 1).tobytes() != words_of(VALUES, bench.sensors, 2).tobytes()
    )


def test_sensors_see_the_state(par):
    state = initial_state(par, 0.1, 15 * BAR, 15 * BAR)
    state[:6] = 0.17, 0.05, 78 * BAR, 28 * BAR, 13 * BAR, 9 * BAR
    values = np.zeros(N_SENSED)
    sensed(state, forces(state, np.ones(3), par, new_work(par)[0]), par, values)
    assert values[:6] == pytest.approx([0.17, 78 * BAR, 28 * BAR, 13 * BAR, 9 * BAR, 150 * BAR])
