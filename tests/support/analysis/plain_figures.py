"""As many figures as a report has, drawn by matplotlib as it comes from a campaign's curves.csv.

``python plain_figures.py CAMPAIGN FOLDER``: no text but labels, no page, no analysis.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd


def plain_figures(campaign: Path, folder: Path) -> int:
    """Draw points with error bars in two panels, as SVG; return how many figures."""
    curves = pd.read_csv(campaign / "results" / "curves.csv")
    count = len(list((campaign / "results" / "figures").glob("*.svg")))
    for number in range(count):
        figure, panels = plt.subplots(2, sharex=True, figsize=(5.2, 5.4), layout="constrained")
        for load, points in curves.groupby("f_load_n"):
            for axes in panels:
                axes.errorbar(
                    points.v_m_s, points.friction_n, points.ci95_n, fmt="o", label=f"{load} N"
                )
        panels[0].legend()
        panels[1].set(xlabel="v (m/s)", ylabel="F (N)")
        figure.savefig(folder / f"{number}.svg")
        plt.close(figure)
    return count


if __name__ == "__main__":
    plain_figures(Path(sys.argv[1]), Path(sys.argv[2]))
