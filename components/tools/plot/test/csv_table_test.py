# SPDX-License-Identifier: Apache-2.0
import tempfile
import unittest
from pathlib import Path

import numpy
from pipescout_plots.csv_table import BadData, read_header, read_table


class CsvTable(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.path = Path(self._folder.name) / "a.csv"

    def read(self, text, numbers=("x",), texts=()):
        self.path.write_bytes(text.encode())
        return read_table(self.path, numbers, texts)

    def problem(self, text, **columns):
        with self.assertRaises(BadData) as caught:
            self.read(text, **columns)
        self.assertIn(str(self.path), str(caught.exception))
        return str(caught.exception)

    def test_reads_columns_by_name(self):
        table = self.read('\ufeffid,y,x\r\n"a,b",2,1\r\nc,4,3\r\n', ("x", "y"), ("id",))
        numpy.testing.assert_array_equal(table.numbers["x"], [1, 3])
        numpy.testing.assert_array_equal(table.numbers["y"], [2, 4])
        self.assertEqual(table.texts["id"], ["a,b", "c"])
        self.assertEqual(read_header(self.path), ["id", "y", "x"])
        self.assertEqual(table.notes, [])

    def test_reads_values_that_are_no_finite_number(self):
        table = self.read("x\nnan\ninf\n-inf\n", ("x",))
        numpy.testing.assert_array_equal(table.numbers["x"], [numpy.nan, numpy.inf, -numpy.inf])
        self.assertTrue(numpy.isnan(self.read("x,y\n,1\n").numbers["x"][0]))

    def test_names_missing_columns_and_those_there_are(self):
        self.assertIn("line 1: no column 'x', 'z'; there are 'y', 'w'",
                      self.problem("y,w\n1,2\n", numbers=("x",), texts=("z",)))

    def test_names_the_place_of_what_is_no_number(self):
        self.assertIn("line 3: column 'x': 'one' is not a number", self.problem("y,x\n1,1\n1,one\n1,1\n"))

    def test_names_a_line_with_too_few_fields(self):
        self.assertIn("line 2: 1 fields, and 2 columns", self.problem("y,x\n1\n1,2\n"))

    def test_names_an_empty_file_and_a_missing_one(self):
        self.assertIn("empty", self.problem(""))
        self.path.unlink()
        with self.assertRaisesRegex(BadData, "a.csv: No such file"):
            read_table(self.path, ["x"])

    def test_names_a_column_that_is_there_twice(self):
        self.assertIn("duplicate column 'x'", self.problem("x,x\n1,1\n"))

    def test_leaves_out_a_last_line_without_its_end(self):
        for cut in ("1,2", "1,", "1", '"a'):
            table = self.read(f"y,x\n1,1\n{cut}")
            numpy.testing.assert_array_equal(table.numbers["x"], [1])
            self.assertIn("line 3 has no line end and is left out", table.notes[0])

    def test_a_file_of_column_names_has_no_rows(self):
        self.assertEqual(len(self.read("y,x\n")), 0)

    def test_names_where_a_value_is_missing(self):
        self.read("x\n1\n").require_finite("x")
        with self.assertRaisesRegex(BadData, "line 3: column 'x': nan is not a finite number"):
            self.read("y,x\n1,1\n1,\n").require_finite("x")

    def test_names_where_a_column_falls(self):
        self.read("x\n1\n1\n2\n").require_rising("x")
        for text in ("x\n1\n2\n1.5\n", "x\n1\n2\nnan\n"):
            with self.assertRaisesRegex(BadData, "line 4: column 'x'"):
                self.read(text).require_rising("x")
