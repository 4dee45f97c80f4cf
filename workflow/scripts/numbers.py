"""Numbers that the captions quote, as substitutions (rule `numbers`)."""

from softsample.io import read_json, read_table, write_text
from softsample.report.captions import CaptionedStudy, caption_numbers, substitutions
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.input
    numbers = caption_numbers(
        CaptionedStudy(**dict(snakemake.params.items())),
        summary=read_table(given.summary),
        stress=read_table(given.stress),
        fits=[read_json(name) for name in given.fits],
        meshes=[read_json(name) for name in given.meshes],
    )
    write_text(snakemake.output.numbers, substitutions(numbers))
