# Which elastic law the tissue follows. Not part of `rule all`: asked for by `snakemake laws`.


rule laws:
    input:
        "<results>/tables/laws.csv",
        expand("<results>/figures/laws.{kind}", kind=PICTURE_FORMATS),
        [f"<results>/laws/confirmed/{group}.csv" for group in GROUPS if PLAN.simulated(group)],
    message:
        "Elastic laws compared: {input}"


use rule mesh as mesh_laws with:
    output:
        mesh="<results>/mesh/{sample}/{geometry}_laws.vtu",
        surface="<results>/mesh/{sample}/{geometry}_laws.stl",
        report="<results>/mesh/{sample}/{geometry}_laws.json",
    log:
        "<logs>/mesh/{sample}_{geometry}_laws.log",
    benchmark:
        "<benchmarks>/mesh/{sample}_{geometry}_laws.tsv"
    params:
        **{
            **OF_SHAPES,
            "mesh": {**config["mesh"], "element_size_mm": config["laws"]["element_size_mm"]},
        },
        coarsening=1,
        ends=ENDS,
    message:
        "Mesh for elastic laws: {wildcards.sample}, {wildcards.geometry} geometry"


# What the laws of a group are simulated with.
OF_LAWS = {
    "rows": rows(PLAN.samples_of),
    "pieces": of(lambda group: [PLAN.piece_of[name] for name in PLAN.samples_of(group)]),
    "simulated": of(PLAN.simulated),
    "ends": of(lambda group: [modelled_ends(SAMPLES[name]) for name in PLAN.simulated(group)]),
    "material": config["material"],
    "laws": config["laws"],
    "solver": config["solver"],
    "contact": config["contact"],
}


rule laws_of_group:
    input:
        records=each(PLAN.samples_of, "<results>/records/{sample}.csv"),
        cuboids=each(PLAN.samples_of, "<results>/cuboid/{piece}.json"),
        meshes=each(PLAN.simulated, "<results>/mesh/{sample}/{geometry}_laws.vtu"),
        curves=each(PLAN.simulated, "<results>/curves/{sample}/{geometry}/ogden2.csv"),
        reports=each(PLAN.simulated, "<results>/curves/{sample}/{geometry}/ogden2.json"),
        qualities=each(PLAN.simulated, "<results>/mesh/{sample}/{geometry}.json"),
        fits=each(PLAN.simulated, "<results>/calibration/{group}/{geometry}/ogden2.json"),
        code=library("workflow/scripts/laws.py"),
    output:
        report="<results>/laws/{group}.json",
        curves="<results>/laws/{group}.csv",
    log:
        "<logs>/laws/{group}.log",
    benchmark:
        "<benchmarks>/laws/{group}.tsv"
    # laws/choice.json is no group's
    wildcard_constraints:
        group=r"(?!choice\.)[A-Za-z0-9_-]+",
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_LAWS,
        folds=of(lambda group: {} if LEAVE_OUT == "group" else PLAN.folds(group)),
        hold_out=HOLD_OUT,
        confidence=config["uncertainty"]["confidence"],
        floor=config["floor"],
        contact_zero_mm=config["loop"]["noise"]["contact_zero_mm"],
    message:
        "Fit every elastic law: group {wildcards.group}"
    script:
        "../scripts/laws.py"


rule choose_law:
    input:
        reports=expand("<results>/laws/{group}.json", group=GROUPS),
        curves=expand("<results>/laws/{group}.csv", group=GROUPS),
        intervals="<results>/tables/intervals.csv",
        code=library("workflow/scripts/choose_law.py"),
    output:
        table="<results>/tables/laws.csv",
        choice="<results>/laws/choice.json",
        figures=expand("<results>/figures/laws.{kind}", kind=PICTURE_FORMATS),
    log:
        "<logs>/choose_law.log",
    conda:
        "../envs/softsample.yaml"
    params:
        groups=GROUPS,
        geometries={group: PLAN.best(group) for group in GROUPS},
        alpha=config["material"]["alpha"],
        laws=config["laws"],
        confidence=config["uncertainty"]["confidence"],
    message:
        "Choose the elastic law: {output.table}"
    script:
        "../scripts/choose_law.py"


# What a fitted law is run with.
OF_CONFIRMED = {
    "records": each(PLAN.samples_of, "<results>/records/{sample}.csv"),
    "cuboids": each(PLAN.samples_of, "<results>/cuboid/{piece}.json"),
    "meshes": each(PLAN.simulated, "<results>/mesh/{sample}/{geometry}.vtu"),
    "reports": each(PLAN.simulated, "<results>/curves/{sample}/{geometry}/ogden2.json"),
    "code": library("workflow/scripts/confirm_law.py"),
}


rule confirm_law:
    input:
        **OF_CONFIRMED,
        choice="<results>/laws/choice.json",
        report="<results>/laws/{group}.json",
        laws="<results>/laws/{group}.csv",
    output:
        table="<results>/laws/confirmed/{group}.csv",
    log:
        "<logs>/confirm_law/{group}.log",
    benchmark:
        "<benchmarks>/confirm_law/{group}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_LAWS,
        law="",  # the chosen one
    message:
        "Run the chosen law on the study's mesh: group {wildcards.group}"
    script:
        "../scripts/confirm_law.py"
