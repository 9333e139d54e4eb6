# Seeing what moved: pairs of pictures, models, SC-experiments to test them on, and the map of what cannot be moved.
MODELS_OF_MASKS = (*LEARNED, "difference")


def parts(folder, name, n, kind):
    return [DATA / folder / f"{name}.{i + 1}-of-{n}.{kind}" for i in range(n)]


def pairs_of(split):
    return parts("mask_pairs", split, MASKS.pair_jobs(split), "h5")


def places_of(model):
    return parts("mask_places", model, MASKS.pair_jobs("training"), "h5")


def all_tuples():
    return [
        part
        for run in TUPLE_RUNS
        for part in parts("mask_tuples", run, tuple_jobs(CONFIG), "h5")
    ]


def memory_of_pairs(n):
    """MB of pictures with their masks and maps, read twice over, of so many pairs of each outcome."""
    return 2 * 3 * n * MASKS.image_size**2 * (2 * 3 + 2) // 1_000_000


def memory_of_training():
    """MB: all pairs, beside torch."""
    return 1500 + memory_of_pairs(MASKS.data.pairs + MASKS.data.validation_pairs)


def given(option, files):
    """An option once for each file."""
    return " ".join(f"--{option} {shlex.quote(str(file))}" for file in files)


rule mask_dof:
    input:
        TABLES / "apartment_scp.parquet",
    output:
        TABLES / "mask_dof.parquet",
    log:
        LOGS / "mask_dof.log",
    localrule: True
    params:
        settings=digest(MASKS.robot, APARTMENT.reference),
    message:
        "choosing the degree of freedom whose SCP is nearest one half"
    shell:
        "sensory-commutativity mask-dof --config {RESOLVED:q} --apartment-scp {input:q} --out {output:q} 2> {log:q}"


rule mask_pairs:
    output:
        DATA / "mask_pairs" / "{split}.{part}-of-{parts}.h5",
    log:
        LOGS / "mask_pairs" / "{split}.{part}-of-{parts}.log",
    benchmark:
        BENCHMARKS / "mask_pairs" / "{split}.{part}-of-{parts}.tsv"
    resources:
        mem_mb=growing(1500),
        runtime=growing(15),
    params:
        settings=lambda w: digest(
            settings_of_data(CONFIG), pairs_of_job(CONFIG, w.split, int(w.part) - 1)
        ),
    message:
        "pairs of pictures, {wildcards.split}, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity mask-pairs --config {RESOLVED:q} --split {wildcards.split} --part {wildcards.part}/{wildcards.parts}"
        " --out {output:q} 2> {log:q}"


rule mask_training:
    input:
        training=pairs_of("training"),
        validation=pairs_of("validation"),
    output:
        curve=DATA / "mask_training" / "{model}.parquet",
        predictor=DATA / "mask_training" / "{model}.predictor",
    log:
        LOGS / "mask_training" / "{model}.log",
    benchmark:
        BENCHMARKS / "mask_training" / "{model}.tsv"
    threads: lambda w: MASKS.model(w.model).threads
    resources:
        mem_mb=growing(memory_of_training()),
        runtime=growing(480),
    params:
        training=lambda w, input: given("training", input.training),
        validation=lambda w, input: given("validation", input.validation),
        settings=lambda w: digest(settings_of_training(CONFIG, w.model)),
    message:
        "training {wildcards.model} to see what moved"
    shell:
        "sensory-commutativity mask-training --config {RESOLVED:q} --model {wildcards.model} {params.training} {params.validation}"
        " --predictor {output.predictor:q} --out {output.curve:q} 2> {log:q}"


rule mask_places:
    input:
        predictor=DATA / "mask_training" / "{model}.predictor",
        pairs=DATA / "mask_pairs" / "training.{part}-of-{parts}.h5",
    output:
        DATA / "mask_places" / "{model}.{part}-of-{parts}.h5",
    log:
        LOGS / "mask_places" / "{model}.{part}-of-{parts}.log",
    benchmark:
        BENCHMARKS / "mask_places" / "{model}.{part}-of-{parts}.tsv"
    resources:
        mem_mb=growing(1500 + memory_of_pairs(2 * MASKS.data.pairs_per_job)),
        runtime=growing(20),
    params:
        settings=digest(MASKS.view_classifier.pairs),
    message:
        "places that {wildcards.model} finds changed, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity mask-places --config {RESOLVED:q} --model {wildcards.model} --predictor {input.predictor:q}"
        " --pairs {input.pairs:q} --out {output:q} 2> {log:q}"


rule mask_judging:
    input:
        predictor=DATA / "mask_training" / "{model}.predictor",
        places=lambda w: places_of(w.model),
        validation=pairs_of("validation"),
    output:
        MODELS / "masks" / "{model}.predictor",
    log:
        LOGS / "mask_judging" / "{model}.log",
    benchmark:
        BENCHMARKS / "mask_judging" / "{model}.tsv"
    wildcard_constraints:
        model="|".join(LEARNED),
    resources:
        mem_mb=growing(2500 + memory_of_pairs(3 * MASKS.data.validation_pairs)),
        runtime=growing(60),
    params:
        places=lambda w, input: given("places", input.places),
        validation=lambda w, input: given("validation", input.validation),
        settings=lambda w: digest(settings_of_judging(CONFIG, w.model)),
    message:
        "training the judge of places of {wildcards.model}"
    shell:
        "sensory-commutativity mask-judging --config {RESOLVED:q} --model {wildcards.model} --predictor {input.predictor:q}"
        " {params.places} {params.validation} --out {output:q} 2> {log:q}"


rule mask_difference:
    input:
        pairs_of("validation"),
    output:
        MODELS / "masks" / "difference.predictor",
    log:
        LOGS / "mask_difference.log",
    params:
        validation=lambda w, input: given("validation", input),
        settings=digest(settings_of_data(CONFIG), MASKS.data.validation_pairs),
    message:
        "tuning the image difference"
    shell:
        "sensory-commutativity mask-difference --config {RESOLVED:q} {params.validation} --out {output:q} 2> {log:q}"


rule mask_curves:
    input:
        [DATA / "mask_training" / f"{model}.parquet" for model in LEARNED],
    output:
        TABLES / "mask_curves.parquet",
    log:
        LOGS / "mask_curves.log",
    localrule: True
    message:
        "gathering training curves"
    shell:
        "sensory-commutativity mask-curves --config {RESOLVED:q} --out {output:q} {input:q} 2> {log:q}"


rule mask_tuples:
    input:
        mask_dof=TABLES / "mask_dof.parquet",
    output:
        DATA / "mask_tuples" / "{run}.{part}-of-{parts}.h5",
    log:
        LOGS / "mask_tuples" / "{run}.{part}-of-{parts}.log",
    benchmark:
        BENCHMARKS / "mask_tuples" / "{run}.{part}-of-{parts}.tsv"
    resources:
        mem_mb=growing(1500),
        runtime=growing(10),
    params:
        settings=lambda w: digest(
            settings_of_tests(CONFIG, TUPLE_RUNS[w.run]),
            experiments_of_job(CONFIG, int(w.part) - 1),
        ),
    message:
        "SC-experiments on objects, {wildcards.run}, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity mask-tuples --config {RESOLVED:q} --run {wildcards.run} --part {wildcards.part}/{wildcards.parts}"
        " --mask-dof {input.mask_dof:q} --out {output:q} 2> {log:q}"


rule mask_model_scores:
    input:
        tuples=all_tuples(),
        predictor=MODELS / "masks" / "{model}.predictor",
    output:
        DATA / "mask_scores" / "{model}.parquet",
    log:
        LOGS / "mask_scores" / "{model}.log",
    benchmark:
        BENCHMARKS / "mask_scores" / "{model}.tsv"
    resources:
        mem_mb=growing(2500),
        runtime=growing(60),
    params:
        tuples=lambda w, input: given("tuples", input.tuples),
        settings=digest(MASKS.tests),
    message:
        "testing {wildcards.model}"
    shell:
        "sensory-commutativity mask-model-scores --config {RESOLVED:q} --model {wildcards.model} --predictor {input.predictor:q}"
        " {params.tuples} --out {output:q} 2> {log:q}"


rule mask_scores:
    input:
        [DATA / "mask_scores" / f"{model}.parquet" for model in MODELS_OF_MASKS],
    output:
        TABLES / "mask_scores.parquet",
    log:
        LOGS / "mask_scores.log",
    localrule: True
    message:
        "gathering the scores of all models"
    shell:
        "sensory-commutativity mask-scores --config {RESOLVED:q} --out {output:q} {input:q} 2> {log:q}"


for table, source in (
    ("mask_summary", "mask_scores"),
    ("mask_comparisons", "mask_scores"),
    ("mask_discoveries", "mask_alternatives"),
):

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
            source=source.replace("_", "-"),
        message:
            "making the table {params.command}"
        shell:
            "sensory-commutativity {params.command} --config {RESOLVED:q} --{params.source} {input:q} --out {output:q} 2> {log:q}"


rule mask_alternatives:
    input:
        tuples=parts("mask_tuples", "as-trained", tuple_jobs(CONFIG), "h5"),
        predictor=MODELS / "masks" / "raft.predictor",
    output:
        TABLES / "mask_alternatives.parquet",
    log:
        LOGS / "mask_alternatives.log",
    benchmark:
        BENCHMARKS / "mask_alternatives.tsv"
    resources:
        mem_mb=growing(2500),
        runtime=growing(60),
    message:
        "looking at SC-experiments and their alternatives"
    shell:
        "sensory-commutativity mask-alternatives --config {RESOLVED:q} --predictor {input.predictor:q} --out {output:q} {input.tuples:q} 2> {log:q}"


rule mask_examples:
    input:
        training=pairs_of("training")[0],
        tuples=all_tuples(),
        predictor=MODELS / "masks" / "raft.predictor",
        mask_scores=TABLES / "mask_scores.parquet",
    output:
        TABLES / "mask_examples.h5",
    log:
        LOGS / "mask_examples.log",
    resources:
        mem_mb=growing(2500),
        runtime=growing(30),
    params:
        tuples=lambda w, input: given("tuples", input.tuples),
    message:
        "putting pictures aside for the figures"
    shell:
        "sensory-commutativity mask-examples --config {RESOLVED:q} --training {input.training:q} {params.tuples}"
        " --predictor {input.predictor:q} --mask-scores {input.mask_scores:q} --out {output:q} 2> {log:q}"


rule local_scp_experiments:
    output:
        DATA / "local_scp_experiments" / "places.{part}-of-{parts}.h5",
    log:
        LOGS / "local_scp_experiments" / "places.{part}-of-{parts}.log",
    benchmark:
        BENCHMARKS / "local_scp_experiments" / "places.{part}-of-{parts}.tsv"
    resources:
        mem_mb=growing(1500),
        runtime=growing(20),
    params:
        settings=digest(settings_of_map(CONFIG)),
    message:
        "SC-experiments for the map, part {wildcards.part} of {wildcards.parts}"
    shell:
        "sensory-commutativity local-scp-experiments --config {RESOLVED:q} --part {wildcards.part}/{wildcards.parts} --out {output:q} 2> {log:q}"


rule local_scp:
    input:
        experiments=parts("local_scp_experiments", "places", map_jobs(CONFIG), "h5"),
        predictor=MODELS / "masks" / "raft.predictor",
    output:
        TABLES / "local_scp.parquet",
    log:
        LOGS / "local_scp.log",
    benchmark:
        BENCHMARKS / "local_scp.tsv"
    resources:
        mem_mb=growing(2500),
        runtime=growing(30),
    message:
        "the local SCP at every place"
    shell:
        "sensory-commutativity local-scp --config {RESOLVED:q} --predictor {input.predictor:q} --out {output:q} {input.experiments:q} 2> {log:q}"


rule local_scp_summary:
    input:
        TABLES / "local_scp.parquet",
    output:
        TABLES / "local_scp_summary.parquet",
    log:
        LOGS / "local_scp_summary.log",
    params:
        settings=digest(APARTMENT.reach, MASKS.map.cramped_room),
    message:
        "does the map show what cannot be moved?"
    shell:
        "sensory-commutativity local-scp-summary --config {RESOLVED:q} --local-scp {input:q} --out {output:q} 2> {log:q}"
