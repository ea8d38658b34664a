"""The certificate's words in each language. A user's own texts are printed as they are."""

from collections.abc import Mapping

from hbench.config.conformity.certificate import Language
from hbench.report.conformity.certificate.english import ENGLISH
from hbench.report.conformity.certificate.german import GERMAN

WORDS: Mapping[Language, Mapping[str, str]] = {"en": ENGLISH, "de": GERMAN}
