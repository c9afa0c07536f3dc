//! The charts of a diagnosis: every record with its repeats, the push, the position, and views of the residual.

use super::spectrum;
use identify::Diagnosed;
use identify::discrepancy::Variable;
use identify::outcome::empirical::Empirical;
use identify::outcome::unnamed::Unnamed;
use identify::record::data::Prepared;
use identify::record::stroke::Phase;
use report::Error;
use report::document::Drawing;
use report::{Axis, Chart, Colour, Mark, Series, chart};

const SIZE: (u32, u32) = (440, 310);
/// Height of the position chart below the pressure.
const POSITION_HEIGHT: u32 = 125;
/// Range shown around a push: this fraction of its length before it, and this multiple after its end.
const AROUND_PUSH: [f64; 2] = [0.4, 1.6];

type Points = Vec<(f64, f64)>;

fn drawn(chart: &Chart<'_>) -> Result<Drawing, Error> {
    Ok(Drawing { svg: chart.draw()?, caption: String::new() })
}

/// Whether a model beyond the paper's was found.
fn has_after(found: &Diagnosed) -> bool {
    found.diagnosis.steps.len() > 1
}

fn line(points: Points, colour: Colour, label: &'static str, width: f64) -> Series<'static> {
    Series { points, colour, label, mark: Mark::Line(width) }
}

/// Data rows of a record, as points.
fn rows(t: &Prepared, value: impl Fn(usize) -> f64) -> Points {
    (0..t.time_s.len()).filter(|&i| t.readout.is_data(i)).map(|i| (t.time_s[i], value(i))).collect()
}

/// The drawings of one experiment: pressure, the push, position, residual.
pub fn experiment(found: &Diagnosed, number: usize) -> Result<Vec<Drawing>, Error> {
    let records: Vec<usize> =
        (0..found.data.traces.len()).filter(|k| found.data.traces[*k].experiment == number).collect();
    let window = records.first().and_then(|k| push_window(&found.data.traces[*k]));
    let mut lines = Lines { window, ..Lines::default() };
    for (nth, &k) in records.iter().enumerate() {
        lines.add(found, k, nth == 0);
    }
    let name = found.data.experiments.get(number).map_or("", String::as_str);
    lines.drawn(name, found.diagnosis.noise_pa)
}

/// Lines drawn for an experiment's records, before and after the diagnosis.
#[derive(Default)]
struct Lines {
    pressure: Vec<Series<'static>>,
    position: Vec<Series<'static>>,
    /// The pressure around the push, on the clock of the first record.
    push: Vec<Series<'static>>,
    /// Start and end of that range, s; `None` if no record has a push.
    window: Option<(f64, f64)>,
    residual_before: Vec<Series<'static>>,
    residual_after: Vec<Series<'static>>,
}

impl Lines {
    /// Adds a record; only the first one's lines have legend entries.
    fn add(&mut self, found: &Diagnosed, k: usize, is_first: bool) {
        let t = &found.data.traces[k];
        let label = |label: &'static str| if is_first { label } else { "" };
        let of_model = |residuals: &[f64]| rows(t, |i| (t.pressure_pa[i] - residuals[i]) * 1e-5);
        // Repeats do not start at the same moment.
        let shift = match (self.window, push_window(t)) {
            (Some(first), Some(this)) => this.0 - first.0,
            _ => 0.0,
        };
        let window = self.window;
        let near = |points: &Points| -> Points {
            let Some((from, to)) = window else { return Vec::new() };
            points.iter().map(|(x, y)| (x - shift, *y)).filter(|p| p.0 >= from && p.0 <= to).collect()
        };
        let measured = rows(t, |i| t.pressure_pa[i] * 1e-5);
        self.push.push(Series {
            points: near(&measured),
            colour: Colour::Ink,
            label: label("measured"),
            mark: Mark::Rings(1.8),
        });
        self.pressure.push(line(measured, Colour::Ink, label("measured"), 2.2));
        let before = of_model(&found.residuals_before[k]);
        self.push.push(line(near(&before), Colour::Before, label("before"), 1.2));
        self.pressure.push(line(before, Colour::Before, label("before"), 1.0));
        let residual = rows(t, |i| found.residuals_before[k][i]);
        self.residual_before.push(line(residual, Colour::Before, label("before"), 0.8));
        if has_after(found) {
            let after = of_model(&found.residuals_after[k]);
            self.push.push(line(near(&after), Colour::After, label("after"), 1.4));
            self.pressure.push(line(after, Colour::After, label("after"), 1.0));
            let residual = rows(t, |i| found.residuals_after[k][i]);
            self.residual_after.push(line(residual, Colour::After, label("after"), 0.8));
        }
        let way = (0..t.time_s.len()).map(|i| (t.time_s[i], t.position_m[i] * 1e3)).collect();
        self.position.push(line(way, Colour::Ink, "", 1.2));
    }

    fn drawn(self, name: &str, noise_pa: f64) -> Result<Vec<Drawing>, Error> {
        let time = || Axis::new("time, s");
        let titles = ["pressure and position", "the push", "residual"].map(|what| format!("{name}: {what}"));
        let above = Chart {
            title: &titles[0],
            y: Axis::new("pressure, bar"),
            series: self.pressure,
            size: (SIZE.0, SIZE.1 - POSITION_HEIGHT),
            ..Chart::default()
        };
        let below = Chart {
            x: time(),
            y: Axis::new("position, mm"),
            series: self.position,
            size: (SIZE.0, POSITION_HEIGHT),
            ..Chart::default()
        };
        let mut drawings = vec![Drawing { svg: chart::sheet("", &[above, below], 1)?, caption: String::new() }];
        if self.window.is_some() {
            let y = Axis::new("pressure, bar");
            let zoom = Chart { title: &titles[1], x: time(), y, series: self.push, size: SIZE, ..Chart::default() };
            drawings.push(drawn(&zoom)?);
        }
        drawings.push(drawn(&Chart {
            title: &titles[2],
            x: time(),
            y: Axis::new("residual, Pa"),
            band: Some(2.0 * noise_pa),
            series: self.residual_before.into_iter().chain(self.residual_after).collect(),
            size: SIZE,
            ..Chart::default()
        })?);
        Ok(drawings)
    }
}

/// Start and end of the range shown around a record's first push, s.
fn push_window(t: &Prepared) -> Option<(f64, f64)> {
    let push = t.course.motion.segments.iter().find(|s| s.phase == Phase::Move)?;
    let length = push.to_s - push.from_s;
    Some((push.from_s - AROUND_PUSH[0] * length, push.to_s + AROUND_PUSH[1] * length))
}

/// The residual as a function of gas variables, and its spectrum.
pub fn residuals(found: &Diagnosed) -> Result<Vec<Drawing>, Error> {
    let mut charts = vec![spectrum_chart(found)];
    let named: Vec<(Variable, String)> = [
        Variable::Pressure,
        Variable::TemperatureDifference,
        Variable::Speed,
        Variable::PressureRate,
        Variable::SinceMove,
    ]
    .into_iter()
    .map(|v| (v, format!("{}, {}", v.name().0, shown(v.name().1).0)))
    .collect();
    for (variable, name) in &named {
        let series = sides(found)
            .into_iter()
            .map(|(residuals, colour, label)| Series {
                points: block_means(found, residuals, *variable),
                colour,
                label,
                mark: Mark::Dots(1.4),
            })
            .collect();
        charts.push(Chart {
            x: Axis::new(name),
            y: Axis::new("residual, Pa"),
            band: Some(2.0 * found.diagnosis.noise_pa),
            series,
            size: SIZE,
            ..Chart::default()
        });
    }
    charts.iter().map(drawn).collect()
}

/// The display unit for an SI unit in charts, and its factor.
fn shown(si: &'static str) -> (&'static str, f64) {
    match si {
        "Pa" => ("bar", 1e-5),
        "Pa/s" => ("bar/s", 1e-5),
        "m" => ("mm", 1e3),
        "kg/s" => ("mg/s", 1e6),
        "kg" => ("g", 1e3),
        other => (other, 1.0),
    }
}

type Side<'a> = (&'a [Vec<f64>], Colour, &'static str);

fn sides(found: &Diagnosed) -> Vec<Side<'_>> {
    let mut sides: Vec<Side<'_>> = vec![(&found.residuals_before, Colour::Before, "before")];
    if has_after(found) {
        sides.push((&found.residuals_after, Colour::After, "after"));
    }
    sides
}

fn block_means(found: &Diagnosed, residuals: &[Vec<f64>], variable: Variable) -> Points {
    let mut points = Vec::new();
    let (_, per_si) = shown(variable.name().1);
    for ((t, path), r) in found.data.traces.iter().zip(&found.paths).zip(residuals) {
        let values = path.variable(variable);
        for b in &t.blocks {
            let mean = |v: &[f64]| v[b.first..b.end].iter().sum::<f64>() / (b.end - b.first) as f64;
            points.push((per_si * mean(&values), mean(r)));
        }
    }
    let step = points.len().div_ceil(500).max(1);
    points.into_iter().step_by(step).collect()
}

fn spectrum_chart(found: &Diagnosed) -> Chart<'static> {
    let noise = &found.diagnosis.noise;
    let mut series: Vec<Series<'static>> = sides(found)
        .into_iter()
        .map(|(residuals, colour, label)| {
            let of: Vec<(f64, Vec<f64>)> = found
                .data
                .traces
                .iter()
                .zip(residuals)
                .map(|(t, r)| {
                    (t.row_s() * t.readout.readings.period(), rows(t, |i| r[i]).into_iter().map(|p| p.1).collect())
                })
                .collect();
            let borrowed: Vec<(f64, &[f64])> = of.iter().map(|(s, r)| (*s, r.as_slice())).collect();
            line(spectrum::density(&borrowed), colour, label, 1.3)
        })
        .collect();
    let ends: Vec<f64> = series.iter().flat_map(|s| &s.points).map(|p| p.0).collect();
    let (low, high) = ends.iter().fold((f64::MAX, f64::MIN), |(l, h), f| (l.min(*f), h.max(*f)));
    if noise.white_pa > 0.0 && low < high {
        let white = noise.white_pa / high.sqrt();
        series.push(Series {
            points: vec![(low, white), (high, white)],
            colour: Colour::Pale,
            label: "white noise",
            mark: Mark::Dashed(1.3),
        });
    }
    let logarithmic = |name| Axis { logarithmic: true, ..Axis::new(name) };
    Chart {
        title: "Spectrum of the residual",
        x: logarithmic("frequency, Hz"),
        y: logarithmic("density, Pa/√Hz"),
        series,
        size: SIZE,
        ..Chart::default()
    }
}

/// A missing term as a curve, with a band of ±2 standard deviations.
pub fn missing(m: &Unnamed, caption: String) -> Result<Drawing, Error> {
    let known = m.value.iter().zip(&m.sd);
    let term = Term {
        title: format!("explains {:.0} % of the residual beyond noise", 100.0 * m.share),
        x: m.subject.variable.name(),
        y: m.subject.quantity(),
        at: &m.at,
        values: &m.value,
        band: known.map(|(value, sd)| [value - 2.0 * sd, value + 2.0 * sd]).collect(),
    };
    term.drawn(caption)
}

/// The refitted curve of a missing term, with its 95 % intervals.
pub fn empirical(e: &Empirical, caption: String) -> Result<Drawing, Error> {
    let title = if e.fate.is_accepted() { "in the model".to_owned() } else { format!("rejected: {}", e.fate.words()) };
    let term = Term {
        title,
        x: e.subject.variable.name(),
        y: e.subject.quantity(),
        at: &e.knots,
        values: &e.values,
        band: e.ci95.clone(),
    };
    term.drawn(caption)
}

/// A term over its variable; names with their SI units.
struct Term<'a> {
    title: String,
    x: (&'static str, &'static str),
    y: (&'static str, &'static str),
    at: &'a [f64],
    values: &'a [f64],
    band: Vec<[f64; 2]>,
}

impl Term<'_> {
    fn drawn(&self, caption: String) -> Result<Drawing, Error> {
        let (x_unit, along) = shown(self.x.1);
        // An error of the reading is small, so pascals are suitable.
        let (y_unit, up) = if self.y.1 == "Pa" { ("Pa", 1.0) } else { shown(self.y.1) };
        let ends = self.at.iter().zip(&self.band).flat_map(|(at, ends)| ends.map(|end| (along * at, up * end)));
        let curve: Points = self.at.iter().zip(self.values).map(|(at, value)| (along * at, up * value)).collect();
        // Shortened to fit the axis, and without a unit if dimensionless.
        let name =
            self.y.0.replace("heat transfer coefficient", "coefficient λ").replace("pressure reading", "reading");
        let y = if y_unit == "1" { name } else { format!("{name}, {y_unit}") };
        let x = format!("{}, {x_unit}", self.x.0);
        let chart = Chart {
            title: &self.title,
            x: Axis::new(&x),
            y: Axis::new(&y),
            series: vec![
                Series { points: ends.collect(), colour: Colour::Pale, label: "", mark: Mark::Segments(1.3) },
                line(curve, Colour::After, "", 1.6),
            ],
            size: SIZE,
            ..Chart::default()
        };
        Ok(Drawing { svg: chart.draw()?, caption })
    }
}
