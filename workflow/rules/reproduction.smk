# The pages of docs/ that show the study's results; `make docs` copies them there.

PAGES = ["reproduction", "recovery"]
EXTENDED = ["direct.csv", "exponents.csv", "common_exponents.csv", "exponents.png"]


rule reproduction:
    input:
        **FILES.fits("ogden2", "json"),
        tables=[
            *(name for name in FILES.tables if name.endswith(".csv")),
            *(name for name in FILES.geometry_effects if name.endswith(".csv")),
            *(f"<results>/extended/{name}" for name in EXTENDED if name.endswith(".csv")),
            "<results>/tables/costs.csv",
            "<results>/scoring/recovery.csv",
            "<results>/scoring/element_type.csv",
        ],
        figures=[
            name
            for name in [
                *FILES.figures,
                *FILES.geometry_effects,
                *(f"<results>/extended/{name}" for name in EXTENDED),
            ]
            if name.endswith(".png")
        ],
        templates=[str(ROOT / f"workflow/report/{page}.md.j2") for page in PAGES],
        code=library("workflow/scripts/reproduction.py"),
    output:
        pages=[f"<results>/docs/{page}.md" for page in PAGES],
        data=directory("<results>/docs/data/reproduction"),
        figures=directory("<results>/docs/figures/reproduction"),
    log:
        "<logs>/reproduction.log",
    conda:
        "../envs/softsample.yaml"
    params:
        settings={
            "element_size_mm": config["mesh"]["element_size_mm"],
            "preload_mm": config["protocol"]["preload_mm"],
            "effects_element_size_mm": EFFECTS["element_size_mm"],
            "prescribed_strain": EFFECTS["prescribed_strain"],
            "level_percent": 100 * config["uncertainty"]["confidence"],
        },
    message:
        "Pages of the documentation: {output.pages}"
    script:
        "../scripts/reproduction.py"
