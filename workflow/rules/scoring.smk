# Results of the virtual cohort against the sealed truth it was made with. Nothing else reads it.


TRUTH = os.path.join(os.path.dirname(TABLE), "truth")


rule score:
    input:
        "<results>/scoring/score.csv",
        "<results>/scoring/score.json",
    message:
        "Scored against the sealed truth: {input}"


rule compare_with_truth:
    input:
        truth=expand(os.path.join(TRUTH, "{sample}.json"), sample=SAMPLES),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=SAMPLES),
        fits=expand(
            "<results>/calibration/{group}/{geometry}/ogden2.json",
            group=GROUPS,
            geometry=GEOMETRIES,
        ),
        intervals="<results>/tables/intervals.csv",
        code=library("workflow/scripts/score.py"),
    output:
        table="<results>/scoring/score.csv",
        report="<results>/scoring/score.json",
    log:
        "<logs>/score.log",
    params:
        samples=list(SAMPLES),
        groups=GROUPS,
        geometries=GEOMETRIES,
    message:
        "Compare geometry and moduli with the sealed truth"
    script:
        "../scripts/score.py"
