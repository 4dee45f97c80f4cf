# Check what comes in before anything is computed from it.

from softsample.validation import record_settings, resolved, stated_shape


rule check_inputs:
    input:
        image=of(image_files, "image"),
        surface=of(image_files, "surface"),
        record=of(FILES.there, "record"),
        # ancient: another file in the manifest does not concern a sample
        manifest=ancient(str(ROOT / "resources/MANIFEST.tsv")) if SHIPPED else [],
        table=str(TABLE) if SHIPPED else [],
        schema=str(ROOT / "workflow/schemas/record.schema.yaml"),
        code=library("workflow/scripts/check_inputs.py"),
    output:
        report="<results>/inputs/{sample}.json",
        record="<results>/records/{sample}.csv",
    log:
        "<logs>/check_inputs/{sample}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        missing=of(FILES.missing),
        mode=row_value("mode"),
        records=of_row(lambda row: record_settings(config, row)),
        cycle=of_row(lambda row: resolved(row)["cycle"]),
        shape=of_row(stated_shape),
        plausibility=config["plausibility"],
    message:
        "Check what comes in: {wildcards.sample}"
    script:
        "../scripts/check_inputs.py"
