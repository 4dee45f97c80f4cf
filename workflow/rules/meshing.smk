# Hexahedral mesh of the real or of the idealised geometry, with a quality report.


# What a sample is meshed with; a bond by contact is simulated.
OF_SHAPES = {
    "mode": row_value("mode"),
    "mesh": config["mesh"],
    "preload_mm": config["protocol"]["preload_mm"],
    "bond": config["bond"],
}
if config["bond"]["rule"] == "contact":
    OF_SHAPES |= {name: config[name] for name in ("material", "contact", "solver")}


rule mesh:
    input:
        distance=of(FILES.for_geometry, "_distance.nii.gz"),
        segmentation=of(FILES.for_geometry, ".json"),
        cuboid="<results>/cuboid/{sample}.json",
        bond_mask=of(image_files, "bond_mask"),
        labels=of(image_files, "labels"),
        code=library("workflow/scripts/mesh.py"),
    output:
        mesh="<results>/mesh/{sample}/{geometry}.vtu",
        surface="<results>/mesh/{sample}/{geometry}.stl",
        report="<results>/mesh/{sample}/{geometry}.json",
    log:
        "<logs>/mesh/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/mesh/{sample}_{geometry}.tsv"
    conda:
        "../envs/softsample.yaml"
    resources:
        **OF_MESHES,
    params:
        **OF_SHAPES,
        coarsening=of(PLAN.coarsening, 1),
        ends=ENDS,
    message:
        "Mesh: {wildcards.sample}, {wildcards.geometry} geometry"
    script:
        "../scripts/mesh.py"


use rule mesh as mesh_coarse with:
    output:
        mesh="<results>/mesh/{sample}/{geometry}_coarse.vtu",
        surface="<results>/mesh/{sample}/{geometry}_coarse.stl",
        report="<results>/mesh/{sample}/{geometry}_coarse.json",
    log:
        "<logs>/mesh/{sample}_{geometry}_coarse.log",
    benchmark:
        "<benchmarks>/mesh/{sample}_{geometry}_coarse.tsv"
    params:
        **OF_SHAPES,
        coarsening=of(PLAN.coarsening, 2),
        ends=ENDS,
    message:
        "Mesh, elements of twice the size: {wildcards.sample}, {wildcards.geometry} geometry"
