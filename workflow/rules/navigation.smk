# Learning to navigate: action spaces from the measured SCPs, one job per training run, and their
# comparison.
NAVIGATION = CONFIG.navigation


rule navigation_scp:
    input:
        # From the experiments of that agent alone: no setting of another agent or world trains all
        # runs again.
        shards(
            "flatland_experiments",
            f"{NAVIGATION.scp_world}.{NAVIGATION.agent}.{CONFIG.flatland.sequence_length}",
        ),
    output:
        TABLES / "navigation_scp.parquet",
    log:
        LOGS / "navigation_scp.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("navigation_scp"),
    message:
        "estimating the SCP that the action spaces are made from"
    shell:
        "sensory-commutativity table navigation_scp --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_action_spaces:
    input:
        TABLES / "navigation_scp.parquet",
    output:
        TABLES / "navigation_action_spaces.parquet",
    log:
        LOGS / "navigation_action_spaces.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("navigation_action_spaces"),
    message:
        "making action spaces from the measured SCPs"
    shell:
        "sensory-commutativity table navigation_action_spaces --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_policy:
    input:
        TABLES / "navigation_scp.parquet",  # not the action spaces: a new seed trains that seed only
    output:
        model=MODELS / "navigation" / "{run}.policy",
        curve=DATA / "navigation_curves" / "{run}.parquet",
    log:
        LOGS / "navigation_policy" / "{run}.log",
    benchmark:
        BENCHMARKS / "navigation_policy" / "{run}.tsv"
    resources:
        mem_mb=scale_with_attempt(2000),
        runtime=scale_with_attempt(40),
    params:
        config=RESOLVED,
        settings=settings("navigation_policy"),
    message:
        "training with the action space and seed {wildcards.run}"
    shell:
        "sensory-commutativity train navigation_policy --run {wildcards.run} --config {params.config:q} --out {output.model:q}"
        " --curve {output.curve:q} {input:q} 2> {log:q}"


rule navigation_curves:
    input:
        shards("navigation_curves"),
    output:
        TABLES / "navigation_curves.parquet",
    log:
        LOGS / "navigation_curves.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("navigation_curves"),
    message:
        "gathering the learning curves of all runs"
    shell:
        "sensory-commutativity table navigation_curves --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_scores:
    input:
        TABLES / "navigation_curves.parquet",
    output:
        TABLES / "navigation_scores.parquet",
    log:
        LOGS / "navigation_scores.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_scores"),
    message:
        "scoring every training run"
    shell:
        "sensory-commutativity table navigation_scores --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_summary:
    input:
        TABLES / "navigation_scores.parquet",
    output:
        TABLES / "navigation_summary.parquet",
    log:
        LOGS / "navigation_summary.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_summary"),
    message:
        "summarizing every score"
    shell:
        "sensory-commutativity table navigation_summary --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_comparisons:
    input:
        TABLES / "navigation_scores.parquet",
    output:
        TABLES / "navigation_comparisons.parquet",
    log:
        LOGS / "navigation_comparisons.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_comparisons"),
    message:
        "comparing the action spaces in pairs"
    shell:
        "sensory-commutativity table navigation_comparisons --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_checkpoints:
    input:
        TABLES / "navigation_curves.parquet",
    output:
        TABLES / "navigation_checkpoints.parquet",
    log:
        LOGS / "navigation_checkpoints.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_checkpoints"),
    message:
        "comparing the action spaces at every checkpoint"
    shell:
        "sensory-commutativity table navigation_checkpoints --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_survival:
    input:
        TABLES / "navigation_scores.parquet",
    output:
        TABLES / "navigation_survival.parquet",
    log:
        LOGS / "navigation_survival.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_survival"),
    message:
        "estimating Kaplan-Meier curves of the steps to the threshold"
    shell:
        "sensory-commutativity table navigation_survival --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_sensitivity:
    input:
        TABLES / "navigation_curves.parquet",
    output:
        TABLES / "navigation_sensitivity.parquet",
    log:
        LOGS / "navigation_sensitivity.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_sensitivity"),
    message:
        "comparing the steps to other thresholds, and by the seeds of the confirmation"
    shell:
        "sensory-commutativity table navigation_sensitivity --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_profiles:
    input:
        TABLES / "navigation_scores.parquet",
    output:
        TABLES / "navigation_profiles.parquet",
    log:
        LOGS / "navigation_profiles.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_profiles"),
    message:
        "computing performance profiles"
    shell:
        "sensory-commutativity table navigation_profiles --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_power:
    input:
        TABLES / "navigation_scores.parquet",
    output:
        TABLES / "navigation_power.parquet",
    log:
        LOGS / "navigation_power.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_power"),
    message:
        "computing the power of the tests"
    shell:
        "sensory-commutativity table navigation_power --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule navigation_calibration:
    input:
        TABLES / "navigation_scores.parquet",
    output:
        TABLES / "navigation_calibration.parquet",
    log:
        LOGS / "navigation_calibration.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_calibration"),
    message:
        "computing how often the tests err (A/A)"
    shell:
        "sensory-commutativity table navigation_calibration --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"
