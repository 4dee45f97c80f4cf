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
            labels={"table": "A simulation per evaluation, or a curve family"},
        ),
    log:
        "<logs>/table_direct.log",
    message:
        "Table of both ways to calibrate"
    script:
        "../scripts/table_direct.py"


rule simulate_exponents:
    input:
        mesh="<results>/mesh/{sample}/real_coarse.vtu",
        record="<results>/records/{sample}.csv",
        family="<results>/curves/{sample}/real/ogden2.json",
        code=library("workflow/scripts/simulate_exponents.py"),
    output:
        curves="<results>/extended/exponents/{sample}.csv",
    log:
        "<logs>/simulate_exponents/{sample}.log",
    benchmark:
        "<benchmarks>/simulate_exponents/{sample}.tsv"
    resources:
        **OF_MESHES,
    params:
        mode=row_value("mode"),
        material=config["material"],
        solver=config["solver"],
        contact=config["contact"],
        family=config["family"],
        exponents=config["exponents"],
    message:
        "Simulate curves for free exponents: {wildcards.sample}"
    script:
        "../scripts/simulate_exponents.py"


rule calibrate_exponents:
    input:
        curves=expand("<results>/extended/exponents/{sample}.csv", sample=SAMPLES),
        fine=expand("<results>/curves/{sample}/real/ogden2.csv", sample=SAMPLES),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=SAMPLES),
        records=expand("<results>/records/{sample}.csv", sample=SAMPLES),
        code=library("workflow/scripts/calibrate_exponents.py"),
    output:
        fits="<results>/extended/exponents.json",
        profiles="<results>/extended/exponents_profiles.csv",
    log:
        "<logs>/calibrate_exponents.log",
    benchmark:
        "<benchmarks>/calibrate_exponents.tsv"
    params:
        groups=GROUPS,
        modes={name: row["mode"] for name, row in SAMPLES.items()},
        settings=config["calibration"],
        uncertainty=config["uncertainty"],
        material=config["material"],
    message:
        "Calibrate with free exponents"
    script:
        "../scripts/calibrate_exponents.py"


rule confirm_exponents:
    input:
        mesh="<results>/mesh/{sample}/real.vtu",
        record="<results>/records/{sample}.csv",
        family="<results>/curves/{sample}/real/ogden2.json",
        curves="<results>/extended/exponents/{sample}.csv",
        fine="<results>/curves/{sample}/real/ogden2.csv",
        cuboid="<results>/cuboid/{sample}.json",
        fits="<results>/extended/exponents.json",
        code=library("workflow/scripts/confirm_exponents.py"),
    output:
        report="<results>/extended/exponents/{sample}.json",
    log:
        "<logs>/confirm_exponents/{sample}.log",
    benchmark:
        "<benchmarks>/confirm_exponents/{sample}.tsv"
    resources:
        **OF_MESHES,
    params:
        mode=row_value("mode"),
        group=row_value("group"),
        material=config["material"],
        solver=config["solver"],
        contact=config["contact"],
    message:
        "Run at the optimum with free exponents: {wildcards.sample}"
    script:
        "../scripts/confirm_exponents.py"


rule table_exponents:
    input:
        fits="<results>/extended/exponents.json",
        runs=expand("<results>/extended/exponents/{sample}.json", sample=SAMPLES),
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
    params:
        samples=list(SAMPLES),
    message:
        "Tables of free exponents"
    script:
        "../scripts/table_exponents.py"


rule figure_exponents:
    input:
        fits="<results>/extended/exponents.json",
        profiles="<results>/extended/exponents_profiles.csv",
        code=library("workflow/scripts/figure_exponents.py"),
    output:
        png=report(
            "<results>/extended/exponents.png",
            caption="../report/exponents_profiles.rst",
            category="Extended",
            labels={"figure": "Profile likelihood with free exponents"},
        ),
        pdf="<results>/extended/exponents.pdf",
    log:
        "<logs>/figure_exponents.log",
    params:
        alpha=config["material"]["alpha"],
        confidence=config["uncertainty"]["confidence"],
    message:
        "Figure: profile likelihood with free exponents"
    script:
        "../scripts/figure_exponents.py"
