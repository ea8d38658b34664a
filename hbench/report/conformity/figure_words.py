"""Words of the figure of decisions, in each language of a certificate."""

from collections.abc import Mapping
from dataclasses import dataclass

from hbench.config.conformity.certificate import Language


@dataclass(frozen=True)
class FigureWords:
    """Words of the figure in the language of its document."""

    title: str
    head: str  # above the axes
    axis: str
    caption: str
    two_sided: str  # of the caption, where a limit has two sides
    efficiency: str  # where an efficiency has a lower limit
    lower: str  # where another quantity has one
    read_as: str
    guard_band: str  # of ``read_as``, where the rule has one
    no_value: str
    no_scale: str  # of a limit of 0
    simulated: str


FIGURE_WORDS: Mapping[Language, FigureWords] = {
    "en": FigureWords(
        title="Measured values against their limits",
        head="Decisions",
        axis="Share of the limit (%)",
        caption="Each value as a share of its limit. All limits are the black line at 100 %; "
        "values in the green strip conform.",
        two_sided="Two limits: distance from the middle between them, as a share of half of their "
        "distance.",
        efficiency="Efficiency: loss as a share of the permitted loss.",
        lower="Lower limit: 100 % is the limit, 0 % is twice the limit.",
        read_as="Bar: measured value ± U.",
        guard_band="Hatched: guard band, as wide as U.",
        no_value="no measured value",
        no_scale="no share of a limit of 0",
        simulated="simulated",
    ),
    "de": FigureWords(
        title="Messwerte und ihre Grenzwerte",
        head="Entscheidungen",
        axis="Anteil am Grenzwert (%)",
        caption="Jeder Messwert als Anteil an seinem Grenzwert. Alle Grenzwerte sind die schwarze "
        "Linie bei 100 %; Werte im grünen Streifen sind konform.",
        two_sided="Zwei Grenzwerte: Abstand von ihrer Mitte als Anteil an ihrem halben Abstand.",
        efficiency="Wirkungsgrad: Verlust als Anteil am zulässigen Verlust.",
        lower="Unterer Grenzwert: 100 % ist der Grenzwert, 0 % sein Doppeltes.",
        read_as="Balken: Messwert ± U.",
        guard_band="Schraffiert: Schutzabstand, so breit wie U.",
        no_value="kein Messwert",
        no_scale="kein Anteil an einem Grenzwert von 0",
        simulated="simuliert",
    ),
}
