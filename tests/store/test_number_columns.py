"""Numbers written by whole columns are read back as the same floats."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hbench.store.files.number_columns import formatted_rows, rounded_to_decimals

SHAPES = st.integers(1, 30)
DECIMAL = st.builds(lambda whole, places: whole / 10**places, st.integers(-(10**15), 10**15),
                    st.integers(0, 15))  # fmt: skip


def columns(elements):
    return SHAPES.flatmap(
        lambda n: st.lists(arrays(float, n, elements=elements), min_size=1, max_size=3)
    )


def read_back(text):
    rows = [[float(cell) for cell in line.split(",")] for line in text.decode().splitlines()]
    return np.array(rows).T


@settings(max_examples=60)
@given(
    st.one_of(
        columns(st.floats(allow_infinity=False)),
        columns(DECIMAL | st.just(float("nan"))),
        columns(st.integers(-(10**7), 10**7).map(lambda n: n / 1000)),
    )
)
def test_every_float_is_read_back(made):
    back = read_back(b"".join(formatted_rows(made)))
    np.testing.assert_array_equal(back, made)
    known = ~np.isnan(made)
    np.testing.assert_array_equal(np.signbit(back)[known], np.signbit(made)[known])


def test_numbers_have_the_fewest_digits():
    made = [np.array([0.0, -12.5, 3.25]), np.array([1e5, 2, 3]), np.array([1e-7, np.pi, np.nan])]
    rows = b"".join(formatted_rows(made)).decode().split()
    assert rows == ["0.0,100000.0,1e-7", "-12.5,2.0,3.141592653589793", "3.25,3.0,nan"]


@settings(max_examples=50)
@given(arrays(float, 20, elements=st.integers(-(10**6), 10**6).map(float)), st.integers(0, 6))
def test_a_conversion_of_decimal_numbers_gives_decimal_numbers(whole, places):
    logged = whole / 10**places
    for factor, shift in ((1e-3, 3), (1e-6, 6), (1e5, -5), (1e3, -3)):
        converted = rounded_to_decimals(logged * factor)
        exact = [float(f"{int(n)}e{-places - shift}") for n in whole]
        np.testing.assert_array_equal(converted, exact)


def test_other_numbers_stay_as_they_are():
    values = np.random.default_rng(0).standard_normal(1000)
    assert rounded_to_decimals(values) is values
