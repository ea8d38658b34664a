"""Payloads: octets of each field type, inverses, wrong lengths and names."""

import numpy as np
import pytest

from hbench.protocol.codec import BY_NAME, pack, pack_settings, unpack
from hbench.protocol.dictionary import MAX_FRAME, MESSAGES, RECORD, SETTINGS

SEGMENT = {"index": 1, "valves": 0x0203, "v_m_s": 1.0, "a_m_s2": -2.0, "duration_s": 0.5}
SEGMENT |= {"force_rate_n_s": 0.0, "displacement_m": 0.0}


def test_numbers_are_little_endian_and_singles_are_ieee():
    payload = pack(BY_NAME["write_segment"].request, SEGMENT)
    assert payload == bytes([1, 0, 3, 2]) + bytes.fromhex(
        "0000803f 000000c0 0000003f 00000000 00000000"
    )


def test_pack_and_unpack_are_inverse():
    fields = BY_NAME["write_segment"].request
    assert unpack(fields, pack(fields, SEGMENT)) == SEGMENT


def test_an_array_extends_to_the_end_of_the_payload():
    values = unpack(BY_NAME["read_log"].reply, bytes([1, 0, 0, 0, 2, 0, 0, 0, 0xFF, 0xEE, 1, 2]))
    assert (values["first"], values["next"]) == (1, 2)
    np.testing.assert_array_equal(values["words"], [0xEEFF, 0x0201])


@pytest.mark.parametrize("size", [0, 9, 11])
def test_a_payload_of_the_wrong_length_is_refused(size):
    with pytest.raises(ValueError):
        unpack(BY_NAME["read_log"].reply[:2] + (("x", "u16"),), bytes(size))


def test_a_missing_field_is_refused():
    with pytest.raises(ValueError, match="count"):
        pack(BY_NAME["read_log"].request, {"first": 1})


def test_every_fixed_message_fits_a_frame():
    for message in MESSAGES:
        for fields in (message.request, message.reply):
            fixed = [(n, k) for n, k in fields if k not in ("words", "f32s")]
            size = len(pack(fixed, {n: "" if k == "text16" else 0 for n, k in fixed}))
            assert size + 4 <= MAX_FRAME


def test_codes_and_names_are_unique():
    assert len({m.code for m in MESSAGES}) == len({m.name for m in MESSAGES}) == len(MESSAGES)
    assert all(m.code < 0x80 for m in MESSAGES)
    assert len({w.name for w in RECORD}) == len(RECORD)


def test_settings_are_packed_in_the_dictionary_order():
    octets = pack_settings({name: float(i) for i, name in enumerate(SETTINGS)})
    np.testing.assert_array_equal(np.frombuffer(octets, "<f4"), np.arange(len(SETTINGS)))


def test_an_unknown_setting_is_refused():
    with pytest.raises(ValueError, match=f"{SETTINGS[0]}, gian_x"):
        pack_settings({name: 0.0 for name in SETTINGS[1:]} | {"gian_x": 0.0})
