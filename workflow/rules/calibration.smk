# Ogden parameters of a group of samples that share their material.


MESHES_OF_MEMBERS = each(PLAN.members, "<results>/mesh/{piece}/{geometry}.vtu")
# What a calibration reads, and what it is made with.
CALIBRATED = {
    "curves": each(PLAN.members, "<results>/curves/{piece}/{geometry}/{model}.csv"),
    "reports": each(PLAN.members, "<results>/curves/{piece}/{geometry}/{model}.json"),
    "meshes": MESHES_OF_MEMBERS if config["calibration"]["method"] == "direct" else [],
    "records": each(PLAN.members, "<results>/records/{sample}.csv"),
    "cuboids": each(PLAN.members, "<results>/cuboid/{piece}.json"),
    "code": library("workflow/scripts/calibrate.py"),
}
OF_CALIBRATION = {
    "rows": rows(PLAN.members),
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
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_CALIBRATION,
    message:
        "Calibrate: group {wildcards.group}, {wildcards.geometry} geometry, {wildcards.model}"
    script:
        "../scripts/calibrate.py"
