"""Figures: style, saving, labels and captions. The finished workflow draws all of them."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import jinja2
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import yaml
from docutils.core import publish_doctree
from PIL import Image, ImageSequence

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import compare_orders
from sensory_commutativity.studies.apartment.builders import load_named_robot
from sensory_commutativity.studies.flatland.figures.flatland_experiment import find_experiment
from sensory_commutativity.studies.loading import merge
from sensory_commutativity.studies.navigation.figures.navigation_episode import median_seed
from sensory_commutativity.studies.objects.figures.mask_discoveries import mask_discoveries
from sensory_commutativity.studies.plotting import (
    GROUP_COLOURS,
    STYLE,
    GifWriter,
    dof_styles,
    error_lengths,
    format_p_value,
    format_probability,
    group_colours,
    save_figure,
)
from sensory_commutativity.studies.provenance import provenance
from tests.helpers import DEFAULT, ROOT


def test_declarations_of_figures_import_no_simulation_and_no_network():
    code = (
        "import sys\n"
        "from sensory_commutativity.studies.declarations import Animation, Figure\n"
        "from sensory_commutativity.studies.registry import declarations\n"
        "assert declarations(Figure) and declarations(Animation)\n"
        "slow = 'pybullet pymunk numba torch stable_baselines3 gymnasium h5py scipy'.split()\n"
        "print(*(module for module in slow if module in sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not run.stdout.strip()


# ---- captions ---------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", ["config", "paper", "test"])
def test_captions_are_valid_with_the_settings_of_every_profile(profile):
    """Snakemake renders them with the configuration as it is written, without default values."""
    settings = yaml.safe_load(DEFAULT.read_text())
    settings = merge(settings, yaml.safe_load((ROOT / "config" / f"{profile}.yaml").read_text()))
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined)
    for path in sorted((ROOT / "workflow" / "report").glob("*.rst")):
        template = environment.from_string(path.read_text())
        text = template.render(snakemake=SimpleNamespace(config=settings))
        publish_doctree(text, settings_overrides={"halt_level": 2})
        if path.stem == "flatland_scp":
            n = settings["flatland"]["reference"]["experiments"]
            assert f"{n:,} SC-experiments each" in text.replace("\n", " ")


# ---- saving -----------------------------------------------------------------------------------


def test_equal_figures_give_equal_files_with_their_provenance(tmp_path, default_config):
    sizes = []

    def draw():
        sizes.append(plt.rcParams["font.size"])
        figure, axes = plt.subplots(figsize=(1, 1))
        axes.plot([0, 1])
        return figure

    for name in ("a.png", "b.png"):
        save_figure(draw, tmp_path / name, default_config)
    assert sizes == [STYLE["font.size"]] * 2 and not plt.get_fignums()
    for suffix in (".png", ".pdf"):
        first, second = (tmp_path / f"{name}{suffix}" for name in "ab")
        assert first.read_bytes() == second.read_bytes()
    text = Image.open(tmp_path / "a.png").text
    assert provenance(default_config).items() <= text.items()


def test_an_animation_has_all_frames_and_one_that_fails_leaves_no_file(tmp_path, default_config):
    def write(path, n, fails=False):
        figure, axes = plt.subplots(figsize=(1, 1))
        with GifWriter(figure, path, default_config, fps=5, dpi=40) as writer:
            for k in range(n):
                axes.plot([0, k + 1])
                writer.grab_frame()
            if fails:
                raise ZeroDivisionError

    write(tmp_path / "a.gif", 3)
    image = Image.open(tmp_path / "a.gif")
    assert default_config.digest() in image.info["comment"].decode()
    frames = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
    assert frames == [200] * 3  # milliseconds
    with pytest.raises(ZeroDivisionError):
        write(tmp_path / "b.gif", 1, fails=True)
    assert [path.name for path in tmp_path.iterdir()] == ["a.gif"] and not plt.get_fignums()


# ---- labels and styles ------------------------------------------------------------------------


def test_numbers_are_never_rounded_to_a_stronger_statement():
    assert [format_probability(p, 2) for p in (0.0, 0.256, 0.999, 1.0)] == [
        "0.00", "0.26", "0.99", "1"
    ]  # fmt: skip
    assert [format_p_value(p) for p in (1e-9, 0.0009, 0.00123, 0.0994, 0.0996, 1.0)] == [
        "p < 0.001", "p < 0.001", "p = 0.001", "p = 0.099", "p = 0.10", "p = 1.00"
    ]  # fmt: skip


def test_error_bars_reach_the_ends_of_the_interval_and_are_never_negative():
    lengths = error_lengths([0.5, 1.0], [0.25, 0.9], [0.625, 1.0 - 1e-16])
    np.testing.assert_allclose(lengths, [[0.25, 0.1], [0.125, 0.0]])
    assert (lengths >= 0).all()


def test_robots_have_a_colour_per_group_and_a_style_per_degree_of_freedom(default_config):
    for name in default_config.apartment.robots:
        robot = load_named_robot(default_config.apartment, name)
        groups, styles = group_colours(robot), dof_styles(robot)
        assert len(set(groups.values())) == len(groups), name
        assert all(GROUP_COLOURS.get(group, c) == c for group, c in groups.items()), name
        assert list(styles) == [dof.name for dof in robot.dofs]
        assert all(styles[dof.name]["color"] == groups[dof.group] for dof in robot.description.dofs)
        assert len({tuple(sorted(style.items())) for style in styles.values()}) == len(styles), name


# ---- choices ----------------------------------------------------------------------------------


def test_the_animated_experiment_is_the_first_that_does_not_commute(tiny_config, monkeypatch):
    module = sys.modules[find_experiment.__module__]
    world, start, *orders = find_experiment(tiny_config, "left-shoulder")
    assert mean_squared_error(*compare_orders(world, start, *orders)) > 0
    assert np.array_equal(np.sort(orders[0], axis=0), np.sort(orders[1], axis=0))
    # The eyelid always commutes here: the last of the experiments is taken.
    monkeypatch.setattr(module, "MOST_EXPERIMENTS", 2)
    world, start, *orders = find_experiment(tiny_config, "eyelid")
    assert mean_squared_error(*compare_orders(world, start, *orders)) == 0


def test_the_animated_run_has_the_lower_median_of_the_learning_curves():
    scores = pd.DataFrame(
        [
            ("full", 7, 0.9),
            ("full", 5, 0.1),
            ("full", 6, 0.4),
            ("full", 8, 0.5),
            ("inverse", 1, 0.2),
        ],
        columns=["action_space", "seed", "auc"],
    )
    assert median_seed(scores, "full") == 6
    assert median_seed(scores, "inverse") == 1


# ---- what is drawn ----------------------------------------------------------------------------


def test_rates_without_experiments_are_left_out_of_the_figure(default_config):
    comparisons = ["sc-experiment", "first-last", "return"]
    table = pd.DataFrame({"comparison": comparisons, "discovery_rate": [9.0, 1.0, 4.0]}).assign(
        kind="random", n=10, p=0.02, ci_low=0.5, ci_high=9.5, n_touched=10, n_untouched=0,
        tpr=[0.5, 0.6, 0.2], tpr_low=0.1, tpr_high=0.7, fpr=np.nan, fpr_low=np.nan,
        fpr_high=np.nan,
    )  # fmt: skip
    other_kind = table.assign(kind="left-right", discovery_rate=99.0)
    tables = {"mask_discoveries": pd.concat([other_kind, table])}
    figure = mask_discoveries.compute(tables, default_config)
    left, right = figure.axes
    assert [bar.get_height() for bar in left.patches] == [9.0, 1.0, 4.0]
    heights = [bar.get_height() for bar in right.patches]
    assert heights[:3] == [0.5, 0.6, 0.2] and np.isnan(heights[3:]).all()
    assert [text.get_text() for text in left.texts] == ["9.0", "1.0\np = 0.020", "4.0\np = 0.020"]
    figure.canvas.draw()
    plt.close(figure)
