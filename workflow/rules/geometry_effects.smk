# Which features of the shape bias the modulus: experiments on changed samples and cuboids.


EFFECTS = config["geometry_effects"]


rule geometry_curves:
    input:
        distance="<results>/segmentation/{sample}_distance.nii.gz",
        segmentation="<results>/segmentation/{sample}.json",
        cuboid="<results>/cuboid/{sample}.json",
        record="<results>/records/{sample}.csv",
        family="<results>/curves/{sample}/real/ogden2.json",
        code=library("workflow/scripts/geometry_curves.py"),
    output:
        curves="<results>/geometry_effects/curves/{sample}.csv",
    log:
        "<logs>/geometry_curves/{sample}.log",
    benchmark:
        "<benchmarks>/geometry_curves/{sample}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        mode=row_value("mode"),
        mesh=config["mesh"],
        preload_mm=config["protocol"]["preload_mm"],
        bond=config["bond"],
        top_normal_deg=config["measurement"]["top_normal_deg"],
        effects={key: EFFECTS[key] for key in EFFECTS if key != "prescribed_strain"},
        material=config["material"],
        family=config["family"],
        solver=config["solver"],
        contact=config["contact"],
    message:
        "Curves with features of the shape changed: {wildcards.sample}"
    script:
        "../scripts/geometry_curves.py"


rule geometry_bias:
    input:
        curves=each(PLAN.samples_of, "<results>/geometry_effects/curves/{sample}.csv"),
        fit="<results>/calibration/{group}/real/ogden2.json",
        code=library("workflow/scripts/geometry_bias.py"),
    output:
        table="<results>/geometry_effects/bias/{group}.csv",
    log:
        "<logs>/geometry_bias/{group}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        modes=of(lambda group: {name: SAMPLES[name]["mode"] for name in PLAN.samples_of(group)}),
        settings=config["calibration"],
    message:
        "Bias with features of the shape changed: group {wildcards.group}"
    script:
        "../scripts/geometry_bias.py"


rule table_geometry_effects:
    input:
        biases=expand("<results>/geometry_effects/bias/{group}.csv", group=GROUPS),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=SAMPLES),
        paper=PAPER[1] if PAPERS else [],
        code=library("workflow/scripts/table_geometry_effects.py"),
    output:
        effects="<results>/tables/geometry_effects.csv",
        shares="<results>/tables/bias_shares.csv",
        needed="<results>/tables/cohort_needed.csv",
    log:
        "<logs>/table_geometry_effects.log",
    conda:
        "../envs/softsample.yaml"
    params:
        groups={
            group: [SAMPLES[name]["mode"] for name in members] for group, members in GROUPS.items()
        },
        modes=[row["mode"] for row in SAMPLES.values()],
        preload_mm=config["protocol"]["preload_mm"],
    message:
        "Effects of the geometry on the bias"
    script:
        "../scripts/table_geometry_effects.py"


rule figure_geometry_effects:
    input:
        effects="<results>/tables/geometry_effects.csv",
        needed="<results>/tables/cohort_needed.csv",
        code=library("workflow/scripts/figure_geometry_effects.py"),
    output:
        png="<results>/figures/geometry_effects.png",
        pdf="<results>/figures/geometry_effects.pdf",
    log:
        "<logs>/figure_geometry_effects.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Figure: effects of the geometry on the bias"
    script:
        "../scripts/figure_geometry_effects.py"


rule prescribed:
    input:
        mesh="<results>/mesh/{sample}/{geometry}.vtu",
        cuboid="<results>/cuboid/{sample}.json",
        family="<results>/curves/{sample}/{geometry}/ogden2.json",
        fit=FIT,
        code=library("workflow/scripts/prescribed.py"),
    output:
        curves="<results>/geometry_effects/prescribed/{sample}_{geometry}.csv",
    log:
        "<logs>/prescribed/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/prescribed/{sample}_{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        strain=EFFECTS["prescribed_strain"],
        top_normal_deg=config["measurement"]["top_normal_deg"],
        solver=config["solver"],
        contact=config["contact"],
    message:
        "Contact against prescribed displacements: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/prescribed.py"


rule table_prescribed:
    input:
        curves=expand(
            "<results>/geometry_effects/prescribed/{sample}_{geometry}.csv",
            sample=COMPRESSED,
            geometry=GEOMETRIES,
        ),
        code=library("workflow/scripts/table_prescribed.py"),
    output:
        table="<results>/tables/prescribed.csv",
    log:
        "<logs>/table_prescribed.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=[sample for sample in COMPRESSED for _ in GEOMETRIES],
        geometries=[geometry for _ in COMPRESSED for geometry in GEOMETRIES],
    message:
        "Strains up to which prescribed displacements replace contact"
    script:
        "../scripts/table_prescribed.py"


rule figure_prescribed:
    input:
        curves=rules.table_prescribed.input.curves,
        table="<results>/tables/prescribed.csv",
        code=library("workflow/scripts/figure_prescribed.py"),
    output:
        png="<results>/figures/prescribed.png",
        pdf="<results>/figures/prescribed.pdf",
    log:
        "<logs>/figure_prescribed.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=rules.table_prescribed.params.samples,
        geometries=rules.table_prescribed.params.geometries,
    message:
        "Figure: prescribed displacements in place of contact"
    script:
        "../scripts/figure_prescribed.py"


rule geometry_effects:
    input:
        of_alike(*FILES.geometry_effects),
    message:
        "Effects of the geometry: {input}"
