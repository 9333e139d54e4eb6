# Three dimensions: SC-experiments of robots in apartments, SCP, hierarchy, stability of the order, true interaction.


def apartment_parts(wildcards):
    return [
        DATA
        / "apartment_experiments"
        / f"{run.robot}.{run.scene}.{run.start}.{run.length}.{i + 1}-of-{APARTMENT.n_jobs(run.experiments)}.parquet"
        for run in APARTMENT.runs()
        for i in range(APARTMENT.n_jobs(run.experiments))
    ]


def robots_and_scenes():
    """Contents of all files that describe them."""
    robots = [contents(r.description, "robot") for r in APARTMENT.robots.values()]
    return robots + [contents(s.file, "scene") for s in APARTMENT.scenes.values()]


def apartment_settings():
    """All settings of the apartment, with the files that they name."""
    return digest(APARTMENT, robots_and_scenes())


def apartment_run(w):
    """Settings of a run of SC-experiments."""
    (run,) = [
        run
        for run in APARTMENT.runs()
        if run[:4] == (w.robot, w.scene, w.start, int(w.length))
    ]
    return digest(settings_of_run(CONFIG, run), APARTMENT.experiments_per_job)


rule apartment_ready:
    output:
        DATA / "apartment_ready" / "{robot}.{scene}.{start}.json",
    log:
        LOGS / "apartment_ready" / "{robot}.{scene}.{start}.log",
    priority: 1000  # before all else: what is missing should be told before the long work
    resources:
        mem_mb=growing(2500),
        runtime=growing(10),
    params:
        settings=lambda w: digest(settings_of_start(CONFIG, w.robot, w.scene, w.start)),
    message:
        "fetching the weights of VGG16, once, and trying whether {wildcards.robot} finds room to start in {wildcards.scene} ({wildcards.start})"
    shell:
        "sensory-commutativity apartment-ready --config {RESOLVED:q} --robot {wildcards.robot} --scene {wildcards.scene}"
        " --start {wildcards.start} --out {output:q} 2> {log:q}"


rule apartment_experiments_part:
    input:
        DATA / "apartment_ready" / "{robot}.{scene}.{start}.json",
    output:
        DATA
        / "apartment_experiments"
        / "{robot}.{scene}.{start}.{length}.{part}-of-{parts}.parquet",
    log:
        LOGS
        / "apartment_experiments_part"
        / "{robot}.{scene}.{start}.{length}.{part}-of-{parts}.log",
    benchmark:
        (
            BENCHMARKS
            / "apartment_experiments_part"
            / "{robot}.{scene}.{start}.{length}.{part}-of-{parts}.tsv"
        )
    threads: 1
    resources:
        mem_mb=growing(2500),
        runtime=growing(20),
    params:
        settings=apartment_run,
    message:
        "SC-experiments of {wildcards.robot} in {wildcards.scene} ({wildcards.start}), length {wildcards.length}, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity apartment-experiments-part --config {RESOLVED:q} --robot {wildcards.robot} --scene {wildcards.scene}"
        " --start {wildcards.start} --length {wildcards.length} --part {wildcards.part}/{wildcards.parts} --out {output:q} 2> {log:q}"


rule apartment_experiments:
    input:
        parts=apartment_parts,
    output:
        TABLES / "apartment_experiments.parquet",
    log:
        LOGS / "apartment_experiments.log",
    localrule: True
    message:
        "gathering the SC-experiments in apartments"
    shell:
        "sensory-commutativity apartment-experiments --config {RESOLVED:q} --out {output:q} {input.parts:q} 2> {log:q}"


APARTMENT_TABLES = {  # table -> the settings it depends on
    "apartment_scp": digest(APARTMENT.thresholds),
    "apartment_hierarchy": digest(
        APARTMENT.thresholds,
        robots_and_scenes(),
    ),
    "apartment_order": digest(
        APARTMENT.thresholds, APARTMENT.fields_of_view, APARTMENT.reference
    ),
    "apartment_interaction": digest(APARTMENT.reference, APARTMENT.fields_of_view[0]),
}

for table, settings in APARTMENT_TABLES.items():

    rule:
        name:
            table
        input:
            TABLES / "apartment_experiments.parquet",
        output:
            TABLES / f"{table}.parquet",
        log:
            LOGS / f"{table}.log",
        params:
            command=table.replace("_", "-"),
            settings=settings,
        message:
            "making the table {params.command}"
        shell:
            "sensory-commutativity {params.command} --config {RESOLVED:q} --apartment-experiments {input:q} --out {output:q} 2> {log:q}"
