# What the study argues with beside its tables: slower than `rule all`, asked for by `make extended`.


rule extended:
    input:
        of_alike(
            "<results>/extended/direct.csv",
            "<results>/extended/exponents.csv",
            "<results>/extended/common_exponents.csv",
            *in_formats(["exponents"], "extended"),
            *FILES.geometry_effects,
            "<results>/tables/confirmation.csv",
        ),
    message:
        "Extended study complete: {input}"


use rule calibrate as calibrate_direct with:
    input:
        **{**CALIBRATED, "meshes": MESHES_OF_MEMBERS},
    output:
        fit="<results>/extended/direct/{group}/{geometry}/{model}.json",
        curve="<results>/extended/direct/{group}/{geometry}/{model}.csv",
    log:
        "<logs>/calibrate_direct/{group}_{geometry}_{model}.log",
    benchmark:
        "<benchmarks>/calibrate_direct/{group}_{geometry}_{model}.tsv"
    params:
        **{**OF_CALIBRATION, "settings": {**config["calibration"], "method": "direct"}},
    message:
        "Calibrate with a simulation per evaluation: group {wildcards.group}, {wildcards.geometry} geometry, {wildcards.model}"


rule table_direct:
    input:
        direct=expand("<results>/extended/direct/{group}/real/ogden2.json", group=SHOWN_GROUPS),
        family=expand("<results>/calibration/{group}/real/ogden2.json", group=SHOWN_GROUPS),
        curves=expand(
            "<results>/curves/{sample}/real/ogden2.json",
            sample=[name for group in SHOWN_GROUPS for name in GROUPS[group]],
        ),
        code=library("workflow/scripts/table_direct.py"),
    output:
        table=report(
            "<results>/extended/direct.csv",
            caption="../report/direct.rst",
            category="Extended",
            labels={"table": "A simulation per evaluation, or response curves"},
        ),
    log:
        "<logs>/table_direct.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Table of both ways to calibrate"
    script:
        "../scripts/table_direct.py"


# Two Ogden terms with exponents in ranges, a law as any other.
FREE = "ogden({:g}:{:g})+ogden({:g}:{:g})".format(
    *config["exponents"]["alpha1"], *config["exponents"]["alpha2"]
)


use rule laws_of_group as exponents_of_group with:
    output:
        report="<results>/extended/exponents/{group}.json",
        curves="<results>/extended/exponents/{group}.csv",
    log:
        "<logs>/exponents/{group}.log",
    benchmark:
        "<benchmarks>/exponents/{group}.tsv"
    params:
        **{**OF_LAWS, "laws": {**config["laws"], "candidates": [FREE]}},
        folds={},
        hold_out=[],
        confidence=config["uncertainty"]["confidence"],
        floor=config["floor"],
        contact_zero_mm=config["loop"]["noise"]["contact_zero_mm"],
    message:
        "Fit with free exponents: group {wildcards.group}"


use rule confirm_law as confirm_exponents with:
    input:
        **OF_CONFIRMED,
        report="<results>/extended/exponents/{group}.json",
        laws="<results>/extended/exponents/{group}.csv",
    output:
        table="<results>/extended/exponents/confirmed/{group}.csv",
    log:
        "<logs>/confirm_exponents/{group}.log",
    benchmark:
        "<benchmarks>/confirm_exponents/{group}.tsv"
    params:
        **{**OF_LAWS, "laws": {**config["laws"], "candidates": [FREE]}},
        law=FREE,
    message:
        "Run at the optimum with free exponents: group {wildcards.group}"


rule table_exponents:
    input:
        reports=expand("<results>/extended/exponents/{group}.json", group=GROUPS),
        runs=expand("<results>/extended/exponents/confirmed/{group}.csv", group=GROUPS),
        code=library("workflow/scripts/table_exponents.py"),
    output:
        table=report(
            "<results>/extended/exponents.csv",
            caption="../report/exponents.rst",
            category="Extended",
            labels={"table": "Free exponents"},
        ),
        common=report(
            "<results>/extended/common_exponents.csv",
            caption="../report/common_exponents.rst",
            category="Extended",
            labels={"table": "Are exponents constant?"},
        ),
    log:
        "<logs>/table_exponents.log",
    conda:
        "../envs/softsample.yaml"
    params:
        groups=list(GROUPS),
        law=FREE,
    message:
        "Tables of free exponents"
    script:
        "../scripts/table_exponents.py"


rule figure_exponents:
    input:
        table="<results>/extended/exponents.csv",
        code=library("workflow/scripts/figure_exponents.py"),
    output:
        png=report(
            "<results>/extended/exponents.png",
            caption="../report/exponents.rst",
            category="Extended",
            labels={"figure": "Free exponents"},
        ),
        pdf="<results>/extended/exponents.pdf",
    log:
        "<logs>/figure_exponents.log",
    conda:
        "../envs/softsample.yaml"
    params:
        alpha=config["material"]["alpha"],
        ranges=[config["exponents"][name] for name in ("alpha1", "alpha2")],
    message:
        "Figure: free exponents"
    script:
        "../scripts/figure_exponents.py"
