# Sensory commutativity of action sequences: from SC-experiments to figures and report.
#
#   snakemake --cores all                                        the default profile, some minutes
#   snakemake --cores all --configfile config/paper.yaml         the paper's sizes
#
# Every rule calls a command (sensory-commutativity --help); the science is in src/.
from snakemake.utils import min_version

min_version("9.0")


configfile: "config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/flatland.smk"
include: "workflow/rules/apartment.smk"
include: "workflow/rules/objects.smk"
include: "workflow/rules/navigation.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/runs.smk"


report: "workflow/report/workflow.rst"


localrules:
    all,


rule all:
    default_target: True
    input:
        figures(),
        CHECKSUMS,
