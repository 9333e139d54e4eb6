# Figures, animations, and the paper's claims beside what was measured.
CATEGORIES = {
    "flatland": "Flatland",
    "apartment": "Apartment",
    "mask": "Detecting changes",
    "local": "Map",
    "navigation": "Navigation",
    "paper": "The paper's claims",
    "reset": "Without a reset",
}


for name, figure in configured(Figure, CONFIG).items():

    rule:
        name:
            f"figure_{name}"
        input:
            [
                RESULTS / source.file(one)
                for source, chosen in input_shards(figure, CONFIG, None)
                for one in chosen
            ],
        output:
            png=report(
                FIGURES / f"{name}.png",
                category=CATEGORIES[name.split("_")[0]],
                caption=f"../report/{name}.rst",
                labels={"figure": name},
            ),
            pdf=FIGURES / f"{name}.pdf",
        log:
            LOGS / "figure" / f"{name}.log",
        localrule: True
        params:
            config=RESOLVED,
            figure=name,
            settings=settings(name, Figure),
        message:
            "drawing {params.figure}"
        shell:
            "sensory-commutativity figure {params.figure} --config {params.config:q} --out {output.png:q} {input:q} 2> {log:q}"


rule flatland_experiment:
    output:
        report(
            FIGURES / "flatland_experiment.gif",
            category="Flatland",
            caption="../report/flatland_experiment.rst",
            labels={"figure": "flatland_experiment"},
        ),
    log:
        LOGS / "flatland_experiment.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("flatland_experiment"),
    message:
        "animating one SC-experiment"
    shell:
        "sensory-commutativity animation flatland_experiment --config {params.config:q} --out {output:q} 2> {log:q}"


rule navigation_episode:
    input:
        inputs("navigation_episode"),
    output:
        report(
            FIGURES / "navigation_episode_{run}.gif",
            category="Navigation",
            caption="../report/navigation_episode.rst",
            labels={"figure": "navigation_episode", "action space": "{run}"},
        ),
    log:
        LOGS / "navigation_episode" / "{run}.log",
    params:
        config=RESOLVED,
        settings=settings("navigation_episode"),
    message:
        "animating an episode with the action space {wildcards.run}"
    shell:
        "sensory-commutativity animation navigation_episode --run {wildcards.run} --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"


rule paper_comparison:
    input:
        [
            RESULTS / source.file()
            for source, _ in input_shards(
                find_product("paper_comparison"), CONFIG, None
            )
        ],
    output:
        TABLES / "paper_comparison.parquet",
    log:
        LOGS / "paper_comparison.log",
    localrule: True
    params:
        config=RESOLVED,
        settings=settings("paper_comparison"),
    message:
        "comparing the paper's claims with what was measured"
    shell:
        "sensory-commutativity table paper_comparison --config {params.config:q} --out {output:q} {input:q} 2> {log:q}"
