//! Pictures of a study's results: the distribution of each result, and the sources of its variance.

use anyhow::{Context, Result};
use report::{Axis, Chart, Colour, Mark, Series, chart};
use serde_json::Value;
use sweep::Store;
use sweep::file_names::{SENSITIVITY, SENSITIVITY_PICTURE, STATISTICS, STATISTICS_PICTURE};

/// Size of a panel without bars of indices, px.
const PANEL: (u32, u32) = (420, 260);
/// Height of a quantity's two bars, px.
const BARS_PX: u32 = 44;
/// Number of panels side by side.
const COLUMNS: usize = 2;

/// Draws a result; `None` if it has no value.
type Draw = fn(&Value) -> Result<Option<String>>;

/// The pictures and their source files.
const PICTURES: [(&str, &str, Draw); 2] =
    [(STATISTICS, STATISTICS_PICTURE, of_statistics), (SENSITIVITY, SENSITIVITY_PICTURE, of_sensitivity)];

/// Draws the results of a study written by a run; returns the names of the pictures.
///
/// # Errors
/// If a result cannot be read, or a picture cannot be drawn or written.
pub fn write(store: &dyn Store, results: &[&str]) -> Result<Vec<&'static str>> {
    let mut written = Vec::new();
    for (source, name, draw) in PICTURES.iter().filter(|(source, ..)| results.contains(source)) {
        let path = |name: &str| store.location().join(name).display().to_string();
        let Some(text) = store.read(source).with_context(|| path(source))? else { continue };
        let Some(picture) = draw(&serde_json::from_slice(&text)?)? else { continue };
        // A finished study does not require a writable folder.
        if store.read(name).with_context(|| path(name))?.as_deref() != Some(picture.as_bytes()) {
            store.write(name, picture.as_bytes()).with_context(|| path(name))?;
        }
        written.push(*name);
    }
    Ok(written)
}

/// Each result's histogram, if the study has one, otherwise its distribution from the quantiles.
fn of_statistics(statistics: &Value) -> Result<Option<String>> {
    let columns = statistics["columns"].as_object().into_iter().flatten();
    let named: Vec<(String, &Value)> = columns
        .filter(|(_, column)| column["count"].as_u64().is_some_and(|count| count > 0))
        .map(|(name, column)| (format!("{name}, {}", column["unit"].as_str().unwrap_or("1")), column))
        .collect();
    let panels: Vec<Chart<'_>> = named
        .iter()
        .map(|(name, column)| {
            let histogram = column.get("histogram").map(steps).filter(|steps| !steps.is_empty());
            let is_histogram = histogram.is_some();
            let points = histogram.unwrap_or_else(|| distribution(column));
            let line = Series { points, colour: Colour::After, label: "", mark: Mark::Line(1.6) };
            let dots = Series { mark: Mark::Dots(3.0), ..line.clone() };
            Chart {
                x: Axis::new(name),
                y: if is_histogram { Axis::new("rows") } else { Axis::new("share of rows below").over(0.0, 1.0) },
                series: if is_histogram { vec![line] } else { vec![line, dots] },
                size: PANEL,
                ..Chart::default()
            }
        })
        .collect();
    sheet("Distribution of the results", statistics, &panels)
}

/// The outline of a histogram.
fn steps(histogram: &Value) -> Vec<(f64, f64)> {
    let numbers =
        |key: &str| -> Vec<f64> { histogram[key].as_array().into_iter().flatten().filter_map(Value::as_f64).collect() };
    let (edges, counts) = (numbers("edges"), numbers("counts"));
    let ends = edges.first().zip(edges.last()).map(|(first, last)| [(*first, 0.0), (*last, 0.0)]);
    let Some([first, last]) = ends else { return Vec::new() };
    let tops = edges.windows(2).zip(&counts).flat_map(|(edge, count)| [(edge[0], *count), (edge[1], *count)]);
    std::iter::once(first).chain(tops).chain([last]).collect()
}

/// Distribution function of a result from its quantiles, from the smallest to the largest value.
fn distribution(column: &Value) -> Vec<(f64, f64)> {
    let extreme = |key: &str, probability: f64| column[key]["value"].as_f64().map(|value| (value, probability));
    let quantiles = column["quantiles"].as_array().into_iter().flatten();
    let quantiles = quantiles.filter_map(|q| Some((q["value"].as_f64()?, q["probability"].as_f64()?)));
    let mut points: Vec<(f64, f64)> = extreme("minimum", 0.0).into_iter().chain(quantiles).collect();
    points.extend(extreme("maximum", 1.0));
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    points
}

/// Bars of the first- and total-order indices of each result, with their 95 % intervals.
fn of_sensitivity(sensitivity: &Value) -> Result<Option<String>> {
    let outputs = sensitivity["outputs"].as_object().into_iter().flatten();
    let panels: Vec<Chart<'_>> = outputs.filter_map(|(name, output)| bars(name, output)).collect();
    sheet("Share of the variance of each result", sensitivity, &panels)
}

fn bars<'a>(name: &'a str, output: &'a Value) -> Option<Chart<'a>> {
    let first = output["first_order"].as_object()?;
    let count = first.len();
    let named: Vec<(f64, String)> =
        first.keys().enumerate().map(|(i, quantity)| ((count - i) as f64, short(quantity).to_owned())).collect();
    let (mut series, mut any) = (Vec::new(), false);
    for (key, label, colour, shift) in [
        ("first_order", "alone (first order)", Colour::After, 0.16),
        ("total_order", "with others (total order)", Colour::Before, -0.16),
    ] {
        let (mut bars, mut whiskers) = (Vec::new(), Vec::new());
        for ((at, _), index) in named.iter().zip(output[key].as_object()?.values()) {
            let (Some(value), Some(half)) = (index["value"].as_f64(), index["ci95"].as_f64()) else { continue };
            any = true;
            bars.extend([(0.0, at + shift), (value, at + shift)]);
            whiskers.extend([(value - half, at + shift), (value + half, at + shift)]);
        }
        series.push(Series { points: bars, colour, label, mark: Mark::Segments(9.0) });
        series.push(Series { points: whiskers, colour: Colour::Ink, label: "", mark: Mark::Segments(1.2) });
    }
    let y = Axis { named, ..Axis::new("").over(0.4, count as f64 + 0.6) };
    any.then(|| Chart {
        title: name,
        x: Axis::new("share of the variance, 1"),
        y,
        series,
        size: (PANEL.0, 90 + BARS_PX * count as u32),
        ..Chart::default()
    })
}

/// A quantity's name without the prefix `effect.`.
fn short(quantity: &str) -> &str {
    quantity.strip_prefix("effect.").unwrap_or(quantity)
}

fn sheet(title: &str, of: &Value, panels: &[Chart<'_>]) -> Result<Option<String>> {
    if panels.is_empty() {
        return Ok(None);
    }
    let study = of["study"].as_str().unwrap_or_default();
    Ok(Some(chart::sheet(&format!("{title}: {study}"), panels, COLUMNS)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_histogram_s_outline_has_each_count_between_its_edges() {
        let outline = steps(&json!({ "edges": [0.0, 1.0, 3.0], "counts": [5, 2] }));
        assert_eq!(outline, [(0.0, 0.0), (0.0, 5.0), (1.0, 5.0), (1.0, 2.0), (3.0, 2.0), (3.0, 0.0)]);
    }

    #[test]
    fn pictures_name_every_result_with_its_unit_and_every_quantity() {
        let quantiles = json!([{ "probability": 0.5, "value": 2.0 }]);
        let column = json!({ "unit": "Pa", "count": 3, "minimum": { "value": 1.0 }, "maximum": { "value": 4.0 }, "quantiles": quantiles });
        let picture =
            of_statistics(&json!({ "study": "s", "columns": { "pressure_peak_pa": column } })).unwrap().unwrap();
        assert!(picture.contains("pressure_peak_pa, Pa") && picture.contains("share of rows below"));
        let index = |value: f64| json!({ "bore_m": { "value": value, "ci95": 0.1 }, "effect.leakage.conductance_m3_per_s_pa": { "value": 0.2, "ci95": 0.1 } });
        let outputs = json!({ "temperature_peak_k": { "first_order": index(0.5), "total_order": index(0.7) } });
        let picture = of_sensitivity(&json!({ "study": "s", "outputs": outputs })).unwrap().unwrap();
        for words in ["temperature_peak_k", "bore_m", "leakage.conductance_m3_per_s_pa", "total order"] {
            assert!(picture.contains(words), "{words}");
        }
    }

    #[test]
    fn results_without_a_value_have_no_picture() {
        let null = json!({ "bore_m": { "value": null, "ci95": null } });
        let outputs = json!({ "time_constant_s": { "first_order": &null, "total_order": &null } });
        assert_eq!(of_sensitivity(&json!({ "study": "s", "outputs": outputs })).unwrap(), None);
        assert_eq!(of_statistics(&json!({ "study": "s", "columns": { "a": { "count": 0 } } })).unwrap(), None);
    }
}
