# Are the results sound? `rule all` needs every check to have passed.


rule check_simulation:
    input:
        mesh="<results>/mesh/{sample}/{geometry}.vtu",
        quality="<results>/mesh/{sample}/{geometry}.json",
        curves=of(FILES.curve_reports),
        direct="<results>/fields/{sample}/{geometry}.json",
        code=library("workflow/scripts/check_simulation.py"),
    output:
        report="<results>/checks/{sample}_{geometry}.json",
    log:
        "<logs>/checks/{sample}_{geometry}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        limits=config["checks"],
    message:
        "Check mesh, energies and reactions: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/check_simulation.py"


rule check_calibration:
    input:
        fits=of(lambda group: FILES.calibrations([group])),
        code=library("workflow/scripts/check_calibration.py"),
    output:
        report="<results>/checks/{group}_calibration.json",
    log:
        "<logs>/checks/{group}_calibration.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Check the calibration: group {wildcards.group}"
    script:
        "../scripts/check_calibration.py"


rule checks_passed:
    input:
        reports=FILES.checks,
        code=library("workflow/scripts/checks_passed.py"),
    output:
        report="<results>/checks/passed.json",
    log:
        "<logs>/checks/passed.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Gather the checks of the whole study"
    script:
        "../scripts/checks_passed.py"
