//! What charts are drawn on: an SVG of `plotters`, in whole units of half a px, with one font and axes with our own ticks.

use crate::Error;
use crate::axis::Ticks;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Drawing units in a px: `plotters` places everything on whole units.
pub(crate) const UNITS: f64 = 2.0;
const FONT: &str = "sans-serif";
pub(crate) const LABEL_PX: f64 = 12.0;
pub(crate) const TITLE_PX: f64 = 13.5;

/// Lines and letters.
pub(crate) const INK: RGBColor = RGBColor(30, 30, 30);
/// Lines at the ticks.
pub(crate) const GRID: RGBColor = RGBColor(225, 225, 225);
/// The band that is noise.
pub(crate) const NOISE: RGBColor = RGBColor(234, 234, 234);

/// What a chart is drawn on.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A length of so many px, in drawing units.
pub(crate) fn units(px: f64) -> i32 {
    (px * UNITS).round() as i32
}

pub(crate) fn failed(error: impl std::fmt::Display) -> Error {
    Error(error.to_string())
}

/// The style of a text of that size.
pub(crate) fn text(px: f64) -> TextStyle<'static> {
    // `plotters` takes the size of a line of text, 1.24 times that of the letters.
    TextStyle::from((FONT, 1.24 * px * UNITS).into_font()).color(&INK)
}

/// A linear axis with ticks of our own.
pub(crate) struct Along {
    axis: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Along {
    pub(crate) fn new(ticks: &Ticks) -> Self {
        Self { axis: (ticks.range[0]..ticks.range[1]).into(), ticks: ticks.at.clone() }
    }
}

impl Ranged for Along {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.axis.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> core::ops::Range<f64> {
        self.axis.range()
    }
}

/// A chart whose axes are drawn.
pub(crate) type Canvas<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Along, Along>>;

/// Where a point of the chart lies on the area.
pub(crate) fn on(area: &Area<'_>, chart: &Canvas<'_, '_>, point: (f64, f64)) -> (i32, i32) {
    let ((right, down), (left, up)) = (chart.backend_coord(&point), area.get_base_pixel());
    (right - left, down - up)
}
