# What people look at: one figure per module of its name, the animation, and the paper's claims beside ours.
def figures():
    """Every figure as PNG and PDF, and the animations."""
    drawn = [DRAWN / f"{name}.{kind}" for name in FIGURES for kind in ("png", "pdf")]
    episodes = [
        DRAWN / f"navigation_episode_{action_space}.gif"
        for action_space in NAVIGATION.action_spaces
    ]
    return [*drawn, DRAWN / "flatland_experiment.gif", *episodes]


CATEGORIES = {
    "flatland": "Flatland",
    "apartment": "Apartment",
    "mask": "What moved",
    "local": "Map",
    "navigation": "Navigation",
    "paper": "The paper's claims",
}


def drawn_from(figure):
    """Settings that a figure depends on, beside its tables."""
    if figure.startswith("apartment"):
        return apartment_settings()
    if figure.startswith(("mask", "local")):
        return digest(MASKS, apartment_settings() if figure == "local_scp" else None)
    return digest(FLATLAND, NAVIGATION if figure.startswith("navigation") else None)


for figure, needed in FIGURES.items():

    rule:
        name:
            f"figure_{figure}"
        input:
            tables=[TABLES / source_file(table) for table in needed],
        output:
            png=report(
                DRAWN / f"{figure}.png",
                category=CATEGORIES[figure.split("_")[0]],
                caption=f"../report/{figure}.rst",
                labels={"figure": figure},
            ),
            pdf=DRAWN / f"{figure}.pdf",
        log:
            LOGS / "figure" / f"{figure}.log",
        localrule: True
        params:
            figure=figure,
            tables=folder_of("tables", TABLES),
            settings=drawn_from(figure),
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
    localrule: True
    params:
        settings=reference(FLATLAND.rest_steps),
    message:
        "animating one SC-experiment"
    shell:
        "sensory-commutativity animation --config {RESOLVED:q} --out {output:q} 2> {log:q}"


rule navigation_episode:
    input:
        navigation_scores=TABLES / "navigation_scores.parquet",
        models=lambda w: [
            MODELS / "navigation" / f"{w.action_space}.{seed}.policy"
            for seed in NAVIGATION.seeds
        ],
    output:
        report(
            DRAWN / "navigation_episode_{action_space}.gif",
            category="Navigation",
            caption="../report/navigation_episode.rst",
            labels={"figure": "navigation_episode", "action space": "{action_space}"},
        ),
    log:
        LOGS / "navigation_episode" / "{action_space}.log",
    params:
        models=folder_of("models", MODELS / "navigation"),
        settings=training(),
    message:
        "animating an episode with the action space {wildcards.action_space}"
    shell:
        "sensory-commutativity navigation-episode --config {RESOLVED:q} --action-space {wildcards.action_space}"
        " --navigation-scores {input.navigation_scores:q} --models {params.models:q} --out {output:q} 2> {log:q}"


rule paper_comparison:
    input:
        tables=[TABLES / f"{name}.parquet" for name in COMPARED],
    output:
        TABLES / "paper_comparison.parquet",
    log:
        LOGS / "paper_comparison.log",
    localrule: True
    params:
        tables=folder_of("tables", TABLES),
        settings=digest(FLATLAND, NAVIGATION, MASKS, apartment_settings()),
    message:
        "setting the paper's claims beside ours"
    shell:
        "sensory-commutativity paper-comparison --config {RESOLVED:q} --tables {params.tables:q} --out {output:q} 2> {log:q}"
