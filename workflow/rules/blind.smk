# The blind laboratory: records with undeclared effects, answers frozen, then scored. Its rules are
# there with `--configfile config/blind.yaml`.


BLIND = config["blind"]
BODIES = [
    f"{kind}_{BLIND['bodies']['first'] + k}"
    for kind, count in (("cuboid", "cuboids"), ("shape", "shapes"))
    for k in range(BLIND["bodies"][count])
]
PARTS = range(12)
MISFITS = "<results>/measured/misfits.csv"  # of `make measured`


wildcard_constraints:
    body="(cuboid|shape)_[0-9]+",
    lab="|".join(BLIND["extents"]),
    part="[0-9]+",


rule blind_curves:
    input:
        code=library("workflow/scripts/blind_curves.py"),
    output:
        curves="<results>/{lab}/curves/{body}.csv",
    log:
        "<logs>/{lab}/curves_{body}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        bank=BLIND["bank"],
        sizes=lambda wildcards: BLIND["extents"][wildcards.lab]["sizes"],
    message:
        "Blind laboratory: curves of {wildcards.body}"
    script:
        "../scripts/blind_curves.py"


rule blind_model:
    input:
        code=library("workflow/scripts/blind_model.py"),
    output:
        curves="<results>/blind/models/{body}.csv",
    log:
        "<logs>/blind/model_{body}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        bank=BLIND["bank"],
        perturbations=config["loop"]["perturbations"],
    message:
        "Blind laboratory: the loop's model of {wildcards.body}"
    script:
        "../scripts/blind_model.py"


rule blind_seal:
    input:
        code=library("workflow/scripts/blind_seal.py"),
    output:
        planted="<results>/{lab}/planted.json",
        seal="<results>/{lab}/seal.json",
    log:
        "<logs>/{lab}/seal.log",
    conda:
        "../envs/softsample.yaml"
    params:
        extent=lambda wildcards: BLIND["extents"][wildcards.lab],
        bodies=BLIND["bodies"],
    message:
        "Blind laboratory: seal what is planted"
    script:
        "../scripts/blind_seal.py"


rule blind_answers:
    input:
        seal="<results>/{lab}/seal.json",
        curves=expand("<results>/{{lab}}/curves/{body}.csv", body=BODIES),
        models=expand("<results>/blind/models/{body}.csv", body=BODIES),
        misfits=lambda wildcards: [MISFITS] if wildcards.lab == "blind-measured" else [],
        code=library("workflow/scripts/blind_answers.py"),
    output:
        answers="<results>/{lab}/answers/{part}.json",
    log:
        "<logs>/{lab}/answers_{part}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        names=BODIES,
        part=lambda wildcards: int(wildcards.part),
        parts=len(PARTS),
        loop=config["loop"],
        noise=BLIND["noise"],
        bodies=BLIND["bodies"],
        extent=lambda wildcards: BLIND["extents"][wildcards.lab],
        bootstraps=BLIND["bootstraps"],
        bootstrap_every=BLIND["bootstrap_every"],
    message:
        "Blind laboratory: answers, part {wildcards.part}"
    script:
        "../scripts/blind_answers.py"


rule blind_score:
    input:
        planted="<results>/{lab}/planted.json",
        seal="<results>/{lab}/seal.json",
        answers=expand("<results>/{{lab}}/answers/{part}.json", part=PARTS),
        code=library("workflow/scripts/blind_score.py"),
    output:
        score="<results>/{lab}/score.json",
        confusion="<results>/{lab}/confusion.csv",
        figure="<results>/{lab}/confusion.png",
    log:
        "<logs>/{lab}/score.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Blind laboratory: score"
    script:
        "../scripts/blind_score.py"


rule blind:
    input:
        "<results>/blind/score.json",
    message:
        "Blind laboratory scored: {input}"


rule blind_foreign:
    input:
        expand("<results>/blind-{family}/score.json", family=("exponential", "polynomial")),
    message:
        "Blind laboratory scored with errors of other families: {input}"


rule blind_measured:
    input:
        "<results>/blind-measured/score.json",
    message:
        "Blind laboratory scored with misfits of measured records: {input}"


rule blind_full:
    input:
        "<results>/blind-full/score.json",
    message:
        "Blind laboratory scored at all sizes and designs: {input}"
