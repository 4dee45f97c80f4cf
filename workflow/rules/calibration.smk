# Ogden parameters of a group of samples that share their material.


rule calibrate:
    input:
        curves=lambda wildcards: [
            f"<results>/curves/{name}/{wildcards.geometry}/{wildcards.model}.csv"
            for name in members(wildcards.group, wildcards.model)
        ],
        records=lambda wildcards: [
            name
            for sample in members(wildcards.group, wildcards.model)
            for name in sample_file(sample, "record")
        ],
        code=library("workflow/scripts/calibrate.py"),
    output:
        fit="<results>/calibration/{group}/{geometry}/{model}.json",
        curve="<results>/calibration/{group}/{geometry}/{model}.csv",
    log:
        "<logs>/calibrate/{group}_{geometry}_{model}.log",
    params:
        samples=lambda wildcards: members(wildcards.group, wildcards.model),
        modes=lambda wildcards: [
            SAMPLES[name]["mode"] for name in members(wildcards.group, wildcards.model)
        ],
        settings=config["calibration"],
        uncertainty=config["uncertainty"],
        contact_zero_mm=config["loop"]["noise"]["contact_zero_mm"],
        material=config["material"],
    message:
        "Calibrate: group {wildcards.group}, {wildcards.geometry} geometry, {wildcards.model}"
    script:
        "../scripts/calibrate.py"
