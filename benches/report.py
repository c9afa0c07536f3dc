"""From measured seconds to the report: medians, spreads, ratios, and which aims are met."""

import dataclasses
import statistics
import time

from table import EFFECTS


@dataclasses.dataclass
class Result:
    """What a contender did."""

    name: str
    group: str
    note: str
    options: dict
    rows: int
    study: str
    rates: list  # scenarios/s, one for each repetition
    peak_memory: int  # bytes, of all its processes
    peak_error: float
    final_error: float

    @classmethod
    def of(cls, entry, seconds, memory, peak, final):
        rates = [entry.rows / s for s in seconds]
        return cls(
            entry.name, entry.group, entry.note, entry.options, entry.rows, entry.study, rates, memory, peak, final
        )

    @property
    def rate(self):
        return statistics.median(self.rates)

    @property
    def error(self):
        return max(self.peak_error, self.final_error)


def readable(rate):
    """A rate with its unit."""
    if rate >= 1e5:
        return f"{rate / 1e6:.2f} M/s"
    return f"{rate / 1e3:.2f} k/s" if rate >= 1e3 else f"{rate:.0f} /s"


def ratio(one, other):
    """How many times faster one result is than the other; zero where one is missing."""
    return one.rate / other.rate if one and other else 0.0


@dataclasses.dataclass
class Outcome:
    """All results of a run."""

    results: list
    checks: dict
    machine: dict

    def best(self, condition, error):
        """The fastest of those that are at least so accurate."""
        good = [r for r in self.results if condition(r) and r.error <= error]
        return max(good, key=lambda r: r.rate, default=None)

    def aims(self):
        """Sentence, number reached, number asked, met or not."""
        lines = self.aims_when_sealed() + [line for study in EFFECTS for line in self.aims_with_effects(study)]
        return [(text, reached, asked, reached >= asked) for text, reached, asked in lines]

    def aims_with_effects(self, study):
        """Ours beside heyoka's best on the same equations, and beside ours without the effect."""
        ours = lambda r: r.group == "ours" and r.study == study
        full = lambda r: ours(r) and not r.options.get("auto")
        sealed = lambda r: r.group == "ours" and r.study == "sealed" and not r.options.get("auto")
        heyoka = lambda r: r.name.startswith("heyoka") and r.study == study
        effect = EFFECTS[study]
        share = 1 / 3 if study == "flows" else 1 / 4
        lines = []
        for kind, name in [(full, "full equations")] + [(ours, "as it comes")] * (study != "flows"):
            for error in (1e-8, 1.5e-10):
                best = self.best(heyoka, error)
                if best:
                    text = f"{effect}, {name}, over heyoka's best on the same equations, ≤ {error:.2g}".replace("e-0", "e-")
                    lines.append((text, ratio(self.best(kind, error), best), 3.0))
        kind, name = (full, "full equations") if study == "flows" else (ours, "as it comes")
        lines.append((f"{effect}, {name}, over sealed full equations, ≤ 1e-8", ratio(self.best(kind, 1e-8), self.best(sealed, 1e-8)), share))
        return lines

    def aims_when_sealed(self):
        """On the rows of the paper's test."""
        ours = lambda r: r.group == "ours" and r.study == "sealed" and not r.options.get("auto")
        heyoka = lambda r: r.name.startswith("heyoka") and r.study == "sealed"
        plain = lambda r: r.name == "heyoka, plain, 8 wide"
        fmpy = lambda r: r.name == "FMPy, push and hold only"
        trace = lambda r: r.name == "FMPy, a trace of 100 Hz"
        other = lambda r: r.group == "peer" and r.study == "sealed"
        one = lambda name: next((r for r in self.results if r.name == name), None)
        loose, tight = self.best(ours, 1e-8), self.best(ours, 1.5e-10)
        process = lambda solver: self.best(lambda r: r.group == "whole" and r.options.get("solver") == solver, 1e-8)
        fit = one("full equations and the paper's regression, rtol 1e-10")
        exact_fit = one("exact solution and the paper's regression")
        return [
            ("full equations at ≤ 1e-8, M/s", (loose.rate if loose else 0) / 1e6, 3.0),
            ("over heyoka's plain equations in batches of the SIMD width, ≤ 1e-8", ratio(loose, self.best(plain, 1e-8)), 2.4),
            ("over heyoka's best of all formulations, ≤ 1e-8", ratio(loose, self.best(heyoka, 1e-8)), 2.4),
            ("over heyoka's best of all formulations, ≤ 1.5e-10", ratio(tight, self.best(heyoka, 1.5e-10)), 1.6),
            ("over the fastest peer of all, ≤ 1e-8", ratio(loose, self.best(other, 1e-8)), 1.0),
            ("over the fastest peer of all, ≤ 1.5e-10", ratio(tight, self.best(other, 1.5e-10)), 1.0),
            ("over FMPy's simulate_fmu, a trace of 100 Hz", ratio(loose, self.best(trace, 1)), 1000.0),
            ("over FMPy's simulate_fmu, push and hold only", ratio(loose, self.best(fmpy, 1)), 1000.0),
            ("with the paper's regression, full equations, M/s", (fit.rate if fit else 0) / 1e6, 1.0),
            ("with the paper's regression, exact solution, M/s", (exact_fit.rate if exact_fit else 0) / 1e6, 1.0),
            ("whole process with Parquet, full equations, over heyoka's best integration alone", ratio(process("adaptive"), self.best(heyoka, 1e-8)), 2.0),
            ("whole process with Parquet, as it comes, over heyoka's best integration alone", ratio(process("auto"), self.best(heyoka, 1e-8)), 2.0),
        ]

    def table(self, results):
        """The results, the fastest first, beside heyoka's best on the same rows."""
        study = results[0].study if results else None
        heyoka = self.best(lambda r: r.name.startswith("heyoka") and r.study == study, 1e-8)
        times = lambda r: f"{ratio(r, heyoka):.3g}" if heyoka else "-"
        lines = [
            "| | scenarios a second (slowest to fastest) | error, peak | error, final | memory, MB | x heyoka's best |",
            "|---|---|---|---|---|---|",
        ]
        for r in sorted(results, key=lambda r: -r.rate):
            spread = f"{readable(min(r.rates))} to {readable(max(r.rates))}"
            rtol = f"rtol {r.options['tolerance']:.0e}".replace("e-0", "e-") if "tolerance" in r.options else ""
            detail = "; ".join(part for part in (r.note, rtol if rtol not in r.name else "") if part)
            name = f"**{r.name}**" if r.group != "peer" else r.name
            label = f"{name}<br>{detail}" if detail else name
            lines.append(
                f"| {label} | {readable(r.rate)} ({spread}) | {r.peak_error:.1e} | {r.final_error:.1e} "
                f"| {r.peak_memory / 1e6:.0f} | {times(r)} |"
            )
        return "\n".join(lines)

    def markdown(self):
        m = self.machine
        versions = ", ".join(f"{name} {number}" for name, number in m["versions"].items())
        aims = "\n".join(
            f"| {text} | {reached:.3g} | {asked:.3g} | {'yes' if met else '**no**'} |" for text, reached, asked, met in self.aims()
        )
        checks = "; ".join(f"{text}: {value:.1e}" for text, value in self.checks.items())
        return f"""# Benchmarks

Written by `benches/run` on {time.strftime('%Y-%m-%d')}, commit {m['commit']}. Not to be edited.

{m['processor']}, {m['cores']} cores, AVX-512 {'yes' if m['avx512'] else 'no'}, {m['system']}.
{versions}.

**Problem.** The sealed push-and-hold test of the paper: 0.04 s of linear push, 5 s of hold, 131,072 random rows of the Latin
hypercube in `benches/sealed.toml` (bore, dead volume, pressure, both strokes, coefficient). Wanted: pressure at the end of
the push and of the hold. Everyone gets the same rows, all on {m['cores']} cores, in turn, several repetitions; medians. Slow ones
solve the first of the rows only. **Error**: the largest relative one over the rows, against the closed form.
({checks}.) **Memory**: the most that all processes of a contender held together, scenarios and answers included; a contender
in Python is three processes.

## Full equations, ours and the peers

{self.table([r for r in self.results if r.study == "sealed" and r.group in ("ours", "peer")])}

## With effects: the same equations by ours, heyoka and diffsol

The same rows with one effect, or two flows, in each. Errors are those of 1,024 rows against scipy's DOP853 at rtol 1e-12,
with the equations as tests/python/reference.py states them. heyoka's best is the fastest form with an error of at most 1e-8.

{self.tables_with_effects()}

## Ours with more to do, and as a whole process

{self.table([r for r in self.results if r.group in ("ours, more", "whole")])}

The whole process is `pneutherm sweep` from its start to the synced manifest, {self.rows_of_whole():,} rows with `fit = false`; ours
otherwise is the batch kernel as the program calls it, which also finds settling time, temperatures and energy closure.

## Aims

| aim | reached | asked | met |
|---|---|---|---|
{aims}

## How the peers were written

Sealed, all integrate dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V'/V) with P = m R T/V: push and hold apart, so that no step crosses
the kink, and rows alike in stiffness together wherever steps are shared. heyoka, diffrax, scipy and FMPy run in two processes,
one for each core, compiled before the clock starts; the crates on two threads, compiled for this processor (ours is the
plain x86-64 build that is shipped). heyoka in batches of its SIMD width spends its time in Python's loop, so wider batches are
shown too, and the same equations with the root of the volume as independent variable, which need no root. Crates that know
nothing of lanes become several times faster with many rows as one system with common steps: also shown, though a row then
depends on its neighbours, which ours does not. With effects, heyoka has each set of equations in the forms that suit Taylor
series: powers of the volume as exponentials or as states, a leak's laws parted by events, the hold of natural convection with
the logarithm or a power of T − Tw. The sources are in `benches/contenders` and `benches/rust`.
"""

    def tables_with_effects(self):
        """A table for each study with effects."""
        of = lambda study: [r for r in self.results if r.study == study]
        return "\n\n".join(f"### {EFFECTS[study].capitalize()}\n\n{self.table(of(study))}" for study in EFFECTS)

    def rows_of_whole(self):
        return next((r.rows for r in self.results if r.group == "whole"), 0)

    def plain(self):
        """For programs."""
        results = [{**dataclasses.asdict(r), "rate": r.rate} for r in self.results]
        aims = [dict(zip(("aim", "reached", "asked", "met"), line)) for line in self.aims()]
        return {"machine": self.machine, "checks": self.checks, "results": results, "aims": aims}
