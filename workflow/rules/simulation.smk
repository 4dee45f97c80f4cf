# Responses to unit modulus, one run at the optimum; the input of that run for other programs.


# What a run of one piece is made with.
OF_RUNS = {
    "mode": row_value("mode"),
    "ends": ENDS,
    "material": config["material"],
    "solver": config["solver"],
    "contact": config["contact"],
}


rule simulate:
    input:
        mesh=of(FILES.mesh_of_runs, "", None),
        preliminary=of(FILES.mesh_of_runs, "_coarse", None),
        cuboid="<results>/cuboid/{sample}.json",
        records=RECORDS,
        code=library("workflow/scripts/simulate.py"),
    output:
        curves="<results>/curves/{sample}/{geometry}/ogden2.csv",
        report="<results>/curves/{sample}/{geometry}/ogden2.json",
    log:
        "<logs>/simulate/{sample}_{geometry}_ogden2.log",
    benchmark:
        "<benchmarks>/simulate/{sample}_{geometry}_ogden2.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_RUNS,
        family=config["family"],
    message:
        "Unit-modulus response: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/simulate.py"


# Ends that a study leaves open: the diagnosis compares both.
use rule simulate as simulate_sliding with:
    input:
        mesh=of(FILES.mesh_of_runs, "", "sliding"),
        preliminary=of(FILES.mesh_of_runs, "_coarse", "sliding"),
        cuboid="<results>/cuboid/{sample}.json",
        records=RECORDS,
        code=library("workflow/scripts/simulate.py"),
    output:
        curves="<results>/curves/{sample}/{geometry}/ogden2_sliding.csv",
        report="<results>/curves/{sample}/{geometry}/ogden2_sliding.json",
    log:
        "<logs>/simulate/{sample}_{geometry}_ogden2_sliding.log",
    benchmark:
        "<benchmarks>/simulate/{sample}_{geometry}_ogden2_sliding.tsv"
    params:
        **{**OF_RUNS, "ends": "sliding"},
        family=config["family"],
    message:
        "Unit-modulus response with sliding ends: {wildcards.sample}, {wildcards.geometry} geometry"


rule one_term:
    input:
        curves="<results>/curves/{sample}/{geometry}/ogden2.csv",
        report="<results>/curves/{sample}/{geometry}/ogden2.json",
        code=library("workflow/scripts/one_term.py"),
    output:
        curves="<results>/curves/{sample}/{geometry}/ogden1.csv",
        report="<results>/curves/{sample}/{geometry}/ogden1.json",
    log:
        "<logs>/one_term/{sample}_{geometry}.log",
    conda:
        "../envs/softsample.yaml"
    message:
        "Response of the first term alone: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/one_term.py"


rule confirm:
    input:
        mesh="<results>/mesh/{sample}/{geometry}.vtu",
        records=RECORDS,
        response="<results>/curves/{sample}/{geometry}/ogden2.json",
        curves="<results>/curves/{sample}/{geometry}/ogden2.csv",
        cuboid="<results>/cuboid/{sample}.json",
        fit=FIT,
        code=library("workflow/scripts/confirm.py"),
    output:
        fields="<results>/fields/{sample}/{geometry}.vtu",
        curve="<results>/fields/{sample}/{geometry}.csv",
        contact="<results>/fields/{sample}/{geometry}_contact.csv",
        energies="<results>/fields/{sample}/{geometry}_energies.csv",
        report="<results>/fields/{sample}/{geometry}.json",
    log:
        "<logs>/confirm/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/confirm/{sample}_{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_RUNS,
    message:
        "Run at the optimum: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/confirm.py"


rule sensitivity:
    input:
        mesh="<results>/mesh/{sample}/{geometry}.vtu",
        coarse="<results>/mesh/{sample}/{geometry}_coarse.vtu",
        records=RECORDS,
        response="<results>/curves/{sample}/{geometry}/ogden2.json",
        fit=FIT,
        optimum="<results>/fields/{sample}/{geometry}.csv",
        code=library("workflow/scripts/sensitivity.py"),
    output:
        report="<results>/sensitivity/{sample}/{geometry}.json",
    log:
        "<logs>/sensitivity/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/sensitivity/{sample}_{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_RUNS,
    message:
        "Sensitivity to mesh and hourglass control: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/sensitivity.py"


rule band:
    input:
        mesh="<results>/mesh/{sample}/real_coarse.vtu",
        distance="<results>/segmentation/{sample}_distance.nii.gz",
        sigma="<results>/segmentation/{sample}_sigma.nii.gz",
        segmentation="<results>/segmentation/{sample}.json",
        records=RECORDS,
        response="<results>/curves/{sample}/real/ogden2.json",
        fit=of(FILES.calibration, "json", geometry="real"),
        code=library("workflow/scripts/band.py"),
    output:
        report="<results>/band/{sample}.json",
        inner="<results>/band/{sample}_inner.stl",
        outer="<results>/band/{sample}_outer.stl",
    log:
        "<logs>/band/{sample}.log",
    benchmark:
        "<benchmarks>/band/{sample}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_RUNS,
    message:
        "Shear modulus within the uncertainty of the boundary: {wildcards.sample}"
    script:
        "../scripts/band.py"


rule bond:
    input:
        mesh="<results>/mesh/{sample}/real.vtu",
        records=RECORDS,
        response="<results>/curves/{sample}/real/ogden2.json",
        fit=of(FILES.calibration, "json", geometry="real"),
        code=library("workflow/scripts/bond.py"),
    output:
        report="<results>/bond/{sample}.json",
    log:
        "<logs>/bond/{sample}.log",
    benchmark:
        "<benchmarks>/bond/{sample}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_RUNS,
        preload_mm=config["protocol"]["preload_mm"],
        bond=config["bond"],
    message:
        "Bonded by height, and by a simulated pre-load: {wildcards.sample}"
    script:
        "../scripts/bond.py"


rule calibrate_bond:
    input:
        curves=each(PLAN.samples_of, "<results>/curves/{piece}/real/ogden2.csv"),
        records=each(PLAN.samples_of, "<results>/records/{sample}.csv"),
        cuboids=each(PLAN.samples_of, "<results>/cuboid/{piece}.json"),
        bonds=each(PLAN.bonded_of, "<results>/bond/{piece}.json"),
        code=library("workflow/scripts/calibrate_bond.py"),
    output:
        fit="<results>/bond/moduli/{group}.json",
    log:
        "<logs>/calibrate_bond/{group}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        rows=rows(PLAN.samples_of),
        bonded=of(PLAN.bonded_of),
        hold_out=HOLD_OUT,
        settings=config["calibration"],
    message:
        "Calibrate as if the other rule had bonded: group {wildcards.group}"
    script:
        "../scripts/calibrate_bond.py"


rule series:
    input:
        mesh=of_piece("<results>/mesh/{sample}/{geometry}.vtu"),
        records=RECORDS,
        response=of_piece("<results>/curves/{sample}/{geometry}/ogden2.json"),
        fit=FIT,
        code=library("workflow/scripts/series.py"),
    output:
        collection="<results>/export/{sample}/{geometry}.pvd",
        meshes=directory("<results>/export/{sample}/{geometry}"),
    log:
        "<logs>/series/{sample}_{geometry}.log",
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_RUNS,
    message:
        "Series of meshes for ParaView: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/series.py"


rule export:
    input:
        mesh=of_piece("<results>/mesh/{sample}/{geometry}.vtu"),
        surface=of_piece("<results>/mesh/{sample}/{geometry}.stl"),
        records=RECORDS,
        fit=FIT,
        curve=of(FILES.calibration, "csv"),
        code=library("workflow/scripts/export.py"),
    output:
        abaqus="<results>/export/{sample}/{geometry}.inp",
        calculix="<results>/export/{sample}/{geometry}_calculix.inp",
        febio="<results>/export/{sample}/{geometry}.feb",
        abaqus_card="<results>/export/{sample}/{geometry}_material_abaqus.inp",
        calculix_card="<results>/export/{sample}/{geometry}_material_calculix.inp",
        febio_card="<results>/export/{sample}/{geometry}_material_febio.xml",
        mesh="<results>/export/{sample}/{geometry}.vtu",
        surface="<results>/export/{sample}/{geometry}.stl",
        curve="<results>/export/{sample}/{geometry}_curve.csv",
    log:
        "<logs>/export/{sample}_{geometry}.log",
    conda:
        "../envs/softsample.yaml"
    params:
        mode=row_value("mode"),
        ends=ENDS,
        contact=config["contact"],
    message:
        "Export for Abaqus, CalculiX and FEBio: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/export.py"
