from snakemake.utils import min_version

min_version("9.20")


configfile: f"{workflow.basedir}/config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/inputs.smk"
include: "workflow/rules/imaging.smk"
include: "workflow/rules/meshing.smk"
include: "workflow/rules/simulation.smk"
include: "workflow/rules/calibration.smk"
include: "workflow/rules/loop.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/checks.smk"
include: "workflow/rules/geometry_effects.smk"
include: "workflow/rules/scoring.smk"
include: "workflow/rules/reproduction.smk"
include: "workflow/rules/laws.smk"
include: "workflow/rules/extended.smk"


if "blind" in config:

    include: "workflow/rules/blind.smk"


report: "workflow/report/workflow.rst"


rule all:
    default_target: True
    input:
        FILES.tables,
        FILES.figures,
        FILES.pictures,
        "<results>/report.html",
        "<results>/results.json",
        "<results>/checks/passed.json",
        "<results>/tables/costs.csv",
    message:
        "Study complete: {config[results]}"


rule reported:
    input:
        FILES.tables,
        FILES.figures,
        "<results>/report.html",
        "<results>/results.json",
    message:
        "Tables, figures and report complete: {config[results]}"


for sample_id in SAMPLES:

    rule:
        name:
            f"sample_{sample_id}"
        input:
            FILES.of_sample(sample_id),
        message:
            f"Sample {sample_id} and its group are complete"

    rule:
        name:
            f"export_{sample_id}"
        input:
            FILES.exports(sample_id),
        message:
            f"Sample {sample_id} is exported for other programs"


onsuccess:
    print(words_of_success(config["results"], numbers_of_this_run(), LEFT_OUT, FAILURES))


onerror:
    print(words_of_failure(failed_jobs(f"{config['results']}/logs")))
