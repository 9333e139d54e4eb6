# Two dimensions: SC-experiments, SCP, comparisons, trends, commutation, and the paper's alternatives.


def reference(*more):
    """Settings of the reference agent in the reference world, and their names, which are part of the seeds."""
    world, agent = FLATLAND.reference.world, FLATLAND.reference.agent
    return digest(
        world,
        FLATLAND.worlds[world],
        agent,
        FLATLAND.agents[agent],
        FLATLAND.sequence_length,
        *more,
    )


def experiment_parts(*names):
    """Files of the SC-experiments of some runs, or of all."""
    return [
        DATA
        / "flatland_experiments"
        / f"{name}.{i + 1}-of-{FLATLAND.n_jobs(RUNS[name].experiments)}.parquet"
        for name in names or RUNS
        for i in range(FLATLAND.n_jobs(RUNS[name].experiments))
    ]


def commutation_parts(wildcards):
    n = FLATLAND.n_commutation_jobs
    return [
        DATA / "flatland_commutation" / f"{world}.{i + 1}-of-{n}.parquet"
        for world in FLATLAND.commutation_worlds()
        for i in range(n)
    ]


rule flatland_experiments_part:
    output:
        DATA
        / "flatland_experiments"
        / "{world}.{agent}.{length}.{part}-of-{parts}.parquet",
    log:
        LOGS
        / "flatland_experiments_part"
        / "{world}.{agent}.{length}.{part}-of-{parts}.log",
    benchmark:
        BENCHMARKS
        / "flatland_experiments_part"
        / "{world}.{agent}.{length}.{part}-of-{parts}.tsv"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(20),
    params:
        settings=lambda w: digest(
            FLATLAND.worlds[w.world],
            FLATLAND.agents[w.agent],
            FLATLAND.rest_steps,
            RUNS[f"{w.world}.{w.agent}.{w.length}"].experiments,
            FLATLAND.experiments_per_job,
        ),
    message:
        "SC-experiments of {wildcards.agent} in {wildcards.world}, length {wildcards.length}, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity flatland-experiments-part --config {RESOLVED:q} --world {wildcards.world} --agent {wildcards.agent}"
        " --length {wildcards.length} --part {wildcards.part}/{wildcards.parts} --out {output:q} 2> {log:q}"


rule flatland_experiments:
    input:
        parts=experiment_parts(),
    output:
        TABLES / "flatland_experiments.parquet",
    log:
        LOGS / "flatland_experiments.log",
    localrule: True
    message:
        "gathering all SC-experiments"
    shell:
        "sensory-commutativity flatland-experiments --config {RESOLVED:q} --out {output:q} {input.parts:q} 2> {log:q}"


rule flatland_scp:
    input:
        flatland_experiments=TABLES / "flatland_experiments.parquet",
    output:
        TABLES / "flatland_scp.parquet",
    log:
        LOGS / "flatland_scp.log",
    params:
        settings=digest(FLATLAND.thresholds, FLATLAND.sequence_length),
    message:
        "estimating the SCP of every degree of freedom"
    shell:
        "sensory-commutativity flatland-scp --config {RESOLVED:q} --flatland-experiments {input.flatland_experiments:q}"
        " --out {output:q} 2> {log:q}"


rule flatland_sensitivity:
    input:
        flatland_experiments=TABLES / "flatland_experiments.parquet",
    output:
        TABLES / "flatland_sensitivity.parquet",
    log:
        LOGS / "flatland_sensitivity.log",
    params:
        settings=digest(FLATLAND.thresholds, FLATLAND.sensitivity, FLATLAND.reference),
    message:
        "estimating the SCP for all sequence lengths"
    shell:
        "sensory-commutativity flatland-sensitivity --config {RESOLVED:q} --flatland-experiments {input.flatland_experiments:q}"
        " --out {output:q} 2> {log:q}"


rule flatland_comparisons:
    input:
        flatland_experiments=TABLES / "flatland_experiments.parquet",
    output:
        TABLES / "flatland_comparisons.parquet",
    log:
        LOGS / "flatland_comparisons.log",
    message:
        "comparing degrees of freedom in pairs"
    shell:
        "sensory-commutativity flatland-comparisons --config {RESOLVED:q} --flatland-experiments {input.flatland_experiments:q}"
        " --out {output:q} 2> {log:q}"


rule flatland_trends:
    input:
        flatland_scp=TABLES / "flatland_scp.parquet",
    output:
        TABLES / "flatland_trends.parquet",
    log:
        LOGS / "flatland_trends.log",
    params:
        settings=digest(FLATLAND.combinations),
    message:
        "testing for trends with objects and arm length"
    shell:
        "sensory-commutativity flatland-trends --config {RESOLVED:q} --flatland-scp {input.flatland_scp:q} --out {output:q} 2> {log:q}"


rule flatland_commutation_part:
    output:
        DATA / "flatland_commutation" / "{world}.{part}-of-{parts}.parquet",
    log:
        LOGS / "flatland_commutation_part" / "{world}.{part}-of-{parts}.log",
    benchmark:
        BENCHMARKS / "flatland_commutation_part" / "{world}.{part}-of-{parts}.tsv"
    threads: 1
    resources:
        mem_mb=growing(1000),
        runtime=growing(60),
    params:
        settings=lambda w: reference(
            FLATLAND.worlds[w.world],
            FLATLAND.rest_steps,
            FLATLAND.commutation,
            FLATLAND.experiments_per_job,
        ),
    message:
        "experiments on pairs of degrees of freedom in {wildcards.world}, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity flatland-commutation-part --config {RESOLVED:q} --world {wildcards.world} --part {wildcards.part}/{wildcards.parts}"
        " --out {output:q} 2> {log:q}"


rule flatland_commutation:
    input:
        parts=commutation_parts,
    output:
        TABLES / "flatland_commutation.parquet",
    log:
        LOGS / "flatland_commutation.log",
    localrule: True
    message:
        "estimating which degrees of freedom commute"
    shell:
        "sensory-commutativity flatland-commutation --config {RESOLVED:q} --out {output:q} {input.parts:q} 2> {log:q}"


rule flatland_baselines_part:
    output:
        DATA / "flatland_baselines" / "{dof}.parquet",
    log:
        LOGS / "flatland_baselines_part" / "{dof}.log",
    benchmark:
        BENCHMARKS / "flatland_baselines_part" / "{dof}.tsv"
    threads: 1
    resources:
        mem_mb=growing(3000),
        runtime=growing(30),
    params:
        settings=reference(FLATLAND.baselines),
    message:
        "naive change and prediction error of {wildcards.dof}"
    shell:
        "sensory-commutativity flatland-baselines-part --config {RESOLVED:q} --dof {wildcards.dof} --out {output:q} 2> {log:q}"


rule flatland_baselines:
    input:
        parts=expand(DATA / "flatland_baselines" / "{dof}.parquet", dof=DOFS),
    output:
        TABLES / "flatland_baselines.parquet",
    log:
        LOGS / "flatland_baselines.log",
    localrule: True
    message:
        "gathering the alternatives to the SCP"
    shell:
        "sensory-commutativity flatland-baselines --config {RESOLVED:q} --out {output:q} {input.parts:q} 2> {log:q}"


rule flatland_alternatives:
    input:
        flatland_baselines=TABLES / "flatland_baselines.parquet",
        flatland_scp=TABLES / "flatland_scp.parquet",
    output:
        TABLES / "flatland_alternatives.parquet",
    log:
        LOGS / "flatland_alternatives.log",
    localrule: True
    message:
        "correlating the alternatives with the SCP"
    shell:
        "sensory-commutativity flatland-alternatives --config {RESOLVED:q} --flatland-baselines {input.flatland_baselines:q}"
        " --flatland-scp {input.flatland_scp:q} --out {output:q} 2> {log:q}"
