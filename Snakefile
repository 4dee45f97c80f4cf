# The workflow is workflow/Snakefile; `snakemake` finds it from the root, too.


include: "workflow/Snakefile"


workflow.default_target = "all"  # which a file that is included cannot set
