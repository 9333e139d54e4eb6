# Do the intervals and tests of the tables keep what they promise? Simulated; only on request.


rule calibration:
    output:
        TABLES / "calibration.parquet",
    log:
        LOGS / "calibration.log",
    resources:
        runtime=scale_with_attempt(60),
    params:
        config=RESOLVED,
        settings=settings("calibration"),
    message:
        "simulating the coverage of intervals and the level of tests"
    shell:
        "sensory-commutativity table calibration --config {params.config:q} --out {output:q} 2> {log:q}"
