//! Drawing surface of charts: an SVG by `plotters`, in integer units of half a px, with one font and axes with our own ticks.

use crate::Error;
use crate::axis::Ticks;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Drawing units per px: `plotters` uses integer positions.
pub(crate) const UNITS: f64 = 2.0;
const FONT: &str = "sans-serif";
pub(crate) const LABEL_PX: f64 = 12.0;
pub(crate) const TITLE_PX: f64 = 13.5;

/// Colour of lines and letters.
pub(crate) const INK: RGBColor = RGBColor(30, 30, 30);
/// Colour of grid lines.
pub(crate) const GRID: RGBColor = RGBColor(225, 225, 225);
/// Colour of the noise band.
pub(crate) const NOISE: RGBColor = RGBColor(234, 234, 234);

/// Drawing area of a chart.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A length, px, in drawing units.
pub(crate) fn units(px: f64) -> i32 {
    (px * UNITS).round() as i32
}

pub(crate) fn failed(error: impl std::fmt::Display) -> Error {
    Error(error.to_string())
}

/// Style of a text of this size, px.
pub(crate) fn text(px: f64) -> TextStyle<'static> {
    // `plotters` takes the line height, 1.24 times the letter size.
    TextStyle::from((FONT, 1.24 * px * UNITS).into_font()).color(&INK)
}

/// A linear axis with our own ticks.
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

/// A chart with drawn axes.
pub(crate) type Canvas<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Along, Along>>;

/// Position of a chart point in the area.
pub(crate) fn on(area: &Area<'_>, chart: &Canvas<'_, '_>, point: (f64, f64)) -> (i32, i32) {
    let ((right, down), (left, up)) = (chart.backend_coord(&point), area.get_base_pixel());
    (right - left, down - up)
}
