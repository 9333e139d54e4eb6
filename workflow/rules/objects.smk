# Detecting what changed: pairs of pictures, models, SC-experiments to test them on, and the map of
# immovable objects.


rule mask_dof:
    input:
        TABLES / "apartment_scp.parquet",
    output:
        TABLES / "mask_dof.parquet",
    log:
        LOGS / "mask_dof.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("mask_dof"),
    message:
        "choosing the degree of freedom whose SCP is nearest one half"
    shell:
        "sensory-commutativity table mask_dof --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_pairs_shard:
    output:
        DATA / "mask_pairs" / "{run}.{part}.h5",
    log:
        LOGS / "mask_pairs" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "mask_pairs" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1500),
        runtime=scale_with_attempt(15),
    params:
        config=RESOLVED,
        settings=shard_settings("mask_pairs"),
    message:
        "pairs of pictures, {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity arrays mask_pairs --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule mask_training:
    input:
        shards("mask_pairs"),
    output:
        predictor=DATA / "mask_training" / "{run}.predictor",
        curve=DATA / "mask_curves" / "{run}.parquet",
    log:
        LOGS / "mask_training" / "{run}.log",
    benchmark:
        BENCHMARKS / "mask_training" / "{run}.tsv"
    threads: lambda w: MASKS.model(w.run).threads
    resources:
        mem_mb=scale_with_attempt(
            1500 + memory_of_pairs(MASKS.data.pairs + MASKS.data.validation_pairs)
        ),
        runtime=scale_with_attempt(480),
    params:
        config=RESOLVED,
        settings=settings("mask_training"),
    message:
        "training {wildcards.run} to find what changed"
    shell:
        "sensory-commutativity train mask_training --run {wildcards.run} --config {params.config:q} --out {output.predictor:q}"
        " --curve {output.curve:q} {input:q} 2> {log:q}"


rule mask_curves:
    input:
        shards("mask_curves"),
    output:
        TABLES / "mask_curves.parquet",
    log:
        LOGS / "mask_curves.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("mask_curves"),
    message:
        "gathering the training curves"
    shell:
        "sensory-commutativity table mask_curves --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_regions_shard:
    input:
        inputs("mask_regions"),
    output:
        DATA / "mask_regions" / "{run}.{part}.h5",
    log:
        LOGS / "mask_regions" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "mask_regions" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(
            1500 + memory_of_pairs(2 * MASKS.data.pairs_per_scene)
        ),
        runtime=scale_with_attempt(20),
    params:
        config=RESOLVED,
        settings=shard_settings("mask_regions"),
    message:
        "regions that {wildcards.run} takes as changed, part {wildcards.part}"
    shell:
        "sensory-commutativity arrays mask_regions --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_predictor:
    input:
        inputs("mask_predictor"),
    output:
        MODELS / "masks" / "{run}.predictor",
    log:
        LOGS / "mask_predictor" / "{run}.log",
    benchmark:
        BENCHMARKS / "mask_predictor" / "{run}.tsv"
    resources:
        mem_mb=scale_with_attempt(
            2500 + memory_of_pairs(3 * MASKS.data.validation_pairs)
        ),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=settings("mask_predictor"),
    message:
        "training the view classifier of {wildcards.run} and tuning its decision thresholds"
    shell:
        "sensory-commutativity train mask_predictor --run {wildcards.run} --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_tuples_shard:
    input:
        TABLES / "mask_dof.parquet",
    output:
        DATA / "mask_tuples" / "{run}.{part}.h5",
    log:
        LOGS / "mask_tuples" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "mask_tuples" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1500),
        runtime=scale_with_attempt(10),
    params:
        config=RESOLVED,
        settings=shard_settings("mask_tuples"),
    message:
        "SC-experiments on objects, {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity arrays mask_tuples --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_scores_shard:
    input:
        inputs("mask_scores"),
    output:
        DATA / "mask_scores" / "{run}.parquet",
    log:
        LOGS / "mask_scores" / "{run}.log",
    benchmark:
        BENCHMARKS / "mask_scores" / "{run}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("mask_scores"),
    message:
        "testing {wildcards.run}"
    shell:
        "sensory-commutativity table mask_scores --shard {wildcards.run} --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_scores:
    input:
        shards("mask_scores"),
    output:
        TABLES / "mask_scores.parquet",
    log:
        LOGS / "mask_scores.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("mask_scores"),
    message:
        "gathering the scores of all models"
    shell:
        "sensory-commutativity table mask_scores --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_summary:
    input:
        TABLES / "mask_scores.parquet",
    output:
        TABLES / "mask_summary.parquet",
    log:
        LOGS / "mask_summary.log",
    params:
        config=RESOLVED,
        settings=settings("mask_summary"),
    message:
        "summarizing the scores of all models"
    shell:
        "sensory-commutativity table mask_summary --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_comparisons:
    input:
        TABLES / "mask_scores.parquet",
    output:
        TABLES / "mask_comparisons.parquet",
    log:
        LOGS / "mask_comparisons.log",
    params:
        config=RESOLVED,
        settings=settings("mask_comparisons"),
    message:
        "comparing RAFT with the other models"
    shell:
        "sensory-commutativity table mask_comparisons --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_alternatives:
    input:
        MODELS / "masks" / "raft.predictor",
        shards("mask_tuples", "as-trained"),
    output:
        TABLES / "mask_alternatives.parquet",
    log:
        LOGS / "mask_alternatives.log",
    benchmark:
        BENCHMARKS / "mask_alternatives.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=settings("mask_alternatives"),
    message:
        "predicting SC-experiments and their alternatives"
    shell:
        "sensory-commutativity table mask_alternatives --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_discoveries:
    input:
        TABLES / "mask_alternatives.parquet",
    output:
        TABLES / "mask_discoveries.parquet",
    log:
        LOGS / "mask_discoveries.log",
    params:
        config=RESOLVED,
        settings=settings("mask_discoveries"),
    message:
        "counting what SC-experiments and their alternatives discover"
    shell:
        "sensory-commutativity table mask_discoveries --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_examples:
    input:
        shards("mask_pairs", "training"),
        shards("mask_tuples"),
        MODELS / "masks" / "raft.predictor",
        TABLES / "mask_scores.parquet",
    output:
        TABLES / "mask_examples.h5",
    log:
        LOGS / "mask_examples.log",
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(30),
    params:
        config=RESOLVED,
        settings=settings("mask_examples"),
    message:
        "choosing pictures for the figures"
    shell:
        "sensory-commutativity arrays mask_examples --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule local_scp_experiments_shard:
    output:
        DATA / "local_scp_experiments" / "{run}.{part}.h5",
    log:
        LOGS / "local_scp_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "local_scp_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1500),
        runtime=scale_with_attempt(20),
    params:
        config=RESOLVED,
        settings=shard_settings("local_scp_experiments"),
    message:
        "SC-experiments of the map, part {wildcards.part}"
    shell:
        "sensory-commutativity arrays local_scp_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule local_scp:
    input:
        MODELS / "masks" / "raft.predictor",
        shards("local_scp_experiments"),
    output:
        TABLES / "local_scp.parquet",
    log:
        LOGS / "local_scp.log",
    benchmark:
        BENCHMARKS / "local_scp.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(30),
    params:
        config=RESOLVED,
        settings=settings("local_scp"),
    message:
        "estimating the local SCP at every pose"
    shell:
        "sensory-commutativity table local_scp --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule local_scp_summary:
    input:
        TABLES / "local_scp.parquet",
    output:
        TABLES / "local_scp_summary.parquet",
    log:
        LOGS / "local_scp_summary.log",
    params:
        config=RESOLVED,
        settings=settings("local_scp_summary"),
    message:
        "comparing the map with what is within reach"
    shell:
        "sensory-commutativity table local_scp_summary --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"
