"""Flags in the files of runs: 0, 1, or a mean of both."""

import numpy as np
import pytest

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.campaign.run_csv import read_channels
from hbench.store.formats.text import parse_table


def channels_with(flag):
    rows = [f"{0.01 * i:.2f},{0.001 * i:.4f},{flag if i == 3 else 0}" for i in range(6)]
    text = "\n".join(["t_s,x_m,sensor_saturated", *rows]) + "\n"
    return read_channels(parse_table(text.encode(), "0001.csv", Format()))[0]


@pytest.mark.parametrize("flag", ["1", "0.5"])
def test_a_flag_is_read_as_it_is(flag):
    found = channels_with(flag)["sensor_saturated"]
    assert np.array_equal(found, [0, 0, 0, float(flag), 0, 0])


@pytest.mark.parametrize("flag", ["1e300", "-1", "2"])
def test_another_number_than_a_flag_is_refused_with_its_line(flag):
    with pytest.raises(DataError, match=r"0001\.csv: line 5: sensor_saturated is .*0 or 1"):
        channels_with(flag)
