"""Claims about robots in apartments hold and fail as their rules say."""

from __future__ import annotations

import pandas as pd

from sensory_commutativity.studies.apartment.claims import apartment_claims
from sensory_commutativity.studies.apartment.tables.apartment_hierarchy import apartment_hierarchy
from sensory_commutativity.studies.apartment.tables.apartment_scp import apartment_scp
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from tests.studies.apartment.examples import make_experiments, overlay
from tests.worlds.apartment.examples import write_robot

FREE = "fetch: in free space everything commutes"


def decide(experiments: pd.DataFrame, order: pd.DataFrame, config) -> dict[str, bool]:
    """Claim -> whether it holds."""
    lengths = experiments["length"] == config.apartment.sequence_length
    views = experiments["field_of_view"] == config.apartment.fields_of_view[0]
    used = experiments[lengths & views & (experiments["start"] == "anywhere")]
    compared = used[used["apartment"] == config.apartment.reference.scene]
    tables = dict(
        apartment_scp=apartment_scp(used, config),
        apartment_hierarchy=apartment_hierarchy(compared, config),
        apartment_order=order,
    )
    return {claim.claim: bool(claim.holds) for claim in apartment_claims(tables, config)}


def test_all_claims_hold_if_everything_is_as_in_the_paper(experiments, order, config):
    claims = decide(experiments, order, config)
    assert len(claims) == 9 and all(claims.values()), claims


def test_a_claim_fails_if_its_condition_is_violated(experiments, order, scp, config):
    for dof, value, failing in (
        ("left-wheel", 0.6, "fetch: the wheels have the lowest SCP"),
        ("torso-lift", 0.9, "fetch: torso-lift always commutes"),
        ("shoulder-pan", 0.8, "fetch: the arm joint nearest the body has the SCP nearest .5"),
        ("wrist-roll", 0.3, "fetch: the SCP rises along wheel < shoulder < elbow < wrist"),
    ):
        changed = {**scp, "fetch": {**scp["fetch"], dof: value}}
        claims = decide(make_experiments(config, changed), order, config)
        assert not claims[failing], dof
        assert claims["jackrabbot: the wheels have the lowest SCP"], dof
    moved = (experiments["apartment"] == "free-space") & (experiments["robot"] == "fetch")
    moved &= experiments["experiment"] == 0
    claims = decide(experiments.assign(distance=experiments["distance"].mask(moved, 900.0)),
                    order, config)  # fmt: skip
    assert not claims[FREE] and claims[FREE.replace("fetch", "jackrabbot")]


def test_a_robot_without_a_hierarchy_has_no_steps_and_no_claims_about_them(
    default_config, order, tmp_path
):
    """As in the smallest description in config/robots/README.md: an arm fixed to the floor."""
    description = write_robot(tmp_path)
    apartment = {
        "robots": {"mine": {"description": str(description)}},
        "reference": {"robot": "mine"},
        "robots_compared": {"robots": []},
        "scenes_compared": {"robots": ["mine"]},
        "within_reach": {"robots": ["mine"]},
        "free_space": {"robots": ["mine"]},
    }
    config = overlay(default_config, apartment=apartment, masks={"robot": "mine", "fixed": {}})
    dofs = [dof.name for dof in load_robot(description).dofs]
    experiments = make_experiments(config, {"mine": dict.fromkeys(dofs, 0.5)})
    assert apartment_hierarchy(experiments, config).empty
    claims = decide(experiments, order, config)
    assert not any("rises" in claim or "wheels" in claim for claim in claims)
    assert claims["mine: in free space everything commutes"]
