# Results of the virtual cohort against the sealed truth it was made with. Nothing else reads it.


TRUTH = os.path.join(os.path.dirname(TABLE), "truth")


rule score:
    input:
        "<results>/scoring/score.csv",
        "<results>/scoring/score.json",
        "<results>/scoring/recovery.csv",
        "<results>/scoring/element_type.csv",
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
        verdicts=expand("<results>/loop/{group}/verdict.json", group=GROUPS),
        code=library("workflow/scripts/score.py"),
    output:
        table="<results>/scoring/score.csv",
        report="<results>/scoring/score.json",
    log:
        "<logs>/score.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=list(SAMPLES),
        groups=GROUPS,
        geometries=GEOMETRIES,
    message:
        "Compare geometry and moduli with the sealed truth"
    script:
        "../scripts/score.py"


rule recovery:
    input:
        truth=expand(os.path.join(TRUTH, "{sample}.json"), sample=SAMPLES),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=SAMPLES),
        curves=expand("<results>/curves/{sample}/real/ogden2.csv", sample=SAMPLES),
        records=expand("<results>/records/{sample}.csv", sample=SAMPLES),
        fits=expand("<results>/calibration/{group}/real/ogden2.json", group=GROUPS),
        score="<results>/scoring/score.csv",
        sensitivity="<results>/tables/sensitivity.csv",
        band="<results>/tables/band.csv",
        code=library("workflow/scripts/recovery.py"),
    output:
        table="<results>/scoring/recovery.csv",
    log:
        "<logs>/recovery.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=list(SAMPLES),
        modes=[row["mode"] for row in SAMPLES.values()],
        groups=GROUPS,
        settings=config["calibration"],
    message:
        "Causes of the difference from the sealed truth"
    script:
        "../scripts/recovery.py"


# Meshes and curves of another program, whose element the records of the cohort were made with.
REFERENCE = ROOT / "tests/data/reference"
REFERENCE_CASES = ["compression_h1", "compression_h07", "shear_h1", "shear_h07"]


rule element_type:
    input:
        meshes=[str(REFERENCE / f"mesh/{name}.npz") for name in REFERENCE_CASES],
        curves=[str(REFERENCE / f"curves/{name}.csv") for name in REFERENCE_CASES],
        code=library("workflow/scripts/element_type.py"),
    output:
        table="<results>/scoring/element_type.csv",
    log:
        "<logs>/element_type.log",
    conda:
        "../envs/softsample.yaml"
    params:
        modes=[name.partition("_")[0] for name in REFERENCE_CASES],
        solver=config["solver"],
        material={"mu": (1196.8, 113.1), "alpha": (-8.0, 16.0), "poisson_ratio": 0.49},
    message:
        "One-point against three-field elements on the same meshes"
    script:
        "../scripts/element_type.py"


rule score_verdicts:
    input:
        truth=expand(os.path.join(TRUTH, "{group}.json"), group=GROUPS),
        verdicts=expand("<results>/loop/{group}/verdict.json", group=GROUPS),
        code=library("workflow/scripts/score_verdicts.py"),
    output:
        table="<results>/scoring/verdicts.csv",
    log:
        "<logs>/score_verdicts.log",
    conda:
        "../envs/softsample.yaml"
    params:
        groups=list(GROUPS),
    message:
        "Compare the verdicts with the sealed truth"
    script:
        "../scripts/score_verdicts.py"
