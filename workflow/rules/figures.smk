# What people look at: one figure per module of its name, the animation, and the paper's claims beside ours.
def figures():
    """Every figure as PNG and PDF, and the animation."""
    drawn = [DRAWN / f"{name}.{kind}" for name in FIGURES for kind in ("png", "pdf")]
    return [*drawn, DRAWN / "flatland_experiment.gif"]


for figure, needed in FIGURES.items():

    rule:
        name:
            f"figure_{figure}"
        input:
            tables=[TABLES / f"{table}.parquet" for table in needed],
        output:
            png=report(
                DRAWN / f"{figure}.png",
                category=(
                    "Flatland"
                    if figure.startswith("flatland")
                    else "The paper's claims"
                ),
                caption=f"../report/{figure}.rst",
                labels={"figure": figure},
            ),
            pdf=DRAWN / f"{figure}.pdf",
        log:
            LOGS / "figure" / f"{figure}.log",
        params:
            figure=figure,
            tables=TABLES,
            settings=digest(FLATLAND),
        message:
            "drawing {params.figure}"
        shell:
            "sensory-commutativity figure {params.figure} --config {RESOLVED:q} --tables {params.tables:q} --out {output.png:q} 2> {log:q}"


rule animation:
    output:
        report(
            DRAWN / "flatland_experiment.gif",
            category="Flatland",
            caption="../report/flatland_experiment.rst",
            labels={"figure": "flatland_experiment"},
        ),
    log:
        LOGS / "animation.log",
    params:
        settings=reference(FLATLAND.rest_steps),
    message:
        "animating one SC-experiment"
    shell:
        "sensory-commutativity animation --config {RESOLVED:q} --out {output:q} 2> {log:q}"


rule paper_comparison:
    input:
        tables=[TABLES / f"{name}.parquet" for name in COMPARED],
    output:
        TABLES / "paper_comparison.parquet",
    log:
        LOGS / "paper_comparison.log",
    params:
        tables=TABLES,
        settings=digest(FLATLAND),
    message:
        "setting the paper's claims beside ours"
    shell:
        "sensory-commutativity paper-comparison --config {RESOLVED:q} --tables {params.tables:q} --out {output:q} 2> {log:q}"
