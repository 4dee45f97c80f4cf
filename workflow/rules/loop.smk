# Closing the loop: what the calibrated model leaves over, and the effect it points at.

OF_CHANGED_MODELS = {
    **OF_SHAPES,
    "ends": row_modelled_ends,
    "region_stiffness": config["material"]["region_stiffness"],
    "element_size_mm": config["loop"]["element_size_mm"],
    "perturbations": config["loop"]["perturbations"],
    "solver": config["solver"],
    "contact": config["contact"],
}


OF_DIAGNOSES = {
    "samples": lambda wildcards: samples_of(wildcards.group),
    "rows": lambda wildcards: rows_of(diagnosed(wildcards)),
    "bonded": bonded_by_rule,
    "folds": lambda wildcards: folds_of(wildcards.group),
    "leave_out": LEAVE_OUT,
    "others": {},
    "loop": config["loop"],
}
BY_ITSELF = {**OF_DIAGNOSES, "leave_out": None}


# Of the real shape, beside those of the idealised one.
REAL_RESPONSES = {
    "real": of_diagnosed("<results>/curves/{sample}/real/ogden2.csv", of=piece_of),
    "sliding_real": of_sliding("<results>/curves/{sample}/real/ogden2{ends}.csv"),
}
# Groups whose verdict takes files of others.
POOLED = list(filter(pools, GROUPS))


rule perturbations:
    input:
        distance=for_real("_distance.nii.gz"),
        segmentation=for_real(".json"),
        cuboid="<results>/cuboid/{sample}.json",
        bond_mask=real_image("bond_mask"),
        labels=real_image("labels"),
        records=records_of_piece,
        fit=optimum("json"),
        code=library("workflow/scripts/perturbations.py"),
    output:
        changes="<results>/loop/perturbations/{sample}_{geometry}.csv",
    log:
        "<logs>/perturbations/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/perturbations/{sample}_{geometry}.tsv"
    resources:
        **OF_MESHES,
    params:
        **OF_CHANGED_MODELS,
    message:
        "Changed models: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/perturbations.py"


use rule perturbations as perturbations_sliding with:
    output:
        changes="<results>/loop/perturbations/{sample}_{geometry}_sliding.csv",
    log:
        "<logs>/perturbations/{sample}_{geometry}_sliding.log",
    benchmark:
        "<benchmarks>/perturbations/{sample}_{geometry}_sliding.tsv"
    params:
        **{**OF_CHANGED_MODELS, "ends": "sliding"},
    message:
        "Changed models with sliding ends: {wildcards.sample}, {wildcards.geometry} geometry"


rule diagnose:
    input:
        **responses(),
        bonds=bonds,
        code=library("workflow/scripts/diagnose.py"),
    output:
        verdict="<results>/loop/{group}/verdict.json",
        page="<results>/loop/{group}/verdict.md",
        figure="<results>/loop/{group}/verdict.png",
        residual="<results>/loop/{group}/residual.csv",
    log:
        "<logs>/diagnose/{group}.log",
    benchmark:
        "<benchmarks>/diagnose/{group}.tsv"
    params:
        **OF_DIAGNOSES,
        hold_out=HOLD_OUT,
    message:
        "Diagnose the residual: group {wildcards.group}"
    script:
        "../scripts/diagnose.py"


# What a study holds out of one group at a time is predicted with all that is known of the others.
use rule diagnose as diagnose_alone with:
    input:
        **responses(),
        bonds=bonds,
        code=library("workflow/scripts/diagnose.py"),
    output:
        verdict="<results>/loop/{group}/alone/verdict.json",
        page="<results>/loop/{group}/alone/verdict.md",
        figure="<results>/loop/{group}/alone/verdict.png",
        residual="<results>/loop/{group}/alone/residual.csv",
    log:
        "<logs>/diagnose/{group}_alone.log",
    benchmark:
        "<benchmarks>/diagnose/{group}_alone.tsv"
    params:
        **BY_ITSELF,
        hold_out=HOLD_OUT,
    message:
        "Diagnose the residual, by itself: group {wildcards.group}"


use rule diagnose as diagnose_whole with:
    input:
        **responses(),
        bonds=bonds,
        code=library("workflow/scripts/diagnose.py"),
    output:
        verdict="<results>/loop/{group}/whole/verdict.json",
        page="<results>/loop/{group}/whole/verdict.md",
        figure="<results>/loop/{group}/whole/verdict.png",
        residual="<results>/loop/{group}/whole/residual.csv",
    log:
        "<logs>/diagnose/{group}_whole.log",
    benchmark:
        "<benchmarks>/diagnose/{group}_whole.tsv"
    params:
        **BY_ITSELF,
        hold_out=[],
    message:
        "Diagnose the residual, all of its records: group {wildcards.group}"


use rule diagnose as diagnose_ideal with:
    input:
        **responses("ideal"),
        **REAL_RESPONSES,
        code=library("workflow/scripts/diagnose.py"),
    output:
        verdict="<results>/loop/{group}/ideal/verdict.json",
        page="<results>/loop/{group}/ideal/verdict.md",
        figure="<results>/loop/{group}/ideal/verdict.png",
        residual="<results>/loop/{group}/ideal/residual.csv",
    log:
        "<logs>/diagnose/{group}_ideal.log",
    benchmark:
        "<benchmarks>/diagnose/{group}_ideal.tsv"
    params:
        **OF_DIAGNOSES,
        hold_out=HOLD_OUT,
    message:
        "Diagnose the residual of the idealised shape: group {wildcards.group}"


# Verdicts that take files of other groups: rules of their own, since a cluster's profile makes one
# job of all that a group needs.
if POOLED:

    use rule diagnose as diagnose_pooled with:
        input:
            **responses(),
            bonds=bonds,
            whole=verdicts_of_others("whole"),
            alone=verdicts_of_others("alone"),
            ends_of_others=ends_of_others,
            code=library("workflow/scripts/diagnose.py"),
        wildcard_constraints:
            group="|".join(POOLED),
        params:
            **{**OF_DIAGNOSES, "others": lambda wildcards: others_of(wildcards.group)},
            hold_out=HOLD_OUT,

    use rule diagnose_ideal as diagnose_ideal_pooled with:
        input:
            **responses("ideal"),
            **REAL_RESPONSES,
            ends_of_others=ends_of_others,
            code=library("workflow/scripts/diagnose.py"),
        wildcard_constraints:
            group="|".join(POOLED),

    ruleorder: diagnose_pooled > diagnose
    ruleorder: diagnose_ideal_pooled > diagnose_ideal


VERDICTS = {
    **{(group, PLAN.best(group)): f"<results>/loop/{group}/verdict.json" for group in GROUPS},
    **{
        (group, "ideal"): f"<results>/loop/{group}/ideal/verdict.json"
        for group in GROUPS
        if "real" in geometries_of(group)
    },
}


rule table_loop:
    input:
        verdicts=VERDICTS.values(),
        code=library("workflow/scripts/table_loop.py"),
    output:
        table=report(
            "<results>/tables/loop.csv",
            caption="../report/loop.rst",
            category="Tables",
            labels={"table": "Verdicts"},
        ),
        errors="<results>/tables/loop_errors.csv",
    log:
        "<logs>/loop.log",
    params:
        models=list(VERDICTS),
    message:
        "Table of verdicts"
    script:
        "../scripts/table_loop.py"


rule verdicts:
    input:
        VERDICTS.values(),
        "<results>/tables/loop.csv",
    message:
        "Verdicts of all groups"


# On demand: the effects that a verdict ranks first, run in the solver at the sizes that were found.
rule simulate_sizes:
    input:
        distance=for_real("_distance.nii.gz"),
        segmentation=for_real(".json"),
        cuboid="<results>/cuboid/{sample}.json",
        bond_mask=real_image("bond_mask"),
        labels=real_image("labels"),
        records=records_of_piece,
        fit=optimum("json"),
        verdict=lambda wildcards: VERDICTS[SAMPLES[wildcards.sample]["group"], wildcards.geometry],
        code=library("workflow/scripts/simulate_sizes.py"),
    output:
        changes="<results>/loop/confirmation/runs/{sample}_{geometry}.csv",
    log:
        "<logs>/simulate_sizes/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/simulate_sizes/{sample}_{geometry}.tsv"
    resources:
        **OF_MESHES,
    params:
        **OF_CHANGED_MODELS,
    message:
        "Effects at their sizes: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/simulate_sizes.py"


rule confirm_verdict:
    input:
        curves=of_pieces("<results>/curves/{sample}/{geometry}/ogden2.csv"),
        perturbations=of_pieces("<results>/loop/perturbations/{sample}_{geometry}.csv"),
        runs=of_pieces("<results>/loop/confirmation/runs/{sample}_{geometry}.csv"),
        fit="<results>/calibration/{group}/{geometry}/ogden2.json",
        records=of_members("<results>/records/{sample}.csv"),
        cuboids=of_pieces("<results>/cuboid/{sample}.json"),
        verdict=lambda wildcards: VERDICTS[wildcards.group, wildcards.geometry],
        code=library("workflow/scripts/confirm_verdict.py"),
    output:
        table="<results>/loop/confirmation/{group}_{geometry}.csv",
    log:
        "<logs>/confirm_verdict/{group}_{geometry}.log",
    params:
        rows=lambda wildcards: rows_of(samples_of(wildcards.group)),
        hold_out=HOLD_OUT,
        loop=config["loop"],
    message:
        "Confirm the verdict: group {wildcards.group}, {wildcards.geometry} geometry"
    script:
        "../scripts/confirm_verdict.py"


rule table_confirmation:
    input:
        groups=[f"<results>/loop/confirmation/{group}_{PLAN.best(group)}.csv" for group in GROUPS],
        code=library("workflow/scripts/table_confirmation.py"),
    output:
        table="<results>/tables/confirmation.csv",
    log:
        "<logs>/confirmation.log",
    message:
        "Table of confirmed effects: {output}"
    script:
        "../scripts/table_confirmation.py"
