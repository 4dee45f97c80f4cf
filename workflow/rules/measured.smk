# The loop on records of others: models of their ideal shapes, verdicts, summary, page.

MEASURED = config["measured"]["sets"]
MEASURED_ROOT = Path(os.environ.get("SOFTSAMPLE_MEASURED_ROOT", config["measured_root"]))
FILES = measured_files(MEASURED_ROOT, read_table(ROOT / "config/measured.tsv"))


wildcard_constraints:
    set="|".join(MEASURED),


rule measured_models:
    input:
        files=lambda wildcards: FILES[wildcards.set],
        catalogue=str(ROOT / "config/measured.tsv"),
        code=library("workflow/scripts/measured_models.py"),
    output:
        models="<results>/measured/{set}/models.csv",
    log:
        "<logs>/measured/{set}_models.log",
    benchmark:
        "<benchmarks>/measured/{set}_models.tsv"
    params:
        root=str(MEASURED_ROOT),
        settings=lambda wildcards: MEASURED[wildcards.set],
        solver={**config["solver"], **config["measured"]["solver"]},
    message:
        "Measured data: models of {wildcards.set}"
    script:
        "../scripts/measured_models.py"


rule measured_verdict:
    input:
        files=lambda wildcards: FILES[wildcards.set],
        models="<results>/measured/{set}/models.csv",
        code=library("workflow/scripts/measured_verdict.py"),
    output:
        verdict="<results>/measured/{set}/verdict.json",
        zeros="<results>/measured/{set}/zeros.csv",
    log:
        "<logs>/measured/{set}_verdict.log",
    benchmark:
        "<benchmarks>/measured/{set}_verdict.tsv"
    params:
        root=str(MEASURED_ROOT),
        settings=lambda wildcards: MEASURED[wildcards.set],
        noise=config["measured"]["noise"],
        loop=config["loop"],
    message:
        "Measured data: verdicts on {wildcards.set}"
    script:
        "../scripts/measured_verdict.py"


rule measured_summary:
    input:
        verdicts=expand("<results>/measured/{set}/verdict.json", set=MEASURED),
        zeros=expand("<results>/measured/{set}/zeros.csv", set=MEASURED),
        catalogue=str(ROOT / "config/measured.tsv"),
        template=str(ROOT / "workflow/report/measured.md.j2"),
        code=library("workflow/scripts/measured_summary.py"),
    output:
        summary="<results>/measured/summary.csv",
        data=directory("<results>/measured/docs/data/measured"),
        page="<results>/measured/docs/measured.md",
    log:
        "<logs>/measured/summary.log",
    params:
        settings=MEASURED,
    message:
        "Measured data: summary and page"
    script:
        "../scripts/measured_summary.py"


rule measured_report:
    input:
        verdicts=expand("<results>/measured/{set}/verdict.json", set=MEASURED),
        summary="<results>/measured/summary.csv",
        template=str(ROOT / "workflow/report/measured.html.j2"),
        style=str(ROOT / "workflow/report/report.css"),
        code=library("workflow/scripts/measured_report.py"),
    output:
        page="<results>/measured/report.html",
        figures=expand("<results>/measured/{set}/errors.png", set=MEASURED),
    log:
        "<logs>/measured/report.log",
    message:
        "Measured data: report"
    script:
        "../scripts/measured_report.py"


rule measured:
    input:
        "<results>/measured/report.html",
    message:
        "Measured data complete: {input}"
