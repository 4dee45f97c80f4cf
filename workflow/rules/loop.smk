# Closing the loop: what the calibrated model leaves over, and the effect it points at.

OF_CHANGED_MODELS = {
    **OF_SHAPES,
    "ends": ENDS,
    "many_fibres": of_row(states_directions),
    "region_stiffness": config["material"]["region_stiffness"],
    "element_size_mm": config["loop"]["element_size_mm"],
    "perturbations": config["loop"]["perturbations"],
    "solver": config["solver"],
    "contact": config["contact"],
}


OF_DIAGNOSES = {
    "samples": of(PLAN.samples_of),
    "rows": rows(PLAN.diagnosed),
    "bonded": of(chosen(PLAN.diagnosed, PLAN.bonded_by_rule)),
    "folds": of(PLAN.folds),
    "leave_out": LEAVE_OUT,
    "group": "{group}",
    "release": config["contact"]["release"],
    "loop": config["loop"],
}
BY_ITSELF = {**OF_DIAGNOSES, "leave_out": None}


VERDICT_PAGE = str(ROOT / "workflow/report/verdict.md.j2")


# What a diagnosis reads: of the nearest geometry, or of the ideal shape beside the real one.
OF_BEST = {
    **responses(),
    "bonds": each(chosen(PLAN.diagnosed, PLAN.only_bonded), "<results>/bond/{piece}.json"),
    "template": VERDICT_PAGE,
    "code": library("workflow/scripts/diagnose.py"),
}
OF_IDEAL = {
    **responses(geometry="ideal"),
    "real": each(PLAN.diagnosed, "<results>/curves/{piece}/real/ogden2.csv"),
    "sliding_real": each(
        chosen(PLAN.diagnosed, PLAN.opened), "<results>/curves/{piece}/real/ogden2{ends}.csv"
    ),
    "template": VERDICT_PAGE,
    "code": library("workflow/scripts/diagnose.py"),
}
OTHER_ENDS = of(FILES.open_ends_verdicts)


rule perturbations:
    input:
        distance=of(FILES.for_geometry, "_distance.nii.gz"),
        segmentation=of(FILES.for_geometry, ".json"),
        cuboid="<results>/cuboid/{sample}.json",
        bond_mask=of(image_files, "bond_mask"),
        labels=of(image_files, "labels"),
        records=RECORDS,
        fit=FIT,
        code=library("workflow/scripts/perturbations.py"),
    output:
        changes="<results>/loop/perturbations/{sample}_{geometry}.csv",
    log:
        "<logs>/perturbations/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/perturbations/{sample}_{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
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
        **OF_BEST,
    output:
        verdict="<results>/loop/{group}/verdict.json",
        page="<results>/loop/{group}/verdict.md",
        figure="<results>/loop/{group}/verdict.png",
        residual="<results>/loop/{group}/residual.csv",
    log:
        "<logs>/diagnose/{group}.log",
    benchmark:
        "<benchmarks>/diagnose/{group}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        runtime=lambda wildcards, attempt: diagnosis_runtime_min(
            len(PLAN.samples_of(wildcards.group)), len(PLAN.folds(wildcards.group)), attempt
        ),
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
        **OF_BEST,
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
        **OF_BEST,
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
        **OF_IDEAL,
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


OF_POOL = {
    **recorded(PLAN.pool),
    "fit": of(FILES.calibration_of_pool),
    "bonds": each(chosen(PLAN.pool, PLAN.only_bonded), "<results>/bond/{piece}.json"),
    "whole": of(FILES.verdicts_in_turn, "whole"),
    "alone": of(FILES.verdicts_in_turn, "alone"),
    "code": library("workflow/scripts/pool.py"),
}
OF_GROUPS = {
    "groups": of(PLAN.in_turn),
    "rows": rows(PLAN.pool),
    "bonded": of(chosen(PLAN.pool, PLAN.bonded_by_rule)),
    "release": config["contact"]["release"],
    "loop": config["loop"],
    "hold_out": HOLD_OUT,
}


# What each group is told by the others, of those whose geometry is known as well.
rule pool:
    input:
        **of_model(PLAN.pool),
        **OF_POOL,
    output:
        told="<results>/loop/pool_{geometry}.json",
    log:
        "<logs>/pool/{geometry}.log",
    benchmark:
        "<benchmarks>/pool/{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: pool_memory_mb(
            len(PLAN.in_turn(wildcards.geometry)), attempt
        ),
        runtime=lambda wildcards, attempt: pool_runtime_min(
            len(PLAN.in_turn(wildcards.geometry)), attempt
        ),
    params:
        **OF_GROUPS,
        sliding=False,
    message:
        "What groups tell of each other: {wildcards.geometry} geometry"
    script:
        "../scripts/pool.py"


use rule pool as pool_sliding with:
    input:
        **of_model(PLAN.pool, "{ends}"),
        **OF_POOL,
    output:
        told="<results>/loop/pool_{geometry}_sliding.json",
    log:
        "<logs>/pool/{geometry}_sliding.log",
    benchmark:
        "<benchmarks>/pool/{geometry}_sliding.tsv"
    params:
        **OF_GROUPS,
        sliding=True,
    message:
        "What groups with sliding ends tell of each other: {wildcards.geometry} geometry"


# Verdicts that take files of other groups: rules of their own, since a cluster's profile makes one
# job of all that a group needs.
if PLAN.pooled:

    use rule diagnose as diagnose_pooled with:
        input:
            **OF_BEST,
            told=of(FILES.told),
            ends_of_others=OTHER_ENDS,
        wildcard_constraints:
            group="|".join(PLAN.pooled),
        params:
            **OF_DIAGNOSES,
            hold_out=HOLD_OUT,

    use rule diagnose_ideal as diagnose_ideal_pooled with:
        input:
            **OF_IDEAL,
            ends_of_others=OTHER_ENDS,
        wildcard_constraints:
            group="|".join(PLAN.pooled),

    ruleorder: diagnose_pooled > diagnose
    ruleorder: diagnose_ideal_pooled > diagnose_ideal


rule table_loop:
    input:
        verdicts=FILES.verdicts.values(),
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
    conda:
        "../envs/softsample.yaml"
    params:
        models=list(FILES.verdicts),
    message:
        "Table of verdicts"
    script:
        "../scripts/table_loop.py"


rule verdicts:
    input:
        FILES.verdicts.values(),
        "<results>/tables/loop.csv",
        "<results>/results.json",
    message:
        "Verdicts of all groups"


# On demand: the effects that a verdict ranks first, run in the solver at the sizes that were found.
rule simulate_sizes:
    input:
        distance=of(FILES.for_geometry, "_distance.nii.gz"),
        segmentation=of(FILES.for_geometry, ".json"),
        cuboid="<results>/cuboid/{sample}.json",
        bond_mask=of(image_files, "bond_mask"),
        labels=of(image_files, "labels"),
        records=RECORDS,
        fit=FIT,
        verdict=lambda wildcards: FILES.verdicts[
            SAMPLES[wildcards.sample]["group"], wildcards.geometry
        ],
        code=library("workflow/scripts/simulate_sizes.py"),
    output:
        changes="<results>/loop/confirmation/runs/{sample}_{geometry}.csv",
    log:
        "<logs>/simulate_sizes/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/simulate_sizes/{sample}_{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
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
        curves=each(PLAN.samples_of, "<results>/curves/{piece}/{geometry}/ogden2.csv"),
        perturbations=each(PLAN.samples_of, "<results>/loop/perturbations/{piece}_{geometry}.csv"),
        runs=each(PLAN.samples_of, "<results>/loop/confirmation/runs/{piece}_{geometry}.csv"),
        fit="<results>/calibration/{group}/{geometry}/ogden2.json",
        records=each(PLAN.samples_of, "<results>/records/{sample}.csv"),
        cuboids=each(PLAN.samples_of, "<results>/cuboid/{piece}.json"),
        verdict=lambda wildcards: FILES.verdicts[wildcards.group, wildcards.geometry],
        code=library("workflow/scripts/confirm_verdict.py"),
    output:
        table="<results>/loop/confirmation/{group}_{geometry}.csv",
    log:
        "<logs>/confirm_verdict/{group}_{geometry}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        rows=rows(PLAN.samples_of),
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
    conda:
        "../envs/softsample.yaml"
    message:
        "Table of confirmed effects: {output}"
    script:
        "../scripts/table_confirmation.py"
