"""One line a job while the workflow runs, from the records that Snakemake logs."""

import logging
from enum import Enum

import pytest

from softsample import progress
from softsample.progress import JobLines, spoken_duration

Event = Enum("Event", "RUN_INFO JOB_INFO JOB_STARTED JOB_FINISHED PROGRESS JOB_ERROR ERROR")


class Run:
    """A run of the workflow with a clock that is set by hand."""

    def __init__(self, monkeypatch, stats, dry=False):
        self.now, self.shown = 100.0, []
        monkeypatch.setattr(progress.time, "monotonic", lambda: self.now)
        self.lines = JobLines(logging.Formatter("plain %(message)s"), dry=lambda: dry)
        self.log("Job stats", Event.RUN_INFO, stats={**stats, "total": sum(stats.values())})

    def log(self, message, event=None, **extra):
        record = logging.makeLogRecord({"msg": message, "event": event, **extra})
        if self.lines.shows(record):
            self.shown.append(self.lines.format(record))

    def start(self, job, rule, words):
        self.log("Select jobs to execute...")
        self.log("Execute 1 jobs...", Event.JOB_STARTED)
        self.log(None, Event.JOB_INFO, jobid=job, rule_name=rule, rule_msg=words)

    def finish(self, job, after):
        self.now += after
        self.log("Finished jobid", Event.JOB_FINISHED, job_id=job)
        self.log(None, Event.PROGRESS, done=1, total=9)


def test_a_job_is_one_line_with_a_bar_the_time_left_and_what_it_computes(monkeypatch):
    run = Run(monkeypatch, {"segment": 3, "mesh": 1})
    run.start(1, "segment", "Segment the image: A")
    run.finish(1, after=60.0)
    run.start(2, "segment", "Segment the image: B")
    run.finish(2, after=40.0)
    run.start(3, "mesh", None)
    bar = "[" + " " * 20 + "]"
    assert run.shown == [
        "plain Job stats",
        f"{bar}   0 %: Segment the image: A",
        # three jobs left of 60 s each, as far as is known: no mesh was made yet
        "[#####               ]  25 %, more than 3 min left: Segment the image: B",
        "[##########          ]  50 %, more than 2 min left: mesh",
    ]


def test_what_ran_side_by_side_is_expected_to_go_on_so(monkeypatch):
    run = Run(monkeypatch, {"segment": 4})
    run.start(1, "segment", "A")
    run.start(2, "segment", "B")
    run.finish(1, after=50.0)
    run.finish(2, after=0.0)
    run.start(3, "segment", "C")
    assert run.shown[-1] == "[##########          ]  50 %, 50 s left: C"


def test_rules_that_take_longer_count_for_more(monkeypatch):
    run = Run(monkeypatch, {"short": 1, "long": 3})
    run.start(1, "short", "s")
    run.finish(1, after=1.0)
    run.start(2, "long", "l")
    assert run.shown[-1].endswith(", more than 3 s left: l")
    run.finish(2, after=99.0)
    run.start(3, "long", "l")
    assert run.shown[-1].endswith(", 3 min left: l")  # 2 of 99 s


def test_a_job_that_failed_is_one_line_since_its_own_message_stands_above(monkeypatch):
    run = Run(monkeypatch, {"segment": 1})
    run.log("Error\n" + 150 * "input\n", Event.JOB_ERROR, rule_name="segment", log=["a.log"])
    run.log("RuleException:\nCalledProcessError in file 'a'", Event.ERROR)
    run.log("Exiting because a job execution failed. Look above", None)
    run.log("WorkflowError:\nAt least one job did not complete successfully.", Event.ERROR)
    run.log("Nothing to be done")
    assert run.shown[1:] == ["Failed: segment (log: a.log)", "plain Nothing to be done"]


def test_a_refusal_is_told_without_the_lines_that_raised_it(monkeypatch):
    run = Run(monkeypatch, {"segment": 1})
    where = '  File "/a/common.smk", line 67, in checked_study'
    text = (
        f'WorkflowError in file "/a b/common.smk", line 6:\ntable is refused:\n  row 3\n{where}\n'
    )
    run.lines = JobLines(logging.Formatter("%(message)s"), dry=lambda: False)
    run.log(text, Event.ERROR)
    run.log("NameError in file 'x', line 3:\nname 'y' is not defined", Event.ERROR)
    assert run.shown[1] == "table is refused:\n  row 3"
    assert run.shown[2].startswith("NameError in file 'x', line 3:")


def test_a_plan_is_told_in_snakemakes_own_words(monkeypatch):
    run = Run(monkeypatch, {"segment": 1}, dry=True)
    run.log("Job 1: Segment", Event.JOB_INFO, jobid=1, rule_name="segment", rule_msg="Segment")
    assert run.shown[1:] == ["plain Job 1: Segment"]


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.4, "0 s"), (89.0, "89 s"), (200.0, "3 min"), (5399.0, "1 h 30 min"), (7300.0, "2 h 2 min")],
)
def test_durations(seconds, words):
    assert spoken_duration(seconds) == words
