# As on a real robot: SC-experiments without a reset, under noise, sampled until the order is decided,
# and imagined. A configuration leaves it out with reset_free: null. The paper's sizes:
#
#   snakemake --cores all --configfile config/reset-free.yaml -- reset_free


rule reset_free:
    input:
        reset_free_outputs(),
    localrule: True


rule reset_free_trials_shard:
    output:
        DATA / "reset_free_trials" / "{run}.{part}.parquet",
    log:
        LOGS / "reset_free_trials" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "reset_free_trials" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1000),
        runtime=scale_with_attempt(30),
    params:
        config=RESOLVED,
        settings=shard_settings("reset_free_trials"),
    message:
        "trials of the return protocol in Flatland: {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table reset_free_trials --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule reset_free_trials:
    input:
        optional_shards("reset_free_trials"),
    output:
        TABLES / "reset_free_trials.parquet",
    log:
        LOGS / "reset_free_trials.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_trials"),
    message:
        "gathering the trials of the return protocol in Flatland"
    shell:
        "sensory-commutativity table reset_free_trials --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_apartment_shard:
    output:
        DATA / "reset_free_apartment" / "{run}.{part}.parquet",
    log:
        LOGS / "reset_free_apartment" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "reset_free_apartment" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("reset_free_apartment"),
    message:
        "trials of the return protocol in an apartment: {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table reset_free_apartment --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule reset_free_apartment:
    input:
        optional_shards("reset_free_apartment"),
    output:
        TABLES / "reset_free_apartment.parquet",
    log:
        LOGS / "reset_free_apartment.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_apartment"),
    message:
        "gathering the trials of the return protocol in apartments"
    shell:
        "sensory-commutativity table reset_free_apartment --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_scp:
    input:
        TABLES / "reset_free_trials.parquet",
        TABLES / "reset_free_apartment.parquet",
    output:
        TABLES / "reset_free_scp.parquet",
    log:
        LOGS / "reset_free_scp.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_scp", Table),
    message:
        "estimating the SCP without a reset"
    shell:
        "sensory-commutativity table reset_free_scp --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_agreement:
    input:
        TABLES / "reset_free_trials.parquet",
        TABLES / "reset_free_apartment.parquet",
    output:
        TABLES / "reset_free_agreement.parquet",
    log:
        LOGS / "reset_free_agreement.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_agreement", Table),
    message:
        "comparing the return protocol with the truth"
    shell:
        "sensory-commutativity table reset_free_agreement --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_comparisons:
    input:
        TABLES / "reset_free_trials.parquet",
    output:
        TABLES / "reset_free_comparisons.parquet",
    log:
        LOGS / "reset_free_comparisons.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_comparisons", Table),
    message:
        "testing the return protocol"
    shell:
        "sensory-commutativity table reset_free_comparisons --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_corrections:
    input:
        TABLES / "reset_free_apartment.parquet",
    output:
        TABLES / "reset_free_corrections.parquet",
    log:
        LOGS / "reset_free_corrections.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_corrections", Table),
    message:
        "comparing corrections of the return in apartments"
    shell:
        "sensory-commutativity table reset_free_corrections --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_noise_experiments_shard:
    output:
        DATA / "reset_free_noise_experiments" / "{run}.{part}.parquet",
    log:
        LOGS / "reset_free_noise_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "reset_free_noise_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(1000),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("reset_free_noise_experiments"),
    message:
        "SC-experiments under noise: {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table reset_free_noise_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule reset_free_noise_experiments:
    input:
        optional_shards("reset_free_noise_experiments"),
    output:
        TABLES / "reset_free_noise_experiments.parquet",
    log:
        LOGS / "reset_free_noise_experiments.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_noise_experiments"),
    message:
        "gathering the SC-experiments under noise"
    shell:
        "sensory-commutativity table reset_free_noise_experiments --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_noise:
    input:
        TABLES / "reset_free_noise_experiments.parquet",
    output:
        TABLES / "reset_free_noise.parquet",
    log:
        LOGS / "reset_free_noise.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_noise", Table),
    message:
        "estimating the SCP under noise"
    shell:
        "sensory-commutativity table reset_free_noise --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_noise_order:
    input:
        TABLES / "reset_free_noise_experiments.parquet",
    output:
        TABLES / "reset_free_noise_order.parquet",
    log:
        LOGS / "reset_free_noise_order.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_noise_order", Table),
    message:
        "measuring how far the order survives noise"
    shell:
        "sensory-commutativity table reset_free_noise_order --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_sequential:
    input:
        TABLES / "reset_free_trials.parquet",
    output:
        TABLES / "reset_free_sequential.parquet",
    log:
        LOGS / "reset_free_sequential.log",
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_sequential", Table),
    message:
        "simulating runs until the order is decided"
    shell:
        "sensory-commutativity table reset_free_sequential --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_imagined_experiments_shard:
    output:
        DATA / "reset_free_imagined_experiments" / "{run}.parquet",
    log:
        LOGS / "reset_free_imagined_experiments" / "{run}.log",
    benchmark:
        BENCHMARKS / "reset_free_imagined_experiments" / "{run}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("reset_free_imagined_experiments"),
    message:
        "imagining the second order: {wildcards.run}"
    shell:
        "sensory-commutativity table reset_free_imagined_experiments --shard {wildcards.run} --config {params.config:q} --out {output:q} 2> {log:q}"


rule reset_free_imagined_experiments:
    input:
        optional_shards("reset_free_imagined_experiments"),
    output:
        TABLES / "reset_free_imagined_experiments.parquet",
    log:
        LOGS / "reset_free_imagined_experiments.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_imagined_experiments"),
    message:
        "gathering imagined orders"
    shell:
        "sensory-commutativity table reset_free_imagined_experiments --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_imagined:
    input:
        TABLES / "reset_free_imagined_experiments.parquet",
    output:
        TABLES / "reset_free_imagined.parquet",
    log:
        LOGS / "reset_free_imagined.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_imagined", Table),
    message:
        "comparing imagined orders with the truth"
    shell:
        "sensory-commutativity table reset_free_imagined --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule reset_free_imagined_agreement:
    input:
        TABLES / "reset_free_imagined_experiments.parquet",
    output:
        TABLES / "reset_free_imagined_agreement.parquet",
    log:
        LOGS / "reset_free_imagined_agreement.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("reset_free_imagined_agreement", Table),
    message:
        "correlating imagined SCPs with the true ones"
    shell:
        "sensory-commutativity table reset_free_imagined_agreement --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"
