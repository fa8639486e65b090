# SPDX-License-Identifier: BSD-3-Clause
"""Tests the arithmetic of scripts/benchmark --against with simple figures."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "scripts" / "benchmark"
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("benchmark", str(SCRIPT))
benchmark = importlib.util.module_from_spec(importlib.util.spec_from_loader("benchmark", loader))
loader.exec_module(benchmark)


def summary(vo_ms, **more):
    return {"frames": 50, "wall_s": 2.0,
            "processes": {"vo": {"cpu_ms_per_frame": vo_ms, "peak_memory_mb": 40.0},
                          "player": {"cpu_ms_per_frame": 5.0, "peak_memory_mb": 30.0}}, **more}


class Figures(unittest.TestCase):
    def test_all_processes_are_summed_and_the_wall_is_per_frame(self):
        found = benchmark.figures_of(summary(20.0))
        self.assertEqual(found["CPU vo, ms a frame"], 20.0)
        self.assertEqual(found["CPU of all, ms a frame"], 25.0)
        self.assertEqual(found["wall of the run, ms a frame"], 40.0)
        self.assertEqual(found["memory of all, sum of peaks MB"], 70.0)

    def test_what_a_summary_lacks_has_no_row(self):
        found = benchmark.figures_of(summary(20.0))
        self.assertNotIn("ATE, mm", found)
        self.assertFalse([name for name in found if "wall ms" in name or "loop" in name])

    def test_stages_have_median_and_quantile(self):
        found = benchmark.figures_of(summary(20.0, stage_ms={"total": {"median": 9.0, "p95": 15.0}},
                                             map={"insert_ms": {"median": 3.0, "p95": 4.0}}, accuracy={"ate_m": 0.004}))
        self.assertEqual(found["vo total, wall ms"], 9.0)
        self.assertEqual(found["vo total, wall ms, 95 %"], 15.0)
        self.assertEqual(found["mapping insert, wall ms, 95 %"], 4.0)
        self.assertEqual(found["ATE, mm"], 4.0)


class Table(unittest.TestCase):
    def test_medians_are_of_each_figure_over_the_runs_that_have_it(self):
        runs = [{"a": 3.0, "b": 1.0}, {"a": 1.0}, {"a": 20.0, "b": 2.0}]
        self.assertEqual(benchmark.medians(runs), {"a": 3.0, "b": 1.5})

    def test_the_change_is_in_percent_of_before(self):
        self.assertEqual(benchmark.cells(20.0, 15.0), ["20.0", "15.0", "-25.0 %"])
        self.assertEqual(benchmark.cells(0.5, 1.0), ["0.50", "1.00", "+100.0 %"])

    def test_no_change_is_told_where_there_is_nothing_to_compare_with(self):
        self.assertEqual(benchmark.cells(None, 120.4), ["–", "120", "–"])
        self.assertEqual(benchmark.cells(12.0, None), ["12.0", "–", "–"])
        self.assertEqual(benchmark.cells(0.0, 12.0), ["0.00", "12.0", "–"])

    def test_a_row_for_each_figure_of_any_version_and_three_cells_for_each_dataset(self):
        lines = benchmark.table({"x": ({"a": 2.0}, {"a": 1.0, "b": 7.0}), "y": ({"a": 4.0}, {"a": 5.0})})
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
        self.assertEqual(rows[0], ["", "x", "now", "change", "y", "now", "change"])
        self.assertEqual(rows[2], ["a", "2.00", "1.00", "-50.0 %", "4.00", "5.00", "+25.0 %"])
        self.assertEqual(rows[3], ["b", "–", "7.00", "–", "–", "–", "–"])
        self.assertEqual(len({len(line) for line in lines}), 1)


class Counts(unittest.TestCase):
    def test_allocations_of_a_process_that_was_started_twice_are_added(self):
        found = benchmark.per_frame("vo_process 600\nplslam 5\nvo_process 400\nviewer_headless 50\n", 10)
        self.assertEqual(found, {"allocations viewer, a frame": 5.0, "allocations vo, a frame": 100.0})

    def test_system_calls_are_those_of_the_total(self):
        text = ("% time     seconds  usecs/call     calls    errors syscall\n"
                " 53.90    2.715159         366      7409           poll\n"
                "100.00    5.000000         100     50000      7000 total\n")
        self.assertEqual(benchmark.system_calls(text, 50), {"system calls of all, a frame": 1000.0})
        self.assertEqual(benchmark.system_calls("", 50), {})


if __name__ == "__main__":
    unittest.main()
