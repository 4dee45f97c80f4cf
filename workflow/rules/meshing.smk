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
        distance=for_real("_distance.nii.gz"),
        segmentation=for_real(".json"),
        cuboid="<results>/cuboid/{sample}.json",
        bond_mask=real_image("bond_mask"),
        labels=real_image("labels"),
        code=library("workflow/scripts/mesh.py"),
    output:
        mesh="<results>/mesh/{sample}/{geometry}.vtu",
        surface="<results>/mesh/{sample}/{geometry}.stl",
        report="<results>/mesh/{sample}/{geometry}.json",
    log:
        "<logs>/mesh/{sample}_{geometry}.log",
    benchmark:
        "<benchmarks>/mesh/{sample}_{geometry}.tsv"
    resources:
        **OF_MESHES,
    params:
        **OF_SHAPES,
        coarsening=coarsening(1),
        ends=row_modelled_ends,
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
        coarsening=coarsening(2),
        ends=row_modelled_ends,
    message:
        "Mesh, elements of twice the size: {wildcards.sample}, {wildcards.geometry} geometry"
