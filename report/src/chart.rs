//! Charts as SVG, drawn with `plotters`: title and legend on top, units on the axes.

use crate::Error;
use crate::axis::{Axis, Ticks};
use crate::canvas::{Along, Area, Canvas, GRID, INK, LABEL_PX, NOISE, TITLE_PX, UNITS, failed, on, text, units};
use crate::page::without_control;
use crate::series::{self, Series};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A chart of series on one pair of axes.
#[derive(Clone, Debug, Default)]
pub struct Chart<'a> {
    /// Title above the chart.
    pub title: &'a str,
    /// The horizontal axis.
    pub x: Axis<'a>,
    /// The vertical axis.
    pub y: Axis<'a>,
    /// Half width of the noise band around zero, in the vertical axis's unit.
    pub band: Option<f64>,
    /// The series, drawn in order.
    pub series: Vec<Series<'a>>,
    /// Texts centred above points.
    pub texts: Vec<(f64, f64, String)>,
    /// Width and height, px.
    pub size: (u32, u32),
}

/// Height of a legend row, or of the title, px.
const ROW_PX: f64 = 18.0;
/// Width of a letter of a label, px.
const LETTER_PX: f64 = 6.6;
/// Points per px of the chart's width above which they are thinned to the extremes of each interval.
const POINTS_A_PX: f64 = 1.0;

impl Chart<'_> {
    /// The chart as an SVG document.
    ///
    /// # Errors
    /// [`Error`]: the drawing failed.
    pub fn draw(&self) -> Result<String, Error> {
        sheet("", std::slice::from_ref(self), 1)
    }

    fn draw_on(&self, area: &Area<'_>) -> Result<(), Error> {
        let (x, y) = self.ticks();
        let top = self.draw_head(area)?;
        let longest = y.texts.iter().map(|t| t.chars().count()).max().unwrap_or(0) as f64;
        let left = 14.0 + LETTER_PX * longest + if self.y.name.is_empty() { 0.0 } else { 18.0 };
        let bottom = if self.x.name.is_empty() { 22.0 } else { 38.0 };
        let mut chart = ChartBuilder::on(area)
            .margin_top(units(top))
            .margin_right(units(16.0))
            .margin_left(units(2.0))
            .margin_bottom(units(4.0))
            .x_label_area_size(units(bottom))
            .y_label_area_size(units(left))
            .build_cartesian_2d(Along::new(&x), Along::new(&y))
            .map_err(failed)?;
        if let Some(band) = self.band {
            let corners = [(x.range[0], -band), (x.range[1], band)];
            chart.draw_series([Rectangle::new(corners, NOISE.filled())]).map_err(failed)?;
        }
        self.draw_axes(&mut chart, &x, &y)?;
        let most = (POINTS_A_PX * f64::from(self.size.0)) as usize;
        for series in &self.series {
            let placed = |p: &(f64, f64)| (self.x.position_of(p.0), self.y.position_of(p.1));
            let within = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite() && p.0 >= x.range[0] && p.0 <= x.range[1];
            let points: Vec<(f64, f64)> = series.points.iter().map(placed).filter(within).collect();
            series::draw(area, &mut chart, series, thinned(points, most))?;
        }
        for (x, y, words) in &self.texts {
            let (right, down) = on(area, &chart, (self.x.position_of(*x), self.y.position_of(*y)));
            let style = text(LABEL_PX).pos(Pos::new(HPos::Center, VPos::Bottom));
            area.draw(&Text::new(words.clone(), (right, down - units(5.0)), style)).map_err(failed)?;
        }
        Ok(())
    }

    /// Draws title and legend; returns their height including the space above, px.
    fn draw_head(&self, area: &Area<'_>) -> Result<f64, Error> {
        let legend = self.legend_rows();
        let title = if self.title.is_empty() { 0.0 } else { ROW_PX + 2.0 };
        if !self.title.is_empty() {
            let style = text(TITLE_PX).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(self.title.to_owned(), (units(10.0), units(4.0 + 0.5 * ROW_PX)), style))
                .map_err(failed)?;
        }
        for (row, entries) in legend.iter().enumerate() {
            let mut at = 10.0;
            let middle = 4.0 + title + ROW_PX * (row as f64 + 0.5);
            for series in entries {
                series::key(area, series, (at, middle))?;
                let style = text(LABEL_PX).pos(Pos::new(HPos::Left, VPos::Center));
                area.draw(&Text::new(series.label.to_owned(), (units(at + 30.0), units(middle)), style))
                    .map_err(failed)?;
                at += entry_px(series.label);
            }
        }
        Ok(8.0 + title + ROW_PX * legend.len() as f64)
    }

    /// Draws the axes with their names and ticks, and the grid.
    fn draw_axes(&self, chart: &mut Canvas<'_, '_>, x: &Ticks, y: &Ticks) -> Result<(), Error> {
        let mut mesh = chart.configure_mesh();
        if !self.x.name.is_empty() {
            mesh.x_desc(x.name(self.x.name));
        }
        if !self.y.name.is_empty() {
            mesh.y_desc(y.name(self.y.name));
        }
        mesh.axis_desc_style(text(LABEL_PX))
            .label_style(text(LABEL_PX))
            .x_label_formatter(&|v| x.text(*v))
            .y_label_formatter(&|v| y.text(*v))
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID.stroke_width(UNITS as u32))
            .axis_style(INK.stroke_width(UNITS as u32))
            .set_all_tick_mark_size(units(3.0))
            .draw()
            .map_err(failed)
    }

    /// Ticks of both axes for the data.
    fn ticks(&self) -> (Ticks, Ticks) {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        let points = self.series.iter().flat_map(|s| &s.points).filter(|p| p.0.is_finite() && p.1.is_finite());
        for (x, y) in points {
            range = [range[0].min(*x), range[1].max(*x), range[2].min(*y), range[3].max(*y)];
        }
        if range[0] > range[1] {
            range = [0.0, 1.0, 0.0, 1.0];
        }
        if let Some(band) = self.band {
            range = [range[0], range[1], range[2].min(-1.5 * band), range[3].max(1.5 * band)];
        }
        let (width, height) = self.size;
        let about = |px: u32, each: u32| (px / each).clamp(2, 8) as usize;
        (
            self.x.ticks(range[0], range[1], about(width, 75)),
            self.y.ticks(range[2], range[3], about(height.saturating_sub(70), 36)),
        )
    }

    /// The legend entries, in rows that fit the width.
    fn legend_rows(&self) -> Vec<Vec<&Series<'_>>> {
        let mut rows: Vec<Vec<&Series<'_>>> = Vec::new();
        let mut free = 0.0;
        for series in self.series.iter().filter(|s| !s.label.is_empty()) {
            let width = entry_px(series.label);
            match rows.last_mut() {
                Some(row) if width <= free => row.push(series),
                _ => {
                    rows.push(vec![series]);
                    free = f64::from(self.size.0) - 10.0;
                }
            }
            free -= width;
        }
        rows
    }
}

/// Width of a legend's entry, px.
fn entry_px(label: &str) -> f64 {
    30.0 + LETTER_PX * label.chars().count() as f64 + 16.0
}

/// Charts in a grid with this many columns, below a title, as one SVG document.
///
/// # Errors
/// [`Error`]: the drawing failed.
pub fn sheet(title: &str, charts: &[Chart<'_>], columns: usize) -> Result<String, Error> {
    let head = if title.is_empty() { 0 } else { 30 };
    let rows: Vec<&[Chart<'_>]> = charts.chunks(columns.max(1)).collect();
    let height = |row: &[Chart<'_>]| row.iter().map(|c| c.size.1).max().unwrap_or(0);
    let width = rows.iter().map(|row| row.iter().map(|c| c.size.0).sum::<u32>()).max().unwrap_or(0);
    let total = head + rows.iter().map(|row| height(row)).sum::<u32>();
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (units(width.into()) as u32, units(total.into()) as u32))
            .into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        if !title.is_empty() {
            let style = text(TITLE_PX + 1.0).pos(Pos::new(HPos::Left, VPos::Center));
            root.draw(&Text::new(title.to_owned(), (units(10.0), units(16.0)), style)).map_err(failed)?;
        }
        let mut top = head;
        for row in rows {
            let mut left = 0;
            for chart in row {
                let size = (units(chart.size.0.into()) as u32, units(chart.size.1.into()) as u32);
                let from = (units(left.into()), units(top.into()));
                let area = root.clone().shrink(from, size);
                chart.draw_on(&area)?;
                left += chart.size.0;
            }
            top += height(row);
        }
        root.present().map_err(failed)?;
    }
    let size = |each: f64| format!("<svg width=\"{}\" height=\"{}\"", each * f64::from(width), each * f64::from(total));
    Ok(without_control(&svg.replacen(&size(UNITS), &size(1.0), 1)))
}

/// At most `most` points, keeping the minimum and maximum of each interval.
fn thinned(points: Vec<(f64, f64)>, most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most {
        return points;
    }
    let size = points.len().div_ceil((most / 2).max(1));
    points
        .chunks(size)
        .flat_map(|chunk| {
            let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
            let low = chunk.iter().min_by(by_value).copied().unwrap_or_default();
            let high = chunk.iter().max_by(by_value).copied().unwrap_or_default();
            if low.0 <= high.0 { [low, high] } else { [high, low] }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::{Colour, Mark};

    #[test]
    fn thinning_keeps_the_extremes() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|k| (f64::from(k), 0.0)).collect();
        points[4321].1 = 7.0;
        points[8765].1 = -3.0;
        let few = thinned(points, 700);
        assert!(few.len() <= 702);
        assert!(few.contains(&(4321.0, 7.0)) && few.contains(&(8765.0, -3.0)));
    }

    fn chart(label: &'static str) -> Chart<'static> {
        let points = vec![(0.0, 1.0), (1.0, 3.0), (2.0, 2.0)];
        let series = |mark| Series { points: points.clone(), colour: Colour::After, label, mark };
        Chart {
            title: "a < b",
            x: Axis::new("time, s"),
            y: Axis::new("pressure, bar"),
            series: vec![series(Mark::Line(1.5)), series(Mark::Dots(2.0)), series(Mark::Squares(4.0, false))],
            size: (400, 250),
            ..Chart::default()
        }
    }

    #[test]
    fn a_chart_names_its_axes_and_its_series() {
        let svg = chart("model").draw().unwrap();
        for words in ["a &lt; b", "time, s", "pressure, bar", "model"] {
            assert!(svg.contains(words), "{words}");
        }
    }

    #[test]
    fn a_legend_that_does_not_fit_a_row_takes_another() {
        assert_eq!(chart("short").legend_rows().len(), 1);
        assert_eq!(chart("a label of forty characters, more or less").legend_rows().len(), 3);
    }

    #[test]
    fn charts_of_a_sheet_stand_side_by_side() {
        let svg = sheet("all of them", &[chart("a"), chart("b"), chart("c")], 2).unwrap();
        assert!(svg.contains("viewBox=\"0 0 1600 1060\""), "{}", &svg[..200]);
    }

    #[test]
    fn a_chart_by_itself_opens_at_its_size() {
        let svg = Chart { size: (640, 250), ..chart("model") }.draw().unwrap();
        assert!(svg.contains("<svg width=\"640\" height=\"250\" viewBox=\"0 0 1280 500\""), "{}", &svg[..200]);
    }
}
