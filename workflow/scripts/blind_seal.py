"""Seal what is planted in the experiments before any is judged (rule `blind_seal`)."""

from softsample.blindlab.plan import Benches, Extent, plan
from softsample.files import sha256
from softsample.io import write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    benches = Benches(**snakemake.params.bodies)
    planted = [e.planted(e.body(benches)) for e in plan(Extent(**snakemake.params.extent))]
    write_json(snakemake.output.planted, {"experiments": planted})
    write_json(
        snakemake.output.seal,
        {
            "experiments": len(planted),
            "sha256": sha256(snakemake.output.planted),
            "provenance": provenance(snakemake),
        },
    )
