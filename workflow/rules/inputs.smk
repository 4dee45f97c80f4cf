# Check what comes in before anything is computed from it.


rule check_inputs:
    input:
        image=study_image("image"),
        record=study_file("record"),
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
    params:
        mode=row_value("mode"),
        records=config["records"],
    message:
        "Check image and record: {wildcards.sample}"
    script:
        "../scripts/check_inputs.py"
