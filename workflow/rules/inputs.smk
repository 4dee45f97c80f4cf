# Check what comes in before anything is computed from it: image and record apart, so that another
# record meshes nothing again.

from softsample.validation import SHAPE_FILES, record_settings, resolved, stated_shape

SHIPPED_FILES = {
    # ancient: another file in the manifest does not concern a sample
    "manifest": ancient(str(ROOT / "resources/MANIFEST.tsv")) if SHIPPED else [],
    "table": str(TABLE) if SHIPPED else [],
}


rule check_image:
    input:
        **SHIPPED_FILES,
        image=of(image_files, "image"),
        surface=of(image_files, "surface"),
        code=library("workflow/scripts/check_image.py"),
    output:
        report="<results>/inputs/images/{sample}.json",
    log:
        "<logs>/check_image/{sample}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        missing=of(FILES.missing, columns=SHAPE_FILES),
    message:
        "Check the image, or the surface: {wildcards.sample}"
    script:
        "../scripts/check_image.py"


rule check_record:
    input:
        **SHIPPED_FILES,
        record=of(FILES.there, "record"),
        schema=str(ROOT / "workflow/schemas/record.schema.yaml"),
        code=library("workflow/scripts/check_record.py"),
    output:
        report="<results>/inputs/{sample}.json",
        record="<results>/records/{sample}.csv",
    log:
        "<logs>/check_record/{sample}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        missing=of(FILES.missing, columns=["record"]),
        mode=row_value("mode"),
        records=of_row(lambda row: record_settings(config, row)),
        cycle=of_row(lambda row: resolved(row)["cycle"]),
        shape=of_row(stated_shape),
        plausibility=config["plausibility"],
    message:
        "Check the record: {wildcards.sample}"
    script:
        "../scripts/check_record.py"
