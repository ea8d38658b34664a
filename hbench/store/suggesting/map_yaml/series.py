"""Section of a suggested map on the series: files, factors and the cylinder's sizes."""

from collections.abc import Iterator

from hbench.config.import_map import UNFILLED
from hbench.store.suggesting.choice import GUESS, LIKELY, SURE
from hbench.store.suggesting.map_yaml.commented_yaml import comment_lines, entry, line, scalar
from hbench.store.suggesting.map_yaml.suggested_map import SuggestedMap, SuggestedSeries


def series_lines(suggested: SuggestedMap) -> Iterator[str]:
    """Yield the section of the series; those that the map can't read are comments."""
    yield line("series:", "{...}: a number in the file name; *: any characters")
    anchor: SuggestedSeries | None = None
    usable = [series for series in suggested.series if not series.fault]
    shown = usable or list(suggested.series)
    for series in shown:
        pattern = series.pattern
        count = len(pattern.names)
        label = pattern.label or suggested.folder
        yield line(f"  - label: {scalar(label)}", f"{count} file{'s' * (count > 1)}")
        yield f"    files: {scalar(pattern.files)}"
        for name, unit in pattern.units.items():
            if name in pattern.assumed:
                yield line(f"    {name}_unit: {unit}", f"{GUESS}: no unit in the names")
            elif unit != {"speed": "mm/s", "load": "N", "pressure": "bar"}[name]:
                yield line(f"    {name}_unit: {unit}", f"{SURE}: in the names")
        if motion := suggested.other_motion(series):
            yield from entry(f"    kind: {motion.kind}", f"{GUESS}: {motion.reason}")
            yield f"    cut: {motion.cut}"
        yield from _factors(series)
        if suggested.is_driven:
            continue
        if anchor is None or _other_bore(anchor.bore_m, series.bore_m):
            several = anchor is None and len(shown) > 1
            yield "    cylinder: &cylinder" if several else "    cylinder:"
            yield from _sizes(suggested, series)
            anchor = anchor or series
        else:
            yield line("    cylinder: *cylinder", "assumed to be the same")
    for series in suggested.series if usable else ():
        if series.fault:
            yield from comment_lines(f"- files: {series.pattern.files}: {series.fault}", "  # ")


def _factors(series: SuggestedSeries) -> Iterator[str]:
    """Yield the factors: fields of the names, and columns with one value in a series."""
    units = series.pattern.factors
    alone = {f: values[0] for f, values in series.factors.items() if len(values) == 1}
    given = [f"{name}: {scalar(unit, flow=True)}" for name, unit in units.items()]
    given += [f"{f.name}: {scalar(f.text(value), flow=True)}" for f, value in alone.items()]
    if given:
        why = [f"{LIKELY}: fields of the names"] if units else []
        why += [
            f"{f.column} is about {f.text(value)} in the files read" for f, value in alone.items()
        ]
        yield from entry(f"    factors: {{{', '.join(given)}}}", "; ".join(why))
    for factor, values in series.factors.items():
        if factor not in alone:
            several = ", ".join(map(factor.text, sorted(values)))
            yield from comment_lines(
                f"factors: {factor.column} has the values {several} in these files; to separate "
                f"their curves write a series for each, with factors: {{{factor.name}: VALUE}}",
                "    # ",
            )


def _sizes(suggested: SuggestedMap, series: SuggestedSeries) -> Iterator[str]:
    if suggested.is_rotary:
        yield line(f"      displacement: {UNFILLED} cm^3", "volume for one radian")
        return
    about = "the bore"
    if series.bore_m is not None:
        about += f"; the balance of forces gives {1e3 * series.bore_m:.1f} mm"
    yield line(f"      piston_diameter: {UNFILLED} mm", about)
    yield line(
        f"      rod_diameter: {UNFILLED} mm", "0 mm if the chamber has no rod; with a rod on"
    )
    yield line("", "both sides write piston_area and rod_area instead")


def _other_bore(a: float | None, b: float | None) -> bool:
    return a is not None and b is not None and abs(a - b) > 0.015 * a
