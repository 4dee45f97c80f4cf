"""Open the seal of the blind laboratory and score the frozen answers (rule `blind_score`)."""

from softsample.blindlab.score import Case, confusion, opened, score
from softsample.figures.confusion import confusion_figure
from softsample.figures.style import write
from softsample.files import sha256
from softsample.io import read_json, write_json, write_table
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    files = snakemake.input
    planted = opened(read_json(files.planted), read_json(files.seal), sha256(files.planted))
    answers = {int(k): a for file in files.answers for k, a in read_json(file).items()}
    cases = [Case(planted[k], answers[k]) for k in sorted(answers)]
    table = confusion(cases)
    write_table(snakemake.output.confusion, table)
    write(confusion_figure(table), snakemake.output.figure)
    write_json(
        snakemake.output.score,
        {
            "score": score(cases),
            "experiments": {"planned": len(planted), "judged": len(cases)},
            "seal": read_json(files.seal),
            "provenance": provenance(snakemake),
        },
    )
