"""The gallery of robots at a tiny size: rows, shards, shares, figure, and its descriptions."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
import pytest
import yaml

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.check import check_gallery
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.gallery.builders import gallery, runs
from sensory_commutativity.studies.gallery.figures.robot_gallery import robot_gallery as figure
from sensory_commutativity.studies.gallery.tables.gallery_experiments import gallery_experiments
from sensory_commutativity.studies.gallery.tables.robot_gallery import robot_gallery
from sensory_commutativity.studies.loading import load, merge, read_settings, validate
from tests.helpers import DEFAULT, ROOT

MOST_LINES = 20
"""Of a robot's description, so that people see how little is needed."""


@pytest.fixture(scope="module")
def config() -> Config:
    husky = {"husky": {"description": str(ROOT / "config/robots/husky.yaml")}}
    section = {"starts": 4, "sequence_length": 3, "image_size": 32, "robots": husky}
    section["scenes"] = {"free-space": {}}
    return validate(merge(read_settings(DEFAULT), {"gallery": section}))


@pytest.fixture(scope="module")
def experiments(config: Config) -> pd.DataFrame:
    return gallery_experiments(config, "husky.free-space").compute(0, 4)


def test_rows_do_not_depend_on_how_starts_are_cut(config, experiments) -> None:
    compute = gallery_experiments(config, "husky.free-space").compute
    parts = pd.concat([compute(0, 1), compute(1, 4)], ignore_index=True)
    assert parts.equals(experiments) and len(parts) == 4 * 2


def test_the_share_of_stops_and_of_self_contacts_is_told(config, experiments) -> None:
    table = robot_gallery(experiments, config)
    assert set(robot_gallery.column_names) <= set(table.columns)
    assert len(table) == 2 * len(gallery(config).thresholds)
    assert (table["scp"] == 1).all() and (table["n"] == 4).all()  # nothing is in its way
    assert (table[["at_stop", "self_contact", "touched"]] == 0).all(axis=None)
    spoiled = experiments.assign(
        touched_self=experiments["experiment"] == 0, at_limit=experiments["experiment"] < 2
    )
    table = robot_gallery(spoiled, config)
    assert set(table["self_contact"]) == {0.25} and set(table["at_stop"]) == {0.5}
    drawn = figure({"robot_gallery": table}, config)
    assert [axes.get_title() for axes in drawn.axes if axes.get_visible()] == ["husky"]
    plt.close(drawn)


def test_the_descriptions_of_the_gallery_are_short_and_name_their_packages() -> None:
    settings = load(DEFAULT, ROOT / "config" / "gallery.yaml").gallery
    assert settings is not None and len(settings.robots) >= 10 and settings.starts >= 200
    for name, robot in settings.robots.items():
        path = ROOT / robot.description
        text = path.read_text(encoding="utf-8")
        if name in ("fetch", "jackrabbot"):  # of the paper, with the sources of all numbers
            continue
        assert len(text.splitlines()) <= MOST_LINES, name
        description = yaml.safe_load(text)
        package = description["urdf"].removeprefix("package://").partition("/")[0]
        assert package.replace("stretch_urdf", "hello-robot-stretch-urdf") in description["about"]


def test_a_configuration_without_a_gallery_has_no_runs(default_config) -> None:
    assert not runs(default_config)
    check_gallery(default_config)
    with pytest.raises(ConfigError, match=r"merge config/gallery\.yaml"):
        gallery(default_config)
