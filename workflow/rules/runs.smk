# The finished run: checksums of everything that it produced.
def all_outputs():
    """All shards, models, tables and arrays, so that a missing one is made again before it gets a
    checksum."""
    starts = {(run.robot, run.scene, run.start) for run in CONFIG.apartment.runs()}
    found = [DATA / "apartment_ready" / f"{'.'.join(start)}.json" for start in starts]
    for kind in (Table, Arrays, Model):
        for name, product in declarations(kind).items():
            if product.shards is not None:
                found += shards(name)
            whole = product.shards is None or isinstance(product, Table)
            if whole and not getattr(product, "shards_only", False):
                found.append(RESULTS / product.file())
    return found


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
