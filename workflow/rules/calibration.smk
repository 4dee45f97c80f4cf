# Ogden parameters of a group of samples that share their material.


# What a calibration reads, and what it is made with.
CALIBRATED = {
    "curves": calibration_curves("csv"),
    "reports": calibration_curves("json"),
    "meshes": calibration_meshes if config["calibration"]["method"] == "direct" else [],
    "records": calibration_records,
    "cuboids": calibration_shapes,
    "code": library("workflow/scripts/calibrate.py"),
}
OF_CALIBRATION = {
    "rows": lambda wildcards: rows_of(members(wildcards.group, wildcards.model)),
    "hold_out": HOLD_OUT,
    "settings": config["calibration"],
    "uncertainty": config["uncertainty"],
    "contact_zero_mm": config["loop"]["noise"]["contact_zero_mm"],
    "material": config["material"],
    "solver": config["solver"],
    "contact": config["contact"],
}


rule calibrate:
    input:
        **CALIBRATED,
    output:
        fit="<results>/calibration/{group}/{geometry}/{model}.json",
        curve="<results>/calibration/{group}/{geometry}/{model}.csv",
    log:
        "<logs>/calibrate/{group}_{geometry}_{model}.log",
    resources:
        **OF_MESHES,
    params:
        **OF_CALIBRATION,
    message:
        "Calibrate: group {wildcards.group}, {wildcards.geometry} geometry, {wildcards.model}"
    script:
        "../scripts/calibrate.py"
