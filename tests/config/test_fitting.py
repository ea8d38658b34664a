"""The fit file: its example holds the defaults, and a bad one is refused with key and limit."""

from pathlib import Path

import pytest

from hbench.config.files.loading import read_yaml
from hbench.config.fitting import Fitting, parse_fitting
from hbench.errors import ConfigError

EXAMPLE = Path(__file__).parents[2] / "configs" / "fit.yaml"


def test_the_example_says_what_holds_without_a_file():
    assert parse_fitting(read_yaml(EXAMPLE), "fit.yaml") == Fitting()


def test_bounds_are_those_of_the_points_or_the_sources_by_name_or_edited_one_by_one():
    assert {value for name, value in Fitting().bounds if name != "k2_s_m"} == {None}
    sources = parse_fitting({"bounds": "table_6_1"}, "fit.yaml").bounds
    assert sources.f_coulomb_n == sources.f_stiction_n == sources.b_viscous_n_s_m == (0.0, 1e5)
    assert sources.v_stribeck_m_s == pytest.approx((0.05, 0.2))
    edited = parse_fitting({"bounds": {"v_stribeck_m_s": ["10 mm/s", "0.3 m/s"]}}, "fit.yaml")
    assert edited.bounds.v_stribeck_m_s == pytest.approx((0.01, 0.3))
    assert edited.bounds.b_viscous_n_s_m is None


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"weight": "trials"}, "'weight'"),
        ({"bounds": {"f_columb_n": ["0 N", "1 N"]}}, "'bounds.f_columb_n'"),
        ({"bounds": {"f_coulomb_n": ["9 N", "1 N"]}}, "bounds.f_coulomb_n"),
        ({"bounds": {"f_coulomb_n": ["0 N"]}}, "bounds.f_coulomb_n"),
        ({"bounds": {"v_stribeck_m_s": ["0 mm/s", "1 m/s"]}}, "bounds.v_stribeck_m_s.0 = '0 mm/s'"),
        ({"bounds": {"v_stribeck_m_s": [0.05, 0.2]}}, "bounds.v_stribeck_m_s"),
        ({"loss": "cauchy"}, "loss = 'cauchy'"),
        ({"laws": ["stribeck"]}, "laws"),
        ({"bootstrap": -1}, "bootstrap = -1"),
    ],
)
def test_what_is_wrong_is_refused_with_its_key(data, words):
    with pytest.raises(ConfigError, match="fit.yaml") as error:
        parse_fitting(data, "fit.yaml")
    assert words in str(error.value)
