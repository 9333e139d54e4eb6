# Learning to navigate: action spaces from the measured SCPs, one job per training run, and what the runs show.


def task(*more):
    """Settings of the task and of the learner, and the names that are part of the seeds."""
    return digest(
        FLATLAND.worlds[NAVIGATION.world],
        FLATLAND.agents[NAVIGATION.agent],
        NAVIGATION.zones,
        NAVIGATION.max_episode_steps,
        NAVIGATION.scp_world,
        NAVIGATION.agent,
        FLATLAND.sequence_length,
        *more,
    )


def training():
    """Settings of every training run."""
    return task(
        NAVIGATION.steps,
        NAVIGATION.checkpoints,
        NAVIGATION.evaluation_episodes,
        NAVIGATION.learner,
    )


rule navigation_scp:
    input:
        # these rows of flatland_scp from their own experiments: no setting of another agent or world trains all runs anew
        parts=experiment_parts(
            f"{NAVIGATION.scp_world}.{NAVIGATION.agent}.{FLATLAND.sequence_length}"
        ),
    output:
        TABLES / "navigation_scp.parquet",
    log:
        LOGS / "navigation_scp.log",
    localrule: True
    message:
        "estimating the SCP that the action spaces are made from"
    shell:
        "sensory-commutativity navigation-scp --config {RESOLVED:q} --out {output:q} {input.parts:q} 2> {log:q}"


rule navigation_action_spaces:
    input:
        navigation_scp=TABLES / "navigation_scp.parquet",
    output:
        TABLES / "navigation_action_spaces.parquet",
    log:
        LOGS / "navigation_action_spaces.log",
    localrule: True
    params:
        settings=digest(
            NAVIGATION.scp_world,
            NAVIGATION.agent,
            NAVIGATION.action_spaces,
            NAVIGATION.seeds,
            FLATLAND.sequence_length,
        ),
    message:
        "making action spaces from the measured SCPs"
    shell:
        "sensory-commutativity navigation-action-spaces --config {RESOLVED:q} --navigation-scp {input.navigation_scp:q} --out {output:q} 2> {log:q}"


rule navigation_run:
    input:
        navigation_scp=TABLES / "navigation_scp.parquet",  # not the table of action spaces: a further seed trains that seed only
    output:
        curve=DATA / "navigation_runs" / "{action_space}.{seed}.parquet",
        model=MODELS / "navigation" / "{action_space}.{seed}.policy",
    log:
        LOGS / "navigation_run" / "{action_space}.{seed}.log",
    benchmark:
        BENCHMARKS / "navigation_run" / "{action_space}.{seed}.tsv"
    threads: 1
    resources:
        mem_mb=growing(2000),
        runtime=growing(40),
    params:
        settings=training(),
    message:
        "training with the action space {wildcards.action_space}, seed {wildcards.seed}"
    shell:
        "sensory-commutativity navigation-run --config {RESOLVED:q} --action-space {wildcards.action_space} --seed {wildcards.seed}"
        " --navigation-scp {input.navigation_scp:q} --model {output.model:q} --out {output.curve:q} 2> {log:q}"


rule navigation_curves:
    input:
        parts=[
            DATA / "navigation_runs" / f"{action_space}.{seed}.parquet"
            for action_space, seed in NAVIGATION.runs
        ],
    output:
        TABLES / "navigation_curves.parquet",
    log:
        LOGS / "navigation_curves.log",
    localrule: True
    message:
        "gathering the learning curves of all runs"
    shell:
        "sensory-commutativity navigation-curves --config {RESOLVED:q} --out {output:q} {input.parts:q} 2> {log:q}"


NAVIGATION_TABLES = (
    {  # table -> the table it is made from, and the settings it depends on
        "navigation_scores": (
            "navigation_curves",
            digest(
                NAVIGATION.steps,
                NAVIGATION.threshold_return,
                NAVIGATION.solved_success_rate,
            ),
        ),
        "navigation_summary": ("navigation_scores", digest()),
        "navigation_comparisons": ("navigation_scores", digest(NAVIGATION.alpha)),
        "navigation_checkpoints": ("navigation_curves", digest()),
        "navigation_survival": ("navigation_scores", digest()),
        "navigation_profiles": ("navigation_scores", digest(NAVIGATION.zones)),
        "navigation_power": (
            "navigation_scores",
            digest(NAVIGATION.seeds, NAVIGATION.alpha, NAVIGATION.primary_measure),
        ),
        "navigation_calibration": (
            "navigation_scores",
            digest(NAVIGATION.calibration_splits, NAVIGATION.alpha),
        ),
    }
)

for table, (source, settings) in NAVIGATION_TABLES.items():

    rule:
        name:
            table
        input:
            TABLES / f"{source}.parquet",
        output:
            TABLES / f"{table}.parquet",
        log:
            LOGS / f"{table}.log",
        params:
            command=table.replace("_", "-"),
            option=source.replace("_", "-"),
            settings=settings,
        message:
            "making the table {params.command}"
        shell:
            "sensory-commutativity {params.command} --config {RESOLVED:q} --{params.option} {input:q} --out {output:q} 2> {log:q}"
