# The finished run: checksums of all that it made.
def raw_data():
    """Everything below data/, so that what is missing there is made anew before it is given a checksum."""
    starts = {(run.robot, run.scene, run.start) for run in APARTMENT.runs()}
    return [
        *experiment_parts(),
        *commutation_parts(None),
        *(DATA / "flatland_baselines" / f"{dof}.parquet" for dof in DOFS),
        *(DATA / "apartment_ready" / f"{'.'.join(start)}.json" for start in starts),
        *apartment_parts(None),
        *pairs_of("training"),
        *pairs_of("validation"),
        *(
            DATA / "mask_training" / f"{model}.{kind}"
            for model in LEARNED
            for kind in ("parquet", "predictor")
        ),
        *(path for model in LEARNED for path in places_of(model)),
        *all_tuples(),
        *(DATA / "mask_scores" / f"{model}.parquet" for model in MODELS_OF_MASKS),
        *parts("local_scp_experiments", "places", map_jobs(CONFIG), "h5"),
        *(
            DATA / "navigation_runs" / f"{action_space}.{seed}.parquet"
            for action_space, seed in NAVIGATION.runs
        ),
    ]


def models():
    """Every model."""
    navigation = [
        MODELS / "navigation" / f"{action_space}.{seed}.policy"
        for action_space, seed in NAVIGATION.runs
    ]
    masks = [MODELS / "masks" / f"{model}.predictor" for model in MODELS_OF_MASKS]
    return [*navigation, *masks]


def tables():
    """Every table but the one of which only the parts are kept, and the arrays beside them."""
    whole = [name for name in SCHEMAS if name != "flatland_commutation_experiments"]
    return [TABLES / source_file(name) for name in (*whole, *ARRAYS)]


rule checksums:
    input:
        sorted(map(str, [*raw_data(), *models(), *tables(), *figures()])),
    output:
        # kept while the rule runs: a file that was not written since keeps its checksum
        update(CHECKSUMS),
    log:
        LOGS / "checksums.log",
    localrule: True
    message:
        "writing the checksums of the run"
    shell:
        "sensory-commutativity checksums --out {output:q} 2> {log:q}"
