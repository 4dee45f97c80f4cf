# From the image, the surface or the stated dimensions to the sample's shape, real and idealised.

from softsample.validation import axes_of, shape_cells


rule segment:
    input:
        image=of(image_files, "image"),
        segmentation=of(image_files, "segmentation"),
        surface=of(FILES.there, "surface"),
        checked="<results>/inputs/images/{sample}.json",
        code=library("workflow/scripts/segment.py"),
    output:
        mask="<results>/segmentation/{sample}.nii.gz",
        segments="<results>/segmentation/{sample}.seg.nrrd",
        distance="<results>/segmentation/{sample}_distance.nii.gz",
        surface="<results>/segmentation/{sample}.stl",
        sigma="<results>/segmentation/{sample}_sigma.nii.gz",
        report="<results>/segmentation/{sample}.json",
    log:
        "<logs>/segment/{sample}.log",
    benchmark:
        "<benchmarks>/segment/{sample}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: 1500 * attempt,
    params:
        settings=config["segmentation"],
        axes=of_row(axes_of),
    message:
        "Segment the image, or take over the surface: {wildcards.sample}"
    script:
        "../scripts/segment.py"


rule measure:
    input:
        distance=of(FILES.segmentation, "_distance.nii.gz"),
        report=of(FILES.segmentation, ".json"),
        code=library("workflow/scripts/measure.py"),
    output:
        cuboid="<results>/cuboid/{sample}.json",
    log:
        "<logs>/measure/{sample}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        settings=config["measurement"],
        preload_mm=config["protocol"]["preload_mm"],
        shape=of_row(shape_cells),
    message:
        "Measure idealised shape and areas: {wildcards.sample}"
    script:
        "../scripts/measure.py"
