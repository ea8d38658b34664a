"""Identity of a board that exists on paper only."""

from hbench.protocol.dictionary import dictionary_hash

IDENTITY = {
    "protocol": 1,
    "dictionary": dictionary_hash(),
    "firmware": "test 1",
    "board": "paper",
    "boots": 3,
    "rate_hz": 10000,
    "ring_records": 1024,
    "max_steps": 128,
    "max_segments": 128,
}
