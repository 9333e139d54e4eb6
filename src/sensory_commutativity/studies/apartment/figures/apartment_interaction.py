"""SCP against what the degree of freedom truly touched: a figure that needs a simulator that tells."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ....worlds.apartment.robots.robot import load_robot
from ...apartment.builders import described_files
from ...config import Config
from ...declarations import figure
from ...plotting import GREEN, GREY, VERMILION, dof_label, group_colours

_KINDS = (
    ("touched", "touched something", VERMILION),
    ("hindered", "only its own body or a joint's limit", GREY),
    ("free", "neither", GREEN),
)


def _labels(rows: pd.DataFrame) -> list[tuple[float, float, str]]:
    """Where to write which names: those of points that lie close to each other together, one below the other."""
    found: list[tuple[float, float, list[str]]] = []
    for _, row in rows.sort_values("touched").iterrows():
        close = next(
            (
                label
                for label in found
                if abs(label[0] - row["touched"]) < 0.08 and abs(label[1] - row["scp"]) < 0.035
            ),
            None,
        )
        if close is None:
            found.append((row["touched"], row["scp"], [dof_label(row["dof"])]))
        else:
            close[2].append(dof_label(row["dof"]))
    return [
        (x, y, ", ".join(names[:2]) + "".join(f",\n{name}" for name in names[2:]))
        for x, y, names in found
    ]


@figure(
    title="SCP against what the degree of freedom truly touched: a figure that needs a simulator that tells",
    inputs=["apartment_interaction"],
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_interaction(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    settings = config.apartment
    reference = settings.reference
    table = tables["apartment_interaction"]
    table = table[(table["length"] == settings.sequence_length)]
    mine = table[(table["robot"] == reference.robot) & (table["apartment"] == reference.scene)]
    robot = load_robot(settings.robots[reference.robot].description)
    colours = group_colours(robot)
    group = {dof.name: dof.group for dof in robot.description.dofs}
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.8), width_ratios=[1, 1.2])
    for start, marker in (("anywhere", "o"), ("within-reach", "^")):
        rows = mine[mine["start"] == start]
        for _, row in rows.iterrows():
            style = dict(color=colours[group[row["dof"]]], marker=marker)
            left.errorbar(
                row["touched"],
                row["scp"],
                xerr=[[row["touched"] - row["ci_low"]], [row["ci_high"] - row["touched"]]],
                elinewidth=0.8,
                **style,
            )
        if start == "anywhere":
            for x, y, names in _labels(rows):
                left.annotate(
                    names,
                    (x, y),
                    textcoords="offset points",
                    xytext=(6, 5),
                    fontsize=7,
                    va="bottom",
                )
        if len(rows):
            left.plot(
                [],
                [],
                color="#555555",
                marker=marker,
                linestyle="",
                label=f"{start}, n = {rows['n'].iloc[0]}",
            )
    left.plot([0, 1], [1, 0], color=GREY, linewidth=0.8, linestyle=":")
    left.set_xlim(-0.02, 1.02)
    left.set_ylim(0, 1.12)
    left.set_xlabel("fraction of experiments in which something was touched")
    left.set_ylabel("SCP")
    left.legend(title="start", loc="lower left")
    left.set_title(
        f"{reference.robot} in {reference.scene}; dotted: nothing that is touched commutes",
        fontsize=9,
    )
    rows = (
        mine[mine["start"] == "anywhere"]
        .set_index("dof")
        .loc[[dof.name for dof in robot.description.dofs]]
    )
    places, bottom = np.arange(len(rows)), np.zeros(len(rows))
    for kind, name, colour in _KINDS:
        n, commuted = rows[f"n_{kind}"] / rows["n"], rows[f"commuted_{kind}"] / rows["n"]
        right.bar(
            places,
            n - commuted,
            bottom=bottom,
            color=colour,
            label=f"{name}: does not commute",
            width=0.75,
        )
        right.bar(
            places,
            commuted,
            bottom=bottom + n - commuted,
            color=colour,
            alpha=0.35,
            label=f"{name}: commutes",
            width=0.75,
        )
        bottom = bottom + n.to_numpy()
    right.set_xticks(
        places,
        [dof_label(dof) for dof in rows.index],
        rotation=45,
        ha="right",
        rotation_mode="anchor",
    )
    right.set_ylabel("fraction of experiments")
    right.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    right.set_title(
        f"why experiments do not commute, started anywhere; threshold {reference.threshold:g}",
        fontsize=9,
    )
    return figure
