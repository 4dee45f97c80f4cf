# Check what comes in before anything is computed from it.


rule check_manifest:
    input:
        manifest=str(ROOT / "resources/MANIFEST.tsv"),
        files=sorted(shipped_files()),
        code=library("workflow/scripts/check_manifest.py"),
    output:
        report="<results>/manifest.json",
    log:
        "<logs>/check_manifest.log",
    message:
        "Compare the shipped files with their manifest"
    script:
        "../scripts/check_manifest.py"


rule check_inputs:
    input:
        image=study_image("image"),
        record=study_file("record"),
        # ancient: another file in the manifest does not concern a sample
        manifest=ancient("<results>/manifest.json") if SHIPPED else [],
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
