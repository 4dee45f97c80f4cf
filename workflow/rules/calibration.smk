# Ogden parameters of a group of samples that share their material.


rule calibrate:
    input:
        curves=calibration_curves("csv"),
        reports=calibration_curves("json"),
        meshes=calibration_meshes if config["calibration"]["method"] == "direct" else [],
        records=calibration_records,
        code=library("workflow/scripts/calibrate.py"),
    output:
        fit="<results>/calibration/{group}/{geometry}/{model}.json",
        curve="<results>/calibration/{group}/{geometry}/{model}.csv",
    log:
        "<logs>/calibrate/{group}_{geometry}_{model}.log",
    resources:
        **OF_MESHES,
    params:
        samples=lambda wildcards: members(wildcards.group, wildcards.model),
        modes=calibration_modes,
        settings=config["calibration"],
        uncertainty=config["uncertainty"],
        contact_zero_mm=config["loop"]["noise"]["contact_zero_mm"],
        material=config["material"],
        solver=config["solver"],
        contact=config["contact"],
    message:
        "Calibrate: group {wildcards.group}, {wildcards.geometry} geometry, {wildcards.model}"
    script:
        "../scripts/calibrate.py"
