#!/usr/bin/env python3
"""The table of tools/bench: medians, ratios, goals met and not met, and goals that name nothing."""

import contextlib
import importlib.machinery
import importlib.util
import io
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
_path = pathlib.Path(__file__).resolve().parents[2] / "tools" / "bench"
_loader = importlib.machinery.SourceFileLoader("bench", str(_path))
bench = importlib.util.module_from_spec(importlib.util.spec_from_loader("bench", _loader))
_loader.exec_module(bench)


def aggregate(name, kind, time, unit="ns", **counters):
    return {"name": f"{name}_{kind}", "run_name": name, "run_type": "aggregate", "aggregate_name": kind,
            "cpu_time": time, "real_time": time, "time_unit": unit, **counters}


RESULTS = {"benchmarks": [
    aggregate("Ours/4", "mean", 900.0), aggregate("Ours/4", "median", 1.0, "us", rate=5.0),
    aggregate("Peer/4", "median", 8000.0, rate=2.0)]}


class Table(unittest.TestCase):
    def rows(self, *goals):
        return bench.compare("area", list(goals), bench.medians(RESULTS))

    def test_takes_medians_in_nanoseconds(self):
        row, = self.rows({"what": "w", "ours": "Ours/4", "goal": {"at_most": 1000.0}})
        self.assertEqual(row["ours"], 1000.0)
        self.assertTrue(row["met"])

    def test_a_ratio_of_times_is_how_many_times_faster(self):
        met, missed = self.rows({"what": "w", "ours": "Ours/4", "peer": "Peer/4", "goal": {"ratio": 8.0}},
                                {"what": "w", "ours": "Ours/4", "peer": "Peer/4", "goal": {"ratio": 8.1}})
        self.assertAlmostEqual(met["ratio"], 8.0)
        self.assertTrue(met["met"])
        self.assertFalse(missed["met"])

    def test_a_ratio_of_rates_is_the_other_way_round(self):
        row, = self.rows({"what": "w", "ours": "Ours/4", "peer": "Peer/4", "value": "rate", "better": "more",
                          "goal": {"ratio": 2.5}})
        self.assertAlmostEqual(row["ratio"], 2.5)
        self.assertTrue(row["met"])

    def test_a_row_without_a_goal_is_neither_met_nor_missed(self):
        row, = self.rows({"what": "w", "ours": "Ours/4", "peer": "Peer/4"})
        self.assertIsNone(row["met"])
        self.assertAlmostEqual(row["ratio"], 8.0)
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            bench.print_table([row])
        self.assertIn("0 of 0 goals met", output.getvalue())

    def test_refuses_a_goal_that_names_what_did_not_run(self):
        with self.assertRaisesRegex(bench.BadInput, "names Nothing, which bench_area did not run"):
            self.rows({"what": "w", "ours": "Nothing", "goal": {"at_most": 1.0}})

    def test_goals_of_every_area_are_well_formed(self):
        for area in bench.areas():
            self.assertGreater(len(bench.read_goals(area)), 0, area)


if __name__ == "__main__":
    unittest.main()
