# Three dimensions: SC-experiments of robots in apartments, SCP, hierarchy, stability of the order,
# contacts.


rule apartment_ready:
    output:
        DATA / "apartment_ready" / "{robot}.{scene}.{start}.json",
    log:
        LOGS / "apartment_ready" / "{robot}.{scene}.{start}.log",
    wildcard_constraints:
        robot="|".join(CONFIG.apartment.robots),
        scene="|".join(CONFIG.apartment.scenes),
        start="anywhere|within-reach",
    priority: 1000  # first of all: what is missing should be reported before the long work
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(10),
    params:
        config=RESOLVED,
        settings=lambda w: digest(start_settings(CONFIG, w.robot, w.scene, w.start)),
    message:
        "fetching the VGG16 weights, once, and looking for start situations of {wildcards.robot} in {wildcards.scene} ({wildcards.start})"
    shell:
        "sensory-commutativity config check-start --config {params.config:q} --robot {wildcards.robot} --scene {wildcards.scene}"
        " --start {wildcards.start} --out {output:q} 2> {log:q}"


rule apartment_experiments_shard:
    input:
        ready=lambda w: DATA / "apartment_ready" / f"{w.run.rpartition('.')[0]}.json",
    output:
        DATA / "apartment_experiments" / "{run}.{part}.parquet",
    log:
        LOGS / "apartment_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "apartment_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(20),
    params:
        config=RESOLVED,
        settings=shard_settings("apartment_experiments"),
    message:
        "SC-experiments in apartments: {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table apartment_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule apartment_experiments:
    input:
        shards("apartment_experiments"),
    output:
        TABLES / "apartment_experiments.parquet",
    log:
        LOGS / "apartment_experiments.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("apartment_experiments"),
    message:
        "gathering the SC-experiments in apartments"
    shell:
        "sensory-commutativity table apartment_experiments --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule apartment_scp:
    input:
        TABLES / "apartment_experiments.parquet",
    output:
        TABLES / "apartment_scp.parquet",
    log:
        LOGS / "apartment_scp.log",
    params:
        config=RESOLVED,
        settings=settings("apartment_scp"),
    message:
        "estimating the SCP of every degree of freedom"
    shell:
        "sensory-commutativity table apartment_scp --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule apartment_hierarchy:
    input:
        TABLES / "apartment_experiments.parquet",
    output:
        TABLES / "apartment_hierarchy.parquet",
    log:
        LOGS / "apartment_hierarchy.log",
    params:
        config=RESOLVED,
        settings=settings("apartment_hierarchy"),
    message:
        "comparing groups of degrees of freedom"
    shell:
        "sensory-commutativity table apartment_hierarchy --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule apartment_order:
    input:
        TABLES / "apartment_experiments.parquet",
    output:
        TABLES / "apartment_order.parquet",
    log:
        LOGS / "apartment_order.log",
    params:
        config=RESOLVED,
        settings=settings("apartment_order"),
    message:
        "testing whether the order of the degrees of freedom is stable"
    shell:
        "sensory-commutativity table apartment_order --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule apartment_interaction:
    input:
        TABLES / "apartment_experiments.parquet",
    output:
        TABLES / "apartment_interaction.parquet",
    log:
        LOGS / "apartment_interaction.log",
    params:
        config=RESOLVED,
        settings=settings("apartment_interaction"),
    message:
        "comparing the SCP with contacts"
    shell:
        "sensory-commutativity table apartment_interaction --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"
