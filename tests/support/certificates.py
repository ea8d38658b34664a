"""What the tests of certificates share."""

from base64 import b64decode

HOSTILE = '<script>alert("x")</script> & {{ 7 * 7 }} $x_1$'
LIMITS = """\
product: P-1
rule: guard_band
limits:
  - {quantity: friction, load: 1000 N, max: 2 kN}
  - {quantity: breakaway, max: 4 bar}
"""
FILE = {
    "laboratory": {"name": "Labor & Söhne", "address": ["Weg 1", "Ort"], "country": "DE"},
    "customer": {"name": "Kunde AG", "address": ["Straße 2"]},
    "signatories": [{"name": "Prof. Prüfer", "role": "head"}],
    "number": "L-17",
    "replaces": "L-16",
    "received": "2025-12-22",
    "method": "WI-12",
    "remarks": ["A remark of the laboratory"],
    "specimen": {"serial": "S-4711", "order": "A-1"},
    "test": {"place": "test hall 2", "ambient": "23 °C, 40 %"},
}
PNG = b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII="
)
