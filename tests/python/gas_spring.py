"""The loop on a measured gas spring: `diagnose` on each record, `validate` on the other one, from the rig files alone.

    python tests/python/gas_spring.py PROGRAM --page results/gas_spring.md

The records are not part of this project (see rigs/mbari-upper.toml for where they are published).
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RECORDS = ROOT.parent / "shared/data/mbari"
CHAMBERS = ["upper", "lower"]
NAMES = ["moves", "friction"]
PSI = 6894.757293168


def is_there():
    """Whether the records exist where the rig files expect them."""
    return (RECORDS / "2021.07.26T10.51.44.exp").exists() and (RECORDS / "FrictionIDMovesWithBiasCurr.exp").exists()


def run(program, *arguments):
    """Runs the program from the project's root and returns its JSON."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.json"
        subprocess.run([program, *arguments, "--json", out], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text())


def diagnose(program, rig, model):
    """Diagnoses a rig and writes the model: returns the findings, the time in seconds, and the error on its own records."""
    begun = time.perf_counter()
    found = run(program, "diagnose", f"rigs/mbari-{rig}.toml", "-o", model)
    return {"found": found, "seconds": time.perf_counter() - begun, "own": found["after"]["rmse_pa"]["fit"] / PSI}


def loop(program, chamber, name, folder):
    """A model from one record, and its error on the other."""
    model = Path(folder) / f"{chamber}-{name}.toml"
    other = f"rigs/mbari-{chamber}-{NAMES[1 - NAMES.index(name)]}.toml"
    return diagnose(program, f"{chamber}-{name}", model) | {
        "other_whole": run(program, "validate", model, other, "--whole-record")["rmse_pa"] / PSI,
        "other_begin": run(program, "validate", model, other)["rmse_pa"] / PSI,
    }


def section(title, one, left_out, beyond=""):
    """The findings of one diagnosis, step by step."""
    found = one["found"]
    lines = [f"## {title}", "", f"| model | own | {left_out} |", "|---|---|---|"]
    for step in found["steps"]:
        terms = " + ".join(step["effects"]) or "the paper's"
        lines.append(f"| {terms} | {step['rmse_pa']['fit'] / PSI:.3f} | {step['rmse_pa']['held_out'] / PSI:.3f} |")
    lines += ["", f"Verdict **{found['verdict']}** in {one['seconds']:.0f} s; systematic part that remains: {found['remaining_pa'] / PSI:.3f} psi.{beyond}", ""]
    if found["missing"]:
        first = found["missing"][0]
        lines += [f"What remains is best described as a {first['quantity']} that follows the {first['variable']} ({first['balance']} balance).", ""]
    return lines


def page(program):
    """The page: each step's error, the error on the other record, and what remains unexplained."""
    lines = [
        "# A measured gas spring", "",
        "Written by `python tests/python/gas_spring.py PROGRAM --page results/gas_spring.md`: `pneutherm diagnose` on each record of each",
        "chamber, then `pneutherm validate` of that model on the other record; at last `pneutherm diagnose` on both records of a chamber,",
        "where each is left out in turn. Errors in psi rms; the records are those of `rigs/mbari-*.toml`.",
        "The noise of the recording is the rounding of its readings to 0.1 psi, about 0.03 psi.", "",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for chamber in CHAMBERS:
            for name in NAMES:
                one = loop(program, chamber, name, folder)
                beyond = (
                    f" On the other record: **{one['other_whole']:.3f}** with its own numbers from all of it, "
                    f"**{one['other_begin']:.3f}** with those from its start and first move."
                )
                lines += section(f"{chamber.capitalize()} chamber, from the record `{name}`", one, "left-out third", beyond)
        for chamber in CHAMBERS:
            both = diagnose(program, chamber, Path(folder) / f"{chamber}.toml")
            lines += section(f"{chamber.capitalize()} chamber, from both records", both, "left-out record")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--page", type=Path, required=True)
    options = parser.parse_args()
    if not is_there():
        raise SystemExit("the measured records are not here: see rigs/mbari-upper.toml")
    options.page.write_text(page(options.program.resolve()))
