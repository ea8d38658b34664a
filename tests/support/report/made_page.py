"""Made-up results with their headline numbers and grades, and their page."""

from dataclasses import fields, replace

from hbench.analysis.summary.headline import headline
from hbench.analysis.summary.quality import quality
from hbench.records import Results
from hbench.report.campaign.page import report_document
from hbench.report.render.document import page


def made_results(*args, **kwargs):
    """Results with the summary of their own runs and curves."""
    names = [field.name for field in fields(Results)]
    given = dict(zip(names, args, strict=False)) | kwargs
    return Results(
        **given,
        headline=headline(given["curves"], given["efficiency"]),
        quality=quality(given["runs"], given["curves"], given["efficiency"]),
    )


def summarized(results, speed_m_s=None):
    """Results that a test has changed, with the summary of what they hold now."""
    return replace(
        results,
        headline=headline(
            results.curves,
            results.efficiency,
            results.motions.breakaways,
            speed_m_s,
        ),
        quality=quality(results.runs, results.curves, results.efficiency),
    )


def page_html(results, drawings):
    """The page of results that a test may have changed."""
    return page(report_document(summarized(results), drawings))
