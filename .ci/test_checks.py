#!/usr/bin/env python3
"""The checks of the plate demonstration, of records, of references, and of words fail where they should."""

import copy
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import records  # noqa: E402
import references  # noqa: E402
import words  # noqa: E402
from main_job import problems  # noqa: E402

ARRIVAL = {"x_m": 1e-3, "y_m": -1e-3, "phi_deg": 0.5, "spin_deg_s": 0.0, "settled_s": 1.4}
GOOD = {
    "succeeded": True,
    "true_plant": {"published_model": {"arrival": {**ARRIVAL, "settled_s": None}}, "extended_model": {"arrival": ARRIVAL}},
    "causes": [{"name": "yaw_friction", "equation": "w", "parameters": [{"name": "spin_ratio_w", "value": 0.75, "in_plant": 0.71}], "in_plant": True}],
    "gain": [{"horizon_s": 0.1, "times_smaller": 12.0}],
    "diagnosis": {"effort": {"fits": 60}},
    "effort": {"programs": {"extended_model": 600}},
}


class MainJob(unittest.TestCase):
    def broken(self, change, budget=None):
        result = copy.deepcopy(GOOD)
        change(result)
        return " ".join(problems(result, budget or {}))

    def test_a_good_result_passes(self):
        self.assertEqual(problems(GOOD, {"diagnosis": {"fits": 66}, "programs": {"extended_model": 660}}), [])

    def test_a_missed_target_fails(self):
        def miss(r):
            r["true_plant"]["extended_model"]["arrival"].update(phi_deg=-91.8, settled_s=None)
        self.assertIn("phi_deg", self.broken(miss))
        self.assertIn("names no cause", self.broken(lambda r: r["true_plant"].update(extended_model=None)))

    def test_a_slow_move_fails(self):
        self.assertIn("2.4", self.broken(lambda r: r["true_plant"]["extended_model"]["arrival"].update(settled_s=2.4)))

    def test_a_cause_that_the_plant_lacks_fails(self):
        self.assertIn("lacks yaw_friction", self.broken(lambda r: r["causes"][0].update(in_plant=False)))

    def test_a_value_far_from_that_of_the_plant_fails(self):
        self.assertIn("spin_ratio_w = 0.4", self.broken(lambda r: r["causes"][0]["parameters"][0].update(value=0.4)))

    def test_a_small_gain_fails(self):
        self.assertIn("gain 4.9", self.broken(lambda r: r["gain"][0].update(times_smaller=4.9)))

    def test_effort_beyond_its_budget_fails(self):
        more = self.broken(lambda r: r["diagnosis"]["effort"].update(fits=67), {"diagnosis": {"fits": 66}})
        self.assertIn("67 fits (diagnosis), budget 66", more)
        more = self.broken(lambda r: r["effort"]["programs"].update(extended_model=661), {"programs": {"extended_model": 660}})
        self.assertIn("661 extended_model (programs), budget 660", more)
        self.assertIn("None steps", self.broken(lambda r: None, {"diagnosis": {"steps": 1}}))


class Records(unittest.TestCase):
    def test_a_record_is_out_of_date_where_its_program_has_changed_since(self):
        root = records.ROOT
        with tempfile.TemporaryDirectory() as folder:
            records.ROOT = pathlib.Path(folder)
            try:
                def git(*arguments):
                    identity = ["-c", "user.name=check", "-c", "user.email=check@localhost"]
                    subprocess.run(["git", *identity, *arguments], cwd=folder, check=True, capture_output=True)

                def put(name, text):
                    (records.ROOT / name).write_text(text)
                    git("add", name)
                    git("commit", "-m", name)

                git("init")
                put("program.rs", "1")
                put("record.md", records.stamp("make", ["program.rs"]))
                self.assertIsNone(records.out_of_date("record.md", ["program.rs"]))
                put("other.rs", "1")
                self.assertIsNone(records.out_of_date("record.md", ["program.rs"]))
                put("program.rs", "2")
                self.assertIn("since then", records.out_of_date("record.md", ["program.rs"]))
                # The same programs in a history that has been written anew.
                put("program.rs", "1")
                self.assertIsNone(records.out_of_date("record.md", ["program.rs"]))
                (records.ROOT / "record.md").write_text("no stamp")
                self.assertIn("does not say", records.out_of_date("record.md", ["program.rs"]))
            finally:
                records.ROOT = root


class References(unittest.TestCase):
    ENTRIES = '- W.-L. Chow, "Systems", 1939.\n- P. Martin and P. Rouchon, "Driftless systems", 1994.\nBrockett 1983\n'

    def test_a_citation_needs_an_entry_with_its_name_and_year(self):
        text = "By Chow (1939), and Martin and Rouchon 1994: yes. Brockett 1983; Chow 1940. Stefani's condition (1986). 1994.5 kg, MuJoCo 2012-3."
        self.assertEqual(references.missing(text, self.ENTRIES), ["Brockett 1983", "Chow 1940", "Stefani 1986"])

    def test_accents_and_line_breaks_do_not_matter(self):
        self.assertEqual(references.missing("# (Kokotovic\n# 1992)", "- P. Kokotović, 1992.\n"), [])

    def test_an_entry_needs_all_names_that_are_cited(self):
        entries = '- J. Fan, "Test of significance", 1996.\n- M. D. Di Benedetto, J. W. Grizzle, and C. H. Moog, 1953–1989, 1989.\n'
        text = "Fan 1996, Hyndman and Fan 1996, Di Benedetto, Grizzle, and Moog 1989, Grizzle and others 1953. (Moog 1989 and 1990)."
        self.assertEqual(references.missing(text, entries), ["Grizzle 1953", "Hyndman, Fan 1996", "Moog 1990"])

    def test_comments_of_code_are_checked(self):
        source = """
            //! Reached by the theorem (Chow
            //! 1939, Brockett 1983).
            const YEAR: i32 = 1986; // `Stefani 1986`, but Kawski 1989

            /// Flat (Martin and Rouchon 1994).
            fn laub_1979() { "Laub 1979" }
        """
        self.assertEqual(references.missing_in_comments(source, self.ENTRIES), ["Brockett 1983", "Kawski 1989"])

    def test_a_year_in_a_comment_may_follow_a_title_or_a_journal(self):
        source = """
            /// By brackets (W.-L. Chow, Math. Annalen 117, 1939), by others (Martin, "Systems" (1994); Eising, Letters 4 (1984)).
            /// At least 60, at most 2000 (and 1800).
        """
        self.assertEqual(references.missing_in_comments(source, self.ENTRIES), ["Eising … 1984"])

    def test_strings_of_code_are_checked(self):
        source = '''
            const QUOTE: char = '"'; // "Laub 1979": in a comment, found there
            case("Brockett 1983", r#"the "car" of Kawski 1990"#, "Chow 1939, \\
                Stefani\n1986");
            let year = Stefani(1987);
        '''
        expected = ["Brockett 1983", "Kawski 1990", "Laub 1979", "Stefani 1986"]
        self.assertEqual(references.missing_in_file(source, self.ENTRIES, ".rs"), expected)

    def test_python_and_model_files_are_checked(self):
        source = '''
            """The car of Brockett
            1983, with the "brackets" of Chow 1939."""
            # By Martin and Rouchon 1994, not by others (Eising,
            # Letters 4 (1984)); "Laub 1979".
            name = f'Kawski {1 + 1} 1990' + "don't, Stefani 1986"
            year = Stefani(1987)
        '''
        expected = ["Brockett 1983", "Eising … 1984", "Laub 1979", "Stefani 1986"]
        self.assertEqual(references.missing_in_file(source, self.ENTRIES, ".py"), expected)
        model = '# A car (Brockett 1983; Eising, Letters 4, 1984)\nsteps = 2000 # (Chow 1939)\nname = "Laub 1979"\n'
        self.assertEqual(references.missing_in_file(model, self.ENTRIES, ".toml"), ["Brockett 1983", "Eising … 1984", "Laub 1979"])

    def test_names_may_consist_of_several_words(self):
        text = "Den Hartog 1931, Pesch and von Stryk 1993; Dupont and Canudas de Wit (1994), Da Lio and Teel 2018, Bernoulli 1696."
        expected = ["Bernoulli 1696", "Da Lio, Teel 2018", "Den Hartog 1931", "Dupont, Canudas de Wit 1994", "Pesch, von Stryk 1993"]
        self.assertEqual(references.missing(text, self.ENTRIES), expected)


class Words(unittest.TestCase):
    def places(self, text):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["git", "init"], cwd=folder, check=True, capture_output=True)
            (pathlib.Path(folder) / "a.md").write_text(text)
            subprocess.run(["git", "add", "a.md"], cwd=folder, check=True, capture_output=True)
            return list(words.places(pathlib.Path(folder)))

    def test_a_turn_is_found_with_its_place(self):
        spelled = "col" + "our"
        self.assertEqual(self.places(f"Good.\nThe {spelled} is red.\n"), [f"a.md:2: `{spelled}`: write color"])

    def test_a_turn_of_documents_may_stand_in_code(self):
        self.assertEqual(self.places("`it_is_refused` is a test.\n"), [])
        self.assertEqual(self.places("It is refused.\n"), ["a.md:1: `refused`: write rejected"])

    def test_an_old_key_is_exempt(self):
        self.assertEqual(self.places("`centre` is a key.\n"), [])


if __name__ == "__main__":
    unittest.main()
