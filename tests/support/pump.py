"""A pump with a pressure compensator and a relief valve, as in a bench file."""

PUMP = {
    "flow": "30 l/min",
    "cut_off": "152 bar",
    "band": "20 bar",
    "compensator_lag": "190 ms",
    "swash_lag": "20 ms",
    "relief": "165 bar",
    "relief_gain": "1.2 l/min/bar",  # 2e-10 m^3/s/Pa
    "leakage": "6.6e-3 l/min/bar",  # 1.1e-12
    "capacity": "0.6 cm^3/bar",  # below 0.45 unstable at rest (Routh)
}
