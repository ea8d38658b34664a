"""NIST's Statistical Reference Datasets: data, starts and certified values from their files.

The models are written here by hand; a parameter vector may be complex, for complex steps.
"""

import re
from typing import NamedTuple

import numpy as np

from tests.support import ROOT

FOLDER = ROOT.parent / "shared" / "data" / "nist-strd"
WHY_MISSING = (
    f"the NIST StRD files are not in {FOLDER.parent.name}/{FOLDER.name} beside the checkout"
)


def _gauss(b, x):
    return (
        b[0] * np.exp(-b[1] * x)
        + b[2] * np.exp(-((x - b[3]) ** 2) / b[4] ** 2)
        + b[5] * np.exp(-((x - b[6]) ** 2) / b[7] ** 2)
    )


def _cubic(b, x):
    top = b[0] + b[1] * x + b[2] * x**2 + b[3] * x**3
    return top / (1 + b[4] * x + b[5] * x**2 + b[6] * x**3)


def _lanczos(b, x):
    return b[0] * np.exp(-b[1] * x) + b[2] * np.exp(-b[3] * x) + b[4] * np.exp(-b[5] * x)


def _enso(b, x):
    def wave(period, cosine, sine):
        turn = 2 * np.pi * x / period
        return cosine * np.cos(turn) + sine * np.sin(turn)

    return b[0] + wave(12, b[1], b[2]) + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])


def _kirby(b, x):
    return (b[0] + b[1] * x + b[2] * x**2) / (1 + b[3] * x + b[4] * x**2)


MODELS = {
    "Bennett5": lambda b, x: b[0] * (b[1] + x) ** (-1 / b[2]),
    "BoxBOD": lambda b, x: b[0] * (1 - np.exp(-b[1] * x)),
    "Chwirut1": lambda b, x: np.exp(-b[0] * x) / (b[1] + b[2] * x),
    "Chwirut2": lambda b, x: np.exp(-b[0] * x) / (b[1] + b[2] * x),
    "DanWood": lambda b, x: b[0] * x ** b[1],
    "ENSO": _enso,
    "Eckerle4": lambda b, x: b[0] / b[1] * np.exp(-0.5 * ((x - b[2]) / b[1]) ** 2),
    "Gauss1": _gauss,
    "Gauss2": _gauss,
    "Gauss3": _gauss,
    "Hahn1": _cubic,
    "Kirby2": _kirby,
    "Lanczos1": _lanczos,
    "Lanczos2": _lanczos,
    "Lanczos3": _lanczos,
    "MGH09": lambda b, x: b[0] * (x**2 + x * b[1]) / (x**2 + x * b[2] + b[3]),
    "MGH10": lambda b, x: b[0] * np.exp(b[1] / (x + b[2])),
    "MGH17": lambda b, x: b[0] + b[1] * np.exp(-x * b[3]) + b[2] * np.exp(-x * b[4]),
    "Misra1a": lambda b, x: b[0] * (1 - np.exp(-b[1] * x)),
    "Misra1b": lambda b, x: b[0] * (1 - (1 + b[1] * x / 2) ** -2),
    "Misra1c": lambda b, x: b[0] * (1 - (1 + 2 * b[1] * x) ** -0.5),
    "Misra1d": lambda b, x: b[0] * b[1] * x / (1 + b[1] * x),
    "Nelson": lambda b, x: b[0] - b[1] * x[0] * np.exp(-b[2] * x[1]),
    "Rat42": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)),
    "Rat43": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Roszman1": lambda b, x: b[0] - b[1] * x - np.arctan(b[2] / (x - b[3])) / np.pi,
    "Thurber": _cubic,
}
NAMES = tuple(MODELS)


class DataSet(NamedTuple):
    """One set as certified."""

    name: str
    level: str  # Lower, Average, Higher
    starts: np.ndarray  # (2, p)
    certified: np.ndarray  # (p,)
    errors: np.ndarray  # (p,) standard deviations of the estimates
    rss: float
    x: np.ndarray  # (n,), of Nelson (2, n)
    y: np.ndarray  # (n,)

    def residual(self, b):
        return MODELS[self.name](b, self.x) - self.y


def load(name):
    text = (FOLDER / f"{name}.dat").read_text()
    rows = re.findall(r"^\s*b\d+\s*=\s*(.*)$", text, re.M)
    numbers = np.array([[float(word) for word in row.split()] for row in rows])
    data = np.array(
        [line.split() for line in text[text.rindex("Data:") :].splitlines()[1:] if line.split()],
        dtype=float,
    )
    y = np.log(data[:, 0]) if name == "Nelson" else data[:, 0]
    return DataSet(
        name,
        re.search(r"(\w+) Level of Difficulty", text)[1],
        numbers[:, :2].T,
        numbers[:, 2],
        numbers[:, 3],
        float(re.search(r"Residual Sum of Squares:\s*(\S+)", text)[1]),
        data[:, 1:].T if name == "Nelson" else data[:, 1],
        y,
    )
