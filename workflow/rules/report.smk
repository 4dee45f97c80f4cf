# Tables and figures of the study. Paper values are read here and nowhere else.


rule table_moduli:
    input:
        **fits("ogden2", "json"),
        paper=PAPER if SHIPPED else [],
        code=library("workflow/scripts/table_moduli.py"),
    output:
        table=report(
            "<results>/tables/table1.csv",
            caption="../report/table1.rst",
            category="Tables",
            labels={"table": "1 Shear moduli, two-term Ogden model"},
        ),
    log:
        "<logs>/table1.log",
    params:
        model="ogden2",
        groups=groups_with("ogden2"),
        members={group: members(group, "ogden2") for group in GROUPS},
        modes={name: row["mode"] for name, row in SAMPLES.items()},
    message:
        "Table 1: moduli of the two-term model"
    script:
        "../scripts/table_moduli.py"


use rule table_moduli as table_moduli_one_term with:
    input:
        **fits("ogden1", "json"),
        paper=PAPER if SHIPPED else [],
        code=library("workflow/scripts/table_moduli.py"),
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
        groups=groups_with("ogden1"),
        members={group: members(group, "ogden1") for group in GROUPS},
        modes={name: row["mode"] for name, row in SAMPLES.items()},
    message:
        "Table 2: moduli of the one-term model, compression alone"


rule table_geometry:
    input:
        cuboids=expand("<results>/cuboid/{sample}.json", sample=SAMPLES),
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
    params:
        samples=list(SAMPLES),
        modes=[row["mode"] for row in SAMPLES.values()],
    message:
        "Table of sizes and areas"
    script:
        "../scripts/table_geometry.py"


# The captions include this file, so that no number is typed twice.
rule numbers:
    input:
        tables=tables(),
        code=library("workflow/scripts/numbers.py"),
    output:
        numbers="<results>/tables/numbers.rst",
    log:
        "<logs>/numbers.log",
    message:
        "Numbers for the captions"
    script:
        "../scripts/numbers.py"


rule figure2:
    input:
        image=sample_file(SHOWN, "image"),
        mask=f"<results>/segmentation/{SHOWN}.nii.gz",
        report=f"<results>/segmentation/{SHOWN}.json",
        cuboid=f"<results>/cuboid/{SHOWN}.json",
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
    params:
        sample=SHOWN,
    message:
        "Figure 2: from image to meshes"
    script:
        "../scripts/figure2.py"


rule figure4:
    input:
        records=[name for sample in SAMPLES for name in sample_file(sample, "record")],
        cuboids=expand("<results>/cuboid/{sample}.json", sample=SAMPLES),
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
    params:
        samples=list(SAMPLES),
        modes=[row["mode"] for row in SAMPLES.values()],
    message:
        "Figure 4: nominal stress against strain"
    script:
        "../scripts/figure4.py"


rule figure5:
    input:
        **fits("ogden2", "csv"),
        **{f"{geometry}_fit": names for geometry, names in fits("ogden2", "json").items()},
        code=library("workflow/scripts/figure5.py"),
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
    params:
        groups=groups_with("ogden2"),
        modes={name: row["mode"] for name, row in SAMPLES.items()},
    message:
        "Figure 5: fitted curves and moduli"
    script:
        "../scripts/figure5.py"


rule figure6:
    input:
        **fits("ogden1", "csv"),
        **{f"{geometry}_fit": names for geometry, names in fits("ogden1", "json").items()},
        code=library("workflow/scripts/figure6.py"),
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
        groups=groups_with("ogden1"),
        modes={name: row["mode"] for name, row in SAMPLES.items()},
    message:
        "Figure 6: compression alone"
    script:
        "../scripts/figure6.py"


rule figure7:
    input:
        images=[name for sample in EXAMPLES.values() for name in sample_file(sample, "image")],
        real=expand("<results>/fields/{sample}/real.vtu", sample=EXAMPLES.values()),
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
    params:
        samples=list(EXAMPLES.values()),
        modes=list(EXAMPLES),
    message:
        "Figure 7: strain on the real and the idealised geometry"
    script:
        "../scripts/figure7.py"
