import numpy as np
import pytest
from numba import njit
from scipy import stats

from hbench.model.noise import draw_bits, new_noise, normal


@njit
def many(noise, count):
    numbers = np.empty(count)
    for i in range(count):
        numbers[i] = normal(noise)
    return numbers


@pytest.fixture(scope="module")
def numbers():
    return many(new_noise(1), 1_000_000)


def test_bits_are_splitmix64():
    # published test vector of splitmix64 with seed 1234567
    noise = new_noise(1234567)
    assert [int(draw_bits(noise)) for _ in range(3)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
    ]


def test_numbers_are_normal(numbers):
    n = len(numbers)
    assert numbers.mean() == pytest.approx(0, abs=4 / np.sqrt(n))
    assert numbers.var() == pytest.approx(1, abs=4 * np.sqrt(2 / n))
    assert stats.skew(numbers) == pytest.approx(0, abs=4 * np.sqrt(6 / n))
    # the cut tails cost 0.02 of the kurtosis
    assert stats.kurtosis(numbers) == pytest.approx(0, abs=0.04)
    assert stats.kstest(numbers[:50_000], "norm").pvalue > 1e-3


def test_numbers_are_independent(numbers):
    n = len(numbers)
    for lag in (*range(1, 8), 35):
        for shape in (lambda x: x, np.square):
            a = shape(numbers) - shape(numbers).mean()
            correlation = (a[:-lag] * a[lag:]).mean() / a.var()
            assert abs(correlation) < 4.5 / np.sqrt(n)


def test_seeds_give_unrelated_numbers(numbers):
    other = many(new_noise(2), len(numbers))
    assert abs(np.corrcoef(numbers, other)[0, 1]) < 4.5 / np.sqrt(len(numbers))


def test_same_seed_same_bytes():
    assert many(new_noise(7), 1000).tobytes() == many(new_noise(7), 1000).tobytes()
