# Tables and figures of the study. Paper values are read here and nowhere else.


# What a table of moduli reads beside the calibrations.
OF_MODULI = {
    "paper": PAPER[0] if PAPERS else [],
    "cuboids": [f"<results>/cuboid/{PLAN.piece_of[name]}.json" for name in SAMPLES],
    "code": library("workflow/scripts/table_moduli.py"),
}


rule table_moduli:
    input:
        **FILES.fits("ogden2", "json"),
        **OF_MODULI,
    output:
        table=report(
            "<results>/tables/table1.csv",
            caption="../report/table1.rst",
            category="Tables",
            labels={"table": "1 Shear moduli, two-term Ogden model"},
        ),
    log:
        "<logs>/table1.log",
    conda:
        "../envs/softsample.yaml"
    params:
        model="ogden2",
        samples=list(SAMPLES),
    message:
        "Table 1: moduli of the two-term model"
    script:
        "../scripts/table_moduli.py"


use rule table_moduli as table_moduli_one_term with:
    input:
        **FILES.fits("ogden1", "json"),
        **OF_MODULI,
    output:
        table=report(
            "<results>/tables/table2.csv",
            caption="../report/table2.rst",
            category="Tables",
            labels={"table": "2 Shear moduli, one-term Ogden model"},
        ),
    log:
        "<logs>/table2.log",
    params:
        model="ogden1",
        samples=list(SAMPLES),
    message:
        "Table 2: moduli of the one-term model, compression alone"


rule table_geometry:
    input:
        cuboids=expand("<results>/cuboid/{sample}.json", sample=PIECES),
        code=library("workflow/scripts/table_geometry.py"),
    output:
        table=report(
            "<results>/tables/geometry.csv",
            caption="../report/geometry.rst",
            category="Tables",
            labels={"table": "Sizes and areas"},
        ),
    log:
        "<logs>/geometry.log",
    conda:
        "../envs/softsample.yaml"
    params:
        modes={name: SAMPLES[name]["mode"] for name in PIECES},
    message:
        "Table of sizes and areas"
    script:
        "../scripts/table_geometry.py"


rule table_summary:
    input:
        moduli=FILES.moduli_tables.values(),
        geometry="<results>/tables/geometry.csv",
        paper=PAPER[1] if PAPERS else [],
        code=library("workflow/scripts/table_summary.py"),
    output:
        table=report(
            "<results>/tables/summary.csv",
            caption="../report/summary.rst",
            category="Tables",
            labels={"table": "Means over samples"},
        ),
    log:
        "<logs>/summary.log",
    conda:
        "../envs/softsample.yaml"
    params:
        models=list(FILES.moduli_tables),
    message:
        "Table of means beside the paper's"
    script:
        "../scripts/table_summary.py"


rule table_sensitivity:
    input:
        reports=FILES.sensitivities(PIECES),
        code=library("workflow/scripts/table_sensitivity.py"),
    output:
        table=report(
            "<results>/tables/sensitivity.csv",
            caption="../report/sensitivity.rst",
            category="Tables",
            labels={"table": "Sensitivity to numerical choices"},
        ),
    log:
        "<logs>/sensitivity.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=PIECES,
    message:
        "Sensitivity of all samples to mesh and hourglass control"
    script:
        "../scripts/table_sensitivity.py"


rule table_band:
    input:
        reports=expand("<results>/band/{sample}.json", sample=PLAN.banded),
        code=library("workflow/scripts/table_band.py"),
    output:
        table=report(
            "<results>/tables/band.csv",
            caption="../report/band.rst",
            category="Tables",
            labels={"table": "Moduli within the uncertainty of the boundary"},
        ),
    log:
        "<logs>/band.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=PLAN.banded,
    message:
        "Table of moduli within the uncertainty of the boundary"
    script:
        "../scripts/table_band.py"


rule table_bond:
    input:
        reports=expand("<results>/bond/{sample}.json", sample=PLAN.bonded),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=PLAN.bonded),
        fits=FILES.calibrations(BONDED_GROUPS),
        others=expand("<results>/bond/moduli/{group}.json", group=BONDED_GROUPS),
        code=library("workflow/scripts/table_bond.py"),
    output:
        table=report(
            "<results>/tables/bond.csv",
            caption="../report/bond.rst",
            category="Tables",
            labels={"table": "Bonded area and modulus by rule"},
        ),
    log:
        "<logs>/table_bond.log",
    conda:
        "../envs/softsample.yaml"
    params:
        rows={name: SAMPLES[name] for name in PLAN.bonded},
        groups=BONDED_GROUPS,
    message:
        "Table of bonded areas and moduli by rule"
    script:
        "../scripts/table_bond.py"


rule table_intervals:
    input:
        fits=FILES.calibrations(GROUPS),
        bands=expand("<results>/band/{sample}.json", sample=PLAN.banded),
        bonds=expand("<results>/bond/{sample}.json", sample=PLAN.bonded),
        sensitivities=FILES.sensitivities(PIECES),
        curves=[f"<results>/curves/{'/'.join(key)}.json" for key in PLAN.curves],
        meshes=[f"<results>/mesh/{piece}/{geometry}.json" for piece, geometry, _ in PLAN.curves],
        code=library("workflow/scripts/table_intervals.py"),
    output:
        table=report(
            "<results>/tables/intervals.csv",
            caption="../report/intervals.rst",
            category="Tables",
            labels={"table": "Intervals of the moduli"},
        ),
    log:
        "<logs>/intervals.log",
    conda:
        "../envs/softsample.yaml"
    params:
        modes={name: SAMPLES[name]["mode"] for name in PIECES},
        piece_of=PLAN.piece_of,
        banded=PLAN.banded,
        bonded=PLAN.bonded,
        curves=PLAN.curves,
        floor=config["floor"],
    message:
        "Intervals of all calibrated moduli"
    script:
        "../scripts/table_intervals.py"


rule table_stress:
    input:
        records=expand("<results>/records/{sample}.csv", sample=SAMPLES),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=PLAN.piece_of.values()),
        code=library("workflow/scripts/table_stress.py"),
    output:
        table="<results>/tables/stress_strain.csv",
    log:
        "<logs>/stress_strain.log",
    conda:
        "../envs/softsample.yaml"
    params:
        modes=[row["mode"] for row in SAMPLES.values()],
    message:
        "Nominal stress against strain, averaged over samples"
    script:
        "../scripts/table_stress.py"


# The captions include this file, so that no number is typed twice.
rule numbers:
    input:
        fits=[
            name
            for model in FILES.moduli_tables
            for name in chain(*FILES.fits(model, "json").values())
        ],
        meshes=[f"<results>/mesh/{SHOWN}/{geometry}.json" for geometry in SHOWN_GEOMETRIES],
        summary="<results>/tables/summary.csv",
        stress="<results>/tables/stress_strain.csv",
        code=library("workflow/scripts/numbers.py"),
    output:
        numbers="<results>/tables/numbers.rst",
    log:
        "<logs>/numbers.log",
    conda:
        "../envs/softsample.yaml"
    params:
        cohort=COHORT,
        shipped=PAPERS,
        shown=SHOWN,
        geometries=SHOWN_GEOMETRIES,
        samples=len(SAMPLES),
        imaged=sum(map(PLAN.has_image, SAMPLES)),
        surfaces=sum("surface" in row for row in SAMPLES.values()),
        ideal=PLAN.ideal_shape,
    message:
        "Numbers for the captions"
    script:
        "../scripts/numbers.py"


rule figure2:
    input:
        image=image_files("image", SHOWN),
        distance=f"<results>/segmentation/{SHOWN}_distance.nii.gz",
        segmentation=f"<results>/segmentation/{SHOWN}.json",
        real=f"<results>/mesh/{SHOWN}/real.vtu",
        ideal=f"<results>/mesh/{SHOWN}/ideal.vtu",
        code=library("workflow/scripts/figure2.py"),
    output:
        png=report(
            "<results>/figures/figure2.png",
            caption="../report/figure2.rst",
            category="Figures",
            labels={"figure": "2 Image, segmentation, meshes"},
        ),
        pdf="<results>/figures/figure2.pdf",
    log:
        "<logs>/figure2.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Figure 2: from image to meshes"
    script:
        "../scripts/figure2.py"


rule figure3:
    input:
        real=expand("<results>/mesh/{sample}/real.vtu", sample=REAL_EXAMPLES),
        ideal=expand("<results>/mesh/{sample}/ideal.vtu", sample=EXAMPLES.values()),
        code=library("workflow/scripts/figure3.py"),
    output:
        png=report(
            "<results>/figures/figure3.png",
            caption="../report/figure3.rst",
            category="Figures",
            labels={"figure": "3 Boundary conditions"},
        ),
        pdf="<results>/figures/figure3.pdf",
    log:
        "<logs>/figure3.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples={"real": REAL_EXAMPLES, "ideal": list(EXAMPLES.values())},
        rows={name: SAMPLES[name] for name in EXAMPLES.values()},
    message:
        "Figure 3: boundary conditions"
    script:
        "../scripts/figure3.py"


rule figure_sample:
    input:
        image=of(image_files, "image"),
        distance="<results>/segmentation/{sample}_distance.nii.gz",
        sigma="<results>/segmentation/{sample}_sigma.nii.gz",
        segmentation="<results>/segmentation/{sample}.json",
        mesh="<results>/mesh/{sample}/real.vtu",
        code=library("workflow/scripts/figure_sample.py"),
    output:
        png=report(
            "<results>/figures/samples/{sample}.png",
            caption="../report/sample.rst",
            category="Samples",
            labels={"sample": "{sample}"},
        ),
    log:
        "<logs>/figure_sample/{sample}.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Contours, uncertainty and mesh quality: {wildcards.sample}"
    script:
        "../scripts/figure_sample.py"


rule figure4:
    input:
        table="<results>/tables/stress_strain.csv",
        code=library("workflow/scripts/figure4.py"),
    output:
        png=report(
            "<results>/figures/figure4.png",
            caption="../report/figure4.rst",
            category="Figures",
            labels={"figure": "4 Nominal stress and strain"},
        ),
        pdf="<results>/figures/figure4.pdf",
    log:
        "<logs>/figure4.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Figure 4: nominal stress against strain"
    script:
        "../scripts/figure4.py"


rule figure5:
    input:
        **FILES.fits("ogden2", "csv"),
        **{f"{geometry}_fit": names for geometry, names in FILES.fits("ogden2", "json").items()},
        table="<results>/tables/table1.csv",
        intervals="<results>/tables/intervals.csv",
        code=library("workflow/scripts/figure_moduli.py"),
    output:
        png=report(
            "<results>/figures/figure5.png",
            caption="../report/figure5.rst",
            category="Figures",
            labels={"figure": "5 Two-term model: curves and moduli"},
        ),
        pdf="<results>/figures/figure5.pdf",
    log:
        "<logs>/figure5.log",
    conda:
        "../envs/softsample.yaml"
    params:
        groups=FILES.fitted_groups("ogden2"),
        model="ogden2",
        ideal=PLAN.ideal_shape,
    message:
        "Figure 5: fitted curves and moduli"
    script:
        "../scripts/figure_moduli.py"


use rule figure5 as figure6 with:
    input:
        **FILES.fits("ogden1", "csv"),
        **{f"{geometry}_fit": names for geometry, names in FILES.fits("ogden1", "json").items()},
        table="<results>/tables/table2.csv",
        intervals="<results>/tables/intervals.csv",
        code=library("workflow/scripts/figure_moduli.py"),
    output:
        png=report(
            "<results>/figures/figure6.png",
            caption="../report/figure6.rst",
            category="Figures",
            labels={"figure": "6 One-term model: curves and moduli"},
        ),
        pdf="<results>/figures/figure6.pdf",
    log:
        "<logs>/figure6.log",
    params:
        groups=FILES.fitted_groups("ogden1"),
        model="ogden1",
        ideal=PLAN.ideal_shape,
    message:
        "Figure 6: compression alone"


rule figure7:
    input:
        distances=expand("<results>/segmentation/{sample}_distance.nii.gz", sample=REAL_EXAMPLES),
        segmentations=expand("<results>/segmentation/{sample}.json", sample=REAL_EXAMPLES),
        real=expand("<results>/fields/{sample}/real.vtu", sample=REAL_EXAMPLES),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=EXAMPLES.values()),
        runs=[f"<results>/fields/{name}/{PLAN.best(name)}.json" for name in EXAMPLES.values()],
        ideal=expand("<results>/fields/{sample}/ideal.vtu", sample=EXAMPLES.values()),
        code=library("workflow/scripts/figure7.py"),
    output:
        png=report(
            "<results>/figures/figure7.png",
            caption="../report/figure7.rst",
            category="Figures",
            labels={"figure": "7 Strain maps"},
        ),
        pdf="<results>/figures/figure7.pdf",
    log:
        "<logs>/figure7.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples=list(EXAMPLES.values()),
        rows=[SAMPLES[sample] for sample in EXAMPLES.values()],
        real=REAL_EXAMPLES,
    message:
        "Figure 7: strain on the real and the idealised geometry"
    script:
        "../scripts/figure7.py"


PRESSED = [run for run in PLAN.runs if run[0] in COMPRESSED]


rule contact_area:
    input:
        contacts=[
            f"<results>/fields/{sample}/{geometry}_contact.csv" for sample, geometry in PRESSED
        ],
        cuboids=[f"<results>/cuboid/{sample}.json" for sample, _ in PRESSED],
        code=library("workflow/scripts/contact_area.py"),
    output:
        table=report(
            "<results>/tables/contact.csv",
            caption="../report/contact.rst",
            category="Tables",
            labels={"table": "Contact area in compression"},
        ),
        png=report(
            "<results>/figures/contact.png",
            caption="../report/contact.rst",
            category="Figures",
            labels={"figure": "Contact area in compression"},
        ),
        pdf="<results>/figures/contact.pdf",
    log:
        "<logs>/contact_area.log",
    conda:
        "../envs/softsample.yaml"
    params:
        runs=PRESSED,
        ideal=PLAN.ideal_shape,
    message:
        "Contact area in compression"
    script:
        "../scripts/contact_area.py"


rule figure_response:
    input:
        curves=of(FILES.fitted_curves),
        code=library("workflow/scripts/figure_response.py"),
    output:
        png=report(
            "<results>/figures/response/{sample}.png",
            caption="../report/response.rst",
            category="Samples",
            labels={"sample": "{sample}, curves"},
        ),
    log:
        "<logs>/figure_response/{sample}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        mode=row_value("mode"),
        geometries=of(lambda sample: PLAN.geometries(sample)),
        ideal=PLAN.ideal_shape,
    message:
        "Record and model: {wildcards.sample}"
    script:
        "../scripts/figure_response.py"


use rule figure7 as figure_strain with:
    input:
        distances=each(PLAN.real_of, "<results>/segmentation/{sample}_distance.nii.gz"),
        segmentations=each(PLAN.real_of, "<results>/segmentation/{sample}.json"),
        real=each(PLAN.real_of, "<results>/fields/{sample}/real.vtu"),
        cuboids=["<results>/cuboid/{sample}.json"],
        runs=each(lambda sample: [sample], "<results>/fields/{sample}/{geometry}.json"),
        ideal=["<results>/fields/{sample}/ideal.vtu"],
        code=library("workflow/scripts/figure7.py"),
    output:
        png=report(
            "<results>/figures/strain/{sample}.png",
            caption="../report/strain.rst",
            category="Samples",
            labels={"sample": "{sample}, strain"},
        ),
    log:
        "<logs>/figure_strain/{sample}.log",
    params:
        samples=lambda wildcards: [wildcards.sample],
        rows=lambda wildcards: [SAMPLES[wildcards.sample]],
        real=of(PLAN.real_of),
    message:
        "Strain: {wildcards.sample}"


WITH_SURFACE = list(filter(PLAN.has_real, PIECES))


# One file that a colleague can be sent; it holds all that it shows.
rule page:
    input:
        **{
            kind: expand(f"<results>/figures/{kind}/{{sample}}.png", sample=names)
            for kind, names in FILES.pictured.items()
        },
        **{
            kind: [f"<results>/{folder}/{piece}/{name}.{ending}" for piece, name in PLAN.runs]
            for kind, folder, ending in (
                ("mesh", "mesh", "json"),
                ("run", "fields", "json"),
                ("fields", "fields", "vtu"),
            )
        },
        **{
            f"verdict_{kind}": expand(f"<results>/loop/{{group}}/verdict.{kind}", group=GROUPS)
            for kind in ("json", "md", "png")
        },
        images=expand("<results>/inputs/images/{sample}.json", sample=WITH_SURFACE),
        records=expand("<results>/inputs/{sample}.json", sample=SAMPLES),
        segmentation=expand("<results>/segmentation/{sample}.json", sample=WITH_SURFACE),
        cuboid=expand("<results>/cuboid/{sample}.json", sample=PIECES),
        tables=captioned(FILES.tables),
        numbers="<results>/tables/numbers.rst",
        document="<results>/results.json",
        figures=captioned(FILES.figures),
        intervals="<results>/tables/intervals.csv",
        fits=FILES.calibrations(GROUPS),
        checks=FILES.checks,
        template=str(ROOT / "workflow/report/report.html.j2"),
        references=str(ROOT / "workflow/report/references.yaml"),
        parts=sorted(str(name) for name in (ROOT / "workflow/report").iterdir()),
        schema=str(ROOT / "workflow/schemas/config.schema.yaml"),
        code=library("workflow/scripts/page.py"),
    output:
        page="<results>/report.html",
    log:
        "<logs>/page.log",
    conda:
        "../envs/softsample.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * (800 + 10 * len(SAMPLES)),
        runtime=lambda wildcards, attempt: attempt * (5 + len(SAMPLES) // 20),
    params:
        samples=SAMPLES,
        groups=GROUPS,
        piece_of=PLAN.piece_of,
        runs=PLAN.runs,
        segmented=WITH_SURFACE,
        pictured=FILES.pictured,
        ideal=PLAN.ideal_shape,
        cohort=COHORT,
        left_out=LEFT_OUT,
        config=config,
        failures=FAILURES,
    message:
        "Report: {output.page}"
    script:
        "../scripts/page.py"


rule results:
    input:
        found=expand("<results>/inputs/{sample}.json", sample=SAMPLES),
        cuboids=expand("<results>/cuboid/{sample}.json", sample=PLAN.piece_of.values()),
        fits=FILES.calibrations(GROUPS),
        intervals="<results>/tables/intervals.csv",
        verdicts=expand("<results>/loop/{group}/verdict.json", group=GROUPS),
        schema=str(ROOT / "workflow/schemas/results.schema.yaml"),
        code=library("workflow/scripts/results.py"),
    output:
        document="<results>/results.json",
    log:
        "<logs>/results.log",
    conda:
        "../envs/softsample.yaml"
    params:
        samples={
            name: {key: row[key] for key in ("group", "mode")} for name, row in SAMPLES.items()
        },
        groups=list(GROUPS),
    message:
        "Numbers of the study: {output.document}"
    script:
        "../scripts/results.py"


rule table_costs:
    input:
        finished=[
            *FILES.tables,
            *FILES.figures,
            "<results>/report.html",
            "<results>/checks/passed.json",
        ],
        code=library("workflow/scripts/table_costs.py"),
    output:
        table="<results>/tables/costs.csv",
    log:
        "<logs>/costs.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Table of what the jobs cost"
    script:
        "../scripts/table_costs.py"
