# The finished run: checksums of everything that it produced.


rule checksums:
    input:
        sorted(map(str, [*all_outputs(), *figures()])),
    output:
        # kept while the rule runs: a file that was not written since keeps its checksum
        update(CHECKSUMS),
    log:
        LOGS / "checksums.log",
    localrule: True
    message:
        "writing the checksums of the run"
    shell:
        "sensory-commutativity run checksums --out {output:q} 2> {log:q}"
