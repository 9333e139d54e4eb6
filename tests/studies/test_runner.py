"""Computing what is declared: inputs are matched and checked, shards are gathered, and a killed job
resumes."""

from __future__ import annotations

import itertools
import shutil
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.errors import TableError, UserError
from sensory_commutativity.storage.arrays import read_arrays, write_arrays
from sensory_commutativity.storage.columns import INT, Column
from sensory_commutativity.storage.tables import read_metadata, write_table
from sensory_commutativity.studies import registry, runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Batched, Product, Shards, arrays, table
from sensory_commutativity.studies.flatland.builders import DOFS
from sensory_commutativity.studies.flatland.tables import flatland_experiments as module
from sensory_commutativity.studies.flatland.tables.flatland_commutation import flatland_commutation
from sensory_commutativity.studies.flatland.tables.flatland_commutation_experiments import (
    flatland_commutation_experiments,
)
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from sensory_commutativity.studies.flatland.tables.flatland_scp import flatland_scp
from sensory_commutativity.studies.objects.arrays.mask_regions import mask_regions
from tests.helpers import update_flatland
from tests.studies.examples import overlay, write_frame, write_shards

RUN = "furnished.polyphemus.4"


@pytest.fixture(scope="module")
def experiments(tiny_config) -> pd.DataFrame:
    """A complete table flatland_experiments; all experiments commute."""
    rows = [
        (*run[:3], dof, i, i, 0.0)
        for run in tiny_config.flatland.runs()
        for i in range(run.experiments)
        for dof in DOFS
    ]
    return pd.DataFrame(rows, columns=flatland_experiments.column_names)


def write_run_shards(config: Config, folder: Path, frame: pd.DataFrame) -> list[Path]:
    """Cut a complete table of experiments into its shards."""
    paths, start = [], 0
    for shard in flatland_experiments.shards.all(config):
        stop = start + (shard.stop - shard.start) * len(DOFS)
        paths.append(write_frame(flatland_experiments, config, folder, frame[start:stop], shard))
        start = stop
    assert start == len(frame)
    return paths


def refuse(product: Product, config: Config, paths: list[Path], out: Path, shard=None) -> str:
    """The message with which inputs are refused: one line, and nothing is written."""
    with pytest.raises(UserError) as caught:
        runner.write_product(product, config, paths, out, shard)
    message = str(caught.value)
    assert "\n" not in message and not out.exists()
    return message


# ---- inputs -----------------------------------------------------------------------------------


def test_a_table_is_computed_from_a_table_that_is_complete_and_of_this_configuration(
    experiments, tiny_config, tmp_path
):
    out = tmp_path / "scp.parquet"

    def refuse_rows(frame: pd.DataFrame, config: Config = tiny_config) -> str:
        path = write_frame(flatland_experiments, tiny_config, tmp_path, frame)
        message = refuse(flatland_scp, config, [path], out)
        assert message.startswith(f"{path}: ")
        assert "; delete it and run" in message
        return message

    slow = experiments["agent"] == "slow-base"
    assert "repeated, the first with world furnished, agent polyphemus, length 4, dof base-" in (
        refuse_rows(pd.concat([experiments, experiments[:2]]))
    )
    assert "1 of 16 groups of rows missing: world furnished, agent slow-base, length 4;" in (
        refuse_rows(experiments[~slow])
    )
    assert "2 of 16 groups of rows missing" in refuse_rows(experiments[experiments["length"] == 4])
    assert "not part of the configuration: world furnished, agent giraffe" in (
        refuse_rows(pd.concat([experiments, experiments[:8].assign(agent="giraffe")]))
    )
    assert "groups of rows incomplete: world furnished, agent polyphemus" in (
        refuse_rows(experiments[1:])
    )
    for change in (dict(rest_steps=4), dict(worlds={"things-4": {"objects": 5}}),
                   dict(reference={"experiments": 6})):  # fmt: skip
        other = update_flatland(tiny_config, **change)
        assert "was computed with other settings than this configuration has" in (
            refuse_rows(experiments, other)
        )
    other = tiny_config.model_copy(update={"seed": 1})
    assert "was computed with other root seed (20210301) than" in refuse_rows(experiments, other)
    other = tiny_config.model_copy(update={"profile": "paper"})
    assert "was computed with other profile (default) than" in refuse_rows(experiments, other)
    path = write_frame(flatland_experiments, tiny_config, tmp_path, experiments)
    content = path.read_bytes()
    for size in (0, 100, len(content) - 10):
        path.write_bytes(content[:size])
        assert "; delete it and run the workflow" in refuse(flatland_scp, tiny_config, [path], out)
    write_table(path, "flatland_scp", flatland_experiments.columns[:4], experiments, {})
    assert "not a flatland_experiments table" in refuse(flatland_scp, tiny_config, [path], out)
    write_table(path, "flatland_experiments", flatland_experiments.columns, experiments, {})
    assert "other profile (none)" in refuse(flatland_scp, tiny_config, [path], out)
    path.unlink()
    assert "there is no such table; run the workflow" in (
        refuse(flatland_scp, tiny_config, [path], out)
    )
    path.write_bytes(content)
    reordered = update_flatland(tiny_config, experiments_per_job=99)
    runner.write_product(flatland_scp, reordered, [path], out)
    table = runner.read_product(flatland_scp, tiny_config, out)
    assert (table["scp"] == 1).all()


def test_inputs_are_recognized_by_their_names_in_any_order(tiny_config, tmp_path):
    config, names = tiny_config, ["flatland_baselines.parquet", "flatland_scp.parquet"]
    product = registry.find_table("flatland_alternatives")
    for folders in (("a", "b"), ("b", "a")):
        paths = [tmp_path / folder / name for folder, name in zip(folders, names, strict=True)]
        for given in itertools.permutations(paths):
            found = runner.match_inputs(product, config, given, None)
            assert [source.name for source, _ in found] == ["flatland_baselines", "flatland_scp"]
            assert [file for _, (file,) in found] == paths
    other = tmp_path / "flatland_trends.parquet"
    for given, message in (
        (paths[:1], r"^flatland_alternatives needs the input flatland_scp\.parquet; give the path"),
        ([], r"needs the input flatland_baselines\.parquet and 1 more; give the path of each file"),
        (
            [*paths, other],
            r"/flatland_trends\.parquet: is no input of flatland_alternatives; leave",
        ),
        ([*paths, tmp_path / names[0]], r"baselines\.parquet: given twice .*; give it once"),
    ):
        with pytest.raises(UserError, match=message):
            runner.match_inputs(product, config, given, None)


def test_a_shard_is_computed_from_the_shards_of_the_same_number(small_config):
    shard = mask_regions.shards.find(small_config, "flownet.2-of-2")
    files = [Path("data/flownet.predictor"), Path("data/training.2-of-2.h5")]
    found = runner.match_inputs(mask_regions, small_config, files[::-1], shard)
    assert [paths for _, paths in found] == [[files[0]], [files[1]]]
    wrong = [files[0], Path("data/training.1-of-2.h5")]
    with pytest.raises(UserError, match=r"training\.1-of-2\.h5: is no input of mask_regions"):
        runner.match_inputs(mask_regions, small_config, wrong, shard)


@arrays(title="Pictures", shards=Shards(
    runs=lambda config: {"a": 4, "b": 2}, settings=lambda config, run: config.masks.objects,
    per_shard=lambda config: config.masks.data.scenes_per_job,
))  # fmt: skip
def pictures(config: Config, shard) -> tuple[dict, dict]:
    return {"unit": np.arange(shard.start, shard.stop)}, {"camera": "left"}


@table(
    title="Pixels of pictures",
    columns=[Column("unit", INT, "1", "number of the picture", key=True)],
    inputs=["pictures/a"],
)
def pixels(files: list[Path], config: Config) -> pd.DataFrame:
    units = [read_arrays(path, "pictures")[0]["unit"] for path in files]
    return pd.DataFrame({"unit": np.concatenate(units)})


@pytest.fixture
def declared(monkeypatch):
    """`pictures` is among the declarations."""
    monkeypatch.setattr(registry, "find_product", lambda name: {"pictures": pictures}[name])


def test_arrays_must_be_of_this_configuration_and_of_their_shard(
    declared, default_config, tmp_path
):
    config, out = default_config, tmp_path / "pixels.parquet"
    paths = write_shards(pictures, config, tmp_path, "a")
    assert [path.name for path in paths] == [f"a.{i}-of-4.h5" for i in (1, 2, 3, 4)]
    texts = read_arrays(paths[2], "pictures")[1]
    assert texts["camera"] == "left" and texts["units"] == "2-3"
    assert texts["profile"] == config.profile and texts["root_seed"] == str(config.seed)
    runner.write_product(pixels, config, paths[::-1], out)
    assert runner.read_product(pixels, config, out)["unit"].tolist() == [0, 1, 2, 3]
    out.unlink()
    other = overlay(config, masks={"objects": 3})
    assert "other settings than this configuration has; delete it and run the workflow" in (
        refuse(pixels, other, paths, out)
    )
    shutil.copy(paths[0], paths[1])
    message = refuse(pixels, config, paths, out)
    assert message.startswith(f"{paths[1]}: was computed with other units (0-1) than")
    shutil.copy(write_shards(pictures, config, tmp_path, "b")[1], paths[1])
    assert "a.2-of-4.h5: was computed with other settings" in refuse(pixels, config, paths, out)
    write_arrays(paths[1], "sounds", {}, {})
    assert "2-of-4.h5: no file of pictures" in refuse(pixels, config, paths, out)
    paths[1].write_bytes(paths[0].read_bytes()[:100])
    assert "2-of-4.h5: incomplete or damaged" in refuse(pixels, config, paths, out)
    paths[1].unlink()
    assert "2-of-4.h5: there is no such file" in refuse(pixels, config, paths, out)
    write_shards(pictures, config, tmp_path, "a")
    with h5py.File(paths[1], "r+") as file:
        file["unit"][:] = 99
    assert "2-of-4.h5: damaged, its content does not match" in refuse(pixels, config, paths, out)


# ---- shards -----------------------------------------------------------------------------------


def test_shards_are_gathered_in_order(experiments, tiny_config, tmp_path):
    paths = write_run_shards(tiny_config, tmp_path, experiments)
    assert len(paths) == 17  # the five experiments of the reference in two shards, 15 further runs
    out = tmp_path / "flatland_experiments.parquet"
    for given in (paths, paths[::-1]):
        runner.write_product(flatland_experiments, tiny_config, given, out)
        table = runner.read_product(flatland_experiments, tiny_config, out)
        pd.testing.assert_frame_equal(table, experiments)
    metadata = read_metadata(out)
    assert metadata["table"] == "flatland_experiments" and "units" not in metadata
    assert metadata["config_sha256"] == tiny_config.digest()
    assert metadata["root_seed"] == str(tiny_config.seed) and metadata["git_commit"]
    assert read_metadata(paths[1])["units"] == "3-5"
    first = out.read_bytes()
    runner.write_product(flatland_experiments, tiny_config, paths, out)
    assert out.read_bytes() == first


def test_shards_must_be_all_there_once_and_of_this_configuration(
    experiments, tiny_config, tmp_path
):
    paths = write_run_shards(tiny_config, tmp_path, experiments)
    out = tmp_path / "flatland_experiments.parquet"

    def refuse_shards(config: Config = tiny_config, given: list[Path] = paths) -> str:
        return refuse(flatland_experiments, config, given, out)

    message = refuse_shards(given=paths[1:])
    assert message.startswith(f"flatland_experiments needs the input {RUN}.1-of-2.parquet; give")
    message = refuse_shards(given=[*paths[:1], *paths[3:]])
    assert "polyphemus.4.2-of-2.parquet and 1 more; give" in message
    assert "1-of-2.parquet: given twice" in refuse_shards(given=[*paths, paths[0]])
    stranger = tmp_path / "attic.polyphemus.4.1-of-1.parquet"
    assert "attic.polyphemus.4.1-of-1.parquet: is no input" in refuse_shards(
        given=[*paths, stranger]
    )
    other = update_flatland(tiny_config, rest_steps=4)
    message = refuse_shards(other)
    assert message.startswith(f"{paths[0]}: was computed with other settings than")
    assert message.endswith(
        "; delete it and run the workflow again, or: sencom table flatland_experiments --shard "
        f"{RUN}.1-of-2 --config results/default/config.yaml"
    )
    # another cut has other file names, or the same names for other units
    recut = update_flatland(tiny_config, experiments_per_job=4)
    message = refuse_shards(recut)
    assert message.startswith(f"{paths[0]}: was computed with other units (0-3) than")
    content = paths[1].read_bytes()
    for replacement, message in (
        (paths[0].read_bytes(), "2-of-2.parquet: was computed with other units (0-3) than"),
        (paths[2].read_bytes(), "2-of-2.parquet: was computed with other settings than"),
        (content[:-9], "2-of-2.parquet: not a readable Parquet file"),
        (b"", "2-of-2.parquet: not a readable Parquet file"),
    ):
        paths[1].write_bytes(replacement)
        assert message in refuse_shards()
    paths[1].unlink()
    assert "2-of-2.parquet: there is no such table" in refuse_shards()
    shard = flatland_experiments.shards.find(tiny_config, f"{RUN}.2-of-2")
    for rows, problem in (
        (experiments[24:39], "incomplete: world furnished, agent polyphemus, length 4, experiment"),
        (experiments[24:32], "missing: world furnished, agent polyphemus, length 4, experiment 4"),
        (experiments[16:40], "not part of the configuration: world furnished, agent polyphemus"),
        (experiments[24:24], "missing: world furnished, agent polyphemus, length 4, experiment 3"),
        (experiments[24:40].assign(world="attic"), "missing: world furnished"),
        (experiments[24:40].assign(distance=-1.0), "distance is below 0 in 16 of 16 rows"),
    ):
        write_frame(flatland_experiments, tiny_config, tmp_path, rows, shard)
        message = refuse_shards()
        assert message.startswith(f"{paths[1]}: ") and problem in message


def test_some_tables_are_read_from_shards_alone(tiny_config, tmp_path):
    paths = [
        path
        for world in tiny_config.flatland.commutation_worlds()
        for path in write_shards(flatland_commutation_experiments, tiny_config, tmp_path, world)
    ]
    assert len(paths) == 6
    out = tmp_path / "flatland_commutation.parquet"
    runner.write_product(flatland_commutation, tiny_config, paths, out)
    table = runner.read_product(flatland_commutation, tiny_config, out)
    assert len(table) == 2 * 64 and (table["n"] == 3).all()
    out.unlink()
    assert "settled.1-of-3.parquet and 2 more" in (
        refuse(flatland_commutation, tiny_config, paths[:3], out)
    )


def test_results_do_not_depend_on_how_experiments_are_cut(tiny_config, tmp_path):
    longer = update_flatland(  # in small rooms, so that some experiments do not commute
        tiny_config, sequence_length=100, baselines=dict(transitions=200, training=100),
        worlds={world: {"width": 320.0, "height": 320.0, "objects": 4}
                for world in ("furnished", "settled", "things-12")},
    )  # fmt: skip
    for product, run in (
        (flatland_experiments, "furnished.polyphemus.100"),
        (flatland_experiments, "things-12.long-arms.100"),
        (flatland_commutation_experiments, "furnished"),
        (flatland_commutation_experiments, "settled"),
    ):
        tables = []
        for per_job, shards in ((1, {5, 3}), (20, {1, 2}), (1000, {1})):
            config = update_flatland(longer, experiments_per_job=per_job)
            folder = tmp_path / f"{run}.{per_job}"
            paths = write_shards(product, config, folder, run)
            assert len(paths) in shards
            assert sorted(folder.iterdir()) == sorted(paths), "batches are left"
            tables.append(runner.read_shards(product, config, paths)[0])
        for frame in tables[1:]:
            pd.testing.assert_frame_equal(frame, tables[0])
        whole = product(longer, run).compute(0, tables[0]["experiment"].nunique())
        pd.testing.assert_frame_equal(whole, tables[0])
        assert (whole["distance"] > 0).any(), run


def test_a_killed_shard_resumes_from_its_finished_batches(tiny_config, tmp_path, monkeypatch):
    config = update_flatland(
        tiny_config, sequence_length=1, experiments_per_job=250,
        free_space={"worlds": ["free-space"], "experiments": 210},
        baselines=dict(transitions=100, training=52),
    )  # fmt: skip
    shard = flatland_experiments.shards.find(config, "free-space.polyphemus.1.1-of-1")
    out, played = tmp_path / "free-space.polyphemus.1.1-of-1.parquet", []

    def play(world, seed, length, rest_steps):
        if len(played) == kill_at:
            raise KeyboardInterrupt
        played.append(seed)
        return {dof: float(seed % 97) for dof in DOFS}

    monkeypatch.setattr(module, "distances_per_dof", play)
    kill_at = 150
    with pytest.raises(KeyboardInterrupt):
        runner.write_product(flatland_experiments, config, [], out, shard)
    assert not out.exists()
    played.clear()
    kill_at = None
    runner.write_product(flatland_experiments, config, [], out, shard)
    assert len(played) == 110  # the first batch of 100 is kept, the 50 after it are not
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    table = runner.read_shards(flatland_experiments, config, [out])[0]
    whole = flatland_experiments(config, "free-space.polyphemus.1").compute(0, 210)
    pd.testing.assert_frame_equal(table, whole)


def test_batches_of_other_settings_are_not_resumed(tiny_config, tmp_path, monkeypatch):
    computed = []

    @table(
        title="Numbers", columns=[Column("unit", INT, "1", "number", key=True)],
        shards=Shards(
            runs=lambda config: {"a": 6}, settings=lambda config, run: config.flatland.rest_steps
        ),
    )  # fmt: skip
    def numbers(config: Config, run: str) -> Batched:
        def compute(start: int, stop: int) -> pd.DataFrame:
            if killed and start == 4:
                raise KeyboardInterrupt
            computed.append(start)
            return pd.DataFrame({"unit": range(start, stop)})

        return Batched(compute, size=2)

    killed = True
    (shard,) = numbers.shards.all(tiny_config)
    with pytest.raises(KeyboardInterrupt):
        runner.write_product(numbers, tiny_config, [], tmp_path / "a.parquet", shard)
    killed = False
    other = update_flatland(tiny_config, rest_steps=4)
    runner.write_product(numbers, other, [], tmp_path / "a.parquet", shard)
    assert computed == [0, 2, 0, 2, 4]


def test_hashes_of_further_files_must_agree_in_all_shards(experiments, tiny_config, tmp_path):
    paths = write_run_shards(tiny_config, tmp_path, experiments)
    for path in paths:
        frame = pd.read_parquet(path)
        metadata = {k: v for k, v in read_metadata(path).items() if k not in ("table", "pandas")}
        weights = {"weights_sha256": "b" if path == paths[3] else "a"}
        write_table(path, "flatland_experiments", flatland_experiments.columns, frame,
                    metadata | weights)  # fmt: skip
    out = tmp_path / "flatland_experiments.parquet"
    message = refuse(flatland_experiments, tiny_config, paths, out)
    assert message.startswith(f"{paths[3]}: its weights_sha256 differs from that of {paths[0]}")
    with pytest.raises(TableError, match="weights_sha256"):
        runner.read_shards(flatland_experiments, tiny_config, paths)
    _, extra = runner.read_shards(flatland_experiments, tiny_config, paths[:2])
    assert extra == {"weights_sha256": "a"}
