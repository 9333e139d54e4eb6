# Two dimensions: SC-experiments, SCP, comparisons, trends, commutation, and the paper's alternatives.


rule flatland_experiments_shard:
    output:
        DATA / "flatland_experiments" / "{run}.{part}.parquet",
    log:
        LOGS / "flatland_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "flatland_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1000),
        runtime=scale_with_attempt(20),
    params:
        config=RESOLVED,
        settings=shard_settings("flatland_experiments"),
    message:
        "SC-experiments in Flatland: {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table flatland_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule flatland_experiments:
    input:
        shards("flatland_experiments"),
    output:
        TABLES / "flatland_experiments.parquet",
    log:
        LOGS / "flatland_experiments.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("flatland_experiments"),
    message:
        "gathering the SC-experiments in Flatland"
    shell:
        "sensory-commutativity table flatland_experiments --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_scp:
    input:
        TABLES / "flatland_experiments.parquet",
    output:
        TABLES / "flatland_scp.parquet",
    log:
        LOGS / "flatland_scp.log",
    params:
        config=RESOLVED,
        settings=settings("flatland_scp"),
    message:
        "estimating the SCP of every degree of freedom"
    shell:
        "sensory-commutativity table flatland_scp --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_sensitivity:
    input:
        TABLES / "flatland_experiments.parquet",
    output:
        TABLES / "flatland_sensitivity.parquet",
    log:
        LOGS / "flatland_sensitivity.log",
    params:
        config=RESOLVED,
        settings=settings("flatland_sensitivity"),
    message:
        "estimating the SCP for all sequence lengths"
    shell:
        "sensory-commutativity table flatland_sensitivity --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_comparisons:
    input:
        TABLES / "flatland_experiments.parquet",
    output:
        TABLES / "flatland_comparisons.parquet",
    log:
        LOGS / "flatland_comparisons.log",
    params:
        config=RESOLVED,
        settings=settings("flatland_comparisons"),
    message:
        "comparing degrees of freedom in pairs"
    shell:
        "sensory-commutativity table flatland_comparisons --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_trends:
    input:
        TABLES / "flatland_scp.parquet",
    output:
        TABLES / "flatland_trends.parquet",
    log:
        LOGS / "flatland_trends.log",
    params:
        config=RESOLVED,
        settings=settings("flatland_trends"),
    message:
        "testing for trends with objects and arm length"
    shell:
        "sensory-commutativity table flatland_trends --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_commutation_experiments_shard:
    output:
        DATA / "flatland_commutation_experiments" / "{run}.{part}.parquet",
    log:
        LOGS / "flatland_commutation_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "flatland_commutation_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1000),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("flatland_commutation_experiments"),
    message:
        "experiments on pairs of degrees of freedom in {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table flatland_commutation_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule flatland_commutation:
    input:
        shards("flatland_commutation_experiments"),
    output:
        TABLES / "flatland_commutation.parquet",
    log:
        LOGS / "flatland_commutation.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("flatland_commutation"),
    message:
        "estimating which degrees of freedom commute"
    shell:
        "sensory-commutativity table flatland_commutation --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_baselines_shard:
    output:
        DATA / "flatland_baselines" / "{run}.parquet",
    log:
        LOGS / "flatland_baselines" / "{run}.log",
    benchmark:
        BENCHMARKS / "flatland_baselines" / "{run}.tsv"
    resources:
        mem_mb=scale_with_attempt(3000),
        runtime=scale_with_attempt(30),
    params:
        config=RESOLVED,
        settings=shard_settings("flatland_baselines"),
    message:
        "naive change and prediction error of {wildcards.run}"
    shell:
        "sensory-commutativity table flatland_baselines --shard {wildcards.run} --config {params.config:q} --out {output:q} 2> {log:q}"


rule flatland_baselines:
    input:
        shards("flatland_baselines"),
    output:
        TABLES / "flatland_baselines.parquet",
    log:
        LOGS / "flatland_baselines.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("flatland_baselines"),
    message:
        "gathering the alternatives to the SCP"
    shell:
        "sensory-commutativity table flatland_baselines --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule flatland_alternatives:
    input:
        TABLES / "flatland_baselines.parquet",
        TABLES / "flatland_scp.parquet",
    output:
        TABLES / "flatland_alternatives.parquet",
    log:
        LOGS / "flatland_alternatives.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("flatland_alternatives"),
    message:
        "correlating the alternatives with the SCP"
    shell:
        "sensory-commutativity table flatland_alternatives --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"
