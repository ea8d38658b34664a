"""Calibration of a raw log to a run in SI: words, counts, volts, units; flags, times and losses."""

import numpy as np

from hbench.config.bench import Bench
from hbench.errors import DataError
from hbench.model.sensors import sensor_gains
from hbench.records import RUN_FLAGS, LogChannel, RawRun, Run
from hbench.units import parse_unit

# A log channel's name -> its field of Run.
RUN_FIELDS = {
    "x": "x_m",
    "v": "v_m_s",
    "p_tp": "p_tp_pa",
    "p_tr": "p_tr_pa",
    "p_lp": "p_lp_pa",
    "p_lr": "p_lr_pa",
    "p_s": "p_s_pa",
    "f_applied": "f_applied_n",
    "u_t": "u_t_v",
    "u_l1": "u_l1_v",
    "u_l2": "u_l2_v",
    "v_ref": "v_ref_m_s",
    "auxiliary": "temp_tank_k",
    "temp_tank": "temp_tank_k",  # name of the auxiliary input in older logs
}
# Logged also without a sensor; no reading of it makes a run doubtful. An acceleration stays in the
# raw log alone.
OPTIONAL_INPUTS = ("auxiliary", "temp_tank")
# Channels that are not sensors, with their units; sensors are logged in counts.
WORD_UNITS = {"v": "m/s", "v_ref": "m/s", "u_t": "V", "u_l1": "V", "u_l2": "V"}
BOOKKEEPING = ("run", "index", "flags")
# Codes of the reader's warnings that cast doubt on the log's completeness.
INCOMPLETE = ("truncated", "missing", "unreadable", "changed")

_INDEX_SPAN = 1 << 16  # the index is a 16-bit word and starts again


def calibrate(raw: RawRun, bench: Bench) -> Run:
    """Convert a raw log to SI.

    A sensor's word is ADC counts times 1/scale; SI = gain * counts + offset with the gains of
    the bench's amplifier chain (appendix B, equation C.6). A record is the mean over the
    interval since the last one, so its time is the middle of that interval:
    t = (index + 1/2) / rate. All channels have this delay.

    At a limit of its converter, the true value is beyond the range: such records are marked as
    ``sensor_saturated``, even if the board did not mark them; a temperature is NaN there. Pressure
    and position inputs saturate at 3 V of 3.16 V, which is 9.49 V of the transducer's 10 V
    (appendix B; the amplifier's gain is too large).

    Records of another run and records out of order are left out, and reported in
    ``Run.truncated``. Raises ``DataError`` unless the log has the channels of a run.
    """
    column = _columns(raw)
    words, faults = _records_of_run(raw, column)
    index = _unwrap(words[:, column["index"]])
    faults += _incomplete(raw, words, column, index)
    gains = sensor_gains(bench.sensors)
    if "temp_tank" in gains:
        gains["auxiliary"] = gains["temp_tank"]
    channels = {
        RUN_FIELDS[channel.name]: _to_si(words[:, number], channel, gains)
        for number, channel in enumerate(raw.channels)
        if channel.name not in BOOKKEEPING
        and (channel.name in gains or channel.name not in OPTIONAL_INPUTS)
    }
    top = 2**bench.sensors.adc.bits - 1
    for number, channel in enumerate(raw.channels):
        if channel.name in OPTIONAL_INPUTS and RUN_FIELDS[channel.name] in channels:
            channels[RUN_FIELDS[channel.name]][_at_limit(words[:, number], channel, top)] = np.nan
    flags = words[:, column["flags"]]
    bits = {
        name: (flags >> raw.flags.index(name) & 1).astype(bool)
        for name in RUN_FLAGS
        if name in raw.flags
    }
    bits["sensor_saturated"] = bits.get("sensor_saturated", False) | _saturated(raw, words, bench)
    return Run(
        plan=raw.plan,
        t_s=(index + 0.5) / raw.rate_hz,
        **channels,
        **bits,
        missing_records=int(index[-1]) + 1 - len(index) if len(index) else 0,
        truncated="; ".join(faults),
        aborted=_stopped_early(raw),
    )


def _columns(raw: RawRun) -> dict[str, int]:
    names = [channel.name for channel in raw.channels]
    run, layout = raw.plan.run, "the log's layout in campaign.yaml"
    if raw.words.ndim != 2 or raw.words.shape[1] != len(names):
        raise DataError(
            f"run {run}: its log has words of shape {raw.words.shape}; "
            f"expected {len(names)} columns, one per channel"
        )
    for name in ("x", *BOOKKEEPING):
        if name not in names:
            raise DataError(f"run {run}: {layout} has no channel '{name}'")
    for channel in raw.channels:
        name, unit = channel.name, channel.unit
        if name not in RUN_FIELDS and name not in BOOKKEEPING:
            raise DataError(
                f"run {run}: {layout} has the unknown channel '{name}'; known are "
                f"{', '.join(RUN_FIELDS)}"
            )
        wanted = WORD_UNITS.get(name, "1" if name in BOOKKEEPING else "count")
        if not _same_dimension(unit, wanted):
            raise DataError(
                f"run {run}: {layout} has channel '{name}' in {unit!r}; expected {wanted!r}"
            )
    return {name: number for number, name in enumerate(names)}


def _same_dimension(unit: str, wanted: str) -> bool:
    if "count" in (unit, wanted):
        return unit == wanted
    return parse_unit(unit).dimension == parse_unit(wanted).dimension


def _to_si(
    words: np.ndarray, channel: LogChannel, gains: dict[str, tuple[float, float]]
) -> np.ndarray:
    numbers = words.astype(np.int16) if channel.signed else words
    values = channel.scale * numbers.astype(float)
    if channel.unit != "count":
        return values * parse_unit(channel.unit).factor
    gain, offset = gains[channel.name]
    return gain * values + offset


def _saturated(raw: RawRun, words: np.ndarray, bench: Bench) -> np.ndarray:
    """Return whether a sensor's word is 0 or that of the highest code, for each record (n,)."""
    top = 2**bench.sensors.adc.bits - 1
    saturated = np.zeros(len(words), dtype=bool)
    for number, channel in enumerate(raw.channels):
        if channel.unit == "count" and channel.name not in (*BOOKKEEPING, *OPTIONAL_INPUTS):
            saturated |= _at_limit(words[:, number], channel, top)
    return saturated


def _at_limit(column: np.ndarray, channel: LogChannel, top: int) -> np.ndarray:
    return (column == 0) | (column >= round(top / channel.scale))


def _records_of_run(raw: RawRun, column: dict[str, int]) -> tuple[np.ndarray, list[str]]:
    """Return the records of this run that are in order, and the faults of the others."""
    words = raw.words
    faults: list[str] = []
    if not len(words):
        return words, faults
    numbers, counts = np.unique(words[:, column["run"]], return_counts=True)
    if len(numbers) > 1:
        number = numbers[np.argmax(counts)]
        foreign = len(words) - counts.max()
        faults.append(f"{foreign} of {len(words)} records belong to another run, left out")
        words = words[words[:, column["run"]] == number]
    index = words[:, column["index"]]
    steps = np.diff(index)  # modulo 2^16, as the words are unsigned
    backwards = np.flatnonzero((steps == 0) | (steps >= _INDEX_SPAN // 2))
    if len(backwards):
        last = backwards[0]
        faults.append(
            f"record {index[last + 1]} follows record {index[last]}, out of order: the last "
            f"{len(words) - last - 1} records left out"
        )
        words = words[: last + 1]
    return words, faults


def _unwrap(index: np.ndarray) -> np.ndarray:
    """Return 16-bit record numbers (n,) without their wrap-around."""
    if not len(index):
        return np.zeros(0, dtype=np.int64)
    steps = np.diff(index).astype(np.int64)
    return int(index[0]) + np.concatenate(([0], np.cumsum(steps)))


def _stopped_early(raw: RawRun) -> str:
    if raw.outcome in ("done", None):
        return ""
    return raw.why or f"the run is marked as {raw.outcome}, without a reason"


def _incomplete(
    raw: RawRun, words: np.ndarray, column: dict[str, int], index: np.ndarray
) -> list[str]:
    """Return the signs that the log does not extend to the end of the run."""
    faults = [warning for warning in raw.warnings if warning.split(":")[0] in INCOMPLETE]
    if raw.outcome is None:
        faults.append("unfinished: hbench ended before the run did, or is still making it")
    if not len(words):
        return [*faults, "the log contains no records"]
    if "last" in raw.flags:
        flags = int(words[-1, column["flags"]])
        if not flags >> raw.flags.index("last") & 1:
            faults.append(f"the log ends with record {index[-1]}, before the run's last record")
    return faults
