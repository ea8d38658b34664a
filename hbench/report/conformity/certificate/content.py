"""Content of a certificate in its language: parts of facts, tables and paragraphs.

The page, the PDF and a laboratory's own template show the same content. ISO/IEC 17025:2017, 7.8
asks for most of it; the README of this folder has the list.
"""

from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.conformity_parts import conformity_part, not_tested_part
from hbench.report.conformity.certificate.identity_parts import (
    conditions_part,
    customer_part,
    data_part,
    instruments_part,
    laboratory_part,
    specimen_part,
    test_part,
    validity_part,
)
from hbench.report.conformity.certificate.layout import (
    Content,
    Part,
    with_joined_units,
)
from hbench.report.conformity.certificate.result_parts import (
    method_part,
    result_parts,
    uncertainty_part,
)


def content(certificate: Certificate) -> Content:
    """Return the content of a certificate."""
    word = certificate.word
    rows = (
        (laboratory_part(certificate), customer_part(certificate)),
        (specimen_part(certificate), test_part(certificate), conditions_part(certificate)),
        (conformity_part(certificate),),  # on the first sheet
        (instruments_part(certificate),),
        (method_part(certificate),),
        *((part,) for part in result_parts(certificate)),
        (uncertainty_part(certificate),),
        (not_tested_part(certificate),),
        *(
            [(Part("remarks", word("remarks"), paragraphs=certificate.file.remarks),)]
            * bool(certificate.file.remarks)
        ),
        (data_part(certificate),),
        (validity_part(certificate),),
    )
    head = [(word("number"), certificate.number), (word("issued"), str(certificate.issued))]
    if certificate.file.replaces:
        head.append((word("replaces"), certificate.file.replaces))
    return Content(
        language=certificate.file.language,
        title=word("title"),
        number_label=word("number"),
        number=certificate.number,
        page_label=word("page"),
        of_label=word("of"),
        mark=word("simulated_short") if certificate.simulated else "",
        mark_text=word("simulated") if certificate.simulated else "",
        head_facts=tuple(head),
        rows=tuple(tuple(map(with_joined_units, row)) for row in rows),
        signature_title=word("signatures"),
        signatories=tuple((each.name, each.role) for each in certificate.file.signatories),
        signature_label=word("date_signature"),
        end=f"{word('end')} {certificate.number}",
    )
