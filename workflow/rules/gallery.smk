# The gallery: the SCP of public robots. A target of its own:
#
#   snakemake --cores all --configfile config/gallery.yaml gallery


rule gallery:
    input:
        TABLES / "robot_gallery.parquet",
        FIGURES / "robot_gallery.png",
    localrule: True


rule gallery_experiments_shard:
    output:
        DATA / "gallery_experiments" / "{run}.{part}.parquet",
    log:
        LOGS / "gallery_experiments" / "{run}.{part}.log",
    benchmark:
        BENCHMARKS / "gallery_experiments" / "{run}.{part}.tsv"
    resources:
        mem_mb=scale_with_attempt(2500),
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=shard_settings("gallery_experiments"),
    message:
        "SC-experiments of {wildcards.run}, part {wildcards.part}"
    shell:
        "sensory-commutativity table gallery_experiments --shard {wildcards.run}.{wildcards.part} --config {params.config:q} --out {output:q} 2> {log:q}"


rule gallery_experiments:
    input:
        gallery_shards("gallery_experiments"),
    output:
        TABLES / "gallery_experiments.parquet",
    log:
        LOGS / "gallery_experiments.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("gallery_experiments"),
    message:
        "gathering the SC-experiments of public robots"
    shell:
        "sensory-commutativity table gallery_experiments --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule robot_gallery:
    input:
        TABLES / "gallery_experiments.parquet",
    output:
        TABLES / "robot_gallery.parquet",
    log:
        LOGS / "robot_gallery.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("robot_gallery", Table),
    message:
        "estimating the SCP of public robots"
    shell:
        "sensory-commutativity table robot_gallery --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule figure_robot_gallery:
    input:
        TABLES / "robot_gallery.parquet",
    output:
        png=report(
            FIGURES / "robot_gallery.png",
            category="Gallery",
            caption="../report/robot_gallery.rst",
            labels={"figure": "robot_gallery"},
        ),
        pdf=FIGURES / "robot_gallery.pdf",
    log:
        LOGS / "figure" / "robot_gallery.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=lambda w: settings("robot_gallery", Figure),
    message:
        "drawing robot_gallery"
    shell:
        "sensory-commutativity figure robot_gallery --config {params.config:q} --out {output.png:q} {input:q} 2> {log:q}"
