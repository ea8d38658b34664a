"""Certificate of a campaign: page, PDF, digital calibration certificate or archive."""

from collections.abc import Callable
from datetime import date, timedelta
from pathlib import Path

from hbench.analysis.conformity.certified import (
    certified_trials,
    certified_values,
    why_not_certified,
)
from hbench.config.conformity.certificate import (
    completed,
    parse_certificate,
    read_logo,
    read_template,
)
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError, DataError
from hbench.report.campaign.results_document import results_json
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.dcc import dcc_xml
from hbench.report.conformity.certificate.page import certificate_page
from hbench.store.campaign.folder import StoredCampaign, load_campaign
from hbench.store.campaign.raw_logs import raw_data
from hbench.store.exporting.printed_page import printed_page
from hbench.store.exporting.ro_crate import Described, write_crate
from hbench.store.files.atomic import write_atomic
from hbench.workflow.conformity.acceptance import decided
from hbench.workflow.results import derive

_FORMS = (".html", ".pdf", ".xml", ".zip")
_DAY = timedelta(days=1)


def certify(folder: Path, file: Path, output: Path) -> Certificate:
    """Write the certificate of a campaign; the form follows from the name of ``output``.

    ``.html``, ``.pdf``, ``.xml`` (digital calibration certificate), ``.zip`` or no extension
    (RO-Crate with the raw logs). It is issued today where the file states no date.
    Raises ``DataError`` for a campaign that gets no certificate.
    """
    form = output.suffix.lower()
    if form and form not in _FORMS:
        raise ConfigError(
            f"{output}: '{form}' is no form of a certificate",
            f"Use {', '.join(_FORMS)}, or a folder's name without an extension.",
        )
    certificate = _certificate(folder, file)
    template = certificate.file.template
    own = None if template is None else read_template(file.parent / template)

    def page() -> bytes:
        return certificate_page(certificate, own, str(template)).encode()

    def pdf() -> bytes:
        if own is not None:
            return printed_page(page().decode(), str(template))
        from hbench.report.conformity.certificate.pdf import certificate_pdf  # slow: matplotlib

        return certificate_pdf(certificate)

    def xml() -> bytes:
        return dcc_xml(certificate).encode()

    forms: dict[str, Callable[[], bytes]] = {".html": page, ".pdf": pdf, ".xml": xml}
    if form in forms:
        write_atomic(output, forms[form]())
        return certificate
    derived = {
        "certificate.html": page(),
        "results.json": results_json(certificate.results).encode(),
    }
    if certificate.performed is not None:  # the DCC needs the date
        derived["certificate.xml"] = xml()
    about = Described(
        name=f"{certificate.word('title')} {certificate.number}",
        description=certificate.word("simulated" if certificate.simulated else "only_item"),
        number=certificate.number,
        published=certificate.issued,
        publisher=certificate.file.laboratory.name,
        raw=certificate.raw,
    )
    write_crate(output, load_campaign(folder), derived, about)
    return certificate


def _refuse_other_specimens(campaign: StoredCampaign) -> None:
    """Raise ``DataError`` unless the specimen is a cylinder: a certificate has its quantities."""
    if campaign.rotary:
        what = "its actuator is rotary; a certificate states forces in N and speeds in mm/s"
    elif all(plan.specimen.area_piston_m2 == 0 for plan in campaign.plans):
        what = "a drive without hydraulics moves its specimen; a certificate is of a cylinder"
    else:
        return
    raise DataError(
        f"{campaign.folder}: gets no certificate: {what}", "Use the report of `hbench report`."
    )


def _certificate(folder: Path, path: Path) -> Certificate:
    file = parse_certificate(read_yaml(path), str(path))
    campaign = load_campaign(folder)
    results = derive(campaign)
    _refuse_other_specimens(campaign)
    reasons = why_not_certified(results)
    if reasons:
        resume = "" if campaign.imported else "; continue an interrupted campaign with --resume"
        raise DataError(
            f"{folder}: gets no certificate: {'; '.join(reasons)}",
            f"`hbench report` shows the data{resume}.",
        )
    specimen, test = completed(file, results.provenance.settings, str(path))
    instruments = campaign.setup().instruments
    acceptance = None if file.limits is None else decided(results, path.parent / file.limits)
    checks = () if acceptance is None else acceptance.checks
    measured = [check.measurement for check in checks if check.measurement is not None]
    known = {results.provenance.name, *(run.run.plan.label for run in results.runs)}
    if acceptance is not None:
        known |= {acceptance.product, *(check.requirement.name for check in checks)}
    for name in file.names:
        if not name or name not in known:
            raise ConfigError(
                f"{path}: names: {name!r} is no series, limit, product or schedule here",
                f"Known are {', '.join(repr(each) for each in sorted(known - {''}))}.",
            )
    values, all_speeds = certified_values(results, instruments, measured)
    values = (*values, *certified_trials(checks))
    if not values:
        raise DataError(f"{folder}: gets no certificate: none of its quantities was measured")
    certificate = Certificate(
        file=file,
        issued=file.issued or date.today(),
        specimen=specimen,
        test=test,
        results=results,
        values=values,
        all_speeds=all_speeds,
        instruments=instruments,
        raw=raw_data(campaign),
        acceptance=acceptance,
        warnings=campaign.warnings,
        logo=None if file.logo is None else read_logo(path.parent / file.logo),
    )
    _check_dates(certificate, str(path))
    return certificate


def _check_dates(certificate: Certificate, source: str) -> None:
    """Raise ``ConfigError`` if the specimen came after its test, or the certificate before it.

    Days are those of UTC: in other time zones they may differ by one.
    """
    if certificate.performed is None:
        return
    (first, last), file = certificate.performed, certificate.file
    if file.received is not None and file.received > first + _DAY:
        raise ConfigError(
            f"{source}: received = {file.received}: the test began on {first}",
            "State the day on which the specimen was received for this test.",
        )
    if file.issued is not None and file.issued < last - _DAY:
        raise ConfigError(
            f"{source}: issued = {file.issued}: the test ended on {last}",
            "Remove 'issued', which means today, or state a day after the test.",
        )
