# The atlas: the SCP of standard environments. A target of its own:
#
#   snakemake --cores all --configfile config/atlas.yaml atlas


rule atlas:
    input:
        TABLES / "atlas_scp.parquet",
        TABLES / "atlas_detection.parquet",
        TABLES / "snapshot_exactness.parquet",
        FIGURES / "atlas_scp.png",
        TABLES / "learning_comparisons.parquet",
        FIGURES / "learning_curves.png",
    localrule: True


rule atlas_experiments_shard:
    output:
        DATA / "atlas_experiments" / "{run}.{part}.parquet",
    log:
        LOGS / "atlas_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "atlas_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("atlas_experiments"),
    message:
        "SC-experiments of {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table atlas_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule atlas_experiments:
    input:
        atlas_shards("atlas_experiments"),
    output:
        TABLES / "atlas_experiments.parquet",
    log:
        LOGS / "atlas_experiments.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("atlas_experiments"),
    message:
        "gathering the SC-experiments of standard environments"
    shell:
        "sensory-commutativity table atlas_experiments --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule atlas_scp:
    input:
        TABLES / "atlas_experiments.parquet",
    output:
        TABLES / "atlas_scp.parquet",
    log:
        LOGS / "atlas_scp.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("atlas_scp", Table),
    message:
        "estimating the SCP of standard environments"
    shell:
        "sensory-commutativity table atlas_scp --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule atlas_detection:
    input:
        TABLES / "atlas_experiments.parquet",
    output:
        TABLES / "atlas_detection.parquet",
    log:
        LOGS / "atlas_detection.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("atlas_detection"),
    message:
        "comparing distances with what moved"
    shell:
        "sensory-commutativity table atlas_detection --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule snapshot_exactness_shard:
    output:
        DATA / "snapshot_exactness" / "{run}.parquet",
    log:
        LOGS / "snapshot_exactness" / "{run}.log",
    benchmark:
        BENCHMARKS / "snapshot_exactness" / "{run}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("snapshot_exactness"),
    message:
        "exactness of snapshots of {wildcards.run}"
    shell:
        "sensory-commutativity table snapshot_exactness --shard {wildcards.run} --config {params.config:q} --out {output:q} 2> {log:q}"


rule snapshot_exactness:
    input:
        atlas_shards("snapshot_exactness"),
    output:
        TABLES / "snapshot_exactness.parquet",
    log:
        LOGS / "snapshot_exactness.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("snapshot_exactness"),
    message:
        "gathering the exactness of snapshots"
    shell:
        "sensory-commutativity table snapshot_exactness --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule figure_atlas_scp:
    input:
        TABLES / "atlas_scp.parquet",
    output:
        png=report(
            FIGURES / "atlas_scp.png",
            category="Atlas",
            caption="../report/atlas_scp.rst",
            labels={"figure": "atlas_scp"},
        ),
        pdf=FIGURES / "atlas_scp.pdf",
    log:
        LOGS / "figure" / "atlas_scp.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("atlas_scp", Figure),
    message:
        "drawing atlas_scp"
    shell:
        "sensory-commutativity figure atlas_scp --config {params.config:q} --out {output.png:q} {input:q} 2> {log:q}"


rule learning_scp:
    output:
        TABLES / "learning_scp.parquet",
    log:
        LOGS / "learning_scp.log",
    params:
        config=RESOLVED,
        settings=lambda w: settings("learning_scp"),
    message:
        "SC-experiments with the planar arm"
    shell:
        "sensory-commutativity table learning_scp --config {params.config:q} --out {output:q} 2> {log:q}"


rule learning_curves_shard:
    input:
        TABLES / "learning_scp.parquet",
    output:
        DATA / "learning_curves" / "{run}.{part}.parquet",
    log:
        LOGS / "learning_curves" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "learning_curves" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(2000),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("learning_curves"),
    message:
        "training with the planar arm, action space {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table learning_curves --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule learning_curves:
    input:
        atlas_shards("learning_curves"),
    output:
        TABLES / "learning_curves.parquet",
    log:
        LOGS / "learning_curves.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("learning_curves"),
    message:
        "gathering the learning curves of the planar arm"
    shell:
        "sensory-commutativity table learning_curves --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule learning_comparisons:
    input:
        TABLES / "learning_curves.parquet",
    output:
        TABLES / "learning_comparisons.parquet",
    log:
        LOGS / "learning_comparisons.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("learning_comparisons"),
    message:
        "comparing action spaces with the planar arm"
    shell:
        "sensory-commutativity table learning_comparisons --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule figure_learning_curves:
    input:
        TABLES / "learning_curves.parquet",
    output:
        png=report(
            FIGURES / "learning_curves.png",
            category="Atlas",
            caption="../report/learning_curves.rst",
            labels={"figure": "learning_curves"},
        ),
        pdf=FIGURES / "learning_curves.pdf",
    log:
        LOGS / "figure" / "learning_curves.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("learning_curves", Figure),
    message:
        "drawing learning_curves"
    shell:
        "sensory-commutativity figure learning_curves --config {params.config:q} --out {output.png:q} {input:q} 2> {log:q}"
