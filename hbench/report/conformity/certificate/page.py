"""The certificate as a page: one file, A4 when printed, or a laboratory's own template.

The text of a replacement template is rendered in Jinja's sandbox with autoescape. Its variables:
``certificate`` (the content, see ``layout.Content``), ``parts`` (the same parts by key),
``laboratory``, ``logo`` (a data URL) and ``style``. It can load no other file.
"""

from base64 import b64encode
from functools import cache

from jinja2 import BaseLoader, Environment, PackageLoader, TemplateError, TemplateSyntaxError
from jinja2.sandbox import ImmutableSandboxedEnvironment
from markupsafe import Markup

from hbench.config.conformity.certificate import Image
from hbench.errors import ConfigError
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.content import content
from hbench.report.conformity.certificate.layout import Content
from hbench.report.render.document import ESCAPED

_PAGE = "certificate.html.j2"
# Chromium from 131 on prints what is in the margins; elsewhere the browser's own header does.
_MARGINS = """
@page {{
  size: A4; margin: 17mm 15mm 15mm; font: 8pt sans-serif; color: #444;
  @top-left {{ content: "{number_label} {number}"; }}
  @top-right {{ content: "{page_label} " counter(page) " {of_label} " counter(pages); }}
  @bottom-center {{ content: "{mark}"; font: bold 10pt sans-serif; color: #9b1c1c; }}
}}
"""


def certificate_page(
    certificate: Certificate, template: str | None = None, source: str = ""
) -> str:
    """Return the page; ``template`` replaces its own. Raises ``ConfigError`` for a faulty one."""
    shown = content(certificate)
    variables = {
        "certificate": shown,
        "parts": shown.parts,
        "laboratory": certificate.file.laboratory.name,
        "logo": _data_url(certificate.logo),
        "style": Markup(_style(shown)),
    }
    if template is None:
        return _environment().get_template(_PAGE).render(variables)
    try:
        text = ImmutableSandboxedEnvironment(**ESCAPED).from_string(template).render(variables)
    except TemplateError as error:
        line = f", line {error.lineno}" if isinstance(error, TemplateSyntaxError) else ""
        raise ConfigError(f"{source}{line}: {error}") from None
    except Exception as error:  # a template can fail as any program
        raise ConfigError(f"{source}: {type(error).__name__}: {error}") from None
    for needed in filter(None, (shown.number, shown.mark)):
        if needed not in text:
            raise ConfigError(f"{source}: the page does not contain {needed!r}")
    return text


def _style(shown: Content) -> str:
    """Return the style sheet. All texts in it are hbench's own, or have letters of a number."""
    loader = _environment().loader
    assert isinstance(loader, BaseLoader)
    css = loader.get_source(_environment(), "certificate.css")[0]
    return css + _MARGINS.format(
        number_label=shown.number_label,
        number=shown.number,
        page_label=shown.page_label,
        of_label=shown.of_label,
        mark=shown.mark,
    )


def _data_url(logo: Image | None) -> str:
    """Return an image as a URL. A browser runs no script of an SVG that is an image."""
    if logo is None:
        return ""
    return f"data:{logo.media_type};base64,{b64encode(logo.data).decode('ascii')}"


@cache
def _environment() -> Environment:
    loader = PackageLoader("hbench.report.conformity.certificate", "")
    return Environment(loader=loader, **ESCAPED)
