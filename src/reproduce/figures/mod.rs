//! The figures, drawn with `plotters` as SVG: units on every axis, one palette that colour-blind readers can tell apart.
//!
//! Palette: M. Okabe and K. Ito, "Color Universal Design" (2008).

pub mod forms;
pub mod pressure_response;
pub mod time_constants;
pub mod trend;

use anyhow::{Result, anyhow};
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Black: measured or true.
pub const INK: RGBColor = RGBColor(30, 30, 30);
/// The paper's method, or the baseline.
pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
/// The exact regression, or what explains more.
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Grid lines.
pub const GRID: RGBColor = RGBColor(225, 225, 225);

/// Width of every figure, in SVG units.
pub const WIDTH: u32 = 900;

const FONT: &str = "sans-serif";

/// Draws on a white canvas of that height and returns the SVG.
pub fn drawing<F>(height: u32, draw: F) -> Result<String>
where
    F: FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Result<()>,
{
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        draw(&root)?;
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

/// A drawing error as one sentence.
pub fn failed(error: impl std::fmt::Display) -> anyhow::Error {
    anyhow!("a figure could not be drawn: {error}")
}

/// The legend of the labelled series, in the upper right corner.
pub fn legend<'a, T: CoordTranslate>(chart: &mut ChartContext<'a, SVGBackend<'a>, T>) -> Result<()> {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(label_style())
        .legend_area_size(32)
        .margin(14)
        .background_style(WHITE.filled())
        .border_style(GRID)
        .draw()
        .map_err(failed)
}

/// Titles.
pub fn title_style() -> TextStyle<'static> {
    TextStyle::from((FONT, 19).into_font()).color(&INK)
}

/// Descriptions of axes.
pub fn axis_style() -> TextStyle<'static> {
    TextStyle::from((FONT, 17).into_font()).color(&INK)
}

/// Numbers at ticks and entries of legends.
pub fn label_style() -> TextStyle<'static> {
    TextStyle::from((FONT, 15).into_font()).color(&INK)
}

/// Text that begins, vertically centred, at a point.
pub fn beside() -> TextStyle<'static> {
    label_style().pos(Pos::new(HPos::Left, VPos::Center))
}

/// Text centred at a point.
pub fn centred() -> TextStyle<'static> {
    label_style().pos(Pos::new(HPos::Center, VPos::Center))
}

/// Text that ends, vertically centred, at a point.
pub fn before() -> TextStyle<'static> {
    label_style().pos(Pos::new(HPos::Right, VPos::Center))
}
